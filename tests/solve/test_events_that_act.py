"""Claims about events that change the state, by a ball that bounces."""

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn import CompileWarning, Phase, Stepper, prepare, solve_ivp, solve_phases
from fastdyn.kernels.methods import METHODS
from tests.support.impacts import (
    ball_after,
    bounce,
    bounce_where_it_is,
    falling,
    ground,
    impacts,
    last_impact,
    marked,
)

EPS = np.finfo(float).eps
TIGHT = {"rtol": 1e-9, "atol": 1e-12}
BALL = {"events": ground, "on_event": bounce, "args": (0.8,), **TIGHT}
DROPPED = [1.0, 0.0]
EXACT_ON_PARABOLAS = [
    n for n, m in METHODS.items() if m.order > 2 and not m.second_order and n != "BDF"
]
ROOT = 4 * EPS * 4.0  # Brent's tolerance for times up to 3 s


def drop(t_span=(0.0, 3.0), y0=DROPPED, **options):
    return solve_ivp(falling, t_span, y0, **{**BALL, **options})


def in_steps(method, step):
    given = {"events": ground, "on_event": bounce, "args": (0.8,), "step": step}
    return solve_ivp(falling, (0.0, 3.0), DROPPED, method, **given)


@pytest.mark.parametrize("method", EXACT_ON_PARABOLAS)
def test_a_ball_bounces_when_geometry_says(method):
    run = drop(method=method) if METHODS[method].error_order else in_steps(method, 0.03)
    n = int((impacts(0.8, 20) < 3.0).sum())
    off = np.abs(run.t_events[0] - impacts(0.8, n))
    slack = 8 * n * ROOT if method != "Tsit5" else 1e-12  # whose table is printed to 1e-13
    assert run.success and off.max() <= slack and run.t[-1] == 3.0
    assert np.abs(run.y[:, -1] - ball_after(0.8, 3.0)[:, 0]).max() <= 25 * slack
    twice = np.flatnonzero(np.diff(run.t) == 0.0)
    assert np.array_equal(run.t[twice], run.t_events[0])
    assert np.array_equal(run.y[:, twice].T, run.y_events[0])
    assert np.array_equal(run.y[1, twice + 1], -0.8 * run.y[1, twice])
    assert np.all(run.y[0, twice + 1] == 0.0)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("jump", [bounce, bounce_where_it_is])
@pytest.mark.parametrize("direction", [-1, 0])
@pytest.mark.parametrize("e", [0.9, 0.5, 0.1, 0.01])
def test_the_ball_comes_to_rest_with_a_sentence(jump, direction, e):
    """Impacts are followed to the end of what their times can resolve, and none is missed."""
    run = drop((0.0, 50.0), events=marked(ground, direction=direction), on_event=jump, args=(e,))
    assert run.status == -1 and "(Zeno)" in run.message
    found = run.t_events[0]
    apart = 16 * 4 * EPS * (1.0 + last_impact(e))  # nearer ones are not told apart
    sure = int((np.diff(impacts(e, 400)) > 2 * apart).sum()) + 1
    most = int((np.diff(impacts(e, 400)) > 0.5 * apart).sum()) + 2
    assert sure <= len(found) <= most
    slack = 8 * len(found) * 4 * EPS * (1.0 + last_impact(e))
    assert np.abs(found - impacts(e, len(found))).max() <= slack
    assert abs(run.t[-1] - last_impact(e)) <= slack + 2 * apart / (1.0 - e)
    assert np.abs(run.y[:, -1]).max() <= 1e-11 and run.y[0].min() >= -1e-14


def test_steps_chunks_and_tiers_give_the_same_bits(monkeypatch):
    given = {"dense_output": True, "t_span": (0.0, 4.0)}
    whole = drop(compile="shared", **given)
    monkeypatch.setattr(fastdyn.run.loop, "CHUNK_SECONDS", 1e-9)  # a step a chunk
    monkeypatch.setattr(fastdyn.run.output, "PIECE", 4)
    for tier in ("shared", "inlined"):
        again = drop(compile=tier, **given)
        for name in ("t", "y", "nfev", "n_accepted", "t_events", "y_events", "status"):
            assert np.array_equal(again[name], whole[name]), name
        assert np.array_equal(again.sol.polynomials, whole.sol.polynomials)
    assert len(whole.t) > 8


def test_each_part_is_the_solve_of_a_phase():
    """First step, derivative and events begin as those of a new solve: the same bits."""
    phase = Phase(falling, marked(ground, terminal=True), lambda t, y, e: ("up", bounce(t, y, e)))
    phases = solve_phases({"up": phase}, "up", (0.0, 3.0), DROPPED, args=(0.8,), **TIGHT)
    run = drop()
    for name in ("t", "y", "nfev", "n_accepted", "n_rejected"):
        assert np.array_equal(run[name], phases[name]), name
    fast = drop(first_step=1e-3, max_step=0.02)
    steps = np.diff(fast.t)
    after = np.flatnonzero(steps == 0.0) + 1
    assert np.allclose(steps[after], 1e-3, rtol=0, atol=4 * EPS)


def test_output_times_and_dense_output_have_the_state_before():
    found = drop().t_events[0]
    times = np.sort(np.r_[np.linspace(0.0, 3.0, 61), found])
    dense, at = drop(dense_output=True), drop(t_eval=times)
    hit = np.isin(times, found)
    assert np.array_equal(at.t, times) and hit.sum() == len(found)
    assert np.abs(at.y - ball_after(0.8, times))[:, ~hit].max() <= 1e-12
    assert np.abs(at.y[:, hit].T - dense.y_events[0]).max() <= 1e-14
    assert np.abs(dense.sol(times) - at.y).max() <= 1e-14
    first = dense.t_events[0][0]
    before, after = dense.sol([first, np.nextafter(first, 4.0)])[1]
    assert before < -4.0 and after == pytest.approx(-0.8 * before)
    assert np.all(np.diff(dense.sol.ts) > 0.0)


def test_terminal_says_whether_the_run_ends():
    goes_on = drop(events=marked(ground, terminal=True))
    assert goes_on.status == 0 and np.array_equal(goes_on.y, drop().y)
    run = drop(events=marked(ground, terminal=3))
    assert run.status == 1 and len(run.t_events[0]) == 3 and run.t[-1] == run.t_events[0][2]
    assert np.array_equal(run.y[:, -1], run.y_events[0][2]) and run.y[1, -1] < 0.0
    assert np.array_equal(run.t, goes_on.t[: len(run.t)])

    def late(t, y, e):
        return t - 1.0

    run = drop(events=[ground, marked(late, terminal=True)], on_event=[bounce, None])
    assert run.status == 1 and run.t[-1] == 1.0 and len(run.t_events[0]) == 1


def test_events_that_look_on_see_each_crossing_once():
    top = marked(lambda t, y, e: y[1], direction=-1)
    low = marked(lambda t, y, e: y[0] - 0.5)
    run = drop(events=[top, ground, low, ground], on_event=[None, bounce, None, None])
    n = len(run.t_events[1])
    ends = impacts(0.8, n + 1)
    tops = ends[:-1] + 0.5 * np.diff(ends)
    assert np.allclose(run.t_events[0], np.r_[0.0, tops[tops < 3.0]], rtol=0, atol=1e-9)
    assert np.array_equal(run.t_events[1], run.t_events[3])
    assert len(run.t_events[2]) == 3  # 0.64 m after the first, 0.41 m after the second


@pytest.mark.parametrize("e", [1.0, 0.8])
def test_backwards_the_ball_comes_back(e):
    ahead = drop((0.0, 2.0), args=(e,))
    back = drop((2.0, 0.0), ahead.y[:, -1], on_event=lambda t, y, e: [0.0, -y[1] / e], args=(e,))
    assert back.success and np.all(np.diff(back.t) <= 0.0)
    n = len(ahead.t_events[0])
    assert np.abs(back.t_events[0] - ahead.t_events[0][::-1]).max() <= 100 * n * ROOT
    assert np.abs(back.y[:, -1] - DROPPED).max() <= 1000 * n * ROOT


@pytest.mark.parametrize("at", ["impact", "before", "after", "many"])
def test_a_breakpoint_anywhere_changes_nothing(at):
    (first,) = impacts(0.8, 1)
    breaks = {
        "impact": [first, float(drop().t_events[0][0])],
        "before": [np.nextafter(first, 0.0)],
        "after": [np.nextafter(first, 9.0)],
        "many": np.arange(0.0, 3.0, 0.01),
    }[at]
    run = drop(breakpoints=breaks)
    assert run.success and len(run.t_events[0]) == len(drop().t_events[0])
    assert np.abs(run.y[:, -1] - drop().y[:, -1]).max() <= 1e-12


def test_what_is_not_compiled_runs_in_python_to_the_same_bits():
    log = []

    def noted(t, y, e):
        log.append(t)
        return bounce(t, y, e)

    with pytest.warns(CompileWarning, match="noted"):
        run = drop(on_event=noted)
    assert np.array_equal(run.y, drop().y) and np.array_equal(run.t_events[0], log)


def test_prepared_solvers_and_checkpoints_take_it(tmp_path):
    ball = prepare(falling, (0.0, 3.0), DROPPED, **BALL)
    assert np.array_equal(ball(args=(0.6,)).y, drop(args=(0.6,)).y)
    rates = np.linspace(0.5, 0.9, 7)
    many = ball.many(args=(rates,))
    for i, e in enumerate(rates):
        one = drop(args=(float(e),))
        assert np.array_equal(many.y[i], one.y[:, -1]) and many.status[i] == one.status
    file = tmp_path / "ball"
    part = drop(checkpoint=file, max_steps=17)
    assert part.status == -1
    whole = drop(checkpoint=file)
    assert np.array_equal(whole.y, drop().y) and np.array_equal(whole.t_events, drop().t_events)
    with pytest.raises(ValueError, match="another run; what differs: "):
        drop(checkpoint=file, on_event=lambda t, y, e: [0.0, -y[1]])


@pytest.mark.parametrize(
    "jump, error, sentence",
    [
        (lambda t, y, e: [0.0], ValueError, "`on_event` returned 1 value for a state of 2"),
        (lambda t, y, e: None, TypeError, "`on_event` returned None; it must return 2 numb"),
        (lambda t, y, e: [0.0, 1j], TypeError, "`on_event` returned complex numbers"),
        (lambda t, y, e: {}["there"], KeyError, "there"),
        ([bounce, bounce], ValueError, "it has 2, and there are 1 events"),
        ([3], TypeError, "`on_event` must be a function"),
    ],
)
def test_wrong_functions_get_a_sentence(jump, error, sentence):
    with pytest.raises(error, match=sentence):
        drop(on_event=jump)


def test_what_is_not_there_is_refused():
    for options, sentence in (
        ({"events": None}, "there are 0 events"),
        ({"method": OdeSolver}, "`on_event` is for compiled methods"),
        ({"callback": print}, "`on_event` and `callback` do not go together"),
        ({"y0": [1.0 + 0j, 0.0]}, "`on_event`: for real states only"),
    ):
        with pytest.raises(ValueError, match=sentence):
            drop(**options)
    with pytest.raises(ValueError, match="there are 0 events"):
        Stepper(falling, 0.0, DROPPED, 1.0, on_event=bounce)
    with pytest.raises(ValueError, match="phases take no `on_event`"):
        solve_phases({}, "up", (0.0, 1.0), DROPPED, on_event=bounce)


def test_a_state_that_is_no_number_ends_the_run():
    run = drop(on_event=lambda t, y, e: [0.0, np.nan])
    assert run.status == -1 and run.y[0, -1] == pytest.approx(0.0, abs=1e-15)
    assert run.message == (
        "`on_event` of event 0, `ground`, returned nan or inf at t = 0.451523641 (component 1)."
    )
    run = solve_ivp(
        lambda t, y: [y[1], -np.sqrt(y[1] + 9.0)], (0, 9), [1.0, 0.0], events=lambda t, y: y[0],
        on_event=lambda t, y: [0.0, -10.0],
    )  # fmt: skip
    assert run.status == -1 and "at the state that `on_event` returned, t = " in run.message
