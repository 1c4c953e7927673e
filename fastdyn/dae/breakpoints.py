"""Breakpoints of F: steps end there, and what F determines jumps there.

A breakpoint is a time of a schedule: the step before ends a few roundings earlier, as those of
`solve_ivp`, and the state behind is consistent with F a few roundings later.
"""

import numpy as np

from fastdyn.problem.schedules import Scheduled, segments


class Breakpoints:
    """The breakpoints of a problem, whose rows of segments tell the times."""

    def __init__(self, problem):
        self._rows = problem.segments
        self._ends = problem.segments[:-1, 1].copy()
        self._watched = problem.events is not None

    @classmethod
    def of(cls, problem, options):
        """The Breakpoints, or None where there are none inside the span."""
        asked = options.get("breakpoints") is not None
        return cls(problem) if asked and len(problem.segments) > 1 else None

    def scheduled(self, problem, again):
        """The problem with a schedule in the place of the segments.

        There ``again(t, state)`` acts, with the first time behind the breakpoint: it returns a
        consistent state.
        """
        p = problem
        n = len(self._ends)
        rising = self._ends if p.tf >= p.t0 else self._ends[::-1].copy()
        indices = (0, n, 1) if p.tf >= p.t0 else (n - 1, -1, -1)
        place = len(p.events or ()) + len(p.schedules)

        def jump(t, state, *_):
            start = float(self._rows[1 + np.argmin(np.abs(self._ends - t)), 0])
            return again(start, state)

        more = Scheduled(place, rising, *indices, 0.0, 0.0, 0, jump)
        whole = segments({}, (more,), p.t0, p.tf, False)
        return p._replace(schedules=(*p.schedules, more), segments=whole)

    def of_result(self, result):
        """The result with the times of the breakpoints, and without the schedule's own events."""
        for at, time in zip(self._ends, self._rows[:-1, 2], strict=True):
            result.t = np.where(np.asarray(result.t) == at, time, result.t)
        if self._watched:
            for name in ("t_events", "y_events", "yp_events"):
                result[name] = result[name][:-1]
        return result
