"""Random inputs that switch with the time, by many solvers and ways: right, or told."""

import itertools
import types
import warnings

import numpy as np
import pytest

from fastdyn import (
    Phase,
    SwitchingWarning,
    at,
    prepare,
    solve_dae,
    solve_dae_ensemble,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)

LINES = itertools.count(100_000)
KNOTS = np.linspace(0.0, 10.0, 101)
METHODS = ("Tsit5", "Vern7", "Vern9", "Rodas5P", "auto", "RK45", "DOP853", "Radau", "BDF", "LSODA")


def inputs(rng):
    """A random input(t) with one pulse between 1 and 9, and the integral of the input."""
    a, width = rng.uniform(1.5, 8.0), 10.0 ** rng.uniform(-2.0, -0.3)
    k, table = rng.integers(15, 85), np.zeros(101)
    table[k] = 1.0
    return (
        (lambda t: 1.0 if a < t < a + width else 0.0, width),
        (lambda t: np.where((t >= a) & (t < a + width), 1.0, 0.0), width),
        (lambda t: np.heaviside(t - a, 0.5) - np.heaviside(t - a - width, 0.5), width),
        (lambda t: 1.0 if (t - a) % 20.0 < width else 0.0, width),
        (lambda t: table[min(int(10.0 * t), 100)], 0.1),
        (lambda t: np.interp(t, KNOTS, table), 0.1),
        (lambda t: np.clip(t - a, 0.0, 0.1) - np.clip(t - a - width, 0.0, 0.1), 0.1 * width),
    )[rng.integers(7)]


def fresh(fun):
    """A copy of a function of which nobody was told yet: on a line of its own."""
    code = fun.__code__.replace(co_firstlineno=next(LINES))
    return types.FunctionType(code, fun.__globals__, "pulsed", None, fun.__closure__)


def first(u, method):
    return solve_ivp(fresh(lambda t, y: [u(t)]), (0, 10), [0.0], method).y[0, -1]


def again(u, method):
    fun = fresh(lambda t, y, a: [a * u(t)])
    for _ in range(4):
        run = solve_ivp(fun, (0, 10), [0.0], method, args=(1.0,))
    return run.y[0, -1]


def prepared(u, method):
    method = "Tsit5" if method == "auto" else method
    solver = prepare(fresh(lambda t, y, a: [a * u(t)]), (0, 10), [0.0], method, args=(2.0,))
    return [solver(args=(1.0,)).y[0, -1] for _ in range(3)][-1]


def ensemble(u, method):
    method = "Tsit5" if method == "auto" else method
    fun = fresh(lambda t, y, a: [a * u(t)])
    return solve_ensemble(fun, (0, 10), [0.0], (np.ones(3),), method=method).y_end[1, 0]


def phases(u, method):
    def early(t, y):
        return t - 0.5

    def late(t, y):
        return t - 9.5

    early.terminal = late.terminal = True
    fun = fresh(lambda t, y: [u(t)])
    both = {"a": Phase(fun, early, lambda t, y: ("b", y)),
            "b": Phase(fun, late, lambda t, y: ("a", y))}  # fmt: skip
    method = "Tsit5" if method == "auto" else method
    return solve_phases(both, "a", (0, 10), [0.0], method).y[0, -1]


def discrete(u, method):
    fun = fresh(lambda t, y, d: [u(t - d[0])])
    given = {"discrete": [50.0], "events": at([1.0]), "on_event": lambda t, y, d: (y, [0.0])}
    return solve_ivp(fun, (0, 10), [0.0], method, **given).y[0, -1]


def dae(u, method):
    return solve_dae(lambda t, y, yp: [yp[0] - y[1], y[1] - u(t)], (0, 10), [0.0, 0.0]).y[0, -1]


def dae_ensemble(u, method):
    run = solve_dae_ensemble(
        lambda t, y, yp, a: [yp[0] - a * u(t)], (0, 10), [0.0], args=(np.ones(2),)
    )
    return run.y_end[0, 0]


# A Stepper is not among the ways yet: a step of Vern9 counts as one that looked if a stage without
# weight lies in the pulse (c of a stage with b = 0), and such a stage changes no integral.
WAYS = (first, again, prepared, ensemble, phases, discrete, dae, dae_ensemble)


@pytest.mark.hunt
def test_no_pulse_is_lost_in_silence(draws=60):
    rng = np.random.default_rng(7)
    for i in range(draws):
        u, area = inputs(rng)
        way, method = WAYS[i % len(WAYS)], METHODS[rng.integers(len(METHODS))]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = way(u, method)
        told = any(issubclass(each.category, SwitchingWarning) for each in caught)
        assert told or abs(found - area) < 0.05 * area, (i, way.__name__, method, found, area)
