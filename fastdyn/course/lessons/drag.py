"""The lesson of air resistance: no formula, but checks (course 3.3.3, example 1)."""

import numpy as np

from fastdyn import plot
from fastdyn.course.tolerances import TIGHT, tolerated
from fastdyn.systems.drag import Drag


def lesson(board):
    board.say(
        """The vertical throw has an exact solution, a tangent on the way up and a hyperbolic
        tangent on the way down; drag shrinks errors of the velocity. In general there is none,
        but the energy can only decrease, and without drag the parabola must come out."""
    )
    for name, ball in (
        ("upwards at 20 m/s", Drag(vx0=0.0, vy0=0.0)),
        ("dropped", Drag(vx0=0.0, vy0=0.0, vz0=0.0, z0=100.0)),
        ("downwards at 20 m/s", Drag(vx0=0.0, vy0=0.0, vz0=-20.0, z0=100.0)),
        ("without drag", Drag(c=0.0)),
    ):
        run = ball.solve(**TIGHT)
        allowed = tolerated(run) * (1.0 + run.t[-1])
        board.zero(f"{name}: error of the state", run.error(), allowed)
    ball = Drag()
    run = ball.solve(**TIGHT, dense_output=True)
    gained = np.diff(run.quantities()["energy"]).max()
    board.check("largest gain of energy in a step (m²/s²)", max(gained, 0.0), 0.0, 0.0)
    tight = ball.solve(method="DOP853", rtol=1e-12, atol=1e-14, t_eval=[5.0])
    allowed = tolerated(run) * (1.0 + run.t[-1])
    error = run.y[:, -1] - tight.y[:, -1]
    board.zero("end of the course's throw, RK45 less DOP853", error, 2.0 * allowed)
    late = Drag(z0=1e3).solve((0.0, 20.0), **TIGHT)
    fall = -late.y[5, -1]
    board.check("terminal speed (m/s)", fall, ball.terminal_speed, 1e-6)
    shown = {
        "without drag": ball.in_vacuum,
        "with drag, c = 0.5/m": ball,
        "with drag, and a wind of 5 m/s": Drag(wx=-5.0),
    }
    runs = {
        label: one.solve(**TIGHT, events="ground", dense_output=True)
        for label, one in shown.items()
    }
    board.figure("projectile-drag", plot.plot(runs))
    _landing(board, runs["with drag, c = 0.5/m"], run)


def _landing(board, landed, through):
    """How fast it is on the ground, and at the end of the course's run."""
    speed, late = (r.quantities()["speed"][-1] for r in (landed, through))
    thrown = 10.0 * 6**0.5
    board.say(
        f"""Thrown at {thrown:.1f} m/s, the ball lands after {landed.t[-1]:.3f} s at {speed:.3f}
        m/s. At t = 5 s the course's run is {-through.y[2, -1]:.1f} m below the ground, at
        {late:.3f} m/s: nearly the terminal speed."""
    )
    fine = landed.system.solve(method="DOP853", rtol=1e-12, atol=1e-14, events="ground")
    allowed = 2.0 * tolerated(landed) * (1.0 + landed.t[-1]) * (1.0 + landed.system.g)
    exact = fine.quantities()["speed"][-1]
    board.check("speed of the landing (m/s), less DOP853", speed, exact, allowed)
