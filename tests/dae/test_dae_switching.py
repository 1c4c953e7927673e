"""Claims about DAEs whose F switches with the time: no pulse is lost, by any method."""

import numpy as np
import pytest

from fastdyn import solve_dae, solve_dae_ensemble

KNOTS = np.arange(11.0)
SAMPLES = np.where(KNOTS == 5.0, 1.0, 0.0)

PULSES = {  # input(t), and its integral from 0 to 10
    "if": (lambda t: 1.0 if 5 < t < 5.2 else 0.0, 0.2),
    "where": (lambda t: np.where((t > 5) & (t < 5.2), 1.0, 0.0), 0.2),
    "interp": (lambda t: np.interp(t, KNOTS, SAMPLES), 1.0),
    "index": (lambda t: SAMPLES[min(int(t), 10)], 1.0),
}


def index_1(u):
    return (lambda t, y, yp, a=1.0: [yp[0] - y[1], y[1] - a * u(t)]), [0.0, 0.0], 0


def index_3(u):
    """Two masses; the second stands still by a constraint on its position."""

    def F(t, y, yp, a=1.0):
        return [yp[0] - y[2], yp[1] - y[3], yp[2] - a * u(t), yp[3] - y[4], y[1] - 1.0]

    return F, [0.0, 1.0, 0.0, 0.0, 0.0], 2


@pytest.mark.parametrize("form", [index_1, index_3])
@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("method", [None, "DOP853", "Radau", "Vern9"])
@pytest.mark.parametrize("span", [(0, 10), (10, 0)])
def test_a_pulse_in_F_is_not_lost(form, name, method, span):
    u, area = PULSES[name]
    F, y0, place = form(u)
    given = {"rtol": 1e-6, "atol": 1e-9}
    if name in ("interp", "index") and (form is index_3 or method is not None):
        with pytest.raises(ValueError, match="index reduction takes no tables"):
            solve_dae(F, span, y0, method=method, **given)
        return
    run = solve_dae(F, span, y0, method=method, **given)
    assert run.success
    assert run.y[place, -1] == pytest.approx(area if span[1] else -area, rel=1e-5)


@pytest.mark.parametrize("name", PULSES)
def test_a_pulse_in_an_ensemble_is_not_lost(name):
    """A trajectory by BDF does not pass the jump of an algebraic component, and says so."""
    u, area = PULSES[name]
    a = np.array([1.0, 2.0, 3.0])
    given = {"args": (a,), "rtol": 1e-6, "atol": 1e-9}
    whole = solve_dae_ensemble(lambda t, y, yp, a: [yp[0] - a * u(t)], (0, 10), [0.0], **given)
    assert whole.success.all() and whole.y_end[:, 0] == pytest.approx(a * area, rel=1e-4)
    F, y0, place = index_1(u)
    whole = solve_dae_ensemble(F, (0, 10), y0, **given)
    right = np.abs(whole.y_end[:, place] / (a * area) - 1.0) < 1e-4
    assert (right == whole.success).all() and (name == "interp") == right.all()

    def late(t, y, yp, start):
        return [yp[0] - (1.0 if start < t < start + 0.25 else 0.0)]

    starts = np.array([2.0, 5.0, 9.5])
    whole = solve_dae_ensemble(late, (0, 10), [0.0], args=(starts,), rtol=1e-6, atol=1e-9)
    assert whole.success.all() and whole.y_end[:, 0] == pytest.approx(0.25, rel=1e-4)


def test_own_breakpoints_and_short_limits_stay():
    F, y0, _ = index_1(PULSES["if"][0])
    run = solve_dae(F, (0, 10), y0, breakpoints=[2.0], max_step=1.0, rtol=1e-6)
    assert np.isin([2.0, 5.0, 5.2], run.t).all() and np.diff(run.t).max() < 1.0 + 1e-9
    assert run.y[1, np.searchsorted(run.t, 5.0, "right") - 1] == pytest.approx(1.0)
