"""The lesson of the tower: how far can a stone be thrown? (course 3.3.2, example 1)"""

import math

import numpy as np

from fastdyn import plot
from fastdyn.course.tolerances import ATOL, RTOL, TIGHT, tolerated
from fastdyn.systems.tower import Tower


def lesson(board):
    thrown = Tower()
    best = Tower(angle=thrown.best_angle)
    board.say(
        """From the Kremlin palace, 71 m, at 25 mph and 45 degrees. The course prints 36 m (118
        ft), which is 25 mph rounded to 11 m/s; exactly 25 mph give 37.10 m (our number). The best
        angle is 16 degrees, since the stone has far to fall: 44.39 m, a fifth farther, where the
        course says that it "won't improve your estimate much"."""
    )
    runs = {}
    for label, tower in (
        ("25 mph at 45°", thrown),
        ("11 m/s at 45°", Tower(V=11.0)),
        ("25 mph at its best angle", best),
    ):
        run = runs[label] = tower.solve(**TIGHT, events="ground", dense_output=True)
        x, _, vx, vz = run.y_events[0][0]
        allowed = tolerated(run) * (1.0 + run.t[-1]) * (1.0 + abs(vx / vz))
        board.check(f"{label}: range (m)", x, tower.range, allowed)
    board.check("11 m/s at 45°: as printed (m)", runs["11 m/s at 45°"].y[0, -1], 36.0, 0.5)
    board.check("best range, from the formula (m)", best.range, thrown.best_range, 1e-12)
    near = [Tower(angle=thrown.best_angle + math.radians(off)).range for off in (-1.0, 1.0)]
    farther = sum(r >= best.range for r in near)
    board.check("throws a degree off that go farther", farther, 0, 0)
    board.figure("tower", plot.plot(runs))
    _monte_carlo(board, thrown)


def _monte_carlo(board, thrown):
    n = 20_000
    spread = {"V": 0.5, "angle": math.radians(3.0)}
    random = np.random.default_rng(71)
    drawn = {name: random.normal(getattr(thrown, name), width, n) for name, width in spread.items()}
    many = thrown.ensemble((0.0, 20.0), events="ground", **TIGHT, **drawn)
    speed = drawn["V"]
    angle = drawn["angle"]
    up = speed * np.sin(angle)
    exact = speed * np.cos(angle) * (up + np.sqrt(up**2 + 2.0 * thrown.g * thrown.h)) / thrown.g
    board.say(
        """Nobody throws twice alike. 20 000 throws with 25 mph give or take 0.5 m/s, at 45 degrees
        give or take 3: the range is uncertain by 2.5 m, and its mean is shorter than that of the
        mean throw, as 45 degrees is too steep and steeper loses more than flatter wins."""
    )
    board.check("throws that landed", (many.status == 1).sum(), n, 0)
    allowed = 1e3 * (ATOL + RTOL * exact.max())
    board.zero("largest error of a range (m)", many.y_end[:, 0] - exact, allowed)
    mean = many.y_end[:, 0].mean()
    deviation = many.y_end[:, 0].std()
    scatter = deviation / math.sqrt(n)
    with board.panel("tower-monte-carlo", (11, 6)) as axes:
        axes.hist(
            many.y_end[:, 0],
            bins=80,
            density=True,
            color=plot.COLOURS[5],
            alpha=0.6,
            label="20 000 throws",
        )
        x = np.linspace(mean - 4 * deviation, mean + 4 * deviation, 200)
        bell = np.exp(-0.5 * ((x - mean) / deviation) ** 2) / (deviation * math.sqrt(2 * math.pi))
        axes.plot(x, bell, label=f"normal, {mean:.2f} ± {deviation:.2f} m")
        axes.set(xlabel="range (m)", ylabel="share of the throws (1/m)")
        near = axes.inset_axes((0.69, 0.45, 0.3, 0.45), yticks=[])
        near.locator_params(axis="x", nbins=4)
        near.set(xlim=(mean - 0.1, thrown.range + 0.1), title="the two means")
        band = {"color": plot.COLOURS[2], "alpha": 0.2, "label": "the mean, ± 2 standard errors"}
        for axes_of_band in (axes, near):  # in the legend, and where it can be seen
            axes_of_band.axvspan(mean - 2 * scatter, mean + 2 * scatter, **band)
        for both in (axes, near):
            both.axvline(mean, color=plot.COLOURS[2], label=f"mean of the throws, {mean:.2f} m")
            about = f"the mean throw, {thrown.range:.2f} m"
            both.axvline(thrown.range, color=plot.COLOURS[1], ls="--", label=about)
