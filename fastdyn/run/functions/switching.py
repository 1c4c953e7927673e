"""What a solve does at the switching times of its equations: see `trace.switching`.

Steps of fastdyn's own methods end there, as at breakpoints.
"""

import math

import numpy as np

from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.problem.step_options import segments_of_members, segments_of_span
from fastdyn.problem.validate import SHARED_METHODS
from fastdyn.trace.reads.reads import flat

KEPT = "switching times"  # a key of a Function's notes


def switching_of(problem, bound):
    """The Switching of a solve; None if its equations do not switch, or its steps do not end."""
    p = problem
    if not p.ends_at_switches or not p.method.error_order or p.method.like_matlab:
        return None
    name = p.method.name.removesuffix(ON_PAIRS)
    if name in SHARED_METHODS or p.mode.residual or bound.pair:
        return None
    traced = bound.function and bound.function.traced
    return Switching(bound, traced.switches) if traced and traced.switches else None


class Switching:
    """The switching times of a function for changing values of its parameters.

    `groups` has the places of the parameters' values, as of `Bound.given`, on which the times
    depend.
    """

    def __init__(self, bound, switches):
        self._switches, self._notes, self._asked = switches, bound.function.notes, None
        slots, begin, self.groups = set(switches.slots), 0, []
        for i, group in enumerate(bound.function.traced.trace.reads.groups):
            end = begin + (1 if group.shape is None else math.prod(group.shape))
            if not slots.isdisjoint(range(begin, end)):
                self.groups.append(i)
            begin = end

    def key(self, given, t0, tf):
        """What the times depend on: the values and the span."""
        found = [given[i] for i in self.groups]
        return t0, tf, *[v.tobytes() if isinstance(v, np.ndarray) else v for v in found]

    def times(self, given, t0, tf):
        """The Times in a span; the last ones are kept."""
        key = self.key(given, t0, tf)
        kept = self._notes.get(KEPT)
        if kept is None or kept[0] != key:
            kept = self._notes[KEPT] = key, self._switches.times(flat(given), t0, tf)
        return kept[1]

    def taken(self, problem, given):
        """A problem whose steps end at the switching times, too."""
        p = problem
        segments, h_max = self.segments(given, p.t0, p.tf, p.h_max, p.segments)
        return p._replace(segments=segments, h_max=h_max)

    def segments(self, given, t0, tf, h_max, asked=()):
        """The segments of a span that has the segments `asked` otherwise, and the longest step.

        Where there are too many switching times, those of a first part of the span end steps, and
        no step is longer than the shortest distance between these.
        """
        found = self.times(given, t0, tf)
        times = found.t if not len(asked) else np.r_[found.t, asked[:-1, 2]]
        if found.end != tf and len(found.t) > 1:
            h_max = min(h_max, float(np.diff(found.t).min()))
        return segments_of_span(times, t0, tf), h_max

    def varying(self, members, bound):
        """The values of parameters that vary between members, by slot."""
        found = {}
        groups = bound.function.traced.trace.reads.groups
        for j, column in members.varying.items():
            if bound.at[j] is not None:
                found[groups[bound.at[j]].first] = np.asarray(column, float)
        return {slot: found[slot] for slot in found if slot in self._switches.slots}

    def segments_of_all(self, problem, members, bound):
        """The problem of an ensemble, its segments, and the first row of each member's.

        A member alone has the same.
        """
        p, varying = problem, self.varying(members, bound)
        count = members.count if varying else 1
        given = flat(bound.given), p.t0, p.tf, count, varying
        found = self._switches.times(*given)
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
    if switching is None:
        return problem, None
    return switching.segments_of_all(problem, members, bound)
