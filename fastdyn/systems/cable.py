"""A pendulum whose cable cannot push: taut along the circle, slack in free flight."""

# ruff: noqa: E741 - the course calls the length l
import math

import numpy as np

from fastdyn.solve.phases import Phase, solve_phases
from fastdyn.systems.base.declare import event

from .pendulum_xy import PendulumXY, slack, tension

NOTHING = 1e-9  # of a length, a speed or a weight


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
    g, _, _, m = parameters[:4]
    return ("cable" if tension(t, w, *parameters) > -NOTHING * m * g else "flight"), w


def at_start(system, w):
    """Name of the first phase and the state that it starts from."""
    x, y, vx, vy = w
    r = math.hypot(x, y)
    if r > system.l * (1.0 + NOTHING):
        raise ValueError(
            f"`y0` is {r:g} m from the pivot: farther than the cable of {system.l:g} m reaches."
        )
    inwards = x * vx + y * vy < -NOTHING * r * math.hypot(vx, vy)
    if r < system.l * (1.0 - NOTHING) or inwards:
        return "flight", w
    return after_flight(0.0, w, *system.args)


def solve_cable(system, t_span, y0, method, **options):
    """Solve a `PendulumXY` in phases; see `PendulumXY.solve_cable`."""
    options = {"rtol": 1e-6, "atol": 1e-9, "dense_output": True} | options
    options["events"] = system.event_functions(options.get("events"))
    t_span = (0.0, system.t_end) if t_span is None else t_span
    start = np.array(system.initial_state() if y0 is None else system.full_state(y0), dtype=float)
    phases = {
        "cable": Phase(system.rhs, slack, after_slack, {"project": system.project}),
        "flight": Phase(falling, taut, after_flight),
    }
    first, start = at_start(system, start)
    run = solve_phases(phases, first, t_span, start, method, args=system.args, **options)
    run.system = system.as_started(t_span[0], system.initial_state()[:1])  # no exact solution
    return run
