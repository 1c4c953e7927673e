"""MinStep: a run ends when its steps would have to be shorter."""

import numpy as np

from fastdyn.run.dense_output import OdeSolution, PiecewisePolynomial


def not_shorter(result, least):
    """
    The result up to the first step that is shorter than `least`; otherwise the whole result.

    The last step, which the end of the span cuts off, may be shorter. So may the first steps, which
    grow from a cautious first guess.
    """
    steps = np.abs(np.diff(result.t))
    enough = steps >= least * (1.0 - 1e-9)
    short = np.flatnonzero(np.logical_or.accumulate(enough)[:-1] & ~enough[:-1])
    if not len(short):
        return result
    n = int(short[0])
    t = float(result.t[n])
    result.message = (
        f"at t = {t:.6g} the tolerances cannot be met without reducing the step size below "
        f"MinStep = {least:g}."
    )
    result.status = -1
    result.success = False
    result.n_accepted = n
    forwards = result.t[-1] >= result.t[0]
    if result.t_events is not None:
        kept = [(times <= t) if forwards else (times >= t) for times in result.t_events]
        pairs = list(zip(result.y_events, kept, strict=True))
        result.t_events = [times[k] for times, k in zip(result.t_events, kept, strict=True)]
        result.y_events = [states[k] if len(states) else states for states, k in pairs]
    result.t, result.y = result.t[: n + 1], result.y[:, : n + 1]
    result.sol = _cut(result.sol, t, forwards) if n else None
    return result


def _cut(sol, t, forwards):
    """The continuous solution up to the end t of a step."""
    n = int(np.sum(sol.ts[1:] <= t if forwards else sol.ts[1:] >= t))
    if isinstance(sol, PiecewisePolynomial):
        return PiecewisePolynomial(sol.ts[: n + 1], sol.polynomials[:n], sol.spans[:n])
    return OdeSolution(sol.ts[: n + 1], sol.interpolants[:n])
