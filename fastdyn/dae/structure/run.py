"""The run of a reduced system through its choices of states."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.run.outcome import SUCCESS
from fastdyn.run.result import OdeResult
from fastdyn.solve.ivp import solve_ivp

from .start import consistent
from .trajectory import Solution, components, places

ROOM = 100.0  # growth, in that at the choice, at which states are chosen anew
MOST = 10_000  # choices in one run
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
    while len(segments) < MOST:
        chosen, growth = reduction.choose(t, z)
        log.append((t, chosen.states))
        own = [] if chosen.pivots is None else [_terminal(chosen.pivots)]
        watched = [_of_components(e, reduction, k) for e, k in zip(events, seen, strict=True)]
        given = dict(options, project=chosen.projection) if chosen.projection else dict(options)
        if steps_left is not None:
            given["max_steps"] = steps_left
        found = solve_ivp(
            reduction.motion, (t, tf), reduction.state_of(z), method,
            dense_output=dense_output or t_eval is not None, events=[*own, *watched],
            args=(reduction.parameters(1 / (1 + ROOM * max(1.0, growth))), *args), **given,
        )  # fmt: skip
        if not own or found.status != 1 or not len(found.t_events[0]):
            segments.append(Segment(found, chosen, len(own), found.t[-1]))
            break
        # the step that ended at the pivots is taken again: its middle is less exact than its ends
        again = -2 if len(found.t) > 2 and method != "Taylor" else -1
        t, x = float(found.t[again]), found.y[:, again]
        segments.append(Segment(found, chosen, len(own), t))
        if t == tf:
            found.status, found.message = 0, SUCCESS
            break
        counts = [len(_until(times, segments[-1])) for times in found.t_events[1:]]
        seen = [k + more for k, more in zip(seen, counts, strict=True)]
        steps_left = steps_left and max(1, steps_left - found.n_accepted)
        options.pop("first_step", None)
        z = _consistent_again(reduction.system, t, x)
    else:
        found.status, found.message = -1, f"The states were chosen {MOST} times, up to t = {t:.6g}."
    return _joined(reduction, segments, log, t_eval, dense_output, len(events))


def _until(times, segment):
    """The times of a segment that count."""
    times = np.asarray(times, float)
    sign = np.sign(segment.end - segment.found.t[0])
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
        sign = np.sign(segments[-1].end - segments[0].found.t[0])
        t = t_eval[sign * t_eval <= sign * segments[-1].end]
        y = sol(t) if len(t) else np.empty((system.given.n, 0))
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
