"""An estimate of the global error, by a second pass that is more exact than the first."""

import numpy as np

from fastdyn.problem.options.table import TOLERANCES, refused_by, value_of
from fastdyn.problem.validate import method_named

TIGHTER = 100.0  # ratio of the tolerances of both passes
LEAST_RTOL = 1e-12  # below this rtol, no tighter tolerance is possible
FIRST_PASS = {"t_eval", "dense_output", "events", *refused_by("second pass")}


def with_error_estimate(solve, given):
    """The result of ``solve(**given)`` with the field `error_estimate`.

    `solve` is `solve_ivp`.
    """
    if given.get("on_event") is not None:
        raise ValueError(
            "`error_estimate` compares two solutions at the same times, where those of `on_event` "
            "jump at different ones: solve from one event to the next."
        )
    second = {name: value for name, value in given.items() if name not in FIRST_PASS}
    share = _tightened(given["method"], second)
    result = solve(**given)
    t, t0 = np.asarray(result.t), float(given["t_span"][0])
    y = np.asarray(result.y).reshape(len(given["y0"]), len(t))
    better = y
    if len(t) and t[-1] != t0:
        other = solve(**{**second, "t_span": (t0, float(t[-1])), "t_eval": t})
        better = np.full_like(y, np.nan)  # NaN after the end of the second pass
        better[:, : len(other.t)] = other.y
    result.error_estimate = share * (y - better)
    return result


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
    rtol, atol = np.maximum(rtol / TIGHTER, least), atol / TIGHTER
    options["rtol"], options["atol"] = (x[()] if x.ndim == 0 else x for x in (rtol, atol))
    return 1.0
