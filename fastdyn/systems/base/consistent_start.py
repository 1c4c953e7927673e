"""Checks that a start satisfies the constraints, or projects the start onto the constraints."""

import dataclasses

import numpy as np

from fastdyn.compile.sentences import warn

from .solve_arguments import full_state

WIGGLE = 2.0**-20  # relative change of a component, to measure its effect on a constraint
TOLERANCE = 1e-7  # largest residual of a constraint, as a share of its largest term
PASSES = 10  # most passes of a projection
CHECKED = 100  # number of starts of an ensemble that are checked


def residuals(system, t0, start):
    """{name: (residual, size of its largest term)} of the constraints that `start` violates."""
    args = system.args
    start = np.asarray(start, float)
    found = {}
    for name, function in system.constraints.items():
        value = float(function(t0, start, *args))
        size = abs(value)
        for i in range(len(start)):
            moved = start.copy()
            moved[i] *= 1.0 + WIGGLE
            size = max(size, abs(float(function(t0, moved, *args)) - value) / WIGGLE)
        if not abs(value) <= TOLERANCE * size:
            found[name] = value, size
    return found


def start(system, t0, y0, project):
    """The state that a solve begins with, on the constraints if `project` is True; or a warning."""
    if y0 is None and (t0 == 0.0 or not system.constraints):
        return system.initial_state()
    y0 = system.initial_state() if y0 is None else full_state(system, y0)
    if not system.constraints:
        return y0
    try:
        y0 = np.asarray(y0, float)
        if project is True:
            y0 = _projected(system, t0, y0)
        wrong = residuals(system, t0, y0)
    except (TypeError, ValueError, ArithmeticError):  # the solver reports the mistake
        return y0
    if wrong:
        far = "it is too far from them to be projected"
        _warn(system, wrong, far if project is True else "`project=True` starts on them")
    return y0


def _projected(system, t0, y0):
    """A state on the constraints; a projection by Newton's method may need to be repeated."""
    for _ in range(PASSES):
        y0, before = np.array(system.project(t0, y0, *system.args), float), y0
        if np.allclose(y0, before, rtol=1e-15, atol=0.0):
            break
    return y0


def check_members(system, t0, states, columns):
    """Warn of an ensemble's starts that violate the constraints; `columns` has parameters."""
    states = np.atleast_2d(np.asarray(states, float))
    count = max([len(states), *map(len, columns.values())])
    for i in np.unique(np.linspace(0, count - 1, min(count, CHECKED)).astype(int)):
        given = {name: column[i if len(column) > 1 else 0] for name, column in columns.items()}
        one = dataclasses.replace(system, **given)
        wrong = residuals(one, t0, states[i if len(states) > 1 else 0])
        if wrong:
            _warn(system, wrong, f"this is trajectory {i}")
            return


def _warn(system, wrong, advice):
    parts = [f"`{name}` is {value:.3g}" for name, (value, _) in wrong.items()]
    warn(
        f"The start violates the constraints of the {system.name} ({', '.join(parts)}, not 0), "
        f"and so will the motion: {advice}."
    )
