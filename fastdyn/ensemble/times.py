"""Schedules whose times differ from one trajectory to the next."""

import math
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.problem.schedules import Schedule, check_span, listed


class Times:
    """The times of one schedule for all trajectories, in one array."""

    def __init__(self, rows):
        self.all = np.ascontiguousarray(np.concatenate(rows))
        self.counts = np.array([len(row) for row in rows])
        self.begins = np.cumsum(self.counts) - self.counts


def common(events, options, t0, tf, count):
    """The events with the times of one trajectory in each schedule, and a dict of all Times.

    Keys of the dict are positions among the schedules.

    Raises
    ------
    ValueError
        For another number of rows than `count`, and for times outside the span.
    """
    times: dict[int, Times] = {}
    events = listed(events, options)
    schedules = [each for each in events or () if isinstance(each, Schedule)]
    for k, schedule in enumerate(schedules):
        rows = schedule.times
        if not isinstance(rows, list):
            continue
        if len(rows) != count:
            raise ValueError(
                f"`at` has times of {len(rows)} trajectories, and the ensemble has {count}: give "
                "one row for each, or the same times for all."
            )
        for row in rows:
            check_span(row, t0, tf)
        one: Any = Schedule(times=np.concatenate(rows)[:0])
        one.terminal = schedule.terminal
        events = [one if each is schedule else each for each in events or ()]
        times[k] = Times(rows)
    return events, times


def of_members(table, members) -> Any:
    """SCHEDULES records with which each trajectory begins, (M or 1, n_schedules)."""
    if not members.times:
        return table[None]
    records: Any = np.repeat(table[None], members.count, axis=0)
    for k, times in members.times.items():
        mine = records[:, k]
        backwards = table[k]["way"] < 0
        mine["times"] = address_of(times.all) + 8 * times.begins
        mine["next"] = times.counts - 1 if backwards else 0
        mine["end"] = -1 if backwards else times.counts
        has = times.counts > 0
        at = times.begins + mine["next"]
        mine["t_next"] = math.copysign(math.inf, table[k]["way"])
        mine["t_next"][has] = times.all[at[has]]
    return records


def of_member(problem, members, i):
    """The problem with the schedules of trajectory i."""
    schedules = list(problem.schedules)
    for k, times in members.times.items():
        begin = times.begins[i]
        n = int(times.counts[i])
        way = schedules[k].way
        first, end = (n - 1, -1) if way < 0 else (0, n)
        own = times.all[begin : begin + n]
        schedules[k] = schedules[k]._replace(times=own, first=first, end=end)
    return problem._replace(schedules=tuple(schedules))
