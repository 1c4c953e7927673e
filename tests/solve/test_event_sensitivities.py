"""Claims about derivatives of the times of events and of the states there: exact formulas."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

import fastdyn
from fastdyn import solve_ivp
from fastdyn.solve import by_method
from tests.support.impacts import marked

TIGHT = {"rtol": 1e-11, "atol": 1e-13}
CLOSE = {"rtol": 1e-8, "atol": 1e-9}  # 1e-11 a step, and the steps of a run


def fall(t, y, g, e):
    return [y[1], -g]


def height(t, y, g, e):
    return y[0]


height.direction = -1


def bounce(t, y, g, e):
    return [0.0, -e * y[1]]


def test_a_bouncing_ball():
    h, g, e = 1.3, 9.81, 0.8
    given = {"args": (g, e), "events": height, "on_event": bounce, **TIGHT}
    r = solve_ivp(fall, (0, 2.2), [h, 0.0], sensitivity=("y0", "args"), **given)
    ((t, y),) = r.event_sensitivity
    k = np.arange(3)
    first = math.sqrt(2 * h / g)
    bounces = first * (1 + 2 * np.array([0, e, e + e**2]))  # the times
    assert np.allclose(r.t_events[0], bounces, rtol=1e-9)
    assert list(t) == list(y) == ["y0", "g", "e"]
    assert np.allclose(t["y0"][0], bounces / (2 * h), **CLOSE)
    assert np.allclose(t["g"], -bounces / (2 * g), **CLOSE)
    assert np.allclose(t["e"], 2 * first * np.array([0, 1, 1 + 2 * e]), **CLOSE)
    assert np.allclose(y["g"][0], 0.0, **CLOSE)  # the ball is on the ground
    speed = math.sqrt(2 * g * h)
    assert np.allclose(y["g"][1], -(e**k) * speed / (2 * g), **CLOSE)
    assert np.allclose(y["e"][1], -k * e ** (k - 1.0) * speed, **CLOSE)
    assert np.allclose(y["y0"][1, 0], -(e**k) * speed / (2 * h), **CLOSE)
    plain = solve_ivp(fall, (0, 2.2), [h, 0.0], **given)
    assert "event_sensitivity" not in plain


def swing(t, y, k):
    return [y[1], -k * np.sin(y[0])]


def test_the_quarter_period_of_a_pendulum():
    """T / 4 = K(sin(a / 2)^2) / sqrt(k), for a pendulum released at the angle a."""
    a, k, h = 1.9, 4.0, 1e-5

    def quarter(a, k):
        return ellipk(math.sin(a / 2) ** 2) / math.sqrt(k)

    down = marked(lambda t, y, k: y[0], terminal=True)
    r = solve_ivp(swing, (0, 9), [a, 0.0], args=(k,), events=down, sensitivity=("y0", "k"), **TIGHT)
    found = r.event_sensitivity[0]
    by_a = (quarter(a + h, k) - quarter(a - h, k)) / (2 * h)  # off by h^2
    assert found.t["y0"].shape == (2, 1) and found.y["k"].shape == (2, 1)
    assert abs(found.t["y0"][0, 0] - by_a) < 1e-8
    assert abs(found.t["k"][0] + quarter(a, k) / (2 * k)) < 1e-8
    speed = -2 * math.sqrt(k) * math.sin(a / 2)  # at the bottom
    assert np.allclose(found.y["k"][:, 0], [0.0, speed / (2 * k)], **CLOSE)
    assert np.allclose(found.y["y0"][:, 0, 0], [0.0, -math.sqrt(k) * math.cos(a / 2)], **CLOSE)
    assert r.sensitivity["k"][1, -1] != found.y["k"][1, 0]  # at a fixed time


def test_events_of_time_and_of_arguments():
    """exp(-k t) = level(t, w): differentiated by hand."""

    def decays(t, y, k, w):
        return [-k * y[0]]

    def level(t, y, k, w):
        return y[0] - w[0] - w[1] * t * k

    k, w = 0.7, np.array([0.2, 0.1])
    r = solve_ivp(
        decays, (0, 5), [1.0], args=(k, w), events=[level, marked(lambda t, y, k, w: y[0] + 1.0)],
        sensitivity=("w", "k", "y0"), **TIGHT,
    )  # fmt: skip
    found, never = r.event_sensitivity
    t = r.t_events[0][0]
    y = math.exp(-k * t)
    crossing = -k * y - w[1] * k
    assert np.allclose(found.t["w"][:, 0], [1 / crossing, t * k / crossing], **CLOSE)
    assert np.allclose(found.t["k"], (t * y + w[1] * t) / crossing, **CLOSE)
    assert np.allclose(found.t["y0"][0], -y / crossing, **CLOSE)
    assert np.allclose(found.y["w"][0, :, 0], -k * y * found.t["w"][:, 0], **CLOSE)
    assert never.t["w"].shape == (2, 0) and never.y["w"].shape == (1, 2, 0)


def test_schedules_do_not_move_and_discrete_states_have_their_part():
    def pushed(t, y, d, k):
        return [y[1], -k * y[0] + d[0]]

    def turned(t, y, d, k):
        return y, [-0.5 * d[0]]

    def crossed(t, y, d, k):
        return y[0] - d[0]

    given = {"args": (2.0,), "discrete": [0.5], "events": crossed, "every": 1.5, **TIGHT}
    given["on_event"] = [None, turned]
    r = solve_ivp(pushed, (0, 4), [1.0, 0.0], sensitivity=("y0", "k"), **given)
    event, schedule = r.event_sensitivity
    assert list(event.t) == list(event.y) == ["y0", "k", "discrete"]
    assert event.y["y0"].shape == (2, 2, len(r.t_events[0]))
    assert event.t["discrete"].shape == (1, len(r.t_events[0]))
    assert not schedule.t["k"].any() and schedule.y["discrete"].shape == (2, 1, 3)

    def first(d, k):
        options = {**given, "args": (k,), "discrete": [d]}
        return solve_ivp(pushed, (0, 4), [1.0, 0.0], **options).t_events[0][0]

    h = 1e-5
    by_d = (first(0.5 + h, 2.0) - first(0.5 - h, 2.0)) / (2 * h)
    by_k = (first(0.5, 2.0 + h) - first(0.5, 2.0 - h)) / (2 * h)
    assert abs(by_d - event.t["discrete"][0, 0]) < 1e-6 and abs(by_k - event.t["k"][0]) < 1e-6


@pytest.mark.filterwarnings("ignore:.*runs in Python")
def test_an_event_that_runs_in_python_has_none():
    seen = []

    def noted(t, y, k):
        seen.append(t)
        return y[1] + 0.5

    r = solve_ivp(
        swing, (0, 2), [1.0, 0.0], args=(4.0,), events=[noted, lambda t, y, k: y[0]],
        sensitivity="k",
    )  # fmt: skip
    assert r.t_events[0].size and r.event_sensitivity[0] is None
    assert r.event_sensitivity[1].t["k"].shape == (1,)


@pytest.mark.filterwarnings("ignore:.*runs in Python")
def test_a_function_in_python_leaves_the_sensitivities_right():
    """Outside values are read again after Python code; other code is refused in a sentence."""
    state, seen = {"push": 0.5}, []

    def pushed(t, y, k):
        return [y[1], -k * np.sin(y[0]) + state["push"]]

    def down(t, y, k):
        seen.append(t)
        return y[0]

    def kicked(t, y, k):
        return [y[0], -0.9 * y[1] + k]

    def changed(t, y, k):
        if t > 0.5:
            state["push"] = state.get("next", 0.5)
        return y[0] - 5.0

    given = {"args": (4.0,), "sensitivity": "k", "t_eval": [2.0], "rtol": 1e-9, "atol": 1e-9}
    span, y0 = (0, 2), [1.0, 0.0]
    crossings = {"events": [lambda t, y, k: y[0], down], "on_event": [kicked, None]}
    acts = solve_ivp(pushed, span, y0, **crossings, **given)
    moves = solve_ivp(pushed, span, y0, events=changed, **given)
    plain = solve_ivp(pushed, span, y0, events=lambda t, y, k: y[0], on_event=kicked, **given)
    assert np.allclose(acts.sensitivity["k"], plain.sensitivity["k"], rtol=1e-6)
    kept = solve_ivp(pushed, span, y0, **given)
    assert np.allclose(moves.sensitivity["k"], kept.sensitivity["k"], rtol=1e-6)
    assert abs(kept.sensitivity["k"]).min() > 0.1
    state["next"] = "none"
    with pytest.raises((ValueError, TypeError), match="reads what another function"):
        solve_ivp(pushed, span, y0, events=changed, **given)


def test_repeated_calls_have_the_results_of_first_ones(monkeypatch):
    """With other values, spans, closures, and marks of the events."""

    def level(height):
        def crosses(t, y, k):
            return y[0] - height

        return crosses

    def turns(t, y, k):
        return k * y[1]

    def solve(k=4.0, height=0.3, a=1.0, end=2.0, **marks):
        events = [marked(level(height), **marks), turns]
        r = solve_ivp(
            swing, (0.0, end), [a, 0.0], args=(k,), events=events, sensitivity=("k", "y0"),
            rtol=1e-9, atol=1e-9,
        )  # fmt: skip
        found = [r.y, r.sensitivity["k"], r.sensitivity["y0"], *r.t_events, *r.y_events]
        for each in r.event_sensitivity:
            found += [None] if each is None else [*each.t.values(), *each.y.values()]
        return found

    asked = [
        {}, {"k": 3.0}, {"height": -0.2}, {"a": 40.0}, {"end": 1.5}, {"height": 5.0},
        {"terminal": True}, {"direction": 1.0}, {},
    ]  # fmt: skip
    first = [solve(**each) for each in asked]
    for _ in range(2):
        for each, known in zip(asked, first, strict=True):
            for one, other in zip(solve(**each), known, strict=True):
                assert (one is None and other is None) or np.array_equal(one, other)

    def never(*given):
        raise AssertionError("the long way")

    assert first[6][0].shape[1] < first[0][0].shape[1]  # terminal
    assert not first[7][3].size and first[0][3].size  # the angle falls through the level
    for _ in range(9):
        solve()
    assert solve(terminal=True)[0].shape == first[6][0].shape
    monkeypatch.setattr(by_method, "solve_with_sensitivities", never)
    assert len(solve(k=2.5)[3]) == 1


@pytest.mark.parametrize("first", [True, False])
def test_derivatives_stand_at_the_place_of_their_event(first):
    """A schedule does not move, whether it stands before or behind an event that does."""

    def ramp(t, y, k):
        return [k]

    def limit(t, y, k):
        return y[0] - 1.0

    events = [fastdyn.at([0.25]), limit] if first else [limit, fastdyn.at([0.25])]
    r = solve_ivp(ramp, (0, 2), [0.0], args=(2.0,), events=events, sensitivity="k", **TIGHT)
    moves, stays = r.event_sensitivity[::-1] if first else r.event_sensitivity
    assert np.allclose(moves.t["k"], -0.25, rtol=1e-9)  # of 1 / k
    assert stays.t["k"] == 0.0 and np.allclose(stays.y["k"], 0.25)
