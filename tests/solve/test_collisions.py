"""Claims about collisions of several bodies, one upon the other."""

import math

import numpy as np
import pytest

from fastdyn import prepare, solve_dae, solve_ensemble, solve_ivp
from tests.support.impacts import impacts, marked

TIGHT = {"rtol": 1e-11, "atol": 1e-13}
GAP = 1e-6


def contact(i, gap=0.0):
    """Body i touches the next one; the state is [positions, velocities]."""
    return marked(lambda t, y: gap + y[i + 1] - y[i], direction=-1)


def collision(i, masses):
    """An elastic collision of body i with the next one."""
    a, b, n = masses[i], masses[i + 1], len(masses)

    def collide(t, y):
        u, v = y[n + i], y[n + i + 1]
        y[n + i] = ((a - b) * u + 2.0 * b * v) / (a + b)
        y[n + i + 1] = ((b - a) * v + 2.0 * a * u) / (a + b)
        return y

    return collide


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_newtons_cradle_hands_the_velocity_on():
    n = 5

    def swing(t, y):
        return [*y[n:], *(-y[:n])]

    y0 = np.zeros(2 * n)
    y0[0] = -1.0
    run = solve_ivp(
        swing, (0.0, 8.0 * math.pi), y0, "DOP853", events=[contact(i, GAP) for i in range(n - 1)],
        on_event=[collision(i, np.ones(n)) for i in range(n - 1)], dense_output=True, **TIGHT,
    )  # fmt: skip
    assert run.success
    order = np.argsort(np.concatenate(run.t_events), kind="stable")
    which = np.repeat(range(n - 1), [len(t) for t in run.t_events])[order]
    assert np.array_equal(which, [0, 1, 2, 3, 3, 2, 1, 0] * 4)
    for i, times in enumerate(run.t_events):
        assert np.abs(times / math.pi - np.arange(0.5, 8.0)).max() <= 8 * n * GAP, i
    y = run.sol(np.arange(9) * math.pi)
    assert np.abs(y[0, ::2] + 1.0).max() <= 8 * n * GAP and np.abs(y[1:n, ::2]).max() <= n * GAP
    assert np.abs(y[4, 1::2] - 1.0).max() <= 8 * n * GAP and np.abs(y[:4, 1::2]).max() <= n * GAP


@pytest.mark.parametrize("method", ["RK45", "Tsit5", "Taylor"])
@pytest.mark.parametrize("masses", [(3.0, 1.0, 3.0), (1.0, 1.0, 1.0), (5.0, 1.0, 1.0, 7.0)])
def test_bodies_that_touch_collide_one_after_the_other_at_one_time(masses, method):
    n = len(masses)
    v = np.eye(n)[0]
    count = np.zeros(n - 1, int)
    while (closing := v[:-1] - v[1:]).max() > 1e-14:
        i = int(np.argmax(closing > 1e-14))
        y = collision(i, masses)(0.0, np.r_[np.zeros(n), v])
        v, count[i] = y[n:], count[i] + 1
    run = solve_ivp(
        lambda t, y: [*y[n:], *(0.0 * y[:n])], (0.0, 3.0), [-1.0, *np.zeros(n - 1), *np.eye(n)[0]],
        method, events=[contact(i) for i in range(n - 1)],
        on_event=[collision(i, masses) for i in range(n - 1)],
    )  # fmt: skip
    assert run.success and [len(t) for t in run.t_events] == count.tolist()
    assert np.ptp(np.concatenate(run.t_events)) == 0.0
    assert np.abs(run.y[n:, -1] - v).max() <= 1e-13
    assert np.abs(run.y[:n, -1] - 2.0 * v).max() <= 1e-13


def free(t, y, *yp):
    """Three bodies without forces: y' or, with yp, the residual."""
    rates = [*y[3:], *(0.0 * y[:3])]
    return [a - b for a, b in zip(yp[0], rates, strict=True)] if yp else rates


def hit(i):
    """Body i of three equal ones hands its velocity on, and is where the next one is."""

    def act(t, y, *_):
        q = [y[k + 1] if k == i else y[k] for k in range(3)]
        v = [y[3 + {i: i + 1, i + 1: i}.get(k, k)] for k in range(3)]
        return [*q, *v]

    return act


def by_dae(fun, span, y0, method, **given):
    return solve_dae(free, span, y0, **given)


def prepared(fun, span, y0, method, **given):
    solver = prepare(fun, span, y0, method, **given)
    solver()
    return solver()


def again(fun, span, y0, method, **given):
    solve_ivp(fun, span, y0, method, **given)
    return solve_ivp(fun, span, y0, method, **given)


TOUCHING = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "ode45", "Tsit5", "Vern9",
            "Rodas5P", "Taylor", "auto")  # fmt: skip


@pytest.mark.parametrize(
    ("way", "method"),
    [*[(solve_ivp, m) for m in TOUCHING], (prepared, "DOP853"), (again, "Taylor"), (by_dae, None)],
)
@pytest.mark.parametrize("direction", [-1.0, 0.0])
@pytest.mark.parametrize("start", [-1.0, -1e-5])
def test_bodies_that_rest_in_contact_are_not_hit_again(way, method, direction, start):
    """The third body is hit where it touched the second from t0 on, also within the first step.

    The first two are at rest in contact then: their distance is exactly zero up to the end.
    """
    contacts = [marked(lambda t, y, *_, i=i: y[i + 1] - y[i], direction=direction) for i in (0, 1)]
    run = way(
        free, (0.0, 3.0), [start, 0.0, 0.0, 1.0, 0.0, 0.0], method, events=contacts,
        on_event=[hit(0), hit(1)],
    )  # fmt: skip
    assert [len(t) for t in run.t_events] == [1, 1]
    assert np.concatenate(run.t_events) == pytest.approx([-start] * 2, rel=1e-9)
    assert run.y[:, -1] == pytest.approx([0.0, 0.0, 3.0 + start, 0.0, 0.0, 1.0], abs=1e-9)


@pytest.mark.parametrize("method", ["RK45", "Tsit5"])
@pytest.mark.parametrize("simd", [True, False])
def test_bodies_of_an_ensemble_are_not_hit_again(method, simd):
    starts = -np.linspace(0.5, 1.0, 9)
    found = solve_ensemble(
        free, (0.0, 3.0), np.stack([starts, *np.zeros((2, 9)), np.ones(9), *np.zeros((2, 9))], 1),
        (), method, events=[contact(0), contact(1)], on_event=[hit(0), hit(1)], simd=simd,
    )  # fmt: skip
    assert (found.width > 1) == simd
    assert all(len(t) == 1 for times in found.t_events for t in times)
    assert found.y_end[:, 2] == pytest.approx(3.0 + starts, abs=1e-9)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_events_at_one_time_act_one_after_the_other():
    def fall(t, y):
        return [y[2], y[3], -9.81, -9.81]

    def bounce_of(i):
        def jump(t, y):
            y[i], y[2 + i] = 0.0, -0.8 * y[2 + i]
            return y

        return jump

    floors = [marked(lambda t, y, i=i: y[i], direction=-1) for i in (0, 1)]
    for second in (1.0, np.nextafter(1.0, 2.0), 1.0 + 1e-9):
        run = solve_ivp(
            fall, (0.0, 2.0), [1.0, second, 0.0, 0.0], events=floors,
            on_event=[bounce_of(0), bounce_of(1)], **TIGHT,
        )  # fmt: skip
        for times in run.t_events:
            assert np.abs(times - impacts(0.8, 3)).max() <= 4e-9
