"""Steps and warnings of a solve at the switching times of its equations: see `trace.switching`.

Steps of fastdyn's own methods end there, as at breakpoints.  The steps of other methods do not: if
one of them jumps over two changes, a warning tells it, once a function.  Where only derivatives
change that a sweep takes, nothing else shows the change to the steps: those of all methods end.
"""

import math
from typing import Any

import numpy as np

from fastdyn.compile.callables import codes
from fastdyn.compile.derivatives.sensitivities import slots_of
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.problem.step_options import segments_of_members, segments_of_span
from fastdyn.trace.reads.reads import flat
from fastdyn.trace.switching.divisions import MOST_TOLD

from .deciding import Deciding

KEPT, TOLD = "switching times", "told of a lost change"  # keys of a Function's notes
NO_TIMES = np.empty(0)


class SwitchingWarning(UserWarning):
    """A step jumped over changes of the function, and the method looked at no time between them."""


def switching_of(problem, bound):
    """The Switching of a solve; None if its equations do not switch, or if it need not know."""
    p, function = problem, bound.function
    if function is None or function.traced is None or bound.pair or p.mode.residual:
        return None
    ends, hidden = p.ends_at_switches, None
    told = not p.method.looks or _place_told(bound) in function.notes
    if not ends and told and not p.differentiated:
        return None
    switches = function.traced.switches
    if switches is None:
        return None
    if p.differentiated:
        hidden = _with_derivatives(bound, p.differentiated)
    return Switching(bound, switches, hidden, ends, p.method)


def _with_derivatives(bound, positions):
    """The Switches of a function and of its derivatives by the arguments at positions."""
    traced = bound.function.traced
    groups = tuple([bound.at[j - 1] for j in positions])
    slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, 0)]
    return bound.function.derived((KEPT, groups), lambda: traced.switches_by(slots))


def _place_told(bound):
    """The key of a note that a function was told of; functions may share machine code."""
    return TOLD, codes(*bound.keepalive[:2])


class Switching:
    """The switching times of a function for changing values of its parameters.

    Attributes
    ----------
    ends : bool
        Whether steps end at these times; else they are looked at behind a step.
    changes, looks : ndarray
        As of `kernels.output.arguments.Output`.
    """

    def __init__(self, bound, switches, hidden, ends, method):
        self._switches, self._hidden = switches, hidden
        self._bound, self._notes, self.ends = bound, bound.function.notes, ends
        self._name = method.name.removesuffix(ON_PAIRS)
        self.changes, self.looks = NO_TIMES, np.array(method.looks)
        self.decides = True  # whether those of the changes that steps look at are left out
        self._deciding = {
            each: Deciding(bound, each, not ends) for each in (switches, hidden) if each
        }
        begin, self._groups = 0, {each: [] for each in self._deciding}
        for i, group in enumerate(bound.function.traced.trace.reads.groups):
            end = begin + (1 if group.shape is None else math.prod(group.shape))
            for each, groups in self._groups.items():
                if any(slots.start < end and slots.stop > begin for slots in each.slots_of_times):
                    groups.append(i)
            begin = end
        self._last: Any = None

    def taken(self, problem, given):
        """The problem of a solve, whose steps may end at the switching times, too."""
        p = problem
        segments, h_max = self.segments(given, p.t0, p.tf, p.h_max, p.segments)
        return p._replace(segments=segments, h_max=h_max)

    def segments(self, given, t0, tf, h_max, asked):
        """The segments of a span that has the segments `asked` otherwise, and the longest step.

        Where there are too many switching times, those of a first part of the span end steps, and
        no step is longer than the shortest distance between these.  The result is the same object
        if nothing has changed.
        """
        found = [self._times(each, given, t0, tf) for each in self._deciding]
        key = *map(id, found), t0, tf, h_max, id(asked)
        if self._last is None or self._last[0] != key:
            kept = self._segments(*found, t0=t0, tf=tf, h_max=h_max, asked=asked)
            self._last = key, kept, found, asked
        return self._last[1]

    def _segments(self, found, hidden=None, *, t0, tf, h_max, asked):
        if not self.ends:
            changes = found.t[found.sharp]
            several = len(changes) > 1  # a single change is seen behind it
            self.changes = (changes if tf > t0 else changes[::-1].copy()) if several else NO_TIMES
        if hidden is not None:
            shown = found.t if not self.ends else NO_TIMES
            found = hidden._replace(t=hidden.t[~np.isin(hidden.t, shown)])
        if not len(found.t) or not (self.ends or hidden is not None):
            return asked, h_max
        times = found.t if not len(asked) else np.r_[found.t, asked[:-1, 2]]
        if found.end != tf and len(found.t) > 1:
            h_max = min(h_max, float(np.diff(found.t).min()))
        return segments_of_span(times, t0, tf), h_max

    def _times(self, switches, given, t0, tf):
        """The Times of Switches in a span; the last ones are kept."""
        found = self._candidates(switches, given, t0, tf)
        deciding = self._deciding[switches]
        return deciding.times(found, given) if self.decides else deciding.all_of(found)

    def doubts(self, record):
        """Whether a step may have jumped over changes of which none is known to matter.

        From then on, it is decided which matter.
        """
        self.decides, before = self.decides or bool(record["jumped"][0]), self.decides
        return self.decides and not before

    def leave_undecided(self):
        """Take all changes as if they mattered, where steps do not end at them."""
        self.decides = self.ends or bool(self._hidden)

    def _candidates(self, switches, given, t0, tf):
        """The Candidates in a span; the last ones of the function are kept."""
        values = [given[i] for i in self._groups[switches]]
        key = [v.tobytes() if isinstance(v, np.ndarray) else v for v in values]
        most = None if self.ends else MOST_TOLD
        place = KEPT, most, switches
        of_values, of_span, grids, found = self._notes.get(place, (None,) * 4)
        if of_values != key:
            of_span, grids = None, switches.grids(flat(given))
        if of_span != (t0, tf):
            values = None if grids else flat(given)
            found = switches.candidates(values, t0, tf, most=most, grids=grids)
            self._notes[place] = key, (t0, tf), grids, found
        return found

    def tell(self, bound, record):
        """Warn, once a function, if a step jumped over changes; `record` is of the output."""
        i, place = int(record["jumped"][0]), _place_told(bound)
        if not i or place in self._notes:
            return
        self._notes[place] = True
        fun = bound.keepalive[0]
        a, b = self.changes[i - 1 : i + 1].tolist()
        warn(
            f"`{getattr(fun, '__name__', 'fun')}` changes at t = {a:.10g} and t = {b:.10g}, and no "
            f"step of {self._name} looked there: what happens between is lost. Take 'auto', "
            "'Tsit5', 'Vern9' or 'Rodas5P', whose steps end at such times, or give `breakpoints=` "
            f"or `max_step={abs(b - a):.2g}`; where the state decides, events.",
            SwitchingWarning
        )  # fmt: skip

    # -- ensembles

    def varying(self, members, bound):
        """The values of parameters that vary between members, by slot, if the times depend on any.

        `bound` is the equations' as bound for the members.
        """
        found = {}
        groups = bound.function.traced.trace.reads.groups
        for j, column in members.varying.items():
            if bound.at[j] is not None:
                found[groups[bound.at[j]].first] = np.asarray(column, float)
        return {k: v for k, v in found.items() if any(k in slots for slots in self._switches.slots)}

    def segments_of_all(self, problem, members, bound):
        """The problem of an ensemble, its segments, and the first row of each member's.

        A member alone has the same.
        """
        p, varying = problem, self.varying(members, bound)
        count = members.count if varying else 1
        found = self._switches.times(flat(bound.given), p.t0, p.tf, count, varying)
        member, times = found.member, found.t
        if found.end != p.tf and len(times) > 1:
            apart = np.diff(times)[np.diff(member) == 0]
            p = p._replace(h_max=min(p.h_max, float(apart.min(initial=math.inf))))
        if len(p.segments):
            asked = p.segments[:-1, 2]
            member = np.r_[member, np.repeat(np.arange(count), len(asked))]
            times = np.r_[times, np.tile(asked, count)]
        return p, segments_of_members(member, times, p.t0, p.tf, count)


def switching_of_members(problem, members, bound):
    """(problem, (segments, first rows) or None) of an ensemble whose function is bound."""
    switching = switching_of(problem, bound) if members.count else None
    if switching is None or not switching.ends:
        return problem, None
    return switching.segments_of_all(problem, members, bound)
