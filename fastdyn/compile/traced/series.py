"""A trace as a Taylor kernel."""

from collections import defaultdict

import numpy as np
from llvmlite import ir

from fastdyn.code_store.target import width
from fastdyn.trace.emit.memory import Memory
from fastdyn.trace.emit.numbers import BIT, INDEX, REAL, WORD, Emitter, number_at
from fastdyn.trace.graph.refusal import refused_as

from ..taylor.coefficients.bundles import Bundles
from ..taylor.coefficients.composed import emit
from ..taylor.kernel import OfElements, OfOrders
from ..taylor.recurrences.deceptive import is_deceptive
from ..taylor.recurrences.impossible_conditions import possible
from ..taylor.recurrences.operations import Choice
from ..taylor.recurrences.plan import Plan, sums_of_terms
from ..taylor.recurrences.rewrite import NotSmooth
from .inputs import Source
from .lanes import by_processor, functions

MAX_ONLINE, MAX_WITH_KINKS = 60, 600  # limits of `size_of`; above the first, lanes hold like nodes
MANY = 250  # invariants, beyond which their code is not optimised: 1600 take 0.1 s, else 6 s
INVARIANTS = ir.FunctionType(ir.VoidType(), [WORD.as_pointer(), REAL.as_pointer()])


@refused_as(NotSmooth)
def text(traced, symbol, order, fine):
    """The text of an LLVM module with the Taylor kernel."""
    graph = traced.trace.graph
    raising = possible(graph, traced.trace.failing)
    plan = Plan(graph, traced.stored, raising)
    large = size_of(plan) > MAX_ONLINE and plan_of_rows(traced, plan)
    plan = large or plan
    if not large and size_of(plan) > MAX_WITH_KINKS:
        raise NotSmooth(f"a function of more than {MAX_WITH_KINKS} formulas with conditions")
    if large:
        module, kernel = _large(traced, plan, order, raising is not graph.false)
    else:
        module = _invariants(traced, plan)
        kernel = OfOrders(plan, order, fine, by_processor()[0])
    return f"{module}\n{kernel(symbol, set(module.globals))}"


def size_of(plan):
    """The size that decides whether the lanes of vectors are orders or like nodes."""
    return max(plan.n_sums, len(plan.outputs), sums_of_terms(plan.steps))


def plan_of_rows(traced, plan):
    """A plan that does not watch where the function raises; None if the function has conditions."""
    if plan.raises():
        plan = Plan(plan.graph, traced.stored, plan.graph.false)
    return plan if plan.is_smooth() else None


def _large(traced, plan, order, raises):
    lanes = width()
    bundles = Bundles(plan, lanes)
    module = _invariants(traced, bundles)
    functions(module, plan, lanes)
    deceptive = is_deceptive(plan)
    return module, OfElements(bundles, order, lanes, raises, deceptive, *by_processor())


@refused_as(NotSmooth)
def text_of_event(traced, symbol, order):
    """The LLVM text of the series of an event; NotSmooth if the event has conditions.

    A series that passes a zero of a root, or a jump of atan2, differs from the event there, and
    `kernels/output/series_roots/` then looks at parts of the step, or at the signs.  Where the
    event raises, the step's end raises.
    """
    graph = traced.trace.graph
    plan = Plan(graph, traced.stored, graph.false)
    if any(isinstance(step, Choice) for step in plan.steps) or plan.outputs[0][1] is None:
        raise NotSmooth("an event with a kink")
    module = _invariants(traced, plan)
    return f"{module}\n{emit(plan, order, symbol, set(module.globals), by_processor()[0])}"


def _invariants(traced, plan):
    """A module with ``fastdyn_invariants(block, out)``: the values constant within a solve."""
    module = ir.Module()
    function = ir.Function(module, INVARIANTS, "fastdyn_invariants")
    block, out = function.args
    builder = ir.IRBuilder(function.append_basic_block())
    source = Source(builder, traced, None, None, block, traced.kinds)
    emitter = Emitter(builder, plan.graph, REAL, source)
    at = {key: i for i, key in enumerate(plan.invariants)}
    for slot, elements in _elements(traced.trace.reads, plan.invariants.values()).items():
        if len(elements) > MANY:
            _copied(
                builder, source.table(slot), elements, [at.pop(key) for key, *_ in elements], out
            )
    if len(at) > MANY:
        function.attributes.add("noinline")
        function.attributes.add("optnone")
    values = emitter.nodes([plan.invariants[key] for key in at])
    for i, value in zip(at.values(), values, strict=True):
        if value.type == BIT:
            value = builder.uitofp(value, REAL)
        builder.store(value, builder.gep(out, [INDEX(i)]))
    builder.ret_void()
    return module


def _elements(reads, invariants):
    """By first slot of an array, the invariants x[i] and -x[i] as (key, i, sign)."""
    found = defaultdict(list)
    for node in invariants:
        inner, sign = (node.args[0], -1.0) if node.op == "neg" else (node, 1.0)
        group = reads.groups[reads.group(inner.data)] if inner.op == "par" else None
        if group is not None and group.shape is not None:
            found[group.first].append((node.key, inner.data - group.first, sign))
    return found


def _copied(builder, array, elements, places, out):
    """Emit a loop that stores the `_elements` of an array at their places."""
    memory = Memory(builder)
    _, source, sign = zip(*elements, strict=True)
    columns = (np.array(source), WORD), (np.array(places), WORD), (np.array(sign), REAL)
    tables = [memory.table(column, kind) for column, kind in columns]
    with memory.each(WORD(len(elements)), 1) as k:
        i, place, sign = (builder.load(builder.gep(table, [k])) for table in tables)
        value = builder.fmul(number_at(builder, array, i), sign)
        builder.store(value, builder.gep(out, [place]))
