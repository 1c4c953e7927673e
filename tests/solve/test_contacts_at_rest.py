"""Contacts at rest: the action stops a body on a level, exactly or but for rounding."""

import numpy as np
import pytest

from fastdyn import solve_ivp

LEVEL = 0.3
LANDS = np.sqrt(2.0)  # from 1.3, with the acceleration -1
ALL = ("RK45", "DOP853", "Radau", "BDF", "LSODA", "Tsit5", "Vern9", "Rodas5P", "Taylor")
OFFSETS = (0.0, -1e-16, 1e-16, -4e-16)


def stopped(method, behind, offset, direction):
    """A fall on the level, where the body stops; then with the acceleration `behind`."""

    def level(t, y):
        return y[0] - LEVEL

    level.direction = direction
    return solve_ivp(
        lambda t, y: [y[1], -1.0 + (1.0 + behind) * y[2], 0.0 * y[0]], (0, 5), [1.3, 0.0, 0.0],
        method, events=level, on_event=lambda t, y: [LEVEL + offset, 0.0, 1.0],
        rtol=1e-8, atol=1e-10, max_steps=10_000,
    )  # fmt: skip


@pytest.mark.few(4)
@pytest.mark.parametrize("direction", [0, -1])
@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("method", ALL)
def test_a_body_that_stays_on_the_level_lands_once(method, offset, direction):
    found = stopped(method, 0.0, offset, direction)
    assert found.status == 0 and len(found.t_events[0]) == 1
    assert found.y[0, -1] == LEVEL + offset


@pytest.mark.few(4)
@pytest.mark.parametrize("direction", [0, -1])
@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("method", ALL)
def test_a_body_that_lifts_off_at_once_lands_once(method, offset, direction):
    found = stopped(method, 1.0, offset, direction)
    assert found.status == 0 and len(found.t_events[0]) == 1
    assert found.y[0, -1] == pytest.approx(LEVEL + 0.5 * (5.0 - LANDS) ** 2, abs=1e-5)


@pytest.mark.few(4)
@pytest.mark.parametrize("direction", [0, -1])
@pytest.mark.parametrize("method", ALL)
def test_a_body_that_falls_on_through_the_level_is_told(method, direction):
    """The event occurs again at once: the run ends, and takes not a short step after the other."""
    found = stopped(method, -1.0, 0.0, direction)
    assert found.status == -1 and "infinitely often" in found.message
    assert found.t[-1] == pytest.approx(LANDS, abs=1e-6)
