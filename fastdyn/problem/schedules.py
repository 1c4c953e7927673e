"""Schedules: times known beforehand, in the place of an event function."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.words.kinds import shown

from . import events as functions
from .step_options import NO_SEGMENTS, segments_of_span

SHORTHANDS = ("at", "every")
OF_EVENTS = {"on_event", *SHORTHANDS}


class Schedule:
    """Times at which a step ends; `at` and `every` make schedules.

    Attributes
    ----------
    times : ndarray or None
        The times, in rising order; None for times at equal distances.
    period, start : float or None
        The distance of the times, and the first time; without `start`, the start of the run.
    terminal : bool or int
        As of an event function.
    """

    terminal: bool | int = False

    def __init__(self, times=None, period=None, start=None):
        self.times = times
        self.period = period
        self.start = start

    def __repr__(self):
        if self.times is not None:
            return f"at({np.array2string(np.asarray(self.times), threshold=6)})"
        start = "" if self.start is None else f", start={self.start}"
        return f"every({self.period}{start})"


def at(times):
    """Make a schedule of given times, to stand among the `events` of a solve.

    Parameters
    ----------
    times : array_like, shape (k,)
        Times in rising order, within the span.  For ensembles also shape (M, k), or a list of M
        sequences: times of each trajectory.

    Raises
    ------
    ValueError, TypeError
        For times that are not finite, not in order, or repeated.

    Notes
    -----
    A step ends exactly at each time, and the function of `on_event` acts there.  A time at
    the start of the span acts at the start; a time at the end is left to the run that goes on.
    """
    rows, several = _rows(times)
    for row in rows:
        _check_times(row, times)
    return Schedule(times=rows if several else rows[0])


def every(period, start=None):
    """Make a schedule of the times ``start + k * period``, k = 0, 1, 2, ...

    Parameters
    ----------
    period : float
        Above zero.
    start : float, optional
        The first time.  By default the times begin at the start of the run, and follow in the
        direction of the run.  With a `start` before the run, parts of a span have equal times.

    Raises
    ------
    ValueError, TypeError
        For a period that is not above zero, and for what is no finite number.
    """
    period = _number("every", period)
    start = None if start is None else _number("start", start)
    if not period > 0.0:
        raise ValueError(f"`every` must be a time above zero; got {period}.")
    return Schedule(period=period, start=start)


def _number(name, value):
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"`{name}` must be a number; got {value!r}.") from None
    if not math.isfinite(number):
        raise ValueError(f"`{name}` must be a finite number; got {number}.")
    return number


def _rows(times):
    """The times as a list of arrays, and whether each trajectory has an array of its own."""
    try:
        several = len(times) > 0 and np.ndim(times[0]) == 1
        rows = [np.array(row, dtype=float) for row in (times if several else [times])]
    except (TypeError, ValueError, KeyError):
        raise TypeError(f"`at` must be a sequence of times; got {times!r}.") from None
    if any(row.ndim != 1 for row in rows):
        raise ValueError("`at` must be a 1-D sequence of times, or one for each trajectory.")
    return rows, several


def _check_times(row, given):
    if not np.isfinite(row).all():
        raise ValueError(f"the times of `at` must be finite; got {given!r}.")
    wrong = np.flatnonzero(np.diff(row) <= 0.0)
    if wrong.size:
        early, late = row[wrong[0] : wrong[0] + 2]
        how = "is there twice" if early == late else f"comes before {late}"
        raise ValueError(f"the times of `at` must be in rising order, each once; {early} {how}.")


class Scheduled(NamedTuple):
    """A schedule in a span, at `place` among the events.

    Its times have the indices from `first` on, in steps of `way`, 1 or -1, up to but not including
    `end`: indices of `times`, or numbers k of ``start + k * period``.
    """

    place: int
    times: Any
    first: int
    end: int
    way: int
    start: float
    period: float
    limit: int
    jump: Any

    def first_time(self, direction):
        """The first time of the run; infinite, with the sign of the direction, without one."""
        if self.first == self.end:
            return math.copysign(math.inf, direction)
        if self.times is not None:
            return float(self.times[self.first])
        return self.start + self.first * self.period


ENDLESS = 2**62  # index behind all times at equal distances


def in_span(schedule, t0, tf):
    """(times, first, end, way, start, period) of a Scheduled."""
    low = min(t0, tf)
    high = max(t0, tf)
    backwards = tf < t0
    if schedule.times is not None:
        times = check_span(schedule.times, t0, tf)
        n = len(times)
        return times, *((n - 1, -1, -1) if backwards else (0, n, 1)), 0.0, 0.0
    start = schedule.start
    period = schedule.period
    far = max(abs(t) for t in (t0, tf) if math.isfinite(t))
    if period < 4.0 * math.ulp(far):
        raise ValueError(f"`every={period}` is no more than the spacing of times near t = {far}.")
    if start is None:
        return None, 0, ENDLESS, 1, t0, -period if backwards else period
    if start > high:
        raise ValueError(f"`every` starts at {start}, behind the span from {low} to {high}.")
    k = max(0, round((t0 - start) / period))
    if backwards:
        k += start + (k + 1) * period <= t0
        return None, k - (start + k * period > t0), -1, -1, start, period
    k -= k > 0 and start + (k - 1) * period >= t0
    return None, k + (start + k * period < t0), ENDLESS, 1, start, period


def check_span(times, t0, tf):
    """The times; ValueError if one lies outside the span."""
    low = min(t0, tf)
    high = max(t0, tf)
    if isinstance(times, list):
        raise ValueError("`at` has times of several trajectories: these are for solve_ensemble.")
    outside = times[(times < low) | (times > high)]
    if outside.size:
        where = "before the start" if outside[0] < low else "behind the end"
        raise ValueError(
            f"`at` has the time {outside[0]}, {where} of the span from {low} to {high}."
        )
    return times


def listed(events, options) -> Any:
    """The events as a list, followed by the schedules of `at` and `every`; None without any."""
    times, periods = [options.get(name) for name in SHORTHANDS]
    if isinstance(events, Schedule | functions.Event) or callable(events):
        events = [events]
    found = _sequence(events)
    if times is None and periods is None:
        return None if events is None else found
    if times is not None:
        several = isinstance(times, list | tuple) and len(times) and np.ndim(times[0]) > 0
        found += [at(each) for each in times] if several else [at(times)]
    if periods is not None:
        found += [every(each) for each in ([periods] if np.ndim(periods) == 0 else periods)]
    return found


def _sequence(events):
    """The events of a sequence of functions and schedules as a list; TypeError for another kind."""
    try:
        found = list(() if events is None else events)
    except TypeError:
        found = [events]
    if isinstance(events, str):
        found = [events]
    for event in found:
        if not (callable(event) or isinstance(event, Schedule | functions.Event)):
            raise TypeError(
                "`events` must be a function of (t, y), or a sequence of functions; got "
                f"{shown(event)}."
            )
    return found


def refuse_schedules(events, advice):
    """Raise ValueError if a schedule stands among the events."""
    for event in listed(events, {}) or ():
        if isinstance(event, Schedule):
            raise ValueError(f"{event!r} cannot stand among the events here; {advice}.")


def divided(events, options, t0, tf) -> tuple[Any, tuple]:
    """(Events, Scheduled ones), all checked; None in place of the Events without any event."""
    found = listed(events, options)
    checked = functions.acting(options.get("on_event"), functions.event_list(found))
    if found is None:
        return checked, ()
    plain = []
    schedules = []
    for place, event in enumerate(checked):
        given = event.function
        if isinstance(given, Schedule):
            schedules.append(Scheduled(place, *in_span(given, t0, tf), event.limit, event.act))
        else:
            plain.append(event)
    return plain, tuple(schedules)


def checked(events, options, t0, tf):
    """The result of `divided`; ValueError for actions with a `callback`, and for an endless run."""
    if events is None and OF_EVENTS.isdisjoint(options):
        functions.endless(tf, None, options.get("max_steps"))
        return None, ()
    found, scheduled = divided(events, options, t0, tf)
    acts = any(event.act for event in found or ())
    if (acts or scheduled) and options.get("callback") is not None:
        said = "`on_event`" if acts else "a schedule"
        raise ValueError(f"{said} and `callback` do not go together: a step may end in two states.")
    functions.endless(tf, found, options.get("max_steps"), scheduled)
    return found, scheduled


def segments(options, schedules, t0, tf, constant_steps):
    """The segments of a span, at least one with schedules; constant steps have no `breakpoints`."""
    breakpoints = None if constant_steps else options.get("breakpoints")
    if breakpoints is None and not schedules:
        return NO_SEGMENTS
    return segments_of_span(() if breakpoints is None else breakpoints, t0, tf)


def in_order(of_functions, schedules, of_schedules):
    """The values of event functions and of schedules as one list, in the order of the events."""
    found = list(of_functions)
    for schedule, each in zip(schedules, of_schedules, strict=True):
        found.insert(schedule.place, each)
    return found
