"""Emits the pointer form of a trace: ``function(t, y, n, block, out)``.  Needs no Numba."""

import contextlib
import functools

import numpy as np
from llvmlite import ir

from fastdyn.code_store.target import width
from fastdyn.kernels.calls.block import MOST_DECISIONS, SIDES
from fastdyn.kernels.vector.emit import Lanes
from fastdyn.kernels.vector.formulas import BY_NAME
from fastdyn.trace.emit.loops import Loops
from fastdyn.trace.emit.numbers import BIT, INDEX, REAL, WORD, Emitter
from fastdyn.trace.emit.plan import LoopPlan
from fastdyn.trace.emit.program import FEWEST, Program, calls_of, cost_of, worth_loops
from fastdyn.trace.emit.sides import Sides
from fastdyn.trace.graph.expressions import is_zero, live
from fastdyn.trace.graph.refusal import Refusal
from fastdyn.trace.graph.rows import ID

from .. import function_convention
from . import equations, past
from .inputs import Source, array_of

equations.calls_kernels()
past.calls_kernel()
MAX_STRAIGHT, MAX_TUPLE = 8, 16  # components without loops, and with loops by their cost only


def text(traced, symbol, around=lambda body: body):
    """The text of an LLVM module with the pointer form.

    ``around(body)`` is the function that emits the pointer form, where `body` emits code that
    stores all that is traced.
    """
    if traced.in_batches:
        return text_in_rows(traced, traced.plan, symbol)
    plan = loops_of(traced)
    if plan is not None:
        with contextlib.suppress(Refusal, RecursionError):  # a long chain of numbers
            return _text(symbol, around(functools.partial(_in_rows, traced, plan)))
    return _text(symbol, around(functools.partial(body, traced)))


def loops_of(traced):
    """The Plan of a function that is faster in loops; None for a function that is not.

    Few components without elementary functions stay straight-line code: loops read vectors across
    the numbers that the kernel has just stored, and wait (AVX-512: a chain of 40 takes 1.2 times as
    long in loops, Lorenz-96 of 40 1.1 times).
    """
    if traced.n <= MAX_STRAIGHT:
        return None
    nodes = live([*traced.stored, traced.trace.raising])
    many = traced.n > MAX_TUPLE and worth_loops(nodes)
    if many or calls_of(nodes) >= FEWEST:
        with contextlib.suppress(Refusal, RecursionError):
            ids = np.array([node.key for node in traced.stored], ID)
            plan = LoopPlan(program_of(traced, ids, True))
            if many or plan.cost(width()) < cost_of(nodes):
                return plan
    return None


def _text(symbol, body):
    module = ir.Module()
    function_convention.define(module, symbol, body)
    return str(module)


def body(traced, builder, t, y, n, block, out):
    """Emit the pointer form: store results at `out`, and mark the block if the function raises."""
    graph = traced.trace.graph
    raising = traced.trace.raising
    stored = traced.stored
    source = Source(builder, traced, t, y, block, traced.kinds)
    emitter = Emitter(builder, graph, REAL, source)
    *values, raises = emitter.nodes([*stored, raising])
    for i, value in enumerate(values):
        place = builder.gep(out, [INDEX(i)])
        if traced.mode.adds:
            if is_zero(stored[i]):
                continue
            value = builder.fadd(builder.load(place), value)
        builder.store(value, place)
    _add_entries(traced, builder, emitter, out)
    if traced.decisions:
        _note_sides(builder, emitter.nodes(traced.decisions), block)
    _note_fault(traced, builder, raises, t, y, block, out)


def _add_entries(traced, builder, emitter, out):
    """Emit code that adds at the places of those entries of tables that are read."""
    for places, index, cotangent in traced.entries:
        at, value = emitter.nodes([index, cotangent])
        first = builder.gep(out, [WORD(places.start)])
        place = emitter.place((first, len(places), places.step), at)
        builder.store(builder.fadd(builder.load(place), value), place)


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


# -- in rows


def program_of(traced, ids, settles=False):
    """The Program of the results of a trace."""
    of_slot = array_of(traced.trace.reads, traced.kinds)
    return Program(traced.trace.graph, ids, traced.trace.raising, of_slot, settles)


def text_in_rows(traced, plan, symbol):
    """The text of an LLVM module with the pointer form of a plan."""
    return _text(symbol, functools.partial(_in_rows, traced, plan))


def _in_rows(traced, plan, builder, t, y, n, block, out):
    """Emit a call of a separate function, whose arrays do not overlap."""
    kind = ir.FunctionType(BIT, [REAL, REAL.as_pointer(), WORD.as_pointer(), REAL.as_pointer()])
    function = ir.Function(builder.module, kind, "fastdyn_loops")
    function.linkage = "internal"
    function.attributes.add("noinline")
    for array in function.args[1:]:
        array.add_attribute("noalias")
    inner = ir.IRBuilder(function.append_basic_block())
    time, state, own, results = function.args
    source = Source(inner, traced, time, state, own, traced.kinds)
    sides = Sides(inner, MOST_DECISIONS) if traced.mode.notes_sides else None
    loops = Loops(inner, plan, source, functools.partial(by_formula, inner), sides)
    raises = loops.store(results, traced.mode.adds)
    _add_entries(traced, inner, Emitter(inner, traced.trace.graph, REAL, source), results)
    if sides is not None:
        sides.store(inner.gep(own, [INDEX(SIDES)]))
    inner.ret(raises)
    _note_fault(traced, builder, builder.call(function, [t, y, block, out]), t, y, block, out)


def by_formula(builder, name, values):
    """Emit an elementary function of vectors."""
    values = [Lanes(builder, v) for v in values]
    if name in BY_NAME:
        return BY_NAME[name](*values).value
    vectors = [v.value for v in values]
    return Emitter(builder, None, vectors[0].type).in_c(name, vectors)
