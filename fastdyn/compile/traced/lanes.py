"""A trace as a Taylor kernel on vectors, with a trajectory in each lane."""

import functools
from typing import Any

from llvmlite import ir

from fastdyn.code_store.target import processor
from fastdyn.trace.emit.numbers import INDEX, REAL, WORD, Emitter
from fastdyn.trace.graph.refusal import refused_as
from fastdyn.trace.operations import OPERATIONS

from ..taylor.coefficients.bundles import Single
from ..taylor.kernel import OfTrajectories
from ..taylor.recurrences.deceptive import is_deceptive
from ..taylor.recurrences.impossible_conditions import possible
from ..taylor.recurrences.operations import Integral, Power
from ..taylor.recurrences.plan import Plan
from ..taylor.recurrences.rewrite import NotSmooth
from ..taylor.text.instructions import OF_VECTORS
from .inputs import VectorSource
from .pointer_form import by_formula

MAX_STEPS = 400  # most steps of a plan, because the code has no loops over steps


@refused_as(NotSmooth)
def text(traced, symbol, order, kinds, width):
    """The text of an LLVM module with the kernel; `kinds` are the types of the parameters."""
    graph = traced.trace.graph
    raising = possible(graph, traced.trace.failing)
    if traced.trace.error:
        raise NotSmooth(f"what can raise ({traced.trace.error}), in vectors,")
    plan = Plan(graph, traced.stored, graph.false)
    if not plan.is_smooth():
        raise NotSmooth("what depends on conditions, in vectors,")
    if len(plan.steps) > MAX_STEPS:
        raise NotSmooth(f"a function of more than {MAX_STEPS} formulas, in vectors,")
    module = ir.Module()
    raises = raising is not graph.false
    define = functools.partial(_define, module, traced, kinds, width)
    define("fastdyn_invariants", ("block", "out"), list(plan.invariants.values()))
    define("fastdyn_slopes", ("t", "y", "block", "out"), traced.stored)
    functions(module, plan, width)
    if raises:  # 1.0 in the lanes where the function raises, else 0.0
        define("fastdyn_raises", ("t", "y", "block"), [raising])
    looks = is_deceptive(plan)
    driver = OfTrajectories(Single(plan), order, width, raises, looks, *by_processor())
    return f"{module}\n{driver(symbol, set(module.globals))}"


def by_processor():
    """LLVM's name for multiply-add, and the number of partial sums that the registers hold."""
    features = processor()[2].split(",")
    fused = "fma" if "+fma" in features else "fmuladd"
    if "+avx512f" in features:
        return fused, 6
    return fused, 2


class _Rows(VectorSource):
    """The inputs of the form on vectors, with the state in memory."""

    def y(self, i):
        at = _place(self.builder, self._y, i, self.t.type)
        value = self.builder.load(at)
        value.align = 8
        return value


def _place(builder, pointer, i, kind):
    at = builder.gep(pointer, [INDEX(i * kind.count)])
    return builder.bitcast(at, kind.as_pointer())


def _define(module, traced, kinds, width, name, given, nodes):
    """Define a function that stores nodes at `out`, or that returns the number of one truth."""
    kind = ir.VectorType(REAL, width)
    numbers = REAL.as_pointer()
    words = WORD.as_pointer()
    types = {"t": kind, "y": numbers, "block": words, "out": numbers}
    stores = "out" in given
    form = ir.FunctionType(ir.VoidType() if stores else kind, [types[each] for each in given])
    function = ir.Function(module, form, name)
    place = {"t": ir.Constant(kind, ir.Undefined), "y": None}
    place |= zip(given, function.args, strict=True)
    builder = ir.IRBuilder(function.append_basic_block())
    source = _Rows(builder, traced, place["t"], place["y"], place["block"], kinds)
    in_vectors = functools.partial(by_formula, builder)
    values = Emitter(builder, traced.trace.graph, kind, source, in_vectors).nodes(nodes)
    if not stores:
        builder.ret(builder.uitofp(values[0], kind))
        return
    for i, value in enumerate(values):
        stored: Any = builder.store(value, _place(builder, place["out"], i, kind))
        stored.align = 8
    builder.ret_void()


def functions(module, plan, width):
    """Define the elementary functions that a plan calls, on vectors."""
    names = {step.name for step in plan.steps if isinstance(step, Integral)}
    if any(isinstance(step, Power) for step in plan.steps):
        names |= {"pow", "cbrt"}
    kind = ir.VectorType(REAL, width)
    for name in sorted(names):
        form = ir.FunctionType(kind, [kind] * len(OPERATIONS[name].factors))
        function = ir.Function(module, form, f"{OF_VECTORS}{name}")
        builder = ir.IRBuilder(function.append_basic_block())
        builder.ret(by_formula(builder, name, list(function.args)))
