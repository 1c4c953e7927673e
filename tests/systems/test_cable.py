"""Claims about the slack cable."""

import math

import numpy as np
import pytest

from fastdyn.systems import cable, pendulum_xy

EPS = np.finfo(float).eps

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


@pytest.mark.parametrize("factor", [2.2, 3.0, 3.5, 4.2, 4.9])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_slack_cable_is_taut_again_where_geometry_says(factor, sense):
    """The parabola touches the circle thrice at the slack angle, so it meets it at -3 of it."""
    system = cable(V0=sense * math.sqrt(factor * 9.81), m=2.0)
    run = system.solve((0.0, 3.0), **TIGHT)
    (first, _, slack), (second, _, taut), (third, _, _) = run.phases[:3]
    assert (first, second, third) == ("cable", "flight", "cable")
    growth = 1e-10 * 2e4 * math.exp(3.2 * slack)
    assert slack == pytest.approx(system.slack_time, abs=growth)
    x, y = run.sol(taut)[:2]
    off = math.remainder(math.atan2(x, y) + 3.0 * sense * system.slack_angle, 2.0 * math.pi)
    assert abs(off) <= growth
    before, after = np.flatnonzero(run.t == taut)
    w, v = run.y[:, before], run.y[:, after]
    along = v[2:] @ v[:2]
    across = (w[3] * w[0] - w[2] * w[1]) - (v[3] * v[0] - v[2] * v[1])
    assert abs(along) <= 1e-12 and abs(across) <= 1e-7  # r = l only to the event's accuracy
    assert np.hypot(*run.y[:2]).max() <= 1.0 + 1e-7
    energy = run.quantities()["energy"]
    assert energy[after] < energy[before]
    pull = run.quantities()["tension"]
    assert pull[run.t < slack].min() > 0.0 and pull[after] > 0.0
    assert np.all(pull[(run.t > slack) & (run.t < taut)] == 0.0) and pull[before] == 0.0


def test_a_taut_cable_never_flies_and_output_times_are_kept():
    t = np.linspace(0.0, 4.0, 41)
    run = cable(V0=4.0).solve((0.0, 4.0), t_eval=t, **TIGHT)
    assert [name for name, _, _ in run.phases] == ["cable"] and np.array_equal(run.t, t)
    flown = cable(V0=5.9).solve((0.0, 4.0), t_eval=t, **TIGHT)
    whole = cable(V0=5.9).solve((0.0, 4.0), **TIGHT)
    assert np.array_equal(flown.t, t) and len(flown.phases) >= 3
    assert np.allclose(flown.y, whole.sol(t), rtol=0, atol=1e-8)


def test_a_mass_that_starts_inside_the_circle_falls_first():
    run = cable().solve((0.0, 2.0), y0=[0.3, 0.0, 0.0, 0.0], **TIGHT)
    (name, _, taut), *_ = run.phases
    assert name == "flight"
    assert 0.5 * 9.81 * taut**2 == pytest.approx(math.sqrt(1 - 0.09), rel=1e-8)
    with pytest.raises(ValueError, match="starts at t = 0 from its own"):
        run.error()


def test_a_cable_is_exact_where_it_stays_taut_and_refuses_what_it_cannot():
    run = cable(V0=4.0).solve(**TIGHT)
    assert np.abs(run.error()).max() <= run.n_accepted * 1e-10 * 100.0
    twin = pendulum_xy(V0=4.0).solve((0.0, 4.0), project=True, **TIGHT)
    assert np.array_equal(run.y[:, -1], twin.y[:, -1])
    with pytest.raises(ValueError, match="No exact solution of a cable that goes slack"):
        cable().solve().error()
    with pytest.raises(ValueError, match="one by one"):
        cable().ensemble(V0=np.ones(3))
    with pytest.raises(ValueError, match="always projects onto"):
        cable().solve(project=lambda t, w, g, l, m: w)  # noqa: E741


def test_a_cable_released_from_the_horizontal_swings():
    run = cable().solve((0.0, 3.0), [1.0, 0.0, 0.0, 0.0], **TIGHT)
    assert run.success and [name for name, _, _ in run.phases] == ["cable"]
    assert np.abs(np.hypot(*run.y[:2]) - 1.0).max() <= 4 * EPS


def test_the_first_phase_is_what_the_start_says():
    inwards = cable().solve((0.0, 0.1), [0.0, 1.0, 0.0, -5.0], **TIGHT)
    assert [name for name, _, _ in inwards.phases] == ["flight"]
    assert inwards.y[1, -1] == pytest.approx(1.0 - 0.5 + 0.5 * 9.81 * 0.01, rel=1e-9)
    with pytest.raises(ValueError, match="farther than the cable"):
        cable().solve((0.0, 1.0), [0.0, 2.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="must be 4 numbers"):
        cable().solve((0.0, 1.0), [0.0, 2.0])
    run = cable(V0=5.9).solve((0.0, 4.0), events="bottom")
    assert len(run.t_events[0]) > 2
