"""Derivatives by a sweep back over events: actions, schedules, times of events and states there."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.solve.adjoint.keeping import Keeping
from support.discrete_solution import by_complex_steps, flat
from support.impacts import flight, marked
from support.thermostat import SWITCH, heated

TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def falling(t, y, g, e):
    return [y[1], -g]


def ground(t, y, g, e):
    return y[0]


def bounce(t, y, g, e):
    return [0.0 * y[0], -e * y[1]]


GROUND = marked(ground, direction=-1)
BALL = [1.3, 0.4], (9.81, 0.8)


@pytest.mark.parametrize("t_eval", [np.linspace(0.1, 2.2, 12), None])
@pytest.mark.parametrize("room", [Keeping.room, 9])
def test_a_ball_that_bounces(t_eval, room, monkeypatch):
    """The steps are exact for parabolas; only the times of impacts have errors, of rounding."""
    monkeypatch.setattr(Keeping, "room", room)
    how = {"events": GROUND, "on_event": bounce, "args": BALL[1], "max_step": 0.07}
    r = solve_ivp(falling, (0, 2.3), BALL[0], "RK45", t_eval, **how, adjoint=("y0", "args"))
    plain = solve_ivp(falling, (0, 2.3), BALL[0], "RK45", t_eval, **how)
    assert np.array_equal(r.y, plain.y) and len(r.t_events[0]) == 3
    times = r.t if t_eval is not None else r.t[-1:]
    g = np.zeros(r.y.shape)
    g[:, -len(times) :] = np.random.default_rng(0).normal(size=(2, len(times)))
    c = np.array([0.3, -1.0, 2.0])

    def number(*values):
        y, impacts = flight(times, *values)
        return (g[:, -len(times) :] * y).sum() + c @ impacts

    found = flat(r.vjp(g, t_events=[c]))
    assert np.allclose(found, by_complex_steps(number, *BALL), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("t_eval", [[0.1, 0.3], None])
@pytest.mark.parametrize("y0", [BALL[0], [1.0, 0.0]])
def test_the_event_that_ends_the_run(t_eval, y0):
    """The derivatives of the time, and of the state at this moving time."""
    ends = marked(ground, direction=-1, terminal=True)
    given = (falling, (0, 9), y0, "RK45", t_eval)
    r = solve_ivp(*given, args=BALL[1], events=ends, adjoint=("y0", "args"))
    assert r.status == 1

    def time(h, v, g, e):
        return (v + (v * v + 2 * g * h) ** 0.5) / g

    def speed(h, v, g, e):
        return v - g * time(h, v, g, e)

    assert np.allclose(
        flat(r.vjp(t_events=[[1.0]])), by_complex_steps(time, y0, BALL[1]), rtol=1e-10
    )
    found = flat(r.vjp(y_events=[[[5.0, 1.0]]]))  # the height there is 0
    assert np.allclose(found, by_complex_steps(speed, y0, BALL[1]), rtol=1e-10)
    both = flat(r.vjp(np.ones_like(r.y), t_events=[[2.0]]))
    assert np.allclose(both, flat(r.vjp(np.ones_like(r.y))) + 2 * flat(r.vjp(t_events=[[1.0]])))


def decays(t, y, k, dose):
    return [-k * y[0]]


@pytest.mark.parametrize("method", ["RK45", "Vern7"])
@pytest.mark.parametrize("backwards", [False, True])
def test_doses_at_known_times(method, backwards):
    """Each dose decays by itself; one falls on the start, one on a breakpoint."""
    times, doses = np.array([0.5, 1.5, 2.5, 3.0]), np.array([0.0, 1.0, 2.0])
    span, sign = ((0, 3.5), 1.0) if not backwards else ((0, -3.5), -1.0)

    def takes(t, y, k, dose):
        return [y[0] + dose * (1 + t)]

    r = solve_ivp(
        decays, span, [0.7], method, sign * times, args=(sign * 0.6, 2.0), at=np.sort(sign * doses),
        on_event=[takes], breakpoints=[sign * 1.0], **TIGHT, adjoint=("y0", "args"),
    )  # fmt: skip
    g = np.array([1.0, -2.0, 0.5, 3.0])

    def number(y0, k, dose):
        parts = [np.where(times > d, dose * (1 + sign * d) * np.exp(-k * sign * (times - d)), 0.0)
                 for d in doses]  # fmt: skip
        return g @ (y0 * np.exp(-k * sign * times) + sum(parts))

    expected = by_complex_steps(number, [0.7], (sign * 0.6, 2.0))
    assert np.allclose(flat(r.vjp(g[None])), expected, rtol=1e-8)


def rolling(t, y, g, drag, e, kick):
    return [y[1], -g - drag * y[1] * abs(y[1])]


def moving_floor(t, y, g, drag, e, kick):
    return y[0] - 0.1 * np.sin(3 * t)


def reflect(t, y, g, drag, e, kick):
    speed = 0.3 * np.cos(3 * t)
    return [y[0], speed - e * (y[1] - speed)]


def passing(t, y, g, drag, e, kick):
    return y[0] - 0.5


def kicked(t, y, g, drag, e, kick):
    return [y[0], y[1] + kick * np.sin(t)]


@pytest.mark.parametrize("method", ["Tsit5", "DOP853"])
def test_beside_forward_sensitivities(method):
    """A floor that moves, kicks twice at one time, an event that does not act; other steps."""
    kicks = fastdyn.at([0.3, 1.7])
    how = {
        "args": (9.81, 0.1, 0.8, 0.9),
        "events": [marked(moving_floor, direction=-1), kicks, passing, fastdyn.at([0.3])],
        "on_event": [reflect, kicked, None, kicked],
        **TIGHT,
    }
    given = (rolling, (0, 2), [1.0, 0.2], method, np.linspace(0.1, 1.9, 7))
    r = solve_ivp(*given, **how, adjoint=("y0", "args"))
    s = solve_ivp(*given, **how, sensitivity=("y0", "args"))
    rng = np.random.default_rng(0)
    g, counts = rng.normal(size=r.y.shape), [len(t) for t in r.t_events]
    assert counts[0] >= 3 and counts[1:] == [2, len(s.t_events[2]), 1]
    of_t = [rng.normal(size=k) for k in counts]
    of_y = [rng.normal(size=(k, 2)) for k in counts]
    found = r.vjp(g, t_events=[of_t[0], None, of_t[2], None], y_events=of_y)
    for name, value in found.items():
        expected = np.einsum("i...k,ik->...", s.sensitivity[name], g)
        for i, each in enumerate(s.event_sensitivity):
            expected = expected + np.einsum("i...k,ki->...", each.y[name], of_y[i])
            if i in (0, 2):
                expected = expected + each.t[name] @ of_t[i]
        assert np.allclose(value, expected, rtol=1e-5, atol=1e-5), name


def test_actions_at_one_time_and_an_end_that_comes_between():
    """Schedules act in their order; the second one at the same time ends the run."""
    first, last = fastdyn.at([0.5, 1.0]), fastdyn.at([1.0])
    last.terminal = 1
    r = solve_ivp(
        decays, (0, 2), [1.0], "RK45", [0.4, 1.0], args=(0.3, 2.0), events=[first, last],
        on_event=[lambda t, y, k, dose: dose * y, None], **TIGHT, adjoint=("y0", "args"),
    )  # fmt: skip
    assert r.status == 1
    found = flat(r.vjp(y_events=[None, [[1.0]]]))  # after both actions of `first`
    e = math.exp(-0.3)
    assert np.allclose(found, [4 * e, -4 * e, 4 * e], rtol=1e-9)
    found = flat(r.vjp([[0.0, 1.0]]))  # before the actions at this time
    assert np.allclose(found, [2 * e, -2 * e, e], rtol=1e-9)


def test_shorter_steps_meet_the_same_events():
    """Heat in a bar, which is warmed twice: the steps of error control are not stable."""
    x = np.linspace(0, 1, 200)
    bump = np.exp(-40 * (x - 0.4) ** 2)

    def heat(t, u, flow, dose):
        gain = flow * (u[1:] - u[:-1])
        return np.concatenate((gain[:1], gain[1:] - gain[:-1], -gain[-1:]))

    def heated(t, u, flow, dose):
        return u + dose * bump

    def solved(**how):
        r = solve_ivp(
            heat, (0, 40), bump, "Tsit5", [15.0, 40.0], args=(1.0 + 0.5 * np.sin(7 * x[1:]), 0.5),
            at=[10.0, 20.0], on_event=[heated], adjoint=("y0", "args"), **how,
        )  # fmt: skip
        before = sum(len(leg.t) for leg in r.vjp._legs)
        return flat(r.vjp(r.y)), before, sum(len(leg.t) for leg in r.vjp._legs)

    found, before, now = solved(rtol=1e-6, atol=1e-6)
    expected, *_ = solved(rtol=1e-9, atol=1e-9, max_step=0.2)
    assert now > before
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()


def test_an_event_that_does_not_cross_zero_has_no_derivative():
    flat = marked(lambda t, y, k, dose: (t - 1.0) ** 3)  # at a breakpoint, the root is exact
    r = solve_ivp(
        decays, (0, 2), [1.0], "RK45", [2.0], args=(1.0, 1.0), events=flat, breakpoints=[1.0],
        on_event=lambda t, y, k, dose: [y[0] + dose], adjoint="k",
    )  # fmt: skip
    with pytest.raises(ValueError, match="touches zero without crossing"):
        r.vjp([[1.0]])


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({}, TypeError, "`g` must be real numbers"),
        ({"t_events": [[1.0]]}, ValueError, "there are 2 events"),
        ({"t_events": 1.0}, ValueError, "an entry for each event"),
        ({"t_events": [[1.0, 2.0], None]}, ValueError, r"`t_events\[0\]` has .* \(3,\); got \(2,"),
        ({"y_events": [[[1.0]], None]}, ValueError, r"`y_events\[0\]`.* \(3, 2\); got \(1, 1\)"),
        ({"y_events": [np.full((3, 2), np.nan), None]}, ValueError, "nan or inf"),
        ({"t_events": [[1j, 0, 0], None]}, TypeError, "real numbers"),
        ({"t_events": [None, [1.0]]}, ValueError, "event 1 have no derivative: .*tgamma"),
    ],
)
def test_wrong_derivatives_at_events_are_told(given, error, words):
    r = solve_ivp(
        falling, (0, 2.3), BALL[0], t_eval=[1.0, 2.3], args=BALL[1],
        events=[GROUND, lambda t, y, g, e: math.gamma(t + 1) - 1.5], on_event=[bounce, None],
        adjoint="args",
    )  # fmt: skip
    assert [len(t) for t in r.t_events] == [3, 1]
    with pytest.raises(error, match=words):
        r.vjp(**given)
    assert np.isfinite(flat(r.vjp(t_events=[np.ones(3), None], y_events=(None, None)))).all()


def test_discrete_states():
    """A thermostat, whose heater two limits switch, and a value that is sampled at known times."""
    given, y0, args = (heated, (0.0, 9.0)), [19.5], (4.0,)
    how = {**SWITCH, "discrete": [0.1], **TIGHT}
    r = solve_ivp(*given, y0, "DOP853", args=args, **how, adjoint=("y0", "args"))
    s = solve_ivp(*given, y0, "DOP853", r.t[-1:], args=args, **how, sensitivity=("y0", "args"))
    g = np.zeros((1, len(r.t)))
    g[0, -1] = 1.0
    found = r.vjp(g)
    assert len(r.t_events[0]) > 1 and found["discrete"].shape == (1,)
    for name, value in found.items():
        assert np.allclose(value, s.sensitivity[name][0, ..., -1], rtol=1e-6, atol=1e-9)
    k = len(r.t_events[0])
    found = r.vjp(t_events=[np.ones(k), None], y_events=[np.ones((k, 1)), None])
    for name, value in found.items():
        each = s.event_sensitivity[0]
        expected = each.t[name].sum(axis=-1) + each.y[name][0].sum(axis=-1)
        assert np.allclose(value, expected, rtol=1e-6, atol=1e-8)

    def sampled(t, y, d, k):
        return y, [k * y[0]]

    r = solve_ivp(
        lambda t, y, d, k: [0.0 * y[0] + d[0]], (0, 2.0), [2.0], "RK45", [0.5, 1.5], args=(3.0,),
        at=[1.0], on_event=sampled, discrete=[0.5], adjoint=("y0", "args"),
    )  # fmt: skip
    found = r.vjp([[0.0, 1.0]])  # y0 + d0 + k (y0 + d0) / 2
    assert np.allclose(flat(found), [1 + 1.5, 1.25, 1 + 1.5], rtol=1e-12)
    found = r.vjp(discrete=[[0.0, 1.0]])  # k (y0 + d0)
    assert np.allclose(flat(found), [3.0, 2.5, 3.0], rtol=1e-12)
    for wrong in ({"g": np.ones((2, 2))}, {"discrete": np.ones((1, 3))}, {"y_events": [[1.0]]}):
        with pytest.raises(ValueError, match="so its shape"):
            r.vjp(**wrong)
    with pytest.raises(TypeError, match="`g` must be real"):
        r.vjp()
