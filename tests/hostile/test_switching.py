"""Random functions that switch with the time, by many solvers and ways: right, told or refused.

The functions are pulses, tables and levels, of equations and of events; the ways are those in which
a function reaches a solver.
"""

import types
import warnings

import numpy as np
import pytest

from fastdyn import (
    Free,
    Phase,
    Record,
    Stepper,
    SwitchingWarning,
    at,
    fit,
    prepare,
    solve_dae,
    solve_dae_ensemble,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)
from support.steppers import ended

from .occurrences import OF_EVENTS, SPAN, drawn_event, explicit, fresh

KNOTS = np.linspace(0.0, 10.0, 101)
OWN = ("Tsit5", "Vern7", "Vern9", "Rodas5P", "Taylor", "auto")
METHODS = (*OWN, "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "ode45")


def pulses(rng):
    """A random input(t) with one or two pulses between 1 and 9, and the integral of the input."""
    a, width = rng.uniform(1.5, 8.0), 10.0 ** rng.uniform(-2.0, -0.3)
    k, table = rng.integers(15, 85), np.zeros(101)
    table[k] = 1.0
    b = a + width
    held = np.array([0.0, 1.0, 0.0])
    marks = np.array([a, b])
    return (
        (lambda t: 1.0 if a < t < b else 0.0, width),
        (lambda t: np.where((t >= a) & (t < b), 1.0, 0.0), width),
        (lambda t: np.heaviside(t - a, 0.5) - np.heaviside(t - b, 0.5), width),
        (lambda t: 1.0 if (t - a) % 20.0 < width else 0.0, width),
        (lambda t: 0.5 * (np.sign(t - a) - np.sign(t - b)), width),
        (lambda t: table[max(0, min(int(10.0 * t), 100))], 0.1),
        (lambda t: np.interp(t, KNOTS, table), 0.1),
        (lambda t: held[np.searchsorted(marks, t)], width),
        (lambda t: np.floor((t - a) / width) == 0.0, width),
        (lambda t: np.clip(t - a, 0.0, 0.1) - np.clip(t - b, 0.0, 0.1), 0.1 * width),
        (lambda t: 1.0 if abs(t - a) < 0.5 * width else 0.0, width),
        (lambda t: max(0.0, 1.0 - abs(t - a) / width), width),
    )[rng.integers(12)]


# -- ways of a pulse: each returns the integral of the input


def first(u, method):
    return solve_ivp(fresh(lambda t, y: [u(t)]), SPAN, [0.0], method).y[0, -1]


def backwards(u, method):
    return -solve_ivp(fresh(lambda t, y: [u(t)]), SPAN[::-1], [0.0], method).y[0, -1]


def again(u, method):
    fun = fresh(lambda t, y, a: [a * u(t)])
    for _ in range(4):
        run = solve_ivp(fun, SPAN, [0.0], method, args=(1.0,))
    return run.y[0, -1]


def shifted(u, method):
    """The same function with another value, that other times depend on."""
    fun = fresh(lambda t, y, a: [u(t + a)])
    for a in (-3.0, 2.0, -3.0, 0.0):
        run = solve_ivp(fun, SPAN, [0.0], method, args=(a,))
    return run.y[0, -1]


def prepared(u, method):
    solver = prepare(fresh(lambda t, y, a: [u(t + a)]), SPAN, [0.0], explicit(method), args=(1.0,))
    return [solver(args=(a,)).y[0, -1] for a in (1.0, -1.5, 0.0)][-1]


def many(u, method):
    solver = prepare(fresh(lambda t, y, a: [a * u(t)]), SPAN, [0.0], explicit(method), args=(1.0,))
    return solver.many(args=(np.array([2.0, 1.0, 3.0]),)).y[1][-1]


def of_second_order(u, method):
    run = solve_ivp(fresh(lambda t, y: [y[1], 0.0 * y[0] + u(t)]), SPAN, [0.0, 0.0], method)
    return run.y[1, -1]


def ensemble(u, method):
    fun = fresh(lambda t, y, a: [a * u(t)])
    run = solve_ensemble(fun, SPAN, [0.0], (np.ones(3),), method=explicit(method))
    return run.y_end[1, 0]


def of_components(u, method):
    """The input is shifted by a component that stays."""
    run = solve_ivp(fresh(lambda t, y: [u(t - y[1]), 0.0]), SPAN, [0.0, 0.0], method)
    return run.y[0, -1]


def stepper(u, method):
    found = ended(Stepper(fresh(lambda t, y: [u(t)]), 0.0, [0.0], 10.0, method=explicit(method)))
    return found.y[0]


def stepper_with_args(u, method):
    fun = fresh(lambda t, y, a: [u(t + a)])
    found = Stepper(fun, 0.0, [0.0], 10.0, method=explicit(method), args=(1.0,), first_step=0.1)
    found.step()
    found.args = (0.0,)
    ended(found)
    return found.y[0]


def phases(u, method):
    def early(t, y):
        return t - 0.5

    def late(t, y):
        return t - 9.5

    early.terminal = late.terminal = True
    fun = fresh(lambda t, y: [u(t)])
    both = {"a": Phase(fun, early, lambda t, y: ("b", y)),
            "b": Phase(fun, late, lambda t, y: ("a", y))}  # fmt: skip
    return solve_phases(both, "a", SPAN, [0.0], explicit(method)).y[0, -1]


def discrete(u, method):
    fun = fresh(lambda t, y, d: [u(t - d[0])])
    given = {"discrete": [5.0], "events": at([1.0]), "on_event": lambda t, y, d: (y, [0.0])}
    return solve_ivp(fun, SPAN, [0.0], method, **given).y[0, -1]


def behind_an_event(u, method):
    """Python code that runs within the solve shifts the input."""
    fun = fresh(lambda t, y, d: [u(t - d[0]), 1.0])
    given = {"discrete": [5.0], "events": lambda t, y, d: y[1] - 1.0}
    given["on_event"] = lambda t, y, d: (y, [0.0])
    return solve_ivp(fun, SPAN, [0.0, 0.0], method, **given).y[0, -1]


def fitted(u, method):
    """The factor of an input, whose integral is measured."""
    times = np.array([0.5, 9.5])
    fun = fresh(lambda t, y, k: [k * u(t)])
    given = {} if method in OWN else {"method": method}
    record = Record(times, np.array([0.0, 1.0]), [0.0], (Free(3.0, name="k"),), t0=0.0)
    return 1.0 / fit(fun, record, **given).x[0]


def dae(u, method):
    method = method if method in ("BDF", "Radau", "Rodas5P") else "Radau"
    F = fresh(lambda t, y, yp: [yp[0] - y[1], y[1] - u(t)])
    return solve_dae(F, SPAN, [0.0, 0.0], method=method).y[0, -1]


def dae_of_index_3(u, method):
    """Two masses; the second stands still by a constraint on its position."""

    def F(t, y, yp):
        return [yp[0] - y[2], yp[1] - y[3], yp[2] - u(t), yp[3] - y[4], y[1] - 1.0]

    return solve_dae(fresh(F), SPAN, [0.0, 1.0, 0.0, 0.0, 0.0]).y[2, -1]


def dae_ensemble(u, method):
    F = fresh(lambda t, y, yp, a: [yp[0] - a * u(t)])
    return solve_dae_ensemble(F, SPAN, [0.0], args=(np.ones(2),)).y_end[0, 0]


def in_long_arrays(u, method):
    return solve_ivp(fresh(lambda t, y: u(t) + 0.0 * y), SPAN, np.zeros(80), method).y[40, -1]


def complex_states(u, method):
    run = solve_ivp(fresh(lambda t, y: [1j * u(t)]), SPAN, [0j], method)
    return run.y[0, -1].imag


def sensitivity(u, method):
    """dy/da of y' = a u(t)."""
    fun = fresh(lambda t, y, a: [a * u(t)])
    method = method if method in OWN else "RK45"
    run = solve_ivp(fun, SPAN, [0.0], explicit(method), args=(2.0,), sensitivity="args")
    return np.ravel(run.sensitivity["a"])[-1]


WAYS = (
    first, backwards, again, shifted, prepared, many, of_second_order, ensemble, of_components,
    stepper, stepper_with_args, phases, discrete, behind_an_event, fitted, dae, dae_of_index_3,
    dae_ensemble, in_long_arrays, complex_states, sensitivity,
)  # fmt: skip


# -- levels: a thermostat, whose level jumps, and the integral of its temperature


def levels(rng):
    """A random level that jumps at times between 1.5 and 8."""
    a, b = np.sort(rng.uniform(1.5, 8.0, 2))
    low, high = rng.permutation([1.0, 2.0])
    values = np.array([low, high, low])
    times = np.array([a, b])
    return (
        lambda t: low if t < a else high,
        lambda t: low if a < t < b else high,
        lambda t: np.where(t < a, low, high),
        lambda t: low + (high - low) * np.heaviside(t - a, 1.0),
        lambda t: values[np.searchsorted(times, t)],
        lambda t: 1.5 + 0.5 * np.sign(np.sin(t - a)),
        lambda t: low + (t >= a),
    )[rng.integers(7)]


def thermostat(level):
    return lambda t, y: [(3.0 if y[0] < level(t) else 0.0) - y[0], y[0]]


def by_euler(fun, h=1e-3):
    """The end state, with errors of some h."""
    y = np.zeros(2)
    for i in range(round(SPAN[1] / h)):
        y += h * np.array(fun(i * h, y))
    return y


def of_first(fun, method):
    return solve_ivp(fun, SPAN, np.zeros(2), method)


def of_repeated(fun, method):
    return [solve_ivp(fun, SPAN, np.zeros(2), method, rtol=1e-4) for _ in range(3)][-1]


def at_times(fun, method):
    return solve_ivp(fun, SPAN, np.zeros(2), method, t_eval=np.linspace(*SPAN, 11))


def of_steppers(fun, method):
    found = ended(Stepper(fun, 0.0, np.zeros(2), 10.0, method=explicit(method)))
    return types.SimpleNamespace(y=found.y[:, None], success=found.status == "finished")


OF_LEVELS = (of_first, of_repeated, at_times, of_steppers)
EVERY = 8  # one draw of EVERY is a level, two are events
# A step of SciPy's and MATLAB's pairs from a pulse to behind it, with rtol = 1e-3, has an error of
# up to 0.1 of the pulse: the first stage has the weight 1e-3 in the estimate, and 0.1 in the sum.
SHARES = dict.fromkeys(METHODS, 0.15) | dict.fromkeys(OWN, 0.01)
# The integral by chattering, with rtol = 1e-3, over one of some 15.
OF_INTEGRAL = 0.5


def of_a_level(rng, method):
    """The way, how far the answer is from the right one, and whether that is near enough."""
    way = OF_LEVELS[rng.integers(len(OF_LEVELS))]
    fun = thermostat(levels(rng))
    run = way(fresh(fun), method)
    apart = np.abs(run.y[:, -1] - by_euler(fun)).max()
    return (way.__name__, apart), not run.success or apart < OF_INTEGRAL


def of_a_pulse(rng, method):
    """The way, the answer and the right one, and whether they agree."""
    u, area = pulses(rng)
    way = WAYS[rng.integers(len(WAYS))]
    found = way(u, method)
    return (way.__name__, found, area), abs(found - area) < SHARES[method] * area


def of_an_event(rng, method):
    """As `of_a_pulse`, of a pulse of an event function."""
    u, _ = pulses(rng)
    way = OF_EVENTS[rng.integers(len(OF_EVENTS))]
    found = way(drawn_event(u, rng), method)
    return (way.__name__, found), np.all(found == 1)


def is_right(rng, i):
    """A description of draw i, and whether its answer is right, or refused."""
    method = METHODS[rng.integers(len(METHODS))]
    kinds = {EVERY - 1: of_a_level, EVERY - 2: of_an_event, EVERY - 3: of_an_event}
    drawn = kinds.get(i % EVERY, of_a_pulse)
    try:
        name, right = drawn(rng, method)
    except (ValueError, NotImplementedError) as reason:  # "takes no tables", "no Taylor series"
        return (drawn.__name__, method, str(reason)), True
    return (method, *name), right


def silent(draws, seed):
    """The draws whose answers are wrong without a word."""
    wrong = []
    for i in range(draws):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            name, right = is_right(np.random.default_rng((seed, i)), i)
        told = any(issubclass(each.category, SwitchingWarning) for each in caught)
        if not (right or told):
            wrong.append((i, *name))
    return wrong


def test_few_draws_are_right_or_told():
    assert silent(24, 1) == []


@pytest.mark.hunt
def test_no_draw_is_wrong_without_a_word(pytestconfig):
    """``--draws 2000`` takes some six minutes of a processor."""
    assert silent(100 * pytestconfig.getoption("draws"), 7) == []
