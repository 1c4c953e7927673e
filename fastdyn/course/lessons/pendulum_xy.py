"""The lesson of the constraint: the dreaded pendulum revisited (course 3.3.3, example 4)."""

import math

import numpy as np

from fastdyn import plot
from fastdyn.course.tolerances import TIGHT, tolerated
from fastdyn.kernels.algebra.linear import SingularMatrixError, solve_linear
from fastdyn.systems.pendulum_xy import PendulumXY


def lesson(board):
    _the_same_motion(board)
    _drift(board)
    _velocities(board)


def _growth(run):
    """By how much an error may grow: an error of the velocity changes the period too."""
    w0 = math.sqrt(run.system.g / run.system.l)
    return (1.0 + w0 + 1.0 / w0) * (1.0 + w0 * run.t[-1])


def _the_same_motion(board):
    board.say(
        """The pendulum once more, in x and y, with the tension as a third unknown: three linear
        equations at each evaluation. It must be the motion by the angle, tension included."""
    )
    for V0 in (0.1, 4.0):
        system = PendulumXY(V0=V0)
        run = system.solve(**TIGHT, project=True)
        allowed = tolerated(run) * _growth(run)
        name = f"V0 = {V0:g} m/s"
        board.zero(f"{name}: error of the state", run.error(), allowed)
        by_angle = system.by_angle
        exact = by_angle.along(by_angle.quantities["tension"], run.t, by_angle.exact(run.t))
        error = run.quantities()["tension"] - exact
        steep = 2.0 * system.m * (V0 / system.l + system.g / system.l)
        board.zero(f"{name}: error of the tension (N)", error, steep * allowed)


def _drift(board):
    system = PendulumXY(V0=4.0)
    periods = 10_000
    t_end = periods * system.period
    board.say(
        f"""With the accelerations constrained and nothing else, the mass leaves the circle step
        by step. Projection takes it back after each step, to rounding; Baumgarte's pull keeps it
        near. RK45 at rtol 1e-6 over {periods} periods:"""
    )
    t_eval = np.linspace(0.0, t_end, 1001)
    last = {}
    runs = {}
    ways = {
        "accelerations only": (system, False),
        "Baumgarte": (system.baumgarte(), False),
        "projection": (system, True),
    }
    for name, (held, project) in ways.items():
        run = held.solve((0.0, t_end), project=project, t_eval=t_eval, max_steps=10**7)
        off = {key: np.abs(values).max() for key, values in run.residuals().items()}
        last[name] = off["circle"]
        runs[name] = held.solve((0.0, 20.0), project=project, dense_output=True)
        tolerance = {
            "accelerations only": tolerated(run, 1e-6, 1e-9) / system.l,
            "Baumgarte": 1e-4,
            "projection": 4.0 * np.finfo(float).eps,
        }[name]
        board.check(f"{name}: distance from the circle (m)", off["circle"], 0.0, tolerance)
        if name == "projection":
            tolerance *= np.abs(run.y[2:]).max()
            board.check("projection: velocity across (m/s)", off["across"], 0.0, tolerance)
    worse = last["accelerations only"] > 1e6 * last["projection"]
    board.check("drift without, at least 1e6 times (1 if so)", worse, 1, 0)
    board.figure("pendulum-constraint", plot.plot(runs))


def _velocities(board):
    message = "none"
    try:
        velocity_matrix(0.6, 0.8, 0.4, -0.3)
    except SingularMatrixError as error:
        message = str(error)
    board.say(
        f"""Constraining the velocity instead, x x' + y y' = 0, fails: x' and y' are already
        given by the first two of the five equations, and the last then says nothing of x'', y''
        and R. MATLAB prints warnings and NaN; here: "{message}"."""
    )
    board.check("an error is raised (1 if so)", message != "none", 1, 0)


def velocity_matrix(x, y, vx, vy, m=1.0, g=9.81, l=1.0):  # noqa: E741
    """The course's five equations, with the constraint on the velocities."""
    rows = (
        (1.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, m, 0.0, x / l),
        (0.0, 0.0, 0.0, m, y / l),
        (x, y, 0.0, 0.0, 0.0),
    )
    return solve_linear(rows, (vx, vy, 0.0, m * g, 0.0))
