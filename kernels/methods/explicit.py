"""Explicit Runge-Kutta methods, compiled from their tables.

A step has s stages.  The derivative at the end of the step is the first stage of the next step.
The interpolant is the Hermite polynomial of `dense_output.py` with further rows.  Stages that only
the interpolant needs are evaluated only in steps that contain an output time.
"""

import operator
from functools import partial

from numba import types
from numba.extending import intrinsic

from ..ensemble import lanes
from ..jit_options import INLINED, njit
from ..output.dense_output import F, cubic
from ..state.constant import ConstantType
from ..state.elementwise import combine, weigh
from ..state.record import STAGE, Y_OLD, K, Y
from ..state.rows import slot
from ..stepping import adaptive, first_step, fixed
from ..stepping.step_size import SCIPY, SCIPYS
from .complex_states import OF_PAIRS, hairer_of_pairs
from .method import method, with_complex_states
from .tableau import Row

NOWHERE = (types.none, None)


def _call(context, builder, function, *given):
    """Call compiled code from generated code: (type, value) of the result.

    `given` are the (type, value) of the arguments.
    """
    kinds, values = zip(*given, strict=True)
    if not isinstance(function, types.Type):
        function = context.typing_context.resolve_value_type(function)
    signature = function.get_call_type(context.typing_context, kinds, {})
    values = [
        context.cast(builder, value, kind, wanted)
        for value, kind, wanted in zip(values, kinds, signature.args, strict=True)
    ]
    return signature.return_type, context.get_function(function, signature)(builder, values)


def _index(context, i):
    return types.intp, context.get_constant(types.intp, i)


def _number(context, x):
    return types.float64, context.get_constant(types.float64, float(x))


def _row(context, row):
    return ConstantType(row), context.get_dummy_value()


def _together(context, builder, values):
    """A tuple of a list of values of equal type."""
    whole = types.UniTuple(values[0][0], len(values))
    return whole, context.make_tuple(builder, whole, [v for _, v in values])


def _append_stages(context, builder, times, rows, rhs, t, y, h, found, block, form, work):
    """Append to the list `found` the derivatives at t + c h of y + h sum(a_j k_j), row by row."""
    for c, row in zip(times.exact, rows, strict=True):
        known = _together(context, builder, found)
        u = _call(context, builder, slot, form, work, _index(context, STAGE))
        u = _call(context, builder, combine, u, y, h, _row(context, row), known)
        later = _call(context, builder, operator.mul, _number(context, c), h)
        time = _call(context, builder, operator.add, t, later)
        out = _call(context, builder, slot, form, work, _index(context, K + len(found)))
        found.append(_call(context, builder, rhs, time, u, block, out))


def make_stages(times, rows):
    """``stages(rhs, t, y, h, k1, block, form, work)``: the tuple of k1 and the stages of `rows`."""

    @intrinsic
    def stages(typingctx, rhs, t, y, h, k1, block, form, work):
        whole = types.UniTuple(y, len(rows) + 1)
        signature = whole(rhs, t, y, h, k1, block, form, work)

        def codegen(context, builder, signature, args):
            _, t, y, h, k1, *rest = zip(signature.args, args, strict=True)
            found = [k1]
            _append_stages(context, builder, times, rows, rhs, t, y, h, found, *rest)
            return _together(context, builder, found)[1]

        return signature, codegen

    return stages


def make_dense_rows(name, n, table):
    """The `dense_rows` of a method; the work array holds the first n stages."""
    (times, rows), weights = table.extra, table.d

    @intrinsic
    def fill(typingctx, rhs, t, h, work, block, d):
        def codegen(context, builder, signature, args):
            _, t, h, work, block, d = zip(signature.args, args, strict=True)

            def place(array, i):
                return _call(context, builder, slot, NOWHERE, array, _index(context, i))

            found = [place(work, K + i) for i in range(n)]
            y = place(work, Y_OLD)
            _append_stages(context, builder, times, rows, rhs, t, y, h, found, block, NOWHERE, work)
            k = _together(context, builder, found)
            for j, row in enumerate(weights):
                _call(context, builder, weigh, place(d, F + 3 + j), h, _row(context, row), k)
            return context.get_dummy_value()

        return types.none(rhs, t, h, work, block, d), codegen

    def dense_rows(rhs, t, h, work, block, d):
        fill(rhs, t, h, work, block, d)
        return len(rows)

    dense_rows.__name__ = name
    return njit(**INLINED)(dense_rows)


def make_solution(table):
    """``solution(rhs, t, y, h, k1, block, form, work)``: the new value, and all stages."""
    stages, b, at_end = make_stages(*table.stages), table.b, K + len(table.b)

    @njit(**INLINED)
    def solution(rhs, t, y, h, k1, block, form, work):
        k = stages(rhs, t, y, h, k1, block, form, work)
        y_new = combine(slot(form, work, Y), y, h, b, k)
        return y_new, (*k, rhs(t + h, y_new, block, slot(form, work, at_end)))

    return solution


def one_estimate(table, norm):
    """``estimate(u, h, k, y, y_new, rtol, atol)``: the norm of the error h sum(e_i k_i).

    A derivative at the end that is not finite makes the error NaN: no step begins there.
    """
    error, mean = Row.of(table.errors[0].exact, to_the_end=True), norm.mean

    @njit(**INLINED)
    def estimate(u, h, k, y, y_new, rtol, atol):
        return mean(weigh(u, h, error, k), y, y_new, rtol, atol)

    return estimate


def make_step(table, estimate):
    """The step of a pair; `estimate` measures the error: see `one_estimate`."""
    solution = make_solution(table)

    @njit(**INLINED)
    def step(rhs, t, y, h, k1, block, form, work, rtol, atol):
        y_new, k = solution(rhs, t, y, h, k1, block, form, work)
        return y_new, k, estimate(slot(form, work, STAGE), h, k, y, y_new, rtol, atol)

    return step


def make_fixed_step(table):
    """The step of a method without an error estimate."""
    solution = make_solution(table)

    @njit(**INLINED)
    def step(rhs, t, y, h, k1, compensation, block, form, work):
        return solution(rhs, t, y, h, k1, block, form, work)

    return step


def read_off(name, table):
    """The fields of a method that follow from its table."""
    s, (times, extra) = len(table.b), table.extra
    return {
        "n_stages": s,
        "n_rows": s + 1 + len(extra),
        "fsal_stage": s,
        "n_dense": 3 + len(table.d),
        "dense_rows": make_dense_rows(name, s + 1, table) if table.d else cubic,
        "tableau": {
            "c": Row.of((0, *table.stages[0].exact, 1, *times.exact)),
            "a": (Row(), *table.stages[1], table.b, *extra),
            "b": table.b,
            "e": table.errors,
            "d": table.d,
        },
    }


def pair(name, table, estimate=one_estimate, *, order, error_order, dense_order, **matlabs):
    """A method of adaptive step from its Table.

    Parameters
    ----------
    name : str
    table : Table
    estimate : function, optional
        ``estimate(table, norm)`` makes the function that `make_step` takes.
    order, error_order, dense_order : int
        Orders of the solution, of the error estimate and of the interpolant.
    **matlabs
        For a pair with another control of the step than SciPy's: `norm`, `control`, other fields of
        `method`.
    """
    of_scipy = not matlabs
    norm, control = matlabs.pop("norm", SCIPYS), matlabs.pop("control", SCIPY)

    def looped(loop, norm):
        step, s = make_step(table, estimate(table, norm)), len(table.b)
        return partial(loop, step, control, -1 / (error_order + 1), s)

    fields = read_off(name, table) | {"start": first_step.hairer} | matlabs
    found = method(
        name,
        order=order,
        error_order=error_order,
        dense_order=dense_order,
        kernel=looped(adaptive.kernel, norm),
        lane_kernel=looped(lanes.adaptive, norm),
        **fields,
    )
    of_pairs = looped(adaptive.kernel, OF_PAIRS), hairer_of_pairs
    return with_complex_states(found, *of_pairs) if of_scipy else found


def single(name, table, **more):
    """A method of fixed step from its Table, which has no error estimate."""
    s = len(table.b)
    given = make_fixed_step(table), s, s
    found = method(
        name,
        error_order=0,
        kernel=partial(fixed.kernel, *given),
        lane_kernel=partial(lanes.fixed, *given),
        start=first_step.plain,
        **read_off(name, table) | more,
    )
    return with_complex_states(found, found.kernel, found.start)
