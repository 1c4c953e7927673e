"""Where a fit starts: trial values, screened by the solutions of an ensemble."""

import contextlib

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble
from fastdyn.problem.members import Shared

from .free import Template

WIDE = 30.0  # ratio of bounds beyond which starts are spread evenly in the logarithm
FACTOR = 10.0  # by which starts of one sign without bounds are spread up and down
REFINED = 4  # of the screened starts, beside the user's own
IN_ENSEMBLES = frozenset(("method", "rtol", "atol", "max_step", "max_steps", "step"))


def starts_of(starts, parameters):
    """Trial coordinates, shape (m, n_parameters); the first are those of the user's own values."""
    p = parameters
    if isinstance(starts, int | np.integer) and not isinstance(starts, bool):
        if starts < 1:
            raise ValueError(f"`starts` must be at least 1; got {starts}.")
        return p.coordinates(np.vstack([p.start, spread(int(starts) - 1, p)]))
    try:
        found = np.atleast_2d(np.asarray(starts, float))
    except (TypeError, ValueError):
        found = np.empty((0, 0))
    if found.ndim != 2 or found.shape[-1] != len(p.names) or not np.isfinite(found).all():
        raise ValueError(
            f"`starts` must be a number of starts, or finite values of shape (m, {len(p.names)}), "
            f"in the order {', '.join(p.names)}."
        )
    if not ((p.low <= found) & (found <= p.high)).all():
        raise ValueError("`starts` has values outside of the bounds of their Free.")
    return p.coordinates(np.vstack([p.start, found]))


def spread(m, parameters):
    """m values of all parameters in their bounds, in a Latin hypercube; the same ones each time."""
    p = parameters
    rng = np.random.default_rng(0)
    n = len(p.names)
    ranks = np.array([rng.permutation(m) for _ in range(n)]).reshape(n, m).T
    u = (ranks + rng.random((m, n))) / max(m, 1)
    found = np.empty((m, n))
    for i in range(n):
        low = p.low[i]
        high = p.high[i]
        start = p.start[i]
        if np.isfinite(low) and np.isfinite(high):
            logarithmic = low > 0 and (p.log[i] or high > WIDE * low)
            found[:, i] = (
                low * (high / low) ** u[:, i] if logarithmic else low + (high - low) * u[:, i]
            )
        elif (start > 0 and low >= 0) or (start < 0 and high <= 0):
            found[:, i] = start * FACTOR ** (2 * u[:, i] - 1)
        else:
            found[:, i] = start + (2 * u[:, i] - 1) * (abs(start) or 1.0)
    return np.clip(found, p.low, p.high)


def best_first(model, trials):
    """The user's own start, then the best of the other trials by their sums of squares."""
    if len(trials) <= 2:
        return trials
    chi2 = screened(model, trials[1:])
    order = np.argsort(chi2, kind="stable")
    return np.vstack([trials[0], trials[1:][order[np.isfinite(chi2[order])][:REFINED]]])


def screened(model, trials):
    """The sum of squares of each trial; inf where a motion fails."""
    total = np.array([model.of_priors(x) for x in trials])
    for k in range(len(model.records)):
        total += _of_record(model, k, trials, model.motions[k].options)
    return np.where(np.isfinite(total), total, np.inf)


def _of_record(model, k, trials, options):
    record = model.records[k]
    motion = model.motions[k]
    given = [motion.places.at(model.parameters.values(x)) for x in trials]
    states = [None] * len(trials)
    if _in_lanes(motion.places) and options.keys() <= IN_ENSEMBLES:
        columns = zip(*[args for _, args in given], strict=True)
        args = [
            np.array(column) if isinstance(place, Template) else _common(place)
            for place, column in zip(motion.places.args, columns, strict=True)
        ]
        with contextlib.suppress(ArithmeticError, ValueError):  # the function raises for one trial
            states = solve_ensemble(
                motion.fun, (record.t0, record.times[-1]), np.array([y0 for y0, _ in given]),
                args=tuple(args), t_eval=record.times, **options,
            ).y  # fmt: skip
    found = np.empty(len(trials))
    for i, (x, y) in enumerate(zip(trials, states, strict=True)):
        found[i] = model.trial(k, x, y)
    return found


def _in_lanes(places):
    """Whether an ensemble takes the arguments that vary: numbers."""
    varies = any(isinstance(a, Template) and a.index.ndim for a in places.args)
    return not (varies or isinstance(places.t0, Template))


def _common(value):
    return Shared(value) if isinstance(value, np.ndarray | list) else value
