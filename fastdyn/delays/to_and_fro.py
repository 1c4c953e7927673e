"""Times of the past that run to and fro within their tolerance, and the sentence about them.

A delay that depends on the state is as uncertain as the state.  Where components as small as their
absolute tolerances decide how fast the time of the past moves, each step may move this time to
where another step did not: steps are tiny, and the result says nothing.
"""

import numpy as np

from fastdyn.kernels.output import arguments as words

from .past import history_of
from .points import read_at

BLOCK = 256  # steps in a row that are examined
TURNS = 8  # least number of times that a time of the past turns back in a block
# The least way back of a time of the past, in units of the time that passes.  By Tsit5, Vern7,
# Vern9 and Rodas5P at 1e-2 and 1e-3, Waltman's thresholds crawl with 20 to 5000.
WAY = 10.0
SMALL = 10.0  # tolerances up to which a component is small
FEW = 3  # small components that are named
SENTENCE = (
    "From t = {t:.10g} on, a time for which `past` is asked runs to and fro within its tolerance: "
    "components that are known no better decide a delay{small}. Give each component an `atol` far "
    "below its size, or a smaller `rtol`."
)


def told_of(run, n_last=None):
    """The sentence about the last steps of a DelayRun, or about all steps; "" without one."""
    t, y = run.steps(n_last)
    read = read_at(run.bounds[0], t, y)
    if read is None:  # unknown before the function is called
        t = t[-BLOCK:]
        y = y[:, -BLOCK:]
        read = _asked(run, t, y)
    p = run.problem
    slack = run.laid_out[words.PAST_SLACK] * np.maximum(np.abs(t), t - p.t0)
    at = to_and_fro(t, read, slack)
    if at is None:
        return ""
    y = y[:, at]
    n = len(y)  # without sensitivities
    atol = np.broadcast_to(p.atol, len(p.y0))[:n]
    tolerance = atol + np.broadcast_to(p.rtol, len(p.y0))[:n] * np.abs(y)
    small = np.flatnonzero((y != 0.0) & (np.abs(y) <= SMALL * tolerance))[:FEW]
    named = [f"component {i} is {y[i]:.1e}, its tolerance {tolerance[i]:.1e}" for i in small]
    return SENTENCE.format(t=t[at], small=f" ({'; '.join(named)})" if named else "")


def _asked(run, t, y):
    """The times for which the function asks at steps, (k, m); k = 0 if they vary in number."""
    p = run.problem
    each = []
    for time, state in zip(t.tolist(), y.T, strict=True):
        with history_of(run.laid_out).asked() as times:
            p.fun(time, state.copy(), *p.args)
        each.append(times)
    alike = len({len(times) for times in each}) == 1
    return np.array(each).T if alike else np.empty((0, len(t)))


def to_and_fro(t, read, slack):
    """The step from which on a time of the past runs to and fro; None if none does.

    Parameters
    ----------
    t : ndarray, shape (m,)
        Times of steps.
    read : ndarray, shape (k, m)
        The times for which the past is asked there.
    slack : ndarray, shape (m,)
        The uncertainty of these times.
    """
    for times in read:
        move = np.diff(times)
        back = np.concatenate([[False], move < 0.0, [False]])
        begins = np.flatnonzero(back[1:] & ~back[:-1])
        ends = np.flatnonzero(back[:-1] & ~back[1:])
        depth = times[begins] - times[ends]
        small = depth <= slack[begins]
        begins = begins[small]
        depth = depth[small]
        if len(begins) < TURNS:
            continue
        for first in range(0, len(t) - 1, BLOCK):
            last = min(first + BLOCK, len(t) - 1)
            within = (begins >= first) & (begins < last)
            way = depth[within].sum()
            if np.count_nonzero(within) >= TURNS and way > WAY * (t[last] - t[first]):
                return first
    return None
