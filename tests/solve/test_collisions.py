"""Claims about collisions of several bodies, one upon the other."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp
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


@pytest.mark.parametrize("masses", [(3.0, 1.0, 3.0), (1.0, 1.0, 1.0), (5.0, 1.0, 1.0, 7.0)])
def test_bodies_that_touch_collide_one_after_the_other_at_one_time(masses):
    n = len(masses)
    v = np.eye(n)[0]
    count = np.zeros(n - 1, int)
    while (closing := v[:-1] - v[1:]).max() > 1e-14:
        i = int(np.argmax(closing > 1e-14))
        y = collision(i, masses)(0.0, np.r_[np.zeros(n), v])
        v, count[i] = y[n:], count[i] + 1
    run = solve_ivp(
        lambda t, y: [*y[n:], *(0.0 * y[:n])], (0.0, 3.0), [-1.0, *np.zeros(n - 1), *np.eye(n)[0]],
        events=[contact(i) for i in range(n - 1)],
        on_event=[collision(i, masses) for i in range(n - 1)],
    )  # fmt: skip
    assert run.success and [len(t) for t in run.t_events] == count.tolist()
    assert np.ptp(np.concatenate(run.t_events)) == 0.0
    assert np.abs(run.y[n:, -1] - v).max() <= 1e-13
    assert np.abs(run.y[:n, -1] - 2.0 * v).max() <= 1e-13


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
