"""A pendulum whose cable cannot push: taut along the circle, slack in free flight."""

# ruff: noqa: E741 - the course calls the length l
import math

import numpy as np

from fastdyn.phases import Phase, solve_phases
from fastdyn.systems.declare import event
from fastdyn.systems.pendulum_xy import PendulumXY, slack, tension


def falling(t, w, g, l, V0, m, rate):
    """Derivative of the state in free flight, while the cable is slack."""
    return [w[2], w[3], 0.0, g]


@event(direction=1, terminal=True)
def taut(t, w, g, l, V0, m, rate):
    """Zero, and rising, where the slack cable is stretched again."""
    x, y, _, _ = w
    return x * x + y * y - l * l


def after_slack(t, w, *parameters):
    """The mass flies on from where it is."""
    return "flight", w


def after_flight(t, w, *parameters):
    """The cable stops the velocity along itself, which is lost; then it pulls, or not at all."""
    w = PendulumXY.project(t, w, *parameters)
    return ("cable" if tension(t, w, *parameters) > 0.0 else "flight"), w


def solve_cable(system, t_span, y0, method, **options):
    """Solve a `PendulumXY` in phases; see `PendulumXY.solve_cable`."""
    options = {"rtol": 1e-6, "atol": 1e-9, "dense_output": True} | options
    t_span = (0.0, system.t_end) if t_span is None else t_span
    start = np.array(system.initial_state() if y0 is None else y0, dtype=float)
    phases = {
        "cable": Phase(system.rhs, slack, after_slack, {"project": system.project}),
        "flight": Phase(falling, taut, after_flight),
    }
    on_circle = start @ start > 0.0 and math.hypot(start[0], start[1]) >= system.l
    pulls = on_circle and tension(0.0, start, *system.args) > 0.0
    first = "cable" if pulls else "flight"
    run = solve_phases(phases, first, t_span, start, method, args=system.args, **options)
    run.system = system._as_started(t_span[0], system.initial_state()[:1])  # no exact solution
    return run
