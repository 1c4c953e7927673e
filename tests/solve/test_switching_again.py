"""Claims about switching times in repeated solves: sought once, decided anew for other values."""

import math
import types
import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from fastdyn import SwitchingWarning, prepare, solve_ivp
from fastdyn.run.functions import deciding
from fastdyn.trace.switching import decided, straight_lines
from fastdyn.trace.switching.switches import Switches

KNOTS = np.linspace(0.0, 1.0, 21)
curve = CubicSpline(KNOTS, np.sin(40.0 * KNOTS))

# input(t, u), for 20 samples u
INPUTS = {
    "held": lambda t, u: u[min(int(t / 0.05), 19)],
    "searched": lambda t, u: u[min(np.searchsorted(KNOTS, t, side="right"), 20) - 1],
    "interpolated": lambda t, u: np.interp(t, KNOTS[:20], u),
    "late": lambda t, u: u[3] if t > 0.3 + 0.1 * u[4] else u[5],
    "remainder": lambda t, u: u[3] if math.fmod(t, 0.1) > 0.05 else u[5],
    "sine": lambda t, u: u[3] * math.sin(9 * t) + u[int(20 * t) % 20],
    "curve": lambda t, u: u[0] * curve(t) + (u[1] if t % 0.3 < 0.1 else u[2]),
    "at a limit": lambda t, u: max(u[0], min(t, u[1])),
}


def samples(rng):
    """Samples of which some neighbours are equal, at random; rarely all."""
    u = np.repeat(rng.normal(size=20), rng.integers(1, 8, 20))[:20]
    return np.full(20, 0.25) if rng.random() < 0.2 else u


@pytest.mark.few
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P", "RK45", "LSODA"])
@pytest.mark.parametrize("name", INPUTS)
@pytest.mark.filterwarnings("ignore::fastdyn.SwitchingWarning")
def test_other_samples_give_the_bits_of_a_first_solve(name, method):
    """The times of an input are found for its grid, and decided by NumPy or in compiled code."""
    source = INPUTS[name]
    rng = np.random.default_rng(len(name))

    def fun(t, y, u):
        return [source(t, u) - y[0]]

    solver = prepare(fun, (0, 1), [0.0], method=method, args=(samples(rng),))
    for _ in range(12):
        u = samples(rng)
        again, alone = solver(args=(u,)), prepare(fun, (0, 1), [0.0], method=method, args=(u,))()
        assert np.array_equal(again.t, alone.t) and np.array_equal(again.y, alone.y)
        repeated = solve_ivp(fun, (0, 1), [0.0], method, args=(u,))
        assert np.array_equal(repeated.t, alone.t) and np.array_equal(repeated.y, alone.y)


def test_the_times_of_a_held_input_are_sought_once(monkeypatch):
    source, rng, calls = INPUTS["held"], np.random.default_rng(0), []
    solver = prepare(lambda t, y, u: [source(t, u) - y[0]], (0, 1), [0.0], method="Tsit5",
                     args=(samples(rng),))  # fmt: skip
    for _ in range(deciding.MANY + 1):
        solver(args=(samples(rng),))
    for owner, called in ((Switches, "candidates"), (decided, "masks")):
        monkeypatch.setattr(owner, called, lambda *given, name=called: calls.append(name))
    for _ in range(5):
        u = samples(rng)
        run = solver(args=(u,))
        jumps = KNOTS[1:20][np.diff(u) != 0.0]
        assert all(np.abs(run.t - t).min() < 1e-15 for t in jumps)
    assert calls == []


@pytest.mark.parametrize("name", INPUTS)
def test_spans_that_move_have_the_times_of_their_own(name):
    """The steps of solves from knot to knot, and across knots, in a loop."""
    source = INPUTS[name]
    u = np.random.default_rng(3).normal(size=20)

    def fun(t, y, u):
        return [source(t, u) - y[0]]

    for k in range(60):
        span = 0.025 * (k % 40), 0.025 * (k % 40) + (0.025, 0.07)[k % 2]
        run = solve_ivp(fun, span, [0.0], "Tsit5", args=(u,), rtol=1e-9, atol=1e-12)
        fine = {"breakpoints": np.arange(0.0, 1.1, 0.0125), "rtol": 1e-11, "atol": 1e-13}
        right = solve_ivp(fun, span, [0.0], "Vern9", args=(u,), **fine)
        assert abs(run.y[0, -1] - right.y[0, -1]) < 1e-9


@pytest.mark.parametrize("method", ["RK45", "DOP853", "LSODA"])
def test_a_pulse_among_smooth_samples_is_told(method):
    """Repeated solves look at all knots first, and decide which matter where a step jumps."""
    line = 2 * len(method)
    knots = np.linspace(0.0, 10.0, 201)
    fun = types.FunctionType(
        (lambda t, y, u: [np.interp(t, knots, u) - y[0]]).__code__.replace(co_firstlineno=line),
        globals(), "fun", None, (types.CellType(knots),),
    )  # fmt: skip
    pulse = np.where(np.abs(knots - 5.0) < 0.1, 1.0, 0.0)
    flat = np.zeros(201)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(10):
            solve_ivp(fun, (0, 10), [0.0], method, args=(flat,))
    with pytest.warns(SwitchingWarning, match="changes at t = 4.[89]"):
        solve_ivp(fun, (0, 10), [0.0], method, args=(pulse,))


@pytest.mark.parametrize("breakpoints", [(), [], (0.5,), np.array([0.25, 0.5])])
@pytest.mark.parametrize("method", ["Tsit5", "RK45", "Radau"])
def test_breakpoints_are_those_of_each_call(breakpoints, method):
    def fun(t, y, a):
        return [abs(math.sin(3 * t)) - a * y[0]]

    given = {"method": method, "args": (1.5,), "rtol": 1e-6}
    first = solve_ivp(fun, (0, 1), [0.0], breakpoints=breakpoints, **given)
    for span in [(0, 1)] * 6 + [(0, 2)] * 3 + [(0, 1)]:
        run = solve_ivp(fun, span, [0.0], breakpoints=breakpoints, **given)
        assert np.isin(np.asarray(breakpoints, float), run.t).all()
        if span == (0, 1):
            assert np.array_equal(run.t, first.t) and np.array_equal(run.y, first.y)
    with pytest.warns(UserWarning, match="none is within"):
        for _ in range(3):
            solve_ivp(fun, (0, 1), [0.0], breakpoints=[7.0], **given)


@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "RK45"])
def test_gradients_by_samples_again(method):
    """Where neighbours are equal, the derivatives by them jump all the same."""
    source, rng = INPUTS["held"], np.random.default_rng(5)

    def fun(t, y, u):
        return [source(t, u) - y[0]]

    right = np.exp(KNOTS[1:] - 1.0) - np.exp(KNOTS[:-1] - 1.0)
    given = {"rtol": 1e-9, "atol": 1e-11, "t_eval": [1.0], "adjoint": "u"}
    for _ in range(10):
        run = solve_ivp(fun, (0, 1), [0.0], method, args=(samples(rng),), **given)
        assert run.vjp(np.array([[1.0]]))["u"] == pytest.approx(
            right, abs=1e-6 if method == "RK45" else 1e-9
        )


@pytest.mark.parametrize("method", ["RK45", "LSODA"])
@pytest.mark.parametrize("watched", [False, True])
def test_a_warning_changes_no_steps(method, watched):
    """Solves behind the one that warned have its steps, and look no more for what was told."""
    line = 20 + 2 * len(method) + watched
    source, u = INPUTS["held"], np.random.default_rng(0).normal(size=20)

    def fun(t, y, u):
        return [source(t, u) - y[0], y[0]]

    fun = types.FunctionType(
        fun.__code__.replace(co_firstlineno=line), globals(), "fun", None, fun.__closure__
    )
    given = {"args": (u,), "rtol": 1e-3}
    if watched:
        given["events"] = lambda t, y, u: y[0] - 10.0 - source(t, u)
    elif method == "RK45":
        given["adjoint"] = "u"
    with pytest.warns(SwitchingWarning):
        solver = prepare(fun, (0, 1), [1.0, 0.5], method=method, **given)
        first = solver()
    for _ in range(6):
        for run in (solver(), solve_ivp(fun, (0, 1), [1.0, 0.5], method, **given)):
            assert np.array_equal(run.t, first.t) and np.array_equal(run.y, first.y)


def test_long_tables_are_searched_as_short_ones(monkeypatch):
    weight = np.arange(21.0)
    listed = straight_lines.Knots(KNOTS, weight)
    monkeypatch.setattr(straight_lines, "MOST_LISTED", 4)
    in_place = straight_lines.Knots(KNOTS, weight)
    for span in ((0.0, 1.0), (0.05, 0.3), (0.06, 0.07), (-1.0, 0.0), (1.5, 2.0)):
        inside = (KNOTS >= span[0]) & (KNOTS <= span[1])
        for own in (listed, in_place):
            t, found = own.within(*span, 100)
            assert np.array_equal(t, KNOTS[inside]) and np.array_equal(found, weight[inside])
