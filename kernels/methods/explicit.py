"""Explicit Runge-Kutta pairs, compiled from their tables.

A step has s stages and, at its end, the derivative that is the first stage of the next step.  The
interpolant adds stages of its own to these, evaluated only where it is wanted, and rows to the
Hermite polynomial of `dense.py`.
"""

import operator

from numba import types
from numba.extending import intrinsic

from ..jit_options import FUSED, njit
from ..output.dense_output import F
from ..state.elementwise import combine, slot, weigh
from ..state.record import STAGE, Y_OLD, K, Y
from ..stepping import adaptive, first_step
from ..stepping.step_size import SCIPY, rms
from .method import Method
from .tableau import Row, RowType

NOWHERE = (types.none, None)
NO_STAGES = (Row(), ())


def _call(context, builder, function, *given):
    """Call compiled code from generated code: (type, value) of the result, for those of `given`."""
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
    return RowType(row.exact), context.get_dummy_value()


def _together(context, builder, values):
    """A list of values of one type as one tuple."""
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


def make_enrich(n, times, rows, weights):
    """The `enrich` of a method whose first n stages are in the rows of the work array."""

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

    @njit(**FUSED)
    def enrich(rhs, t, h, work, block, d):
        fill(rhs, t, h, work, block, d)
        return len(rows)

    return enrich


def pair(name, order, error_order, stages, b, embedded, d, dense_order, extra=NO_STAGES):
    """A method from its tables.

    Parameters
    ----------
    name : str
    order, error_order, dense_order : int
    stages : tuple (Row, tuple of Row)
        Times and rows of the stages from the second on; see `row.tableau`.
    b : Row
        Weights of the s stages.
    embedded : Row
        Weights of the pair's other method; s + 1 numbers, the last for the derivative at the end.
    d : tuple of Row
        Weights of all stages in the rows of the interpolant beyond the Hermite polynomial.
    extra : tuple (Row, tuple of Row), optional
        The same as `stages`, for the stages of the interpolant.
    """
    s = len(b)
    error = b - embedded
    first, at_end = make_stages(*stages), K + s

    @njit(**FUSED)
    def step(rhs, t, y, h, k1, block, form, work, rtol, atol):
        k = first(rhs, t, y, h, k1, block, form, work)
        y_new = combine(slot(form, work, Y), y, h, b, k)
        k_all = (*k, rhs(t + h, y_new, block, slot(form, work, at_end)))
        estimate = weigh(slot(form, work, STAGE), h, error, k_all)
        return y_new, k_all, rms(estimate, y, y_new, rtol, atol)

    return Method(
        name,
        order=order,
        error_order=error_order,
        n_stages=s,
        n_rows=s + 1 + len(extra[1]),
        last=s,
        advance=adaptive.advance,
        step=step,
        arguments=(SCIPY, -1 / (error_order + 1), s),
        start=first_step.hairer,
        n_dense=3 + len(d),
        enrich=make_enrich(s + 1, *extra, d),
        dense_order=dense_order,
        tableau={
            "c": Row.of((0, *stages[0].exact, 1, *extra[0].exact)),
            "a": (Row(), *stages[1], b, *extra[1]),
            "b": b,
            "e": (error,),
            "d": d,
        },
    )
