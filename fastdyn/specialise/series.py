"""The stepping kernel of the Taylor method, compiled for each function."""

import numpy as np

from fastdyn.compile.bind import NUMPY_ERRORS, numpy_errors_are_heard
from fastdyn.compile.python_callback import value_of
from fastdyn.compile.taylor.recurrences.rewrite import NotSmooth
from fastdyn.compile.traced.code import MANY_OPERATIONS
from fastdyn.compile.traced.known import Attempt
from fastdyn.kernels.methods.taylor.accuracy import is_fine, order_for

# Time of Taylor over Vern9 at rtol 1e-10, AVX-512 (with AVX2 twice as much): a chain of 200
# components 1.3, of 120 1.1, Lorenz-96 of 100 1.4, 12 bodies 1.8; but 6 bodies 0.85, 60 pendulums,
# which have sines, 0.75, and 100 waves at 1e-12 1.0.
FEW = 60
TIGHT = 1e-11


class NoSeries(ValueError):
    """Taylor does not apply to a function, or to an event."""


def series_kernel(problem, bound, order=None):
    """The code of the kernel; if there is none, NoSeries, with advice on another method."""
    p = problem
    function = bound.function
    if function is None or function.series is None:
        attempt = Attempt(p.fun, p.args, p.mode, len(p.y0))
        reason = attempt.why()
        if not p.reaction.automatic:  # else another method solves
            attempt.forget_refusals()
        if numpy_errors_are_heard():
            reason = NUMPY_ERRORS
        if reason is None:
            value_of(p.fun, p.args, p.mode.argument, p.t0, p.y0.copy())  # its exception says more
            reason = "it could not be traced"
        raise NoSeries(
            f"Taylor needs the formulas of `fun`: {reason}. "
            "Take Vern9, which needs its values only."
        )
    if p.reaction.refuses_large and function.traced.n_operations > MANY_OPERATIONS:
        raise NoSeries(
            f"The code of Taylor for the {function.traced.n_operations} operations of `fun` takes "
            f"seconds, and pays beyond {MANY_OPERATIONS} in long runs only."
        )
    if p.reaction.refuses_large and _is_for_vern9(p, function):
        raise NoSeries(
            f"Of more than {FEW} components without elementary functions, Vern9 takes less time "
            "than Taylor."
        )
    try:
        return function.series(order or order_for(p.rtol, p.atol, p.y0), is_fine(p.rtol))
    except NotSmooth as reason:
        raise NoSeries(f"Taylor does not apply: {reason}. Take Vern9 instead.") from None


def _is_for_vern9(problem, function):
    """Whether the lanes of Taylor would hold like nodes that Vern9 computes in less time."""
    p = problem
    return len(p.y0) > FEW and np.min(p.rtol) > TIGHT and function.traced.is_algebraic


def series_of_events(problem, bounds, order=None):
    """The addresses of the kernels of the events' series; NoSeries if an event has none."""
    p = problem
    order = order or order_for(p.rtol, p.atol, p.y0)
    return [_series_of_event(bound.function, order) for bound in bounds]


def _series_of_event(function, order):
    reason = "it could not be traced"
    if function is not None and function.series is not None:
        try:
            return function.series(order).address
        except NotSmooth as refusal:
            reason = str(refusal)
    raise NoSeries(
        f"Taylor finds events by their series, and one has none: {reason}. Write it without "
        "conditions and absolute values, or take Vern9."
    )
