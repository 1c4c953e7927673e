"""Emits the pointer form of a trace.  Needs no Numba."""

import functools

from llvmlite import ir

from fastdyn.kernels.calls.block import SIDES
from fastdyn.kernels.vector.emit import Lanes
from fastdyn.kernels.vector.formulas import BY_NAME
from fastdyn.trace.emit.loops import LoopEmitter, worth_loops
from fastdyn.trace.emit.numbers import BIT, INDEX, REAL, WORD, Emitter
from fastdyn.trace.graph.expressions import live

from .. import calling_convention
from .inputs import Source

MAX_STRAIGHT = 16  # up to so many components, kernels inline functions as straight-line code


def text(traced, symbol):
    """The text of an LLVM module with the pointer form."""
    module = ir.Module()
    calling_convention.define(module, symbol, functools.partial(body, traced))
    return str(module)


def body(traced, builder, t, y, n, block, out):
    """Emit the pointer form: store results at `out`, and mark the block if the function raises."""
    graph, raising, stored = traced.trace.graph, traced.trace.raising, traced.stored
    if traced.n > MAX_STRAIGHT and worth_loops(live([*stored, raising])):
        raises = builder.call(_in_loops(traced, builder.module), [t, y, block, out])
    else:
        source = Source(builder, traced, t, y, block, traced.kinds)
        emitter = Emitter(builder, graph, REAL, source)
        *values, raises = emitter.nodes([*stored, raising])
        for i, value in enumerate(values):
            builder.store(value, builder.gep(out, [INDEX(i)]))
        if traced.decisions:
            _note_sides(builder, emitter.nodes(traced.decisions), block)
    if raising is not graph.false:
        with builder.if_then(raises, likely=False):
            lengths = WORD(traced.n), WORD(len(stored))
            calling_convention.note_fault(builder, t, y, block, out, *lengths)


def _note_sides(builder, truths, block):
    """Emit the note, in the block, of the sides that decisions take."""
    place = builder.gep(block, [INDEX(SIDES)])
    sides = builder.load(place)
    for i, truth in enumerate(truths):
        side = builder.select(truth, WORD(1 << 2 * i), WORD(2 << 2 * i))
        sides = builder.or_(sides, side)
    builder.store(sides, place)


def _in_loops(traced, module):
    """A separate function, with equal nodes in loops; it returns whether the function raises."""
    kind = ir.FunctionType(BIT, [REAL, REAL.as_pointer(), WORD.as_pointer(), REAL.as_pointer()])
    function = ir.Function(module, kind, module.get_unique_name("fastdyn_loops"))
    function.linkage = "internal"
    function.attributes.add("noinline")
    t, y, block, out = function.args
    builder = ir.IRBuilder(function.append_basic_block())
    source = Source(builder, traced, t, y, block, traced.kinds)
    in_vectors = functools.partial(by_formula, builder)
    emitter = LoopEmitter(builder, traced.trace.graph, source, in_vectors)
    builder.ret(emitter.store(traced.stored, out, traced.trace.raising))
    return function


def by_formula(builder, name, values):
    """Emit an elementary function of vectors."""
    values = [Lanes(builder, v) for v in values]
    if name in BY_NAME:
        return BY_NAME[name](*values).value
    vectors = [v.value for v in values]
    return Emitter(builder, None, vectors[0].type).in_c(name, vectors)
