"""Steps and warnings of a solve at the switching times of its equations: see `trace.switching`.

Steps of fastdyn's own methods end there, as at breakpoints.  The steps of other methods do not: if
one of them jumps over two changes, a warning tells it, once a function and method.  Where nothing
shows a change to the steps, those of all methods end: where event functions switch, and where only
derivatives change that a sweep takes.
"""

import math
from typing import Any

import numpy as np

from fastdyn.compile.callables import codes
from fastdyn.compile.sentences import warn
from fastdyn.kernels.calls.block import FAULT, FIRST
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.kernels.state.record import Y
from fastdyn.problem.events import between_steps
from fastdyn.problem.step_options import last_time, segments_of_members, segments_of_span
from fastdyn.trace.reads.reads import flat

from .timed import SwitchingWarning, Timed, held_of, switches_of, untold, with_trace

TOLD = "told of a lost change"  # a key of a Function's notes
NO_TIMES = np.empty(0)
MOST_KEPT = 16  # segments for other times: samples of an input have few patterns of equal ones
UNKNOWN = (
    "`%s` runs in Python until its code is ready, and its switching times are not known yet: if it "
    "switches with the time, a step may jump over two changes. Solve again later, take `prepare`, "
    "which waits, or give `breakpoints=` or `max_step=`."
)


def switching_of(problem, bound, others=(), python_between=False):
    """The Switching of a solve; None if its functions do not switch, or if it need not know.

    `others` are the functions that are called between steps, first those of the events;
    `python_between` tells whether Python code runs within the solve.
    """
    p = problem
    parts = []
    hidden = []
    if p.mode.residual:  # see `dae/switching.py`
        for place, each in enumerate(others[: len(p.events or ())], 1):
            _tell_unseen(p, place, with_trace(each, len(p.y0)))
        return None
    ends = p.ends_at_switches
    n_pair = len(bound.pair)
    bound, *others = [with_trace(each, len(p.y0)) for each in (bound, *others)]
    held = held_of(bound)
    own = [with_trace(each, len(p.y0)) for each in bound.pair] or [bound]
    compiled = own[0].function is not None
    if not compiled and p.method.error_order and not len(p.segments) and untold(bound, len(p.y0)):
        warn(UNKNOWN % getattr(bound.held.fun, "__name__", "fun"), SwitchingWarning)
    by = p.differentiated if p.method.error_order and not n_pair else ()
    if compiled:
        for place, each in enumerate(own):
            parts.append((place, each, switches_of(each, held, by if ends else ())))
    if by and not ends:
        hidden.append((0, bound, switches_of(bound, (), by)))
    for place, each in enumerate(others[: len(p.events or ())], 1 + n_pair):
        listed = hidden if p.method.error_order else parts  # constant steps end nowhere else
        listed.append((place, each, switches_of(each, held)))
    parts, hidden = (
        [Timed(*each, sharp) for each in listed if each[2] is not None]
        for listed, sharp in ((parts, not ends), (hidden, False))
    )
    switching = Switching(bound, parts, hidden, p, python_between) if parts or hidden else None
    return switching if hidden or (switching and switching.parts) else None


def _tell_unseen(problem, place, bound):
    """Warn, once, of an event function that switches between steps which end at no such times."""
    p = problem
    switches = switches_of(bound)
    if switches is None or place_told(bound, p.method) in _notes_of(bound):
        return
    found = Timed(place, bound, switches, True).times(bound.given, p.y0, p.t0, p.tf, True)
    sharp = np.sort(found.t[found.sharp])
    close = np.flatnonzero(np.diff(sharp) < p.h_max)  # else a step ends between
    if len(close):
        sharp = sharp[close[0] :]
        _notes_of(bound)[place_told(bound, p.method)] = True
        name = getattr(bound.held.fun, "__name__", "an event function")
        warn(
            f"`{name}` changes at t = {sharp[0]:.10g} and t = {sharp[1]:.10g}, and the steps of "
            f"{p.method.name.split()[0]} do not end there: events between may be lost. Take "
            "'Radau', or give `max_step=`.",
            SwitchingWarning
        )  # fmt: skip


def place_told(bound, method, told=TOLD):
    """The key of a note that of a function and a method was told; functions may share code."""
    return told, method.name.removesuffix(ON_PAIRS), codes(bound.held.fun, bound.held.args)


def _notes_of(bound):
    """The notes of compiled equations; of a pair, those of its first part."""
    return (bound.pair or (bound,))[0].function.notes


class Switching:
    """The switching times of the functions of a solve for changing values of their parameters.

    Attributes
    ----------
    ends : bool
        Whether steps end at these times; else they are looked at behind a step.
    hidden : list of Timed
        Functions at whose times the steps of all methods end: what switches there shows nowhere.
    changes, looks : ndarray
        As of `kernels.output.arguments.Output`.
    follows : bool
        Whether actions may change components of the state on which the times depend, or Python code
        that runs within a solve values from outside.
    """

    def __init__(self, bound, parts, hidden, problem, python_between):
        p = problem
        self.parts = parts
        self.hidden = hidden
        self.ends = p.ends_at_switches
        self._bound = bound
        self._method = p.method
        self._told = {each: (_notes_of(each.bound), place_told(each.bound, p.method))
                      for each in parts}  # fmt: skip
        self._last: Any = None
        self._kept: dict = {}  # the last ones
        self._sought: Any = ()  # pairs of a Timed and its Times
        self._forget_told()
        self._asked = p.segments
        self.changes = NO_TIMES
        n_own = max(1, len(bound.pair))
        events = any(each.place >= n_own for each in parts)  # seen at the ends of steps alone
        self.looks = NO_TIMES if events else np.array(p.method.looks)
        self.decides = True  # whether those of the changes that steps look at are left out
        self.held = sorted({i for each in (*parts, *hidden) for i in each.switches.held})
        acts = any(jump is not None for jump in p.jumps)
        self.follows = (bool(self.held) and acts) or python_between
        self._present: Any = None

    def taken(self, problem, bounds):
        """The problem of a solve, whose steps may end at the switching times, too."""
        p = problem
        given = [each.given for each in bounds]
        self._asked = p.segments
        segments, h_max = self.segments(given, p.y0, p.t0, p.tf, p.h_max, p.segments)
        return p._replace(segments=segments, h_max=h_max)

    def segments(self, given, y, t0, tf, h_max, asked):
        """The segments of a span that has the segments `asked` otherwise, and the longest step.

        Where there are too many switching times, those of a first part of the span end steps, and
        no step is longer than the shortest distance between these.  The result is the same object
        if nothing has changed.  `given` are the values of the parameters of each function.
        """
        decides = self.decides
        found = [each.times(given[each.place], y, t0, tf, decides) for each in self.parts]
        hidden = [each.times(given[each.place], y, t0, tf, True) for each in self.hidden]
        key = *map(id, (*found, *hidden)), t0, tf, h_max, id(asked)
        last = self._last
        if last is None or last[0] != key:
            last = self._kept.get(key)
            if last is None:
                if len(self._kept) == MOST_KEPT:
                    self._kept.clear()
                kept = self._segments(found, hidden, t0, tf, h_max, asked)
                pairs = list(zip(self.parts, found, strict=True))
                last = self._kept[key] = key, kept, self.changes, pairs, hidden, asked
            self._last = last
            self.changes, self._sought = last[2:4]
        return last[1]

    def _segments(self, found, hidden, t0, tf, h_max, asked):
        shown = found
        if not self.ends:
            pairs = zip(self.parts, found, strict=True)
            changes = _joined([each.t[each.sharp] for part, each in pairs if self._asks(part)])
            several = len(changes) > 1  # a single change is seen behind it
            self.changes = (changes if tf > t0 else changes[::-1].copy()) if several else NO_TIMES
            known = _joined([each.t for each in found])
            found = []
            shown = hidden
            hidden = [each._replace(t=each.t[~np.isin(each.t, known)]) for each in hidden]
        times = _joined([each.t for each in (*found, *hidden)])
        if not len(times):
            return asked, h_max
        if len(times) > 1 and any(each.end != tf for each in shown):
            h_max = min(h_max, float(np.diff(times).min()))
        times = times if not len(asked) else np.concatenate([times, asked[:-1, 2]])
        return segments_of_span(times, t0, tf), h_max

    def _asks(self, part):
        """Whether nobody was told yet that a step jumped over changes of a function."""
        notes, place = self._told[part]
        return place not in notes

    def _forget_told(self):
        """Look no more for jumps that were told; other times depend on no warning."""
        self._last = None
        self._kept.clear()
        if not (self.ends or self.hidden):
            self.parts = [each for each in self.parts if self._asks(each)]

    def follow(self, run):
        """Let the steps end at the times for the present values of parameters and components.

        Actions, or Python code, may have changed them in the last step.
        """
        y = run.view("solve.work")[Y]
        before, self._present = self._present, self._values(y)
        if before == self._present:
            return
        p = run.problem
        state = run.view("solve.state")[0]
        t = float(state["t"])
        if (p.tf - t) * (p.tf - p.t0) <= 0.0:
            return
        given = [each.given for each in run.bounds]
        asked = rest_of(self._asked, t, p.tf)
        goes_on(run, *self.segments(given, y.copy(), t, p.tf, float(state["h_max"]), asked))

    def begin(self, y):
        """Note the values at the start of a solve, from the state `y`."""
        self._present = self._values(y)

    @property
    def place(self):
        """The values at which the times were sought last, and the changes found."""
        return self._present, self.changes

    @place.setter
    def place(self, place):
        self._present, self.changes = place

    def _values(self, y):
        """The values on which the switching times may depend."""
        blocks = [each.bound.block for each in (*self.parts, *self.hidden)]
        given = [block[FIRST : int(block[FAULT])].tobytes() for block in blocks]
        return y[self.held].tolist(), given

    def doubts(self, record):
        """Whether a step may have jumped over changes of which none is known to matter.

        From then on, it is decided which matter.
        """
        self.decides, before = self.decides or bool(record["jumped"][0]), self.decides
        return self.decides and not before

    def leave_undecided(self):
        """Take all changes as if they mattered, where steps do not end at them."""
        self.decides = self.ends or bool(self.hidden)

    def tell(self, record):
        """Warn, once a function and method, if a step jumped over changes; see `Output`."""
        i = int(record["jumped"][0])
        if not 0 < i < len(self.changes):  # later steps of a Stepper look no more
            return
        a, b = self.changes[i - 1 : i + 1].tolist()
        own = (each.bound for each, times in self._sought if a in times.t)
        bound = next(own, self._bound)  # a copy of a Stepper may have sought other times last
        place = place_told(bound, self._method)
        notes = _notes_of(bound)
        known = place in notes
        notes[place] = True
        self._forget_told()
        if known:
            return
        fun = bound.held.fun
        shorter = f"step={abs(b - a):.2g}"
        if self._method.error_order:
            shorter = f"breakpoints=` or `max_{shorter}"
        warn(
            f"`{getattr(fun, '__name__', 'fun')}` changes at t = {a:.10g} and t = {b:.10g}, and no "
            f"step of {place[1]} looked there: what happens between is lost. Take 'Tsit5', "
            "'Vern9' or 'Rodas5P', whose steps end at such times, or give "
            f"`{shorter}`; where the state decides, events.",
            SwitchingWarning
        )  # fmt: skip

    # -- ensembles

    def _varying(self, members, part):
        """The values that vary between members, by slot, if the times of a Timed depend on any."""
        found = {}
        bound = part.bound
        groups = bound.function.traced.trace.reads.groups
        switches = part.switches
        for j, column in members.varying.items():
            if bound.at[j] is not None:
                found[groups[bound.at[j]].first] = np.asarray(column, float)
        if len(members.y0) > 1:
            found |= {slot: members.y0[:, i].astype(float) for i, slot in switches.held.items()}
        return {k: v for k, v in found.items() if any(k in slots for slots in switches.slots)}

    def segments_of_all(self, problem, members):
        """The problem of an ensemble, its segments, and the first row of each member's.

        A member alone has the same.
        """
        p = problem
        every = [*(self.parts if self.ends else ()), *self.hidden]
        varying = [self._varying(members, each) for each in every]
        count = members.count if any(varying) else 1
        found = []
        for each, own in zip(every, varying, strict=True):
            values = each.switches.values(flat(each.bound.given), members.y0[0])
            found.append(each.switches.times(values, p.t0, p.tf, count, own))
        member = np.concatenate([each.member for each in found])
        times = np.concatenate([each.t for each in found])
        if any(each.end != p.tf for each in found) and len(times) > 1:
            order = np.lexsort((times, member))
            apart = np.diff(times[order])[np.diff(member[order]) == 0]
            p = p._replace(h_max=min(p.h_max, float(apart.min(initial=math.inf))))
        if len(p.segments):
            asked = p.segments[:-1, 2]
            member = np.r_[member, np.repeat(np.arange(count), len(asked))]
            times = np.r_[times, np.tile(asked, count)]
        return p, segments_of_members(member, times, p.t0, p.tf, count)


def rest_of(segments, t, tf):
    """The segments of the rest of a span, from the time t."""
    return segments_of_span(segments[:-1, 2], t, tf) if len(segments) else segments


def goes_on(run, segments, h_max):
    """Let a solve that has begun go on in other segments, with another longest step."""
    run.lay_segments(segments)
    state = run.view("solve.state")[0]
    record = run.view("output.record")[0]
    end = segments[0, 1] if len(segments) else last_time(run.problem.tf)
    state["t_end"] = end
    state["t_stop"] = end
    state["h_max"] = h_max
    record["i_segment"] = 0
    record["i_change"] = 0


def _joined(times):
    """Times of several functions in rising order."""
    if len(times) == 1:
        return times[0]
    return np.sort(np.concatenate(times)) if times else NO_TIMES


def switching_of_members(problem, members, bound):
    """(problem, (segments, first rows) or None) of an ensemble whose function is bound."""
    if not members.count:
        return problem, None
    n = len(problem.y0)
    near = members.near(problem, n)
    watched = between_steps(problem)[: len(problem.events or ())]
    others = [members.bind(function, mode, n, near)[0] for function, mode in watched]
    switching = switching_of(problem, bound, others)
    if switching is None or not (switching.hidden or (switching.ends and switching.parts)):
        return problem, None
    return switching.segments_of_all(problem, members)
