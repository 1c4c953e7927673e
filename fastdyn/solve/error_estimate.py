"""An estimate of the global error, by a second pass that is more exact than the first."""

from typing import Any

import numpy as np

from fastdyn.problem.options.table import TOLERANCES, refused_by, value_of
from fastdyn.problem.sensitivities import check_adjoint
from fastdyn.problem.validate import method_named
from fastdyn.run import again

from . import by_method, repeated
from .keys import key_of, with_times

TIGHTER = 100.0  # ratio of the tolerances of both passes
LEAST_RTOL = 1e-12  # below this rtol, no tighter tolerance is possible


def solved_by(asked, method):
    """The result of Arguments by a method; with an `error_estimate` if asked for."""
    if not asked.error_estimate:
        return by_method.solved(asked, method)
    if asked.options.get("on_event") is not None:
        raise ValueError(
            "`error_estimate` compares two solutions at the same times, but with `on_event` they "
            "jump at different times: solve from one event to the next."
        )
    if asked.adjoint is not None:
        check_adjoint(asked, method_named(method))  # which refuses the two together
    left = refused_by("second pass")
    options = {name: value for name, value in asked.options.items() if name not in left}
    share = _tightened(method, options)
    first = asked._replace(error_estimate=None)
    second = first._replace(dense_output=False, events=None, sensitivity=None, options=options)

    def again_at(t):
        return by_method.solved(second._replace(tf=float(t[-1]), t_eval=t), method)

    result = by_method.solved(first, method)
    result = _estimated(result, len(asked.y0), asked.t0, share, again_at)
    kind = by_method.kind_of(asked, method)
    at_times = second._replace(t_eval=np.asarray(result.t))
    repeated.choose(
        asked, kind, first, kind, lambda of: Estimated(of, first, at_times, kind, share)
    )
    return result


def _estimated(result, n, t0, share, again_at) -> Any:
    """A result with its `error_estimate`; None if there is no second pass, ``again_at(t)``."""
    t = np.asarray(result.t)
    y = np.asarray(result.y).reshape(n, len(t))
    better = y
    if len(t) and t[-1] != t0:
        other = again_at(t)
        if other is None:
            return None
        better = np.full_like(y, np.nan)  # NaN after the end of the second pass
        better[:, : len(other.t)] = other.y
    result.error_estimate = share * (y - better)
    return result


class Estimated(again.Kind):
    """Calls of one kind with `error_estimate`: calls without, and second passes at their times.

    Parameters
    ----------
    of : Kind
        Of the first pass.
    first, second : Arguments
        Those of a first and of a second pass, as examples.
    method : str or tuple
        As of `by_method.kind_of`.
    share : float
        That of the first pass in the difference.
    """

    def __init__(self, of, first, second, method, share):
        super().__init__(of.codes)
        self._of = of
        self._second, functions = key_of(second, method)
        self._n_events = len(key_of(first, method)[1]) - len(functions)
        self._share = share

    def solve(self, fun, y0, args, others=(), t_span: Any = None, t_eval=None):
        of = self._of
        if not all(ready.is_traced for ready in of.idle):  # the long way has both passes, too,
            return None  # and functions in Python may do more than give values
        result = of.solve(fun, y0, args, others, t_span, t_eval)
        if result is None:
            return None

        def again_at(t):
            found = again.calls.get(with_times(self._second, len(t)))
            span = t_span[0], float(t[-1])
            given = fun, y0, args, others[self._n_events :], span, t
            return None if found is None else found.solve(*given)

        return _estimated(result, len(y0), t_span[0], self._share, again_at)


def _tightened(method, options):
    """Tighten the options of the second pass; return the first pass's share of the difference."""
    ours = method_named(method)
    if ours is not None and not ours.error_order:
        if options.get("step") is not None:
            options["step"] = options["step"] / 2
        return 1.0 / (1.0 - 0.5**ours.order)
    rtol, atol = (np.asarray(value_of(options, name)) for name in TOLERANCES)
    if np.any(rtol < LEAST_RTOL):
        raise ValueError(
            f"`error_estimate` solves at a tolerance {TIGHTER:g} times tighter, too: give an "
            f"`rtol` of at least {LEAST_RTOL}; got {rtol.min()}."
        )
    least = 100 * np.finfo(float).eps
    rtol = np.maximum(rtol / TIGHTER, least)
    atol = atol / TIGHTER
    options["rtol"], options["atol"] = (x if x.ndim else float(x) for x in (rtol, atol))
    return 1.0
