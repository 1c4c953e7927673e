"""Whether two solves of a case agree, by a tolerance that SciPy itself sets."""

import contextlib
import io
import warnings
from typing import Any, NamedTuple

import numpy as np
import scipy.integrate

from . import EXPLICIT

EPS = np.finfo(float).eps
SEEDS = range(1, 9)  # of eight shaken solves of a chaotic case, two take another step
OF_SPREAD, OF_RTOL = 30.0, 1e-4


class Outcome(NamedTuple):
    """A result and what was said on the way."""

    result: Any
    said: list


class Verdict(NamedTuple):
    """How far the end states are apart, what is allowed, and whether all agrees."""

    far: float
    allowed: float
    equal: bool


def run(solve_ivp, case, fun=None, t_span=None):
    """One solve of a case, silent."""
    if case.reset is not None:
        case.reset()
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        result = solve_ivp(
            fun or case.fun,
            t_span or case.t_span,
            case.y0,
            method=case.method,
            args=case.args,
            **case.options,
        )
    return Outcome(result, list(said))


def distance(result, reference):
    """Largest difference of a component at the end, relative to the largest value it ever had."""
    if not result.success or not reference.success:
        return 0.0 if result.status == reference.status else np.inf
    scale = np.abs(reference.y).max(axis=1)
    scale[scale == 0] = 1.0
    far = np.abs(result.y[:, -1] - reference.y[:, -1]) / scale
    return float(far.max()) if np.isfinite(far).all() else np.inf


def compare(case, ours, theirs, t_span=None):
    """A verdict: state and time at the end, status, occurrences of events, evaluations.

    The end states may differ by a small part of rtol, or by what SciPy's own answer changes when
    the last digits of the function's arguments and values do; so may the evaluations.
    """
    far = distance(ours, theirs)
    allowed = OF_RTOL * case.options.get("rtol", 1e-3)
    counts = [_counts(case, theirs)]
    if far > allowed or _counts(case, ours) != counts[0]:
        for seed in SEEDS:
            shaken = run(scipy.integrate.solve_ivp, case, _shaken(case.fun, seed), t_span).result
            allowed = max(allowed, OF_SPREAD * distance(shaken, theirs))
            counts.append(_counts(case, shaken))
    same = _counts(case, ours) == counts[0] or len(set(counts)) > 1
    return Verdict(far, allowed, bool(far <= allowed and same))


def _counts(case, result):
    """What must be equal as integers: implicit methods look at differences that rounding makes."""
    events = None if result.t_events is None else tuple(len(times) for times in result.t_events)
    return result.status, events, result.nfev if case.method in EXPLICIT else None


def _shaken(fun, seed):
    rng = np.random.default_rng(seed)

    def shaken(t, y, *args):
        dy = np.asarray(fun(t, y * (1 + EPS * rng.integers(-1, 2, y.shape)), *args))
        return dy * (1 + EPS * rng.integers(-1, 2, dy.shape))

    return shaken
