"""The lesson of the tower: how far can a stone be thrown? (course 3.3.2, example 1)"""

import dataclasses
import math

from fastdyn import plot
from fastdyn.systems.marks import tolerated
from fastdyn.systems.tower import Tower

RTOL, ATOL = 1e-9, 1e-12


def lesson(board):
    """Tell the lesson to a board of `fastdyn.tour`."""
    thrown = Tower()
    rounded = dataclasses.replace(thrown, V=11.0)
    best = dataclasses.replace(thrown, angle=thrown.best_angle)
    board.say(
        """From the Kremlin palace, 71 m, at 25 mph and 45 degrees. The course prints 36 m, which
        is 25 mph rounded to 11 m/s; exactly 25 mph give 37.10 m. The best angle is 16 degrees,
        since the stone has far to fall."""
    )
    board.head()
    ranges = {}
    runs = {}
    for label, tower, printed in (
        ("25 mph at 45°", thrown, 37.10),
        ("11 m/s at 45°", rounded, 36.40),
        ("25 mph at its best angle", best, 44.39),
    ):
        run = runs[label] = tower.solve(rtol=RTOL, atol=ATOL, events="ground", dense_output=True)
        x, _, vx, vz = run.y_events[0][0]
        allowed = tolerated(run, RTOL, ATOL) * (1.0 + run.t[-1]) * (1.0 + abs(vx / vz))
        ranges[label] = x
        board.check(f"{label}: range (m)", x, tower.range, allowed)
        board.check(f"{label}: as published (m)", x, printed, 0.5e-2)
    board.check("best range, from the formula (m)", best.range, thrown.best_range, 1e-12)
    near = [
        dataclasses.replace(thrown, angle=thrown.best_angle + math.radians(off)).range
        for off in (-1.0, 1.0)
    ]
    farther = sum(r >= best.range for r in near)
    board.check("throws a degree off that go farther", farther, 0, 0)
    board.figure("tower", plot.plot(runs))
