"""The run of a reduced system through its choices of states."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.algebra.linear import SingularMatrixError
from fastdyn.run.outcome import SUCCESS
from fastdyn.run.result import OdeResult
from fastdyn.solve.ivp import solve_ivp

from .start import Unsolved, consistent
from .trajectory import MANY, Solution, components, places

ROOM = 100.0  # growth, in that at the choice, at which states are chosen anew
MOST, FAST = 20, 1e-3  # so many choices in this share of the longest time of one are too many
SINGULAR = (
    "The equations are singular between t = {:.8g} and t = {:.8g}: their index changes there, or "
    "there is no solution beyond; or steps are too long for a choice of states: reduce `max_step`."
)
COUNTS = ("nfev", "njev", "nlu", "n_accepted", "n_rejected")


class Segment(NamedTuple):
    """A run with one choice of states, of which the times up to `end` count.

    `own` is the number of events before those of the user.
    """

    found: Any
    chosen: Any
    own: int
    end: float


def run(reduction, t_span, z, method, t_eval, dense_output, events, args, options):
    """The OdeResult from a consistent start z, all orders of all components."""
    (t, tf), segments, log = t_span, [], []
    seen, steps_left = [0] * len(events), options.pop("max_steps", None)
    while True:
        chosen, growth = reduction.choose(t, z)
        log.append((t, chosen.states))
        own = [] if chosen.pivots is None else [_terminal(chosen.pivots)]
        watched = [_of_components(e, reduction, k) for e, k in zip(events, seen, strict=True)]
        given = dict(options, project=chosen.projection) if chosen.projection else dict(options)
        if steps_left is not None:
            given["max_steps"] = steps_left
        found = _solved(
            reduction.motion, (t, tf), reduction.state_of(z), method,
            dense_output=dense_output or t_eval is not None, events=[*own, *watched],
            args=(reduction.parameters(1 / (1 + ROOM * max(1.0, growth))), *args), **given,
        )  # fmt: skip
        last = _last(reduction.system, chosen, found, own)
        segments.append(Segment(found, chosen, len(own), float(found.t[last])))
        if _accumulate(log, float(found.t[last])):
            found.status, found.message = -1, SINGULAR.format(t, float(found.t[-1]))
        if found.status < 0 or last == len(found.t) - 1 and not _chooses(found, own):
            break
        t = float(found.t[last])
        if t == tf:
            found.status, found.message = 0, SUCCESS
            break
        counts = [len(_until(times, segments[-1])) for times in found.t_events[len(own) :]]
        seen = [k + more for k, more in zip(seen, counts, strict=True)]
        steps_left = steps_left and max(1, steps_left - last)
        options.pop("first_step", None)
        z = _consistent_again(reduction.system, t, found.y[:, last])
    return _joined(reduction, segments, log, t_eval, dense_output, len(events))


def _accumulate(log, t):
    """Whether the choices, the last up to t, come ever faster, as towards a singularity."""
    if len(log) <= MOST:
        return False
    times = np.array([each for each, _ in log] + [t])
    return abs(t - times[-1 - MOST]) < FAST * np.abs(np.diff(times)).max()


def _solved(*given, **options):
    try:
        return solve_ivp(*given, **options)
    except SingularMatrixError as error:
        raise Unsolved(
            f"the equations become singular on the way ({error}): their index changes there, or "
            "there is no solution beyond."
        ) from None


def _chooses(found, own):
    """Whether the run ended because states have to be chosen anew."""
    return bool(own) and found.status == 1 and len(found.t_events[0]) > 0


def _last(system, chosen, found, own):
    """The number of the last step end that counts; a singularity before ends the run.

    Where a determinant changes its sign, the states no longer determine what follows from them;
    if so within the first step after a choice, there is no choice.
    """
    end = len(found.t) - 1
    if _chooses(found, own):
        # the step that ended at the pivots is taken again: its middle is less exact than its ends
        end -= 1 if end > 1 else 0
    changed, whole = _sign_changes(system, chosen, found, end)
    if changed == 1 or whole == changed < end + 1:
        found.status = -1
        found.message = SINGULAR.format(float(found.t[changed - 1]), float(found.t[changed]))
    return min(end, changed - 1)


def _sign_changes(system, chosen, found, end):
    """The first step ends where a determinant, and where that of the whole matrix, has changed."""
    first = whole = end + 1
    for k in range(0, end + 1, MANY):
        t, y = found.t[k : min(k + MANY, end + 1)], found.y[:, k : min(k + MANY, end + 1)]
        z = np.zeros(((system.levels() + 1) * system.given.n, len(t)))
        z[places(system)] = y
        matrices = system.matrices(t, z)
        parts = [matrices, *(matrices[:, d.rows][:, :, d.follow] for d in chosen.depths)]
        signs = np.array([np.linalg.slogdet(part)[0] for part in parts])
        start = signs[:, :1] if k == 0 else start
        changed = [np.flatnonzero(row) for row in signs != start]
        whole = min([whole, *(k + changed[0][:1])])
        first = min([first, *(k + np.concatenate([at[:1] for at in changed]))])
        if first <= end:
            break
    return int(first), int(whole)


def _until(times, segment):
    """The times of a segment that count."""
    times = np.asarray(times, float)
    sign = np.sign(segment.found.t[-1] - segment.found.t[0])
    return times[sign * times <= sign * segment.end]


def _consistent_again(system, t, x):
    z = np.zeros((system.levels() + 1) * system.given.n)
    z[places(system)] = x
    return consistent(system, t, z, ())


def _terminal(pivots):
    event: Any = functools.partial(pivots)
    event.terminal, event.direction = True, -1.0
    return event


def _of_components(event, reduction, occurred):
    """An event of y as an event of the reduced state, after occurrences in earlier segments."""
    all_components = reduction.components

    def watched(t, x, p, *args):
        return event(t, np.array(all_components(t, x, p)), *args)

    found: Any = watched
    found.direction = getattr(event, "direction", 0)
    terminal = getattr(event, "terminal", None)
    if terminal:
        found.terminal = terminal if occurred == 0 else int(terminal) - occurred
    return found


def _joined(reduction, segments, log, t_eval, dense_output, n_events):
    system, last = reduction.system, segments[-1].found
    sol = None
    if last.sol is not None:
        sol = Solution(system, [(s.found.sol, s.end, s.chosen.depths) for s in segments])
    if t_eval is None:
        t, y = _steps(system, segments)
    else:
        sign = np.sign(last.t[-1] - segments[0].found.t[0])
        t = t_eval[sign * t_eval <= sign * segments[-1].end]
        y = sol(t) if len(t) and sol else np.empty((system.given.n, 0))
    events = [_events_of(system, segments, i) for i in range(n_events)]
    return OdeResult(
        t=t,
        y=y,
        sol=sol if dense_output else None,
        t_events=[times for times, _ in events],
        y_events=[states for _, states in events],
        status=last.status,
        message=last.message,
        success=last.status >= 0,
        index=reduction.index,
        differentiated=reduction.differentiated,
        states=log,
        **{name: sum(segment.found[name] for segment in segments) for name in COUNTS},
    )


def _steps(system, segments):
    """The ends of all steps, and the components there."""
    t, y = [], []
    for i, segment in enumerate(segments):
        times = _until(segment.found.t, segment)
        t.append(times[min(i, 1) :])
        y.append(components(system, t[-1], segment.found.y[:, min(i, 1) : len(times)]))
    return np.concatenate(t), np.concatenate(y, axis=1)


def _events_of(system, segments, i):
    """Times (k,) and states (k, n) of event i of the user."""
    times, states = [np.empty(0)], [np.empty((0, system.given.n))]
    for segment in segments:
        at = _until(segment.found.t_events[segment.own + i], segment)
        if len(at):
            x = np.asarray(segment.found.y_events[segment.own + i], float)[: len(at)].T
            times.append(at)
            states.append(components(system, at, x, segment.chosen.depths).T)
    return np.concatenate(times), np.concatenate(states)
