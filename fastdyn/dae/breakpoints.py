"""Breakpoints of F: steps end there, and what F determines jumps there.

A breakpoint is a time of a schedule: the step before ends a few roundings earlier, as those of
`solve_ivp`, and the state behind is consistent with F a few roundings later.  So do the methods of
`solve_ivp` for a reduced state, whose steps also begin these roundings later.
"""

import numpy as np

from fastdyn.problem.schedules import Scheduled, segments


class Breakpoints:
    """The breakpoints of a problem, whose rows of segments tell the times."""

    def __init__(self, problem):
        self._rows = problem.segments
        self._ends = problem.segments[:-1, 1].copy()
        self._way = 1.0 if problem.tf >= problem.t0 else -1.0
        self._watched = problem.events is not None

    @classmethod
    def of(cls, problem, options):
        """The Breakpoints, or None where there are none inside the span."""
        asked = options.get("breakpoints") is not None
        return cls(problem) if asked and len(problem.segments) > 1 else None

    def scheduled(self, problem, again, behind=False):
        """The problem with a schedule in the place of the segments.

        There ``again(t, state)`` acts, with the first time behind the breakpoint: it returns a
        consistent state.  With `behind` the segments stay, and the next step begins at that time.
        """
        p = problem
        n = len(self._ends)
        times = self._rows[:-1, 2].copy() if behind else self._ends
        rising = times if p.tf >= p.t0 else times[::-1].copy()
        indices = (0, n, 1) if p.tf >= p.t0 else (n - 1, -1, -1)
        place = len(p.events or ()) + len(p.schedules)

        def jump(t, state, *_):
            start = float(self._rows[1 + np.argmin(np.abs(times - t)), 0])
            return again(start, state)

        more = Scheduled(place, rising, *indices, 0.0, 0.0, 0, jump)
        whole = self._rows if behind else segments({}, (more,), p.t0, p.tf, False)
        return p._replace(schedules=(*p.schedules, more), segments=whole)

    def before(self, t):
        """Times, but a breakpoint is the end of the step before it."""
        place = self._place(t)
        return np.where(place < 0, t, self._ends[place])

    def beside(self, t):
        """Times of a result, but a breakpoint is the end of a step, or the start of the next."""
        found = self.before(t)
        place = self._place(t)
        again = np.r_[False, np.diff(t) == 0.0] & (place >= 0)
        return np.where(again, self._rows[1 + place, 0], found)

    def _place(self, t):
        """The number of the breakpoint at each time, from the end of the step before; -1 beside."""
        way = self._way
        u = way * np.asarray(t, float)
        place = np.searchsorted(way * self._ends, u, side="right") - 1
        return np.where(u < way * self._rows[1 + place, 0], place, -1)

    def of_result(self, result):
        """The result with the times of the breakpoints, and without the schedule's own events."""
        for at, time in zip(self._ends, self._rows[:-1, 2], strict=True):
            result.t = np.where(np.asarray(result.t) == at, time, result.t)
        if self._watched:
            for name in ("t_events", "y_events", "yp_events"):
                result[name] = result[name][:-1]
        return result
