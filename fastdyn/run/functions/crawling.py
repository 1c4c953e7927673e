"""What a solution does along switches, in sentences; and whether steps crawl along a switch.

A step over a jump of the slope by f has an error of some h f, so that steps in a row across a
switch stay within few tolerances of a straight line, while the slope jumps to and fro.  Steps that
accuracy limits leave the line by thousands of tolerances; those that stability limits stay near,
too, but there the slope goes on changing away from the line.
"""

import numpy as np

from fastdyn.kernels.methods.method import ON_PAIRS

MOST = 100_000  # steps after which runs are examined: a solution that is resolved takes thousands
LATER = 0.1  # a run is examined again after so many times all steps so far: 80 times in 10^8
SAMPLES = 64  # steps in a row that are examined
MOST_NUMBERS = 2**22  # of the states of these steps; larger states are not examined
# Largest distances from the line in 32 to 1000 steps, in tolerances, by Tsit5, RK45, DOP853, LSODA,
# Radau and Rodas5P: 88 on switches; 940 of a relay about the level 20 with rtol = 1e-3.
STRAIGHT = 100.0
FLIPS = 3  # times that the slope changes sides
# The change of the slope times the time, in distances from the line: a kink has 4, a parabola 8,
# twisting by Tsit5 170.
TO_AND_FRO = 20.0
WIDE = 100.0  # times a distance at which a slope that saturates is looked at
# The share of WIDE times its change that a slope changes there: friction v / |v| that crawls at
# |v| = 9 tolerances has 0.12, the reaction of Robertson 1.6.
SATURATES = 0.25

# Methods that count the steps that `beyond` in kernels/stepping/implicit.py tells.
BY_NEWTON = "Radau", "BDF"
# A run is told of from so many such steps on, and from this share of all: the fast oscillations of
# the ring modulator have 1 to 6 in 20 000, friction v / |v| with a guard 1 in 75 where it is lost.
LEAST_BEYOND = 3
LEAST_SHARE = 1e-3

SMOOTH = "make the change smooth, tanh(v / w) for sign(v), say"
WIDER = "make the change smooth over a larger width, v / sqrt(v**2 + w**2)"
SENTENCES = {
    "slides": "At t = {t:.6g} the solution switches back and forth: both sides of a condition "
    "point at the other. {advice} an event or hysteresis.",
    "twists": "At t = {t:.6g} the solution has come to a point on {k} switches of `fun` at once, "
    "ever faster from one to the next (as with a twisting controller: second-order sliding): end "
    f"the solve by a terminal event before, or {SMOOTH}.",
    "changes": "At t = {t:.6g} the solution changes sides for ever at a condition of `fun`, "
    f"within few tolerances: {SMOOTH}, or end the solve by an event before.",
    "crawls": "At t = {t:.6g} `fun` changes as at a switch, such as v / |v|, within few "
    f"tolerances: no implicit method helps there. {WIDER.capitalize()}, or end the solve by an "
    "event.",
    "beyond": "{k} of them change the state more than `fun` does in their time: do not trust the "
    "result. Newton's iteration ended far from a solution, as beside a switch such as v / |v|: "
    f"{WIDER}, or take Tsit5 or RK45.",
}


def counts_beyond(problem):
    """Whether `n_standing` counts steps that change the state more than the equations do."""
    return problem.mass is None and problem.method.name.removesuffix(ON_PAIRS) in BY_NEWTON


class Samples:
    """States of steps in a row, from step MOST on.

    Parameters
    ----------
    judge : callable
        ``judge(times, states)`` of SAMPLES steps tells what they show, and returns whether the
        steps crawl; not called again then.
    """

    def __init__(self, judge):
        self._judge = judge
        self._from = MOST
        self._taken: list = []

    def left(self, done):
        """The number of steps up to the next state that is taken, after `done` steps."""
        return max(1, self._from - done)

    def take(self, done, t, y):
        """Take the state after `done` steps; the steps to the end, if they crawl, else None."""
        if done < self._from or len(y) * SAMPLES > MOST_NUMBERS:
            return None
        if self._taken and self._taken[-1][0] == t:  # a step was taken back, at a border
            return None
        self._taken.append((t, y.copy()))
        if len(self._taken) < SAMPLES:
            return None
        times, states = map(np.array, zip(*self._taken, strict=True))
        self._taken = []
        self._from = done + int(LATER * done)
        if not self._judge(times, states):
            return None
        self._from = np.inf
        return abs(times[-1] - times[0]) / (SAMPLES - 1)


def crawl(times, states, tolerance, slope=None):
    """Whether steps in a row, the states (m, n), crawl where the slope jumps.

    `tolerance` is that of each component, ``slope(y)`` the slope at the last time: it jumps across
    the line, whereas along the line it may oscillate, as in revolutions that are much faster than
    their change of speed.  Without it, the slopes are those of the steps.
    """
    if not (np.isfinite(states).all() and times[-1] != times[0]):
        return False
    along = ((times - times[0]) / (times[-1] - times[0]))[:, None]
    across = states - states[0] - along * (states[-1] - states[0])
    apart = np.abs(across).max(axis=0) / tolerance
    if not apart.max() <= STRAIGHT:
        return False
    if slope is None:
        slopes = np.diff(states, axis=0) / np.diff(times)[:, None]
    else:
        slopes = np.array([slope(states[-1] + each) for each in across])
    change = np.ptp(slopes, axis=0)
    moves = change * abs(times[-1] - times[0]) / tolerance
    i = int(np.argmax(moves))  # NaN, if there is one
    above = slopes[:, i] > slopes[:, i].min() + 0.5 * change[i]
    if not (moves[i] > TO_AND_FRO * apart[i] and np.count_nonzero(np.diff(above)) >= FLIPS):
        return False
    return slope is None or saturates(slope, states[-1], slopes[:, i], across, i)


def saturates(slope, y, values, across, i):
    """Whether component i of a slope, with these values across y, hardly changes beyond them."""
    far = WIDE * (across[np.argmax(values)] - across[np.argmin(values)])
    changes = [abs(slope(y + way * far)[i] - slope(y)[i]) for way in (1.0, -1.0)]
    return bool(max(changes) < SATURATES * WIDE * np.ptp(values))
