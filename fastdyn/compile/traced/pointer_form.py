"""Emits the pointer form of a trace: ``function(t, y, n, block, out)``.  Needs no Numba."""

import functools

import numpy as np
from llvmlite import ir

from fastdyn.kernels.calls.block import MOST_DECISIONS, SIDES
from fastdyn.kernels.vector.emit import Lanes
from fastdyn.kernels.vector.formulas import BY_NAME
from fastdyn.operations import OPERATIONS
from fastdyn.trace.batches.pieces import Irregular
from fastdyn.trace.batches.plan import Plan
from fastdyn.trace.batches.singles.dependencies import Needed
from fastdyn.trace.batches.singles.settle import Settled
from fastdyn.trace.batches.table import ID, Table
from fastdyn.trace.emit.batches import BatchEmitter, TooManyEdges
from fastdyn.trace.emit.numbers import BIT, INDEX, REAL, WORD, Emitter
from fastdyn.trace.emit.sides import Sides
from fastdyn.trace.graph.expressions import live

from .. import function_convention
from .inputs import Source, array_of

FEWEST_CALLS, FEWEST_NODES = 64, 400
MAX_STRAIGHT = 16  # a function of at most so many components has no loops


def text(traced, symbol):
    """The text of an LLVM module with the pointer form."""
    if traced.n > MAX_STRAIGHT and worth_loops(live([*traced.stored, traced.trace.raising])):
        try:
            return _text(symbol, functools.partial(in_loops, traced, *_plan(traced)))
        except (Irregular, TooManyEdges):
            pass
    return _text(symbol, functools.partial(body, traced))


def _text(symbol, body):
    module = ir.Module()
    function_convention.define(module, symbol, body)
    return str(module)


def worth_loops(nodes):
    """Whether loops are faster than straight-line code for so many nodes."""
    calls = sum(OPERATIONS[node.op].elementary for node in nodes)
    return len(nodes) > FEWEST_NODES or calls > FEWEST_CALLS


def body(traced, builder, t, y, n, block, out):
    """Emit the pointer form: store results at `out`, and mark the block if the function raises."""
    graph, raising, stored = traced.trace.graph, traced.trace.raising, traced.stored
    source = Source(builder, traced, t, y, block, traced.kinds)
    emitter = Emitter(builder, graph, REAL, source)
    *values, raises = emitter.nodes([*stored, raising])
    for i, value in enumerate(values):
        builder.store(value, builder.gep(out, [INDEX(i)]))
    if traced.decisions:
        _note_sides(builder, emitter.nodes(traced.decisions), block)
    _note_fault(traced, builder, raises, t, y, block, out)


def _note_fault(traced, builder, raises, t, y, block, out):
    if traced.trace.raising is not traced.trace.graph.false:
        with builder.if_then(raises, likely=False):
            lengths = WORD(traced.n), WORD(traced.n_stored)
            function_convention.note_fault(builder, t, y, block, out, *lengths)


def _note_sides(builder, truths, block):
    """Emit code that stores in the block which side, true or false, each decision takes."""
    place = builder.gep(block, [INDEX(SIDES)])
    sides = builder.load(place)
    for i, truth in enumerate(truths):
        bit = 2 * (i % MOST_DECISIONS)
        side = builder.select(truth, WORD(1 << bit), WORD(2 << bit))
        sides = builder.or_(sides, side)
    builder.store(sides, place)


# -- in loops


def _plan(traced):
    ends = [*traced.stored, traced.trace.raising]
    size = 1 + max((node.data for node in live(ends) if node.op == "y"), default=0)
    table = Table(traced.trace.graph, size)
    return plan_of(traced, Needed(table, traced.stored, traced.trace.raising))


def plan_of(traced, needed):
    """The Plan of the loops of a trace, and the nodes that are computed behind the loops."""
    of_slot = array_of(traced.trace.reads, traced.kinds)
    settled = Settled(traced.trace.graph, needed, of_slot)
    try:
        behind = [settled.condition]
        return Plan(settled.table, settled.numbers(), behind), behind
    except Irregular:
        if not needed.single:
            raise
        behind = [*settled.alone(), settled.condition]
        return Plan(settled.table, np.empty(0, ID), behind), behind


def in_loops(traced, plan, nodes, builder, t, y, n, block, out):
    """Emit the pointer form of a plan.

    The last of `nodes` tells whether the function raises.  The values of the others go to `out`.
    """
    raises = builder.call(_loops(traced, plan, nodes, builder.module), [t, y, block, out])
    _note_fault(traced, builder, raises, t, y, block, out)


def _loops(traced, plan, nodes, module):
    """A separate function that stores the results and returns whether the function raises."""
    kind = ir.FunctionType(BIT, [REAL, REAL.as_pointer(), WORD.as_pointer(), REAL.as_pointer()])
    function = ir.Function(module, kind, "fastdyn_loops")
    function.linkage = "internal"
    function.attributes.add("noinline")
    t, y, block, out = function.args
    for array in (y, block, out):
        array.add_attribute("noalias")
    builder = ir.IRBuilder(function.append_basic_block())
    source = Source(builder, traced, t, y, block, traced.kinds)
    in_vectors = functools.partial(by_formula, builder)
    sides = Sides(builder, MOST_DECISIONS) if traced.mode.notes_sides else None
    emitter = BatchEmitter(builder, traced.trace.graph, plan, source, in_vectors, sides)
    *values, raises = emitter.store(out, nodes)
    for i, value in enumerate(values):
        builder.store(value, builder.gep(out, [INDEX(i)]))
    if sides is not None:
        sides.store(builder.gep(block, [INDEX(SIDES)]))
    builder.ret(raises)
    return function


def by_formula(builder, name, values):
    """Emit an elementary function of vectors."""
    values = [Lanes(builder, v) for v in values]
    if name in BY_NAME:
        return BY_NAME[name](*values).value
    vectors = [v.value for v in values]
    return Emitter(builder, None, vectors[0].type).in_c(name, vectors)
