"""Steps and warnings of a solve at the switching times of its equations: see `trace.switching`.

Steps of fastdyn's own methods end there, as at breakpoints.  The steps of other methods do not: if
one of them jumps over two changes, a warning tells it, once a function.
"""

import math
import warnings

import numpy as np

from fastdyn.compile.callables import codes
from fastdyn.compile.sentences import levels_inside
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.problem.step_options import segments_of_members, segments_of_span
from fastdyn.trace.reads.reads import flat
from fastdyn.trace.switching.divisions import MOST_TOLD

KEPT, TOLD = "switching times", "told of a lost change"  # keys of a Function's notes
NO_TIMES = np.empty(0)


class SwitchingWarning(UserWarning):
    """A step jumped over changes of the function, and the method looked at no time between them."""


def switching_of(problem, bound):
    """The Switching of a solve; None if its equations do not switch, or if it need not know."""
    p, function = problem, bound.function
    if function is None or function.traced is None or bound.pair or p.mode.residual:
        return None
    ends = p.ends_at_switches
    if not ends and (not p.method.looks or _place_told(bound) in function.notes):
        return None
    switches = function.traced.switches
    return None if switches is None else Switching(bound, switches, ends, p.method)


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

    def __init__(self, bound, switches, ends, method):
        self._switches, self._notes, self.ends = switches, bound.function.notes, ends
        self._name = method.name.removesuffix(ON_PAIRS)
        self.changes, self.looks = NO_TIMES, np.array(method.looks)
        begin, self._groups = 0, []  # on which the times depend
        for i, group in enumerate(bound.function.traced.trace.reads.groups):
            end = begin + (1 if group.shape is None else math.prod(group.shape))
            if any(slots.start < end and slots.stop > begin for slots in switches.slots):
                self._groups.append(i)
            begin = end

    def key(self, given, t0, tf):
        """The values and the span, on which the switching times depend."""
        found = [given[i] for i in self._groups]
        return t0, tf, *[v.tobytes() if isinstance(v, np.ndarray) else v for v in found]

    def taken(self, problem, given):
        """The problem of a solve, whose steps may end at the switching times, too."""
        p = problem
        segments, h_max = self.segments(given, p.t0, p.tf, p.h_max, p.segments)
        return p._replace(segments=segments, h_max=h_max)

    def segments(self, given, t0, tf, h_max, asked):
        """The segments of a span that has the segments `asked` otherwise, and the longest step.

        Where there are too many switching times, those of a first part of the span end steps, and
        no step is longer than the shortest distance between these.
        """
        found = self._times(given, t0, tf)
        if not self.ends:
            changes = found.t[found.sharp]
            several = len(changes) > 1  # a single change is seen behind it
            self.changes = (changes if tf > t0 else changes[::-1].copy()) if several else NO_TIMES
            return asked, h_max
        times = found.t if not len(asked) else np.r_[found.t, asked[:-1, 2]]
        if found.end != tf and len(found.t) > 1:
            h_max = min(h_max, float(np.diff(found.t).min()))
        return segments_of_span(times, t0, tf), h_max

    def _times(self, given, t0, tf):
        """The Times in a span; the last ones are kept."""
        key = self.key(given, t0, tf)
        kept = self._notes.get((KEPT, self.ends))
        if kept is None or kept[0] != key:
            most = None if self.ends else MOST_TOLD
            kept = self._notes[KEPT, self.ends] = (
                key,
                self._switches.times(flat(given), t0, tf, most=most),
            )
        return kept[1]

    def tell(self, bound, record):
        """Warn, once a function, if a step jumped over changes; `record` is of the output."""
        i, place = int(record["jumped"][0]), _place_told(bound)
        if not i or place in self._notes:
            return
        self._notes[place] = True
        fun = bound.keepalive[0]
        a, b = self.changes[i - 1 : i + 1].tolist()
        warnings.warn(
            f"`{getattr(fun, '__name__', 'fun')}` changes at t = {a:.10g} and t = {b:.10g}, and no "
            f"step of {self._name} looked there: what happens between is lost. Take 'auto', "
            "'Tsit5', 'Vern9' or 'Rodas5P', whose steps end at such times, or give `breakpoints=` "
            f"or `max_step={abs(b - a):.2g}`; where the state decides, events.",
            SwitchingWarning, stacklevel=levels_inside(),
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
