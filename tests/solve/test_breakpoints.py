"""Claims about breakpoints: what happens between one step and the next."""

import math

import numpy as np
import pytest
import scipy.integrate
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.methods import METHODS
from fastdyn.problem.step_options import segments_of_members, segments_of_span
from fastdyn.problem.validate import SHARED_METHODS
from fastdyn.systems import building

ADAPTIVE = [name for name, m in METHODS.items() if m.error_order and not m.series and name != "BDF"]

EPS = np.finfo(float).eps


def triangle(t):
    """A wave of straight lines of period 1, and its integral from 0."""
    x = t % 1.0
    value = x if x < 0.5 else 1.0 - x
    inside = 0.5 * x * x if x < 0.5 else 0.25 - 0.5 * (1.0 - x) ** 2
    return value, 0.25 * (t - x) + inside


def square(t, y):
    """A derivative that jumps every half second."""
    return [1.0 if t % 1.0 < 0.5 else -1.0]


def driven(t, y):
    x = t % 1.0
    return [y[1], (x if x < 0.5 else 1.0 - x) - y[0] + math.sin(y[0])]


@pytest.mark.filterwarnings("ignore::fastdyn.SwitchingWarning")  # of RK45 without breakpoints
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("span", [(0.0, 9.75), (9.75, 0.0)])
def test_steps_end_at_breakpoints_and_a_jump_costs_nothing(method, span):
    breaks = np.arange(0.0, 10.0, 0.5)
    options = {"rtol": 1e-8, "atol": 1e-10, "breakpoints": breaks}
    exact = np.vectorize(lambda t: triangle(t)[0])
    run = solve_ivp(square, span, exact([span[0]]), method, dense_output=True, **options)
    assert run.success and run.t[-1] == span[1]
    assert np.isin(breaks[1:], run.t).all() and run.n_rejected == 0
    assert np.abs(run.y[0] - exact(run.t)).max() <= 128 * EPS
    t = np.sort(np.r_[np.linspace(0.0, 9.75, 333), breaks])
    assert np.abs(run.sol(t)[0] - exact(t)).max() <= 2e-14
    t = np.unique(t)[:: 1 if span[1] > 0.0 else -1]
    at = solve_ivp(square, span, exact([span[0]]), method, t_eval=t, **options)
    assert np.array_equal(at.t, t) and np.abs(at.y[0] - exact(t)).max() <= 2e-14
    plain = solve_ivp(square, span, exact([span[0]]), method, rtol=1e-8, atol=1e-10)
    if method in SHARED_METHODS or METHODS[method].like_matlab:
        assert plain.nfev > 5 * run.nfev
    else:  # whose steps end there unasked
        assert plain.n_accepted == run.n_accepted


def test_bdf_begins_anew_behind_breakpoints():
    """At order 1, whose error it bounds in each step: no step is refused for the jump."""
    breaks = np.arange(0.0, 10.0, 0.5)
    run = solve_ivp(square, (0.0, 9.75), [0.0], "BDF", breakpoints=breaks, rtol=1e-6, atol=1e-8)
    exact = [triangle(t)[0] for t in run.t]
    assert run.success and np.isin(breaks[1:], run.t).all() and run.n_rejected == 0
    assert np.abs(run.y[0] - exact).max() <= 128 * EPS


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "Tsit5"])
def test_landing_on_kinks_keeps_the_order(method):
    """Steps of one size that does not divide the half period, cut short at the kinks or not."""
    tight = {"rtol": 1e-13, "atol": 1e-14, "method": "DOP853"}
    y = [0.5, 0.0]
    for k in range(12):  # piece by piece
        end = 0.5 * (k + 1)
        y = scipy.integrate.solve_ivp(driven, (0.5 * k + 1e-15, end - 1e-15), y, **tight).y[:, -1]
    steps = 0.42 / 2.0 ** np.arange(2 if METHODS[method].order > 5 else 4)
    slopes = {}
    for name, breaks in (("landed", np.arange(0.5, 6.0, 0.5)), ("not", None)):
        errors = []
        for h in steps:
            given = {"first_step": h, "max_step": h, "rtol": 1e9, "atol": 1e9}
            run = solve_ivp(driven, (0.0, 6.0), [0.5, 0.0], method, breakpoints=breaks, **given)
            errors.append(np.abs(run.y[:, -1] - y).max())
        slopes[name] = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    order = METHODS[method].order
    assert slopes["landed"] > order - 0.8
    if method in SHARED_METHODS:  # others land unasked
        assert slopes["not"] < 3.2 and (order == 3 or slopes["not"] < order - 1.5)


def test_landing_keeps_the_order_of_a_sampled_earthquake():
    times = np.linspace(0.0, 4.0, 17)
    ground = 0.1 * np.random.default_rng(2).normal(size=17)
    house = building.sampled(times, displacements=ground, k=5.0)
    exact = house.solve((0.0, 5.0), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    slopes = []
    for options in ({}, {"breakpoints": None}):
        errors = []
        steps = 0.11 / 2.0 ** np.arange(4)
        for h in steps:
            given = {"first_step": h, "max_step": h, "rtol": 1e9, "atol": 1e9, **options}
            errors.append(np.abs(house.solve((0.0, 5.0), **given).y[:, -1] - exact).max())
        slopes.append(np.polyfit(np.log(steps), np.log(errors), 1)[0])
    assert slopes[0] > 4.2 and slopes[1] < 3.2


@pytest.mark.parametrize(
    "breaks", [[], [-3.0, 20.0], [0.0, 1.0], [0.5, 0.5, 0.5], [0.9, 0.1], [math.inf, 0.3]]
)
@pytest.mark.filterwarnings("ignore:`breakpoints` have no effect")
def test_any_set_of_breakpoints_gives_the_same_answer(breaks):
    given = {"rtol": 1e-8, "atol": 1e-10, "breakpoints": breaks}
    run = solve_ivp(lambda t, y: -y, (0, 1), [1.0], **given)
    assert run.success and run.t[-1] == 1.0 and np.all(np.diff(run.t) > 0.0)
    assert run.y[0, -1] == pytest.approx(math.exp(-1), rel=1e-7)
    assert np.isin([b for b in breaks if 0 < b < 1], run.t).all()


def test_breakpoints_with_events_chunks_and_the_two_tiers(monkeypatch):
    def hit(t, y):
        return y[0] - 0.25

    given = {"breakpoints": np.arange(0.5, 40.0, 0.5), "events": hit, "rtol": 1e-6}
    whole = solve_ivp(square, (0, 40), [0.0], **given)
    crossings = np.sort(np.r_[np.arange(40) + 0.25, np.arange(40) + 0.75])
    assert np.allclose(whole.t_events[0], crossings, rtol=0, atol=1e-9)
    monkeypatch.setattr(fastdyn.run.loop, "CHUNK_SECONDS", 1e-9)  # a step a chunk
    for tier in ("shared", "inlined"):
        again = solve_ivp(square, (0, 40), [0.0], compile=tier, **given)
        assert np.array_equal(again.y, whole.y) and again.nfev == whole.nfev


@pytest.mark.parametrize(
    "options, error, sentence",
    [
        ({"breakpoints": [math.nan]}, ValueError, "NaN"),
        ({"breakpoints": [[1.0]]}, ValueError, "1-D"),
        ({"breakpoints": [1.0], "method": OdeSolver}, ValueError, "`breakpoints` is for compiled"),
        ({"project": 3}, ValueError, "`project` must be a function"),
        ({"project": lambda t, y: y, "method": OdeSolver}, ValueError, "`project` is for compiled"),
        ({"project": lambda t, y: [1.0, 2.0]}, ValueError, "2 values for a state of 1"),
        ({"project": lambda t, y: None}, TypeError, "returned None"),
    ],
)
def test_wrong_breakpoints_and_projections_get_a_sentence(options, error, sentence):
    with pytest.raises(error, match=sentence):
        solve_ivp(lambda t, y: -y, (0, 2), [1.0], **options)


def test_a_fixed_step_says_that_breakpoints_have_no_effect():
    with pytest.warns(UserWarning, match="no effect.*`breakpoints`"):
        solve_ivp(lambda t, y: -y, (0, 2), [1.0], "RK4", step=0.1, breakpoints=[1.0])


def one(t, y):
    return [1.0]


def test_an_event_at_a_breakpoint_occurs_once():
    run = solve_ivp(one, (0, 5), [0.0], breakpoints=[3.0], events=lambda t, y: t - 3.0)
    assert np.array_equal(run.t_events[0], [3.0])

    def late(t, y):
        return t - 0.30000000000000004

    late.terminal = True
    run = solve_ivp(one, (0, 1), [0.0], breakpoints=[0.3, 0.6], events=late)
    assert run.status == 1 and run.t[-1] == pytest.approx(0.3, abs=4 * EPS)


def test_many_breakpoints_lose_no_time():
    run = solve_ivp(one, (0, 1000), [0.0], breakpoints=np.arange(0.0, 1000.0, 0.01))
    assert abs(run.y[0, -1] - 1000.0) <= 1000.0 * 1e5 * EPS / 300.0  # rounding, a random walk


def test_breakpoints_outside_the_span_do_not_matter():
    run = solve_ivp(square, (0.0, 4.75), [0.0], breakpoints=[*np.arange(0.0, 5.0, 0.5), 1e16])
    assert run.y[0, -1] == pytest.approx(0.25, abs=64 * EPS)


@pytest.mark.parametrize("span", [(0.0, 5.0), (5.0, 0.0)])
def test_a_jump_at_the_end_of_the_span_is_seen_from_inside(span):
    run = solve_ivp(square, span, [0.0], rtol=1e-9, breakpoints=np.arange(0.0, 5.5, 0.5))
    assert abs(run.y[0, -1]) <= 128 * EPS and run.n_rejected == 0


def test_an_event_in_a_last_step_that_overshoots_is_where_it_is():
    run = solve_ivp(one, (0, 1), [0.0], "RK4", step=0.3, events=lambda t, y: y[0] - 0.95)
    assert run.t_events[0] == pytest.approx([0.95], abs=1e-12)


@pytest.mark.parametrize("method", ["RK4", "Gauss8", "VelocityVerlet"])
def test_constant_steps_have_no_breakpoints(method):
    """The option is named in a warning, and changes nothing."""
    given = (lambda t, y: [y[1], np.cos(t)], (0.0, 2.0), [0.0, 1.0], method)
    plain = solve_ivp(*given, step=0.3)
    with pytest.warns(UserWarning, match="no effect .*`breakpoints`"):
        result = solve_ivp(*given, step=0.3, breakpoints=[0.5, 1.0])
    assert np.array_equal(result.t, plain.t) and np.array_equal(result.y, plain.y)


def test_segments_of_one_span_are_those_of_many():
    """Breakpoints at the ends, within roundings of each other, beyond the span, in any order."""
    rng = np.random.default_rng(0)
    ends = (0.0, 1.0, -1.0, 1e6, 0.3, 1e-7, 1e-300, math.inf, -math.inf)
    near = (0.0, 1e-16, 1e-15, -1e-15, 3e-15, 1e-10, 1e-9, 0.1, -0.1)
    for _ in range(2000):
        t0, tf = rng.choice(ends, 2, replace=False)
        if math.isinf(t0):
            continue
        last = tf if math.isfinite(tf) else 3.0
        m = rng.integers(0, 8)
        times = rng.choice((t0, last, 0.5 * (t0 + last)), m)
        times = times + rng.choice(near, m) * rng.integers(-3, 4, m)
        alone = segments_of_span(times, t0, tf)
        found, rows = segments_of_members(np.zeros(m, int), times, t0, tf, 1)
        assert np.array_equal(alone, found) and rows.tolist() == [0, len(alone)]
