"""Claims about switching times: steps of fastdyn's methods end where `fun` changes in time."""

import itertools
import math
import warnings

import numpy as np
import pytest
import scipy.integrate
from scipy import signal
from scipy.interpolate import CubicSpline, PchipInterpolator, interp1d

from fastdyn import Stepper, SwitchingWarning, prepare, solve_ensemble, solve_ivp
from fastdyn.trace.switching import divisions
from support.pulsed import fresh
from support.steppers import ended

KNOTS = np.arange(11.0)
RECORD = np.where(KNOTS == 5.0, 1.0, 0.0)
FINE = np.linspace(0.0, 10.0, 2001)
LATE = np.exp(-(((FINE - 5.0) / 0.05) ** 2))
held, linear = interp1d(KNOTS, RECORD, kind="previous"), interp1d(KNOTS, RECORD)
PEAK = math.asin(0.99)
smooth, shaped = CubicSpline(FINE, LATE), PchipInterpolator(KNOTS, RECORD)


def with_elif(t):
    if t < 5.0:
        return 0.0
    elif t < 5.5:
        return 1.0
    return 0.0


# input(t), and the times at which it changes
PULSES = {
    "chained": (lambda t: 1.0 if 5 < t < 6 else 0.0, (5, 6)),
    "and": (lambda t: 1.0 if t >= 5 and t <= 5.25 else 0.0, (5, 5.25)),
    "or": (lambda t: 0.0 if t < 5 or t > 5.25 else 1.0, (5, 5.25)),
    "elif": (with_elif, (5, 5.5)),
    "product": (lambda t: (t > 5) * (t < 6), (5, 6)),
    "where": (lambda t: np.where((t > 5) & (t < 6), 1.0, 0.0), (5, 6)),
    "heaviside": (lambda t: np.heaviside(t - 5, 0.5) - np.heaviside(t - 5.1, 0.5), (5, 5.1)),
    "sign": (lambda t: 0.5 * (np.sign(t - 5) - np.sign(t - 6)), (5, 6)),
    "piecewise": (lambda t: np.piecewise(t, [t < 5, t >= 5.5], [0.0, 0.0, 1.0]), (5, 5.5)),
    "select": (lambda t: np.select([t < 5, t < 5.5], [0.0, 1.0], 0.0), (5, 5.5)),
    "abs": (lambda t: 1.0 if abs(t - 5.5) < 0.25 else 0.0, (5.25, 5.75)),
    "modulo": (lambda t: 1.0 if t % 4.0 > 3.9 else 0.0, (3.9, 4, 7.9, 8)),
    "fmod": (lambda t: 1.0 if math.fmod(t, 4.0) > 3.9 else 0.0, (3.9, 4, 7.9, 8)),
    "floor": (lambda t: 1.0 if math.floor(2 * t) == 11 else 0.0, (5.5, 6)),
    "phase": (lambda t: 1.0 if t / 4 - np.floor(t / 4) > 0.95 else 0.0, (3.8, 4, 7.8, 8)),
    "round": (lambda t: 1.0 if round(t) == 5 else 0.0, (4.5, 5.5)),
    "record": (lambda t: RECORD[min(int(t / 1.0), 10)], (5, 6)),
    "search": (lambda t: RECORD[np.searchsorted(KNOTS, t, side="right") - 1], (5, 6)),
    "held": (lambda t: held(t), (5, 6)),
    "interp": (lambda t: np.interp(t, KNOTS, RECORD), (4, 5, 6)),
    "interp1d": (lambda t: linear(t), (4, 5, 6)),
    "spline": (lambda t: smooth(t), ()),
    "pchip": (lambda t: shaped(t), ()),
    "table": (lambda t: np.interp(t, FINE, LATE), ()),
    "max": (lambda t: max(0.0, 1 - 4 * abs(t - 5)), (4.75, 5, 5.25)),
    "clip": (lambda t: np.clip(t - 5, 0, 0.1) - np.clip(t - 5.2, 0, 0.1), (5, 5.1, 5.2, 5.3)),
    "sine": (lambda t: 1.0 if math.sin(t) > 0.99 else 0.0,
             (PEAK, math.pi - PEAK, 2 * math.pi + PEAK, 3 * math.pi - PEAK)),
    "square": (lambda t: 0.5 + 0.5 * signal.square(t, 0.02), (2 * math.pi,)),
    "bell": (lambda t: 1.0 if math.exp(-(((t - 5) / 0.1) ** 2)) > 0.5 else 0.0,
             (5 - 0.1 * math.log(2) ** 0.5, 5 + 0.1 * math.log(2) ** 0.5)),
    "two sines": (lambda t: 1.0 if math.sin(t) + 0.5 * math.sin(3 * t + 1) > 1.1 else 0.0, ()),
}  # fmt: skip
METHODS = ["auto", "Tsit5", "Vern7", "Vern9", "Rodas5P"]


def driven(u):
    return lambda t, y: [u(t) * (1 - y[0]) - y[0]]


def reference(fun, y0=(0.0,), span=(0.0, 10.0)):
    """Steps of RK45 do not end at switching times."""
    tight = {"rtol": 1e-10, "atol": 1e-12, "max_step": 0.002}
    return solve_ivp(fun, span, y0, "RK45", **tight).y[:, -1]


@pytest.mark.parametrize("name", PULSES)
def test_a_pulse_is_not_lost_however_it_is_written(name):
    u, times = PULSES[name]
    fun = driven(u)
    right = reference(fun)
    assert right[0] > 1e-4  # else losing it would be right
    for method in METHODS:
        run = solve_ivp(fun, (0, 10), [0.0], method, rtol=1e-6, atol=1e-9)
        assert run.success and np.abs(run.y[:, -1] - right).max() < 3e-7, method
        for t in times:
            assert np.abs(run.t - t).min() < 1e-7, (method, t)


@pytest.mark.parametrize("method", METHODS)
def test_a_narrow_pulse_far_ahead_is_found(method):
    """No step of a solve at rest is as short as a millionth of the span."""
    run = solve_ivp(driven(lambda t: 1.0 if 7e5 < t < 7e5 + 1 else 0.0), (0, 1e6), [0.0], method)
    assert run.success and np.isin([7e5, 7e5 + 1], run.t).all()


def test_each_of_many_pulses_is_found():
    """20 000 pulses, each a tenth of its period: the mean is their share, to the tolerance."""
    run = solve_ivp(lambda t, y: [1.0 if t % 1e-3 < 1e-4 else 0.0], (0, 10), [0.0], "Tsit5")
    assert abs(run.y[0, -1] - 1.0) < 1e-9


@pytest.mark.parametrize("span", [(0.0, 500.0), (500.0, 0.0), (0.0, math.inf)])
def test_of_too_many_pulses_the_steps_are_short_enough(span, monkeypatch):
    """Steps end at the first ones, and are no longer than these are."""
    monkeypatch.setattr(divisions, "MOST", 300)

    def pulses(t, y):
        return [1.0 if t % 1.0 < 0.25 else 0.0]

    def end(t, y):
        return t - 500.0

    end.terminal = True
    events = end if span[1] == math.inf else None
    run = solve_ivp(pulses, span, [0.0], "Tsit5", events=events, rtol=1e-8, atol=1e-9)
    assert abs(run.y[0, -1]) == pytest.approx(125.0, rel=1e-4)
    assert np.isin(span[0] + np.sign(span[1] - span[0]) * np.arange(1.0, 15.0), run.t).all()


def test_smooth_phases_and_smooth_tables_cost_no_steps():
    """A jump that the state does not see is no switching time."""
    wrapped = solve_ivp(
        lambda t, y: [math.sin(2 * math.pi * (t % 1.0)) - y[0]], (0, 10), [0.0], "Vern7"
    )
    plain = solve_ivp(lambda t, y: [math.sin(2 * math.pi * t) - y[0]], (0, 10), [0.0], "Vern7")
    assert wrapped.nfev <= plain.nfev + 5
    waves = np.sin(FINE)
    run = solve_ivp(lambda t, y: [np.interp(t, FINE, waves) - y[0]], (0, 10), [0.0], "Tsit5")
    assert run.n_accepted < 300  # of 2000 knots


@pytest.mark.parametrize("method", METHODS)
def test_times_follow_parameters_and_spans_from_call_to_call(method):
    """Repeated solves, a prepared solver and its `many`; the last agree to the last bit."""
    level = 1.0

    def pulse(t, y, a, width):
        return [(level if a < t < a + width else 0.0) * (1 - y[0]) - 0.2 * y[0]]

    def right(a, width, end):
        on = max(min(a + width, end) - a, 0.0)
        top = level * (1 - math.exp(-(level + 0.2) * on)) / (level + 0.2)
        return top * math.exp(-0.2 * (end - min(a + width, end)))

    rng = np.random.default_rng(5)
    given = {"method": method, "rtol": 1e-8, "atol": 1e-10}
    for i in range(40):
        a, width, end = rng.uniform(0, 11), rng.uniform(0.001, 2.0), (10.0, 8.0)[i % 7 == 0]
        level = 1.0 + (i > 20)
        run = solve_ivp(pulse, (0, end), [0.0], args=(a, width), t_eval=[end], **given)
        assert abs(run.y[0, -1] - right(a, width, end)) < 1e-8, i
    if method != "auto":
        solver = prepare(pulse, (0, 10), [0.0], args=(1.0, 1.0), t_eval=[10.0], **given)
        for _ in range(20):
            args = rng.uniform(0, 11), rng.uniform(0.001, 2.0)
            run = solve_ivp(pulse, (0, 10), [0.0], args=args, t_eval=[10.0], **given)
            assert run.y[0, -1] == solver(args=args).y[0, -1]
        starts, widths = rng.uniform(0, 9, 5), rng.uniform(0.001, 1.0, 5)
        many = solver.many(args=(starts, widths)).y[:, 0, 0]
        assert many.tolist() == [
            solver(args=each).y[0, -1] for each in zip(starts, widths, strict=True)
        ]


@pytest.mark.few
@pytest.mark.parametrize("method", METHODS[1:])
@pytest.mark.parametrize("simd", [True, False])
@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
def test_each_trajectory_has_times_of_its_own(method, simd, span):
    def pulses(t, y, a, width):
        return [(1.0 if (t - a) % 4.0 < width else 0.0) * (1 - y[0]) - 0.1 * y[0]]

    rng = np.random.default_rng(6)
    a, width = rng.uniform(0, 9, 20), rng.uniform(0.001, 0.5, 20)
    given = {"method": method, "rtol": 1e-7, "atol": 1e-9}
    whole = solve_ensemble(pulses, span, [0.1], (a, width), simd=simd, **given)
    alone = [
        solve_ivp(pulses, span, [0.1], args=each, **given).y[0, -1]
        for each in zip(a.tolist(), width.tolist(), strict=True)
    ]
    assert np.abs(whole.y_end[:, 0] - alone).max() < 1e-11  # roundings


def test_long_arrays():
    """A pulse for all cells, switching times of each cell, and those of one of them."""
    starts = np.linspace(1.0, 9.0, 80)

    def all_cells(t, y):
        return (1.0 if 5 < t < 5.01 else 0.0) * (1 - y) - y

    def each_cell(t, y):
        return np.where((t > starts) & (t < starts + 0.01), 1.0, 0.0) * (1 - y) - y

    def one_cell(t, y):
        u = np.where((t > starts) & (t < starts + 0.01), 1.0, 0.0)
        change = -y
        change[40] += u[40] * (1 - y[40])
        return change

    top = 0.5 * (1.0 - math.exp(-0.02))
    run = solve_ivp(one_cell, (0, 10), np.zeros(80), "Tsit5", rtol=1e-6, atol=1e-9)
    assert abs(run.y[40, -1] - top * np.exp(starts[40] + 0.01 - 10.0)) < 1e-7
    for fun in (all_cells, each_cell):
        run = solve_ivp(fun, (0, 10), np.zeros(80), "Tsit5", rtol=1e-6, atol=1e-9)
        begins = starts if fun is each_cell else np.full(80, 5.0)
        assert np.abs(run.y[:, -1] - top * np.exp(begins + 0.01 - 10.0)).max() < 1e-7


def test_a_switch_at_the_start_counts_from_the_start():
    """At t0 = 5, ``5 < t`` is false, and true for all of the solve."""
    run = solve_ivp(lambda t, y: [1.0 if 5 < t else 0.0], (5, 6), [0.0], "Tsit5")
    assert abs(run.y[0, -1] - 1.0) < 1e-14 and run.n_rejected == 0
    run = solve_ivp(lambda t, y: [1.0 if math.sin(t) > 0 else 0.0], (0, 3), [0.0], "Tsit5")
    assert abs(run.y[0, -1] - 3.0) < 1e-14 and run.n_rejected == 0


def test_other_breakpoints_events_and_dense_output_stay():
    def pulse(t, y):
        return [1.0 if 5 < t < 6 else 0.0]

    def half(t, y):
        return y[0] - 0.5

    given = {"events": half, "breakpoints": [2.0], "dense_output": True}
    run = solve_ivp(pulse, (0, 10), [0.0], "Vern7", **given)
    assert np.isin([2.0, 5.0, 6.0], run.t).all() and run.t_events[0] == pytest.approx([5.5])
    assert run.sol(np.array([4.0, 5.25, 9.0]))[0] == pytest.approx([0.0, 0.25, 1.0])


def test_a_sensitivity_to_the_time_of_a_pulse_is_refused():
    """At both ends of the step over the pulse, the pulse is over."""

    def pulse(t, y, k, a):
        return [np.where((a < t) & (t < a + 1), 1.0, 0.0) * (1 - y[0]) - k * y[0]]

    given = {"args": (0.5, 5.0), "rtol": 1e-8, "atol": 1e-10}
    found = solve_ivp(pulse, (0, 10), [0.0], "Vern9", sensitivity="k", **given).sensitivity["k"]
    ends = [
        solve_ivp(pulse, (0, 10), [0.0], "Vern9", **given | {"args": (k, 5.0)}).y[0, -1]
        for k in (0.5 - 1e-5, 0.5 + 1e-5)
    ]
    assert found[0, -1] == pytest.approx((ends[1] - ends[0]) / 2e-5, rel=1e-6)
    with pytest.raises(ValueError, match="jumps at t = 5"):
        solve_ivp(pulse, (0, 10), [0.0], "Vern9", args=(0.5, 5.0), sensitivity="a")


# -- methods whose steps are SciPy's, MATLAB's or constant, and Steppers

NOT_OWN = ["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"]


def pulsed():
    return fresh(lambda t, y: [1.0 - 2 * y[0] if 5 < t < 6 else -y[0]], "fun")


def narrow(t, y, a):
    return [(1.0 if a < t < a + 0.3 else 0.0) - y[0]]


def told(call):
    """The result of a call, and the messages of its SwitchingWarnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = call()
    assert all(issubclass(each.category, SwitchingWarning) for each in caught)
    return result, [str(each.message) for each in caught]


@pytest.mark.parametrize("method", NOT_OWN)
@pytest.mark.parametrize("t_eval", [None, [10.0]])
def test_a_jump_over_a_pulse_is_told_once_and_steps_stay(method, t_eval):
    fun = pulsed()
    run, said = told(lambda: solve_ivp(fun, (0, 10), [0.0], method, t_eval=t_eval))
    assert run.y[0, -1] == 0.0 and len(said) == 1
    assert "changes at t = 5 and t = 6, and no step of " + method in said[0]
    assert "max_step=1" in said[0] and "breakpoints" in said[0]
    scipys = scipy.integrate.solve_ivp(fun, (0, 10), [0.0], method, t_eval=t_eval)
    assert run.nfev == scipys.nfev and np.array_equal(run.t, scipys.t)
    assert told(lambda: solve_ivp(fun, (0, 10), [0.0], method, t_eval=t_eval))[1] == []
    fun = pulsed()
    for options in ({"max_step": 0.1}, {"breakpoints": [5.0, 6.0]}):
        assert told(lambda o=options: solve_ivp(fun, (0, 10), [0.0], method, **o))[1] == []


@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
def test_only_a_step_without_a_look_is_told(span):
    """Stages within the pulse with a weight in the error, and a single change, are seen."""

    fun = fresh(lambda t, y, on, off: [1.0 if on < t < off else 0.0], "fun")
    given = {"max_step": 1.0, "first_step": 1.0, "rtol": 1e9, "atol": 1e9}

    def solved(*args):
        return told(lambda: solve_ivp(fun, span, [0.0], "RK45", args=args, **given))[1]

    looks = np.array([0, 3 / 10, 4 / 5, 8 / 9, 1])  # 1 / 5 has no weight
    inside = 5.0 + looks if span[1] > 0 else 6.0 - looks
    for a, b in itertools.pairwise(np.sort(inside).tolist()):
        assert solved(a - 0.01, a + 0.01) == [] == solved(a - 0.01, b + 0.01)
    assert solved(5.5, 20.0) == [] == solved(-5.0, 5.5)
    a = 5.2 if span[1] > 0 else 5.8
    assert solved(a - 0.01, a + 0.01)[0].startswith("`fun` changes at t = 5.")


def test_one_of_many_periodic_pulses_is_told():
    """SciPy's implicit methods lose some of them at any tolerance, the more so at the end."""

    for method in ("Radau", "BDF", "LSODA"):
        fun = fresh(lambda t, y: [(1.0 if t % 10.0 < 0.1 else 0.0) - 5 * y[0]], "fun")
        _, said = told(lambda m=method, f=fun: solve_ivp(f, (1, 100), [0.0], m, rtol=1e-9))
        assert len(said) == 1, method


def test_repeated_and_prepared_solves_and_ensembles_tell():
    fun = fresh(narrow, "fun")

    def one(a):
        return told(lambda: solve_ivp(fun, (0, 10), [0.0], args=(a,), t_eval=[10.0]))[1]

    for _ in range(12):  # the first step looks at 1e-4 and before
        assert one(-1.0) == []
    assert len(one(5.0)) == 1 and one(5.0) == []
    solver = prepare(fresh(narrow, "fun"), (0, 10), [0.0], args=(-1.0,))
    assert told(solver)[1] == [] and len(told(lambda: solver(args=(5.0,)))[1]) == 1
    solver = prepare(fresh(narrow, "fun"), (0, 10), [0.0], args=(-1.0,))
    assert len(told(lambda: solver.many(args=(np.array([5.0, 6.0]),)))[1]) == 1
    for simd in (True, False):
        starts = np.array([5.0, 6.0])
        asked = fresh(narrow, "fun"), (0, 10), [0.0], (starts,)
        assert len(told(lambda a=asked, s=simd: solve_ensemble(*a, simd=s))[1]) == 1


@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Vern9"])
def test_a_stepper_takes_the_steps_without_switching_times_and_tells(method):
    stepper = Stepper(pulsed(), 0.0, [0.0], 10.0, method=method)

    def to_the_end():
        ended(stepper)

    _, said = told(to_the_end)
    lost = method == "RK45" or stepper.y[0] == 0.0
    assert len(said) == lost and stepper.status == "finished" and stepper.t == 10.0


def test_auto_ends_the_steps_of_radau():
    """Stiff after a while, with a pulse while the solution rests; Radau's own steps lose it."""

    def stiff(t, y):
        u = 1.0 if 5e3 < t < 5e3 + 1 else 0.0
        return [-1e4 * (y[0] - math.cos(1e-3 * t)) + 1e4 * u, y[0] - y[1]]

    right = solve_ivp(stiff, (0, 5003), [1.0, 1.0], "Radau", breakpoints=[5e3, 5e3 + 1], rtol=1e-8)
    run = solve_ivp(stiff, (0, 5003), [1.0, 1.0], "auto", rtol=1e-4)
    assert run.method == "Radau" and np.isin([5e3, 5e3 + 1], run.t).all()
    assert np.abs(run.y[:, -1] - right.y[:, -1]).max() < 1e-3
    lost = told(lambda: solve_ivp(stiff, (0, 5003), [1.0, 1.0], "Radau", rtol=1e-4))
    assert len(lost[1]) == 1 and not np.isin(5e3, lost[0].t)
