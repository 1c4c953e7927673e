"""Claims about schedules in ensembles: each trajectory is the one of solve_ivp."""

import math

import numpy as np
import pytest

from fastdyn import at, every, solve_ensemble, solve_ivp

RATES = np.linspace(0.1, 0.9, 11)
TIGHT = {"rtol": 1e-9, "atol": 1e-12}
SPAN = (0.0, 6.0)


def eliminated(t, y, k):
    return [-k * y[0]]


def dose(t, y, k):
    return [y[0] + 1.0]


def low(t, y, k):
    return y[0] - 0.5


def exact(t, doses, k):
    return np.where(t > doses, np.exp(-k * (t - doses)), 0.0).sum()


def of_each(n):
    """Times of n trajectories, in different numbers."""
    return [np.array([0.0, 1.0, 2.5, 4.0, 5.5])[i % 3 : 3 + i % 3] + 0.01 * i for i in range(n)]


@pytest.mark.few
@pytest.mark.parametrize("method", ["RK45", "Vern9", "Rodas5P", "Taylor", "Radau"])
@pytest.mark.parametrize("simd", ["auto", False])
def test_each_trajectory_has_its_times(method, simd):
    rows = of_each(len(RATES))
    many = solve_ensemble(
        eliminated, SPAN, [0.0], (RATES,), method, events=at(rows), on_event=dose, simd=simd,
        t_eval=[2.0, 6.0], **TIGHT,
    )  # fmt: skip
    assert many.success.all()
    for i, (k, doses) in enumerate(zip(RATES, rows, strict=True)):
        assert np.array_equal(many.t_events[0][i], doses)
        found = [exact(t, doses, k) for t in (2.0, 6.0)]
        assert np.abs(many.y[i, 0] - found).max() <= 1e-6
        one = solve_ivp(
            eliminated, SPAN, [0.0], method, at=doses, on_event=dose, args=(k,),
            t_eval=[2.0, 6.0], **TIGHT,
        )  # fmt: skip
        assert np.allclose(many[i].y, one.y, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("method", ["RK45", "RK4"])
def test_schedules_stand_beside_events(method):
    options = {"step": 0.013} if method == "RK4" else TIGHT
    given = {"events": [low, every(1.5)], "on_event": [None, dose], **options}
    many = solve_ensemble(eliminated, SPAN, [1.0], (RATES,), method, **given)
    firsts = solve_ensemble(
        eliminated, SPAN, [1.0], (RATES,), method, reduce="first_event", **given
    )
    assert (many.width > 1) == (method == "RK45")
    for i, k in enumerate(RATES):
        one = solve_ivp(eliminated, SPAN, [1.0], method, args=(k,), **given)
        assert many.y_end[i] == pytest.approx(one.y[:, -1], rel=1e-9)
        for times, of_one in zip(many.t_events, one.t_events, strict=True):
            assert np.allclose(times[i], of_one, rtol=1e-9)
        first = [times[0] if len(times) else math.nan for times in one.t_events]
        assert np.allclose(firsts.reduced["first_event"][i], first, equal_nan=True)


def test_times_run_backwards_in_ensembles():
    rows = of_each(len(RATES))
    many = solve_ensemble(
        eliminated, SPAN[::-1], [1.0], (RATES,), events=at(rows), on_event=dose, **TIGHT
    )
    for i, k in enumerate(RATES):
        one = solve_ivp(
            eliminated, SPAN[::-1], [1.0], at=rows[i], on_event=dose, args=(k,), **TIGHT
        )
        assert np.array_equal(many.t_events[0][i], one.t_events[0])
        assert many.y_end[i] == pytest.approx(one.y[:, -1], rel=1e-9)


def test_trajectories_that_end_at_the_start():
    ticks = every(1.0)
    ticks.terminal = 1
    many = solve_ensemble(eliminated, SPAN, np.ones((3000, 1)), (0.5,), events=ticks)
    assert (many.status == 1).all() and (many.t_end == 0.0).all()
    assert all(np.array_equal(times, [0.0]) for times in many.t_events[0])


def test_hostile_times_are_answered_by_sentences():
    def solve(times, **options):
        solve_ensemble(eliminated, SPAN, [1.0], (RATES,), events=at(times), **options)

    with pytest.raises(ValueError, match="has times of 2 trajectories, and the ensemble has 11"):
        solve([[1.0], [2.0]])
    with pytest.raises(ValueError, match="behind the end"):
        solve([[1.0]] * 10 + [[7.0]])
    with pytest.raises(ValueError, match="does not see the jumps"):
        solve([1.0], on_event=dose, reduce="max")
    with pytest.raises(ValueError, match="for solve_ensemble"):
        solve_ivp(eliminated, SPAN, [1.0], events=at([[1.0], [2.0]]), args=(0.5,))
