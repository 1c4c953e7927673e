"""Claims about motion in phases, by a ball that bounces."""

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn.solve.phases import Phase, solve_phases
from support.impacts import falling, impacts

OPTIONS = {"rtol": 1e-9, "atol": 1e-12}


def ground(t, y, e):
    return y[0]


ground.direction, ground.terminal = -1, True


def bounce(t, y, e):
    return "up", [0.0, -e * y[1]]


def apex(t, y, e):
    return y[1]


apex.direction = -1
BALL = {"up": Phase(falling, ground, bounce)}


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "RK4"])
def test_a_ball_bounces_when_geometry_says(method):
    options = {"step": 0.01} if method == "RK4" else OPTIONS
    run = solve_phases(BALL, "up", (0.0, 3.0), [1.0, 0.0], method, args=(0.8,), **options)
    ends = [end for _, _, end in run.phases]
    exact = impacts(0.8, 9)
    n = int((exact < 3.0).sum())
    assert run.success and np.allclose(ends[:n], exact[:n], rtol=0, atol=1e-9)
    assert ends[-1] == 3.0 and len(ends) == n + 1
    twice = np.flatnonzero(np.diff(run.t) == 0.0)
    assert np.allclose(run.t[twice], exact[:n]) and np.all(np.diff(run.t) >= 0.0)


def test_output_times_dense_output_and_events_go_through_the_phases():
    t = np.linspace(0.0, 2.5, 51)
    given = {"args": (0.8,), "events": apex, **OPTIONS}
    dense = solve_phases(BALL, "up", (0.0, 2.5), [1.0, 0.0], dense_output=True, **given)
    at = solve_phases(BALL, "up", (0.0, 2.5), [1.0, 0.0], t_eval=t, **given)
    assert np.array_equal(at.t, t) and np.allclose(at.y, dense.sol(t), rtol=0, atol=1e-12)
    tops = impacts(0.8, 9)[:-1] + np.diff(impacts(0.8, 9)) / 2
    tops = tops[tops < 2.5]
    found = dense.t_events[0][-len(tops) :]
    assert np.allclose(found, tops, rtol=0, atol=1e-8)
    assert np.allclose(dense.y_events[0][-1][0], 0.8 ** (2 * len(tops)), atol=1e-8)
    assert dense.nfev > 0 and dense.n_accepted > 10


def test_phases_that_get_ever_shorter_stop_with_a_sentence():
    run = solve_phases(
        BALL, "up", (0.0, 9.0), [1.0, 0.0], args=(0.5,), max_phases=20, **OPTIONS
    )  # fmt: skip
    assert run.status == -1 and "`max_phases=20` was reached at t = 1.35" in run.message
    assert len(run.phases) == 20


def test_an_event_of_the_user_ends_the_motion():
    def late(t, y, e):
        return t - 1.0

    late.terminal = True
    run = solve_phases(BALL, "up", (0.0, 9.0), [1.0, 0.0], args=(0.8,), events=late, **OPTIONS)
    assert run.status == 1 and run.t[-1] == pytest.approx(1.0) and len(run.phases) == 2


def test_a_phase_that_fails_says_why():
    def explodes(t, y, e):
        return [y[0] ** 2, 0.0]

    phases = {"up": Phase(falling, ground, lambda t, y, e: ("end", [1.0, 0.0])),
              "end": Phase(explodes, ground, bounce)}  # fmt: skip
    run = solve_phases(phases, "up", (0.0, 9.0), [1.0, 0.0], args=(0.8,), **OPTIONS)
    assert run.status == -1 and "blows up" in run.message
    with pytest.raises(ValueError, match="1-dimensional"):
        solve_phases(BALL, "up", (0.0, 1.0), 1.0)
    assert fastdyn.solve.phases.Phase is Phase


def test_terminal_counts_and_max_steps_hold_for_the_whole_motion():
    def top(t, y, e):
        return y[1]

    top.terminal, top.direction = 3, -1
    run = solve_phases(BALL, "up", (0.0, 9.0), [1.0, 0.0], args=(0.8,), events=top, **OPTIONS)
    assert run.status == 1 and len(run.t_events[0]) == 3
    run = solve_phases(BALL, "up", (0.0, 3.0), [1.0, 0.0], args=(0.8,), max_steps=10, **OPTIONS)
    assert run.status == -1 and "`max_steps`" in run.message and run.n_accepted <= 12


@pytest.mark.parametrize(
    "phases, options, sentence",
    [
        ({"up": Phase(falling, lambda t, y, e: y[0], bounce)}, {}, "must be terminal"),
        ({"up": Phase(falling, ground, lambda t, y, e: ("walk", y))}, {}, "no phase 'walk'"),
        (BALL, {"method": OdeSolver}, "compiled method"),
        (BALL, {"max_phases": 0}, "at least 1"),
    ],
)
def test_wrong_phases_get_a_sentence(phases, options, sentence):
    with pytest.raises(ValueError, match=sentence):
        solve_phases(phases, "up", (0.0, 3.0), [1.0, 0.0], args=(0.8,), **options)


def test_a_phase_may_have_a_method_of_its_own_and_no_output():
    phases = {"up": BALL["up"]._replace(options={"method": "DOP853", "dense_output": True})}
    run = solve_phases(phases, "up", (0.0, 2.0), [1.0, 0.0], args=(0.8,), t_eval=[1.9], **OPTIONS)
    assert run.success and run.y.shape == (2, 1)
    assert solve_phases(BALL, "up", (0.0, 2.0), [1.0, 0.0], args=(0.8,), t_eval=[]).success


def of_a_wave(event, after=lambda t, y: ("b", y)):
    def wave(t, y):
        return [y[1], -y[0]]

    event.terminal = True
    return {"a": Phase(wave, event, after), "b": Phase(wave, event, lambda t, y: ("a", y))}


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5", "Vern9", "Radau"])
def test_a_crossing_that_goes_on_counts_once(method):
    """Both phases have one event, and the motion goes on: one crossing a period."""
    for level in np.linspace(0.2, 0.8, 7):

        def upwards(t, y, level=level):
            return y[0] - level

        upwards.direction = 1
        run = solve_phases(of_a_wave(upwards), "a", (0, 20), [0.0, 1.0], method, **OPTIONS)
        exact = np.arcsin(level) + 2 * np.pi * np.arange(4)
        ends = [end for *_, end in run.phases]
        assert ends == pytest.approx([*exact[exact < 20], 20.0], abs=1e-6)
        assert run.status == 0


@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Radau"])
@pytest.mark.parametrize("t_jump", [5.0, 8.0, 63.7])
def test_a_jump_that_ends_a_phase_counts_once_behind_another_state(method, t_jump):
    def pulse(t, y):
        return 0.7 if t_jump < t < t_jump + 0.1 else -0.3

    pulse.direction = 1
    both = of_a_wave(pulse, lambda t, y: ("b", [0.5, 0.0]))
    run = solve_phases(both, "a", (0, 80), [0.0, 1.0], method)
    assert [end for *_, end in run.phases] == pytest.approx([t_jump, 80.0], rel=1e-14)


@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Radau"])
@pytest.mark.parametrize("breakpoints", [None, [1e7]])
def test_an_endless_span_has_the_phases_of_a_span_that_ends(method, breakpoints):
    def upwards(t, y):
        return y[0] - 0.5

    def late(t, y):
        return t - 20.0

    upwards.direction = 1
    late.terminal = True
    ends = []
    for tf in (2e7, np.inf):
        given = of_a_wave(upwards), "a", (0, tf), [0.0, 1.0], method
        options = OPTIONS if breakpoints is None else {**OPTIONS, "breakpoints": breakpoints}
        run = solve_phases(*given, events=late, max_phases=20, **options)
        assert run.status == 1 and run.t[-1] == pytest.approx(20.0, abs=1e-12)
        ends.append([end for *_, end in run.phases][:-1])
    assert ends[1] == pytest.approx(ends[0], abs=1e-6)
    assert len(ends[0]) == 4


@pytest.mark.parametrize("largest", [1.0, 1e7])
def test_a_crossing_of_an_endless_span_counts_once_beside_a_late_breakpoint(largest):
    """The root may lie beside the breakpoint by the roundings of the largest time."""

    def upwards(t, y):
        return t - 5.0

    upwards.direction = 1
    upwards.terminal = True
    phase = Phase(lambda t, y: [1.0], upwards, lambda t, y: ("a", y))

    def stop(t, y):
        return t - 6.0

    stop.terminal = True
    times = [5.0 - 1e-9, 5.0 * largest]
    run = solve_phases({"a": phase}, "a", (0, np.inf), [0.0], events=stop, breakpoints=times)
    assert len(run.phases) == 2 and run.status == 1


def test_a_body_at_rest_on_the_ground_does_not_fall_through():
    """Its event is at the start of each phase, and the state behind is the same."""
    run = solve_phases(BALL, "up", (0.0, 1.0), [0.0, 0.0], args=(0.8,), max_phases=20)
    assert run.status == -1 and run.y[0].min() == 0.0


@pytest.mark.parametrize("look", [lambda t, y: y[0], lambda t, y: np.sinh(y[0])])
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5", "Vern9", "Radau"])
def test_events_see_the_zeros_that_end_phases(method, look):
    """With and without a jump behind them, once each."""

    def ground(t, y):
        return y[0]

    def upwards(t, y):
        return y[0] - 0.3

    def through(t, y):
        return look(t, [y[0] - 0.3])

    def falls(t, y):
        return [y[1], -9.81]

    ground.terminal = upwards.terminal = True
    ground.direction = -1
    upwards.direction = 1
    bouncing = {"up": Phase(falls, ground, lambda t, y: ("up", [0.0, -0.8 * y[1]]))}
    run = solve_phases(bouncing, "up", (0, 2.0), [1.0, 0.0], method, events=look, **OPTIONS)
    assert run.t_events[0].tolist() == pytest.approx([end for *_, end in run.phases[:-1]])
    run = solve_phases(of_a_wave(upwards), "a", (0, 40), [0.0, 1.0], method, events=through,
                       **OPTIONS)  # fmt: skip
    turns = 2 * np.pi * np.arange(7)
    exact = np.sort(np.r_[np.arcsin(0.3) + turns, np.pi - np.arcsin(0.3) + turns])
    assert run.t_events[0] == pytest.approx(exact[exact < 40], abs=1e-6)
    through.terminal = 3
    run = solve_phases(of_a_wave(upwards), "a", (0, 40), [0.0, 1.0], method, events=through,
                       **OPTIONS)  # fmt: skip
    assert run.status == 1 and run.t[-1] == pytest.approx(exact[2], abs=1e-6)
