"""solve_dae with `discrete`: further components with the equation d' = 0, which events change."""

from typing import Any

import numpy as np

from fastdyn.problem import discrete as longer
from fastdyn.problem import validate
from fastdyn.problem.options.table import TOLERANCES
from fastdyn.problem.options.tolerances import longer_tolerances
from fastdyn.problem.schedules import SHORTHANDS, listed
from fastdyn.run.result import OdeResult


def solve_with_discrete(solve, arguments, options):
    """The result of ``solve(**arguments, **options)`` with `discrete`, and its discrete states.

    `solve` is `solve_dae`.
    """
    given = dict(arguments)
    options = dict(options)
    if options.get("sensitivity") is not None:
        raise ValueError(
            "`sensitivity` and `discrete` do not go together in `solve_dae`: make a discrete state "
            "a component of `y` with the equation yp = 0."
        )
    y0 = validate.initial_state(given["y0"])
    d0 = longer.discrete_states(options.pop("discrete"), y0, options)
    longer.expect_action(options.get("on_event"))
    n = len(y0)
    m = len(d0)
    events = listed(given["events"], options)
    jumps = longer.extended_events(events, options.pop("on_event", None), n, m)
    given["events"], options["on_event"] = jumps
    for name in SHORTHANDS:
        options.pop(name, None)
    given["F"] = _extended(given["F"], n)
    given["y0"] = np.concatenate([y0, d0])
    if given["yp0"] is not None:
        given["yp0"] = np.r_[validate.initial_state(given["yp0"], "yp0"), np.zeros(m)]
    given["given"] = _held(given["given"], n, m)
    tolerances = {**TOLERANCES, **options}
    rtol, atol = longer_tolerances(None, tolerances["rtol"], tolerances["atol"], n, m)
    atol[n:] = np.max(atol[:n], initial=0.0)  # all count in the iteration for consistent values
    options["rtol"] = rtol
    options["atol"] = atol
    return _parted(solve(**given, **options), n, m)


def _extended(F: Any, n):
    """The residual of the longer state."""
    if not callable(F):
        return F

    def residual(t, z, zp, *args):
        found: Any = F(t, z[:n], zp[:n], z[n:], *args)
        if np.shape(found) != (n,):
            raise ValueError(
                f"`F` must return {n} residuals; {longer.BESIDE}: F(t, y, yp, d, *args)."
            )
        return [*found, *zp[n:]]

    residual.__name__ = getattr(F, "__name__", "F")
    residual.form = "t, y, yp, d, *args"  # pyright: ignore
    return residual


def _held(given, n, m):
    """`given` for the longer state: the discrete states are held."""
    if given is None or (isinstance(given, str) and given != "yp"):
        return given
    held = np.asarray([False] * n + [True] * n if isinstance(given, str) else given)
    if held.dtype == bool and held.shape == (2 * n,):
        return np.r_[held[:n], np.full(m, True), held[n:], np.full(m, True)]
    if held.ndim == 1 and (held.dtype.kind == "i" or not held.size) and np.all(held < n):
        return np.r_[held.astype(int), n : n + m]
    return given  # refused with the other mistakes


def _parted(whole, n, m):
    """The result with the first n components as the state, the others as discrete states."""
    result = OdeResult(whole)
    y = np.asarray(whole.y).reshape(n + m, -1)
    result.y, result["yp"], result["discrete"] = y[:n], whole.yp[:n], y[n:]
    result.y_events = [each[:, :n] if each.size else each for each in whole.y_events]
    result["discrete_events"] = [each[:, n:] if each.size else each for each in whole.y_events]
    if whole.get("yp_events") is not None:
        result["yp_events"] = [each[:, :n] if each.size else each for each in whole.yp_events]
    if "states" in whole:
        result["differentiated"] = whole.differentiated[:n]
        result["states"] = [(t, _own(places, n, m)) for t, places in whole.states]
    if whole.sol is not None:
        result.sol = OwnSolution(whole.sol, n)
    return result


def _own(places, n, m):
    """The states without discrete ones; n l + j stands for derivative l of component j."""
    parts = [divmod(place, n + m) for place in places]
    return tuple([n * order + j for order, j in parts if j < n])


class OwnSolution:
    """The first n components of a continuous solution."""

    def __init__(self, sol, n):
        self._sol = sol
        self._n = n
        self.t_min = sol.t_min
        self.t_max = sol.t_max

    def __call__(self, t):
        return self._sol(t)[: self._n]

    def derivative(self, t):
        """The derivative, (n,) at one time, (n, k) at k times."""
        return self._sol.derivative(t)[: self._n]
