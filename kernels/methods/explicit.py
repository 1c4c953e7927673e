"""Explicit Runge-Kutta methods, compiled from their tables.

A step has s stages.  The derivative at the end of the step is the first stage of the next step.
The interpolant is the Hermite polynomial of `dense_output.py` with further rows.  Stages that only
the interpolant needs are evaluated only in steps that contain an output time.
"""

from functools import partial

from ..ensemble import lanes
from ..jit.options import INLINED, njit
from ..output.dense_output import cubic
from ..state.elementwise import weigh
from ..stepping import adaptive, first_step, fixed
from ..stepping.step_size import SCIPY, SCIPYS
from .complex_states import OF_PAIRS, hairer_of_pairs
from .method import method, with_complex_states
from .order_conditions import check
from .step_text import write_dense_rows, write_step
from .tableau import Row


def one_estimate(table, norm):
    """``estimate(u, h, k, y, y_new, rtol, atol)``: the norm of the error h sum(e_i k_i).

    A derivative at the end that is not finite makes the error NaN: no step begins there.
    """
    error = Row.of(table.errors[0].exact, to_the_end=True)
    mean = norm.mean

    @njit(**INLINED)
    def estimate(u, h, k, y, y_new, rtol, atol):
        return mean(weigh(u, h, error, k), y, y_new, rtol, atol)

    return estimate


def read_off(name, table, **orders):
    """The orders of a method, which are checked, and the fields that follow from its table."""
    s = len(table.b)
    times, extra = table.extra
    c = (0, *table.stages[0].exact, 1)
    tableau = {
        "c": Row.of((*c, *times.exact)),
        "a": (Row(), *table.stages[1], table.b, *extra),
        "b": table.b,
        "e": table.errors,
        "d": table.d,
    }
    check(name, tableau, table.accuracy, **orders)
    return orders | {
        "n_stages": s,
        "n_rows": s + 1 + len(extra),
        "fsal_stage": s,
        "n_dense": 3 + len(table.d),
        "looks": looks(c, table.errors),
        "dense_rows": write_dense_rows(name, table) if table.d else cubic,
        "tableau": tableau,
        "backward": "stages",
    }


def looks(c, errors):
    """The times after the start, as shares of a step, of the stages that an error estimate sees.

    A change that other stages see alone, those of Vern7 and Vern9 without weight, say, or those of
    a step without an estimate, makes no step shorter.
    """
    weights = errors[0].exact if errors else ()
    return tuple(sorted({float(t) for t, e in zip(c, weights, strict=bool(errors)) if t > 0 and e}))


def pair(name, table, estimate=one_estimate, *, order, error_order, dense_order, **matlabs):
    """A method of adaptive step from its Table.

    Parameters
    ----------
    name : str
    table : Table
    estimate : function, optional
        ``estimate(table, norm)`` makes the function that `write_step` takes.
    order, error_order, dense_order : int
        Orders of the solution, of the error estimate and of the interpolant.
    **matlabs
        For a pair with another control of the step than SciPy's: `norm`, `control`, other fields of
        `method`.
    """
    of_scipy = not matlabs
    norm, control = matlabs.pop("norm", SCIPYS), matlabs.pop("control", SCIPY)
    orders = {"order": order, "error_order": error_order, "dense_order": dense_order}
    fields = read_off(name, table, **orders) | {"start": first_step.hairer} | matlabs

    def looped(loop, norm):
        step = write_step(name, table, estimate(table, norm))
        s = len(table.b)
        return partial(loop, step, control, -1 / (error_order + 1), s)

    found = method(
        name,
        kernel=looped(adaptive.kernel, norm),
        lane_kernel=looped(lanes.adaptive, norm),
        **fields,
    )
    of_pairs = looped(adaptive.kernel, OF_PAIRS), hairer_of_pairs
    return with_complex_states(found, *of_pairs) if of_scipy else found


def single(name, table, *, order, dense_order):
    """A method of fixed step from its Table, which has no error estimate."""
    s = len(table.b)
    given = write_step(name, table), s, s
    found = method(
        name,
        kernel=partial(fixed.kernel, *given),
        lane_kernel=partial(lanes.fixed, *given),
        start=first_step.plain,
        **read_off(name, table, order=order, error_order=0, dense_order=dense_order),
    )
    return with_complex_states(found, found.kernel, found.start)
