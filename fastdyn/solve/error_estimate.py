"""An estimate of the global error, by a second pass that is more exact than the first."""

import numpy as np

from fastdyn.problem.options.table import TOLERANCES, refused_by, value_of
from fastdyn.problem.validate import method_named

from . import by_method

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
    left = refused_by("second pass")
    options = {name: value for name, value in asked.options.items() if name not in left}
    share = _tightened(method, options)
    result = by_method.solved(asked, method)
    t = np.asarray(result.t)
    y = np.asarray(result.y).reshape(len(asked.y0), len(t))
    better = y
    if len(t) and t[-1] != asked.t0:
        other = by_method.solved(
            asked._replace(
                tf=float(t[-1]), t_eval=t, dense_output=False, events=None, sensitivity=None,
                options=options,
            ),
            method,
        )  # fmt: skip
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
    rtol = np.maximum(rtol / TIGHTER, least)
    atol = atol / TIGHTER
    options["rtol"], options["atol"] = (x[()] if x.ndim == 0 else x for x in (rtol, atol))
    return 1.0
