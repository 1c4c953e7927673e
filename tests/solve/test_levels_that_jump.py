"""Claims about levels that change in time: "auto" slides along no level that has gone."""

import functools

import numpy as np
import pytest
from scipy.interpolate import interp1d

from fastdyn import solve_ivp
from fastdyn.problem import switched
from fastdyn.solve import automatic

TIMES = np.array([0.0, 25.0, 50.0, 75.0])
VALUES = np.array([20.0, 15.0, 18.0, 12.0])
of_scipy = interp1d(TIMES, VALUES, kind="previous")

LEVELS = {
    "if": lambda t: 20.0 if t < 25 else 15.0,
    "up": lambda t: 15.0 if t < 25 else 20.0,
    "where": lambda t: np.where(t < 25, 20.0, 15.0),
    "heaviside": lambda t: 20.0 - 5 * np.heaviside(t - 25, 1.0),
    "sign": lambda t: 17.5 - 2.5 * np.sign(t - 25),
    "index": lambda t: VALUES[min(int(t / 25), 3)],
    "search": lambda t: VALUES[np.searchsorted(TIMES, t, side="right") - 1],
    "interp1d": lambda t: of_scipy(t),
    "remainder": lambda t: 20.0 if t % 50 < 25 else 15.0,
    "floor": lambda t: 20.0 - 5 * (np.floor(t / 25) % 2),
    "product": lambda t: 20.0 - 5 * (t >= 25),
    "ramp": lambda t: np.interp(t, [0, 24.9, 25.1, 100], [20, 20, 15, 15]),
    "pulse": lambda t: 20.0 - 5 * (30 < t < 32),
    "sine": lambda t: 20.0 if np.sin(t / 8) > 0 else 16.0,
}
STEP = 2e-3  # of the reference, which chatters within 0.003 of the level


def heated(level):
    return lambda t, y: [-0.1 * (y[0] - 5.0) + (3.0 if y[0] < level(t) else 0.0)]


@functools.cache
def by_euler(name):
    """The solution at each second, until 60, by Euler's method in Python."""
    fun, y, found = heated(LEVELS[name]), 10.0, []
    for i in range(round(60.0 / STEP) + 1):
        if i % round(1 / STEP) == 0:
            found.append(y)
        y += STEP * fun(i * STEP, [y])[0]
    return np.array(found)


@pytest.mark.few
@pytest.mark.parametrize("name", LEVELS)
@pytest.mark.parametrize("each", [True, False])
def test_a_thermostat_follows_its_level(name, each):
    fun, times = heated(LEVELS[name]), np.arange(61.0)
    given = {} if each else {"t_eval": times}
    run = solve_ivp(fun, (0, 60), [10.0], "auto", rtol=1e-6, atol=1e-8, **given)
    assert run.success and run.nfev < 2000
    found = np.interp(times, run.t, run.y[0]) if each else run.y[0]
    if not each:
        assert np.abs(found - by_euler(name)).max() < 3.0 * STEP
    assert abs(run.y[0, -1] - by_euler(name)[-1]) < 3.0 * STEP


@pytest.mark.filterwarnings("ignore:.*as at a switch")
def test_a_solution_far_from_its_switch_is_not_returned(monkeypatch):
    """Without the modes behind a jump, the states show that the switch has gone."""
    before = switched.longer

    def without_modes_behind_jumps(asked, of, chosen):
        found = before(asked, of, chosen)
        actions = found.options["on_event"][:-1]
        return found._replace(events=found.events[:-1]).with_options(on_event=actions)

    monkeypatch.setattr(automatic, "longer", without_modes_behind_jumps)
    run = solve_ivp(heated(LEVELS["where"]), (0, 60), [10.0], "auto", rtol=1e-6, atol=1e-8)
    assert not (run.success and abs(run.y[0, -1] - 15.0) > 1.0)
