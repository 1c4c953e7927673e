"""The lesson of the cable that cannot push: flight and impact (course 3.3.2, example 4)."""

import math

from fastdyn import plot
from fastdyn.course.tolerances import TIGHT
from fastdyn.systems.cable import Cable

from .pendulum import allowance


def lesson(board):
    board.say(
        """In one call, past the slack: the mass flies freely until the cable is taut again, loses
        its velocity along the cable at once (an inelastic impact) and goes on along the circle.
        Where the tension vanishes, parabola and circle have the same curvature; they meet again
        at -3 times the angle."""
    )
    flights = {}
    for factor in (3.0, 3.5, 4.2):
        cable = Cable(V0=math.sqrt(factor * 9.81))
        run = cable.solve((0.0, 6.0), **TIGHT)
        (_, _, slack), (_, _, taut) = run.phases[:2]
        x, y = run.sol(taut)[:2]
        name = f"V₀² = {factor:g} g l"
        v = cable.l * math.sqrt(-math.cos(cable.slack_angle) * 9.81)
        allowed = 2.0 * allowance(run, cable.by_angle) * (1.0 + 1.0 / v)
        exact = math.remainder(-3.0 * cable.slack_angle, 2.0 * math.pi)
        angle = math.remainder(math.atan2(x, y) - exact, 2.0 * math.pi)
        board.check(f"{name}: slack at (s)", slack, cable.slack_time, allowed)
        board.check(f"{name}: taut again, angle (rad)", exact + angle, exact, allowed)
        flights[name] = run
    board.figure("cable", plot.plot(flights))
