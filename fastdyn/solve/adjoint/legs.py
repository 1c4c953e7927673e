"""The steps of a solve for a sweep back over them, in legs: an action ends a leg."""

import itertools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store import Call
from fastdyn.kernels.methods.adjoint import Steps
from fastdyn.kernels.state.record import Y
from fastdyn.specialise import scalar


class Occurrence(NamedTuple):
    """The occurrence of an event or a schedule, or the time of a schedule.

    `place` is the index among event functions, followed by schedules, `number` counts the
    occurrences of each.  `y` is the state at the time `t`, before the event acts; `acted` tells
    whether it does.
    """

    place: int
    number: int
    t: float
    y: np.ndarray
    acted: bool


class Leg(NamedTuple):
    """Steps from the initial state, or from the state that an action returned.

    Attributes
    ----------
    t : ndarray, shape (n_steps + 1,)
        The times of the steps as the output has them.  The last one is the end of a whole step,
        also if an event ends the leg within the step.
    steps : Steps
    rows : ndarray, shape (n_kept,)
    states : ndarray, shape (n_kept, n)
        The states after rows[i] steps.  The first one is the state at the start.
    seen : list of Occurrence
        Occurrences within the leg.
    ends : list of Occurrence
        Occurrences at the end, from the first one on that acts.
    """

    t: np.ndarray
    steps: Any
    rows: np.ndarray
    states: np.ndarray
    seen: list
    ends: list

    @property
    def is_whole(self):
        """Whether all states are kept."""
        return len(self.rows) == len(self.t)


def leg_of(problem, t, rows, states, seen=(), ends=()):
    """A Leg; its first time is that of the start of the solve, or that of an action."""
    n_steps = len(t) - 1
    steps = Steps(*np.empty((3, n_steps)), np.empty(n_steps, np.int64))
    Call(scalar.steps_kernel(), t, problem.segments, *steps)()
    if not problem.method.error_order:
        steps.h[:] = problem.h if problem.tf >= problem.t0 else -problem.h
    return Leg(t, steps, rows, states, list(seen), list(ends))


def legs_of(run):
    """The legs of a Keeping run that has reached the end."""
    p = run.problem
    times, rows, states, behind = run.output.rows()
    t = np.concatenate([[p.t0], times])
    cuts = [0, *behind.tolist(), len(t)]
    legs = []
    for i, (seen, ends) in enumerate(occurrences_of(run, t[behind].tolist())):
        first, end = cuts[i : i + 2]
        own = slice(*np.searchsorted(rows, (first, end)))
        legs.append(leg_of(p, t[first:end], rows[own] - first, states[own], seen, ends))
    return legs


def steps_in(plan, memory, n_eval, t0, y0, shared):
    """The times and states of the steps of a solve in its memory, which others may `share`."""
    (end,) = plan.counts("n_out")(memory)
    n = plan.n
    of_t = plan.arrays["output.t"][0]
    of_y = plan.arrays["output.y"][0]
    t = memory[of_t + n_eval : of_t + end]
    y = memory[of_y + n_eval * n : of_y + end * n]
    t[0] = t0
    y[:n] = y0
    return t.copy(), (y.copy() if shared else y).reshape(-1, n)


def leg_in(problem, t, states):
    """The legs of a solve without events, from the times and states of its steps."""
    return [leg_of(problem, t, np.arange(len(t)), states)]


def outputs_of(legs, t, each_step):
    """The slice of the outputs at the times t that belongs to each leg.

    The outputs are each step, with the states behind actions, or given times.
    """
    if len(legs) == 1:
        return [slice(0, len(t))]
    sign = 1.0 if t[-1] >= t[0] else -1.0
    cuts = []
    behind = iter((np.flatnonzero(sign * np.diff(t) <= 0.0) + 1).tolist())
    for leg in legs[:-1]:
        if each_step and any(each.acted for each in leg.ends):
            cuts.append(next(behind))
        else:
            cuts.append(int(np.searchsorted(sign * t, sign * leg.ends[0].t, "right")))
    return [slice(*each) for each in itertools.pairwise([0, *cuts, len(t)])]


def end_with_step(leg, run):
    """The Leg of all steps of a run that an event ended, whose last step has its whole length."""
    end = float(run.view("solve.state")["t"][0])
    leg.t[-1] = leg.steps.end[-1] = end
    if run.problem.method.error_order:
        leg.steps.h[-1] = end - leg.steps.t[-1]
    if leg.is_whole:
        leg.states[-1] = run.view("solve.work")[Y]


def occurrences_of(run, times=()):
    """For each leg, the occurrences within it, and those at its end.

    `times` are those of the actions.  Behind the time of a schedule, constant steps begin anew, as
    if an action had changed nothing.
    """
    p = run.problem
    if not (p.events or p.schedules):
        return [([], [])]
    n_events = len(p.events or ())
    jumps = p.jumps
    found = []
    counts = [0] * len(jumps)
    for place, t, y in zip(*run.output.found_so_far(), strict=True):
        place = int(place)
        found.append(Occurrence(place, counts[place], float(t), y.copy(), jumps[place] is not None))
        counts[place] += 1
    legs = []
    i = 0
    for t in times:
        first = i
        while not (found[i].t == t and (found[i].acted or found[i].place >= n_events)):
            i += 1
        start = i
        own = found[i]
        i = i + 1
        while i < len(found) and _at(found[i], own, n_events):
            i += 1
        legs.append((found[first:start], found[start:i]))
    return [*legs, _last(found[i:], n_events)]


def _at(other, own, n_events):
    """Whether an occurrence belongs to the action of another one, which is before it."""
    if other.t != own.t:
        return False
    if own.place >= n_events:
        return other.place >= n_events
    return not other.acted and np.array_equal(other.y, own.y)


def _last(found, n_events):
    """The occurrences within the last leg, and at its end.

    The last occurrence of a run that an event ends does not act, but schedules at the same time may
    have acted before it.
    """
    for i, each in enumerate(found[:-1]):
        if each.acted and each.place >= n_events:
            return found[:i], [*found[i:-1], found[-1]._replace(acted=False)]
    return [each._replace(acted=False) for each in found], []
