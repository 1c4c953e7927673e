"""A trace as a Taylor kernel on vectors, with a trajectory in each lane."""

from typing import Any

from llvmlite import ir

from fastdyn.code_store.target import processor
from fastdyn.operations import OPERATIONS
from fastdyn.trace.emit.numbers import INDEX, REAL, WORD, Emitter
from fastdyn.trace.graph.refusal import refused_as

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
    module, raises = ir.Module(), raising is not graph.false
    _invariants(module, traced, plan, kinds, width)
    _slopes(module, traced, kinds, width)
    functions(module, plan, width)
    if raises:
        _raises(module, traced, raising, kinds, width)
    looks = is_deceptive(plan)
    driver = OfTrajectories(Single(plan), order, width, raises, looks, *by_processor(width))
    return f"{module}\n{driver(symbol, set(module.globals))}"


def by_processor(width):
    """LLVM's name for multiply-add, and the number of partial sums that the registers hold."""
    features = processor()[2].split(",")
    fused = "fma" if "+fma" in features else "fmuladd"
    if "+avx512f" in features:
        return fused, 6
    return fused, 2


class _Rows(VectorSource):
    """The inputs of the form on vectors, with the state in memory."""

    def y(self, i):
        return _vector(self.builder, self._y, i, self.t.type)


def _vector(builder, pointer, i, kind):
    at = builder.gep(pointer, [INDEX(i * kind.count)])
    value = builder.load(builder.bitcast(at, kind.as_pointer()))
    value.align = 8
    return value


def _emitter(function, traced, kinds, kind, t, y, block):
    builder = ir.IRBuilder(function.append_basic_block())
    source = _Rows(builder, traced, t, y, block, kinds)

    def in_vectors(name, values):
        return by_formula(builder, name, values)

    return builder, Emitter(builder, traced.trace.graph, kind, source, in_vectors)


def _invariants(module, traced, plan, kinds, width):
    """``fastdyn_invariants(block, out)``: the values that do not change within a solve."""
    kind = ir.VectorType(REAL, width)
    form = ir.FunctionType(ir.VoidType(), [WORD.as_pointer(), REAL.as_pointer()])
    function = ir.Function(module, form, "fastdyn_invariants")
    block, out = function.args
    nothing = ir.Constant(kind, ir.Undefined)
    builder, emitter = _emitter(function, traced, kinds, kind, nothing, None, block)
    _stored(builder, emitter.nodes(list(plan.invariants.values())), out)


def _slopes(module, traced, kinds, width):
    """``fastdyn_slopes(t, y, block, out)``: the function itself."""
    kind = ir.VectorType(REAL, width)
    places = [REAL.as_pointer(), WORD.as_pointer(), REAL.as_pointer()]
    form = ir.FunctionType(ir.VoidType(), [kind, *places])
    function = ir.Function(module, form, "fastdyn_slopes")
    builder, emitter = _emitter(function, traced, kinds, kind, *function.args[:3])
    _stored(builder, emitter.nodes(traced.stored), function.args[3])


def _stored(builder, values, out):
    """Emit: store vectors one behind the other, and return."""
    for i, value in enumerate(values):
        at = builder.gep(out, [INDEX(i * value.type.count)])
        stored: Any = builder.store(value, builder.bitcast(at, value.type.as_pointer()))
        stored.align = 8
    builder.ret_void()


def _raises(module, traced, raising, kinds, width):
    """``fastdyn_raises(t, y, block)``: 1.0 in the lanes where the function raises, else 0.0."""
    kind = ir.VectorType(REAL, width)
    form = ir.FunctionType(kind, [kind, REAL.as_pointer(), WORD.as_pointer()])
    function = ir.Function(module, form, "fastdyn_raises")
    builder, emitter = _emitter(function, traced, kinds, kind, *function.args)
    (truth,) = emitter.nodes([raising])
    builder.ret(builder.uitofp(truth, kind))


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
