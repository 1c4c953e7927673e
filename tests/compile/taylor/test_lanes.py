"""A trajectory in each lane: what one alone does, whatever is beside it."""

import math

import numpy as np
import pytest

import fastdyn
from tests.support.smooth import drawn

RNG = np.random.default_rng(0)
MANY = 37  # which fill no whole number of vectors
Y0 = np.column_stack([RNG.uniform(0.5, 1.5, MANY), RNG.uniform(-0.5, 0.5, MANY)])
RATES = RNG.uniform(0.2, 30.0, MANY)  # some take a hundred times the steps of others
OPTIONS = {"method": "Taylor", "rtol": 1e-11, "atol": 1e-11}


def driven(t, y, rate, damping):
    return [y[1], -rate * math.sin(y[0]) - damping * y[1] + math.cos(rate * t)]


def solved(y0=Y0, rates=RATES, simd=True, **more):
    return fastdyn.solve_ensemble(
        driven, (0.0, 5.0), y0, (rates, 0.1), simd=simd, **OPTIONS, **more
    )


def test_as_one_after_the_other():
    """The bound is that of the tolerance: both are within some of it, over 5 units of time."""
    lanes, alone = solved(), solved(simd=False)
    assert lanes.width > 1
    assert alone.width == 1
    np.testing.assert_allclose(lanes.y_end, alone.y_end, rtol=0.0, atol=1e-8)
    assert (abs(lanes.n_accepted - alone.n_accepted) <= 1).all()
    assert lanes.n_accepted.max() > 5 * lanes.n_accepted.min()


def test_bits_do_not_depend_on_neighbours():
    whole = solved(threads=1)
    order = np.random.default_rng(1).permutation(MANY)
    mixed, few = solved(Y0[order], RATES[order], threads=2), solved(Y0[5:7], RATES[5:7])
    assert (mixed.y_end == whole.y_end[order]).all()
    assert (few.y_end == whole.y_end[5:7]).all()
    assert (mixed.n_accepted == whole.n_accepted[order]).all()


def test_times_between_do_not_change_the_end():
    times = np.linspace(0.0, 5.0, 23)
    sampled = solved(t_eval=times)
    assert (sampled.y[:, :, 0] == Y0).all()
    for i in (0, 11, MANY - 1):
        one = fastdyn.solve_ivp(
            driven, (0.0, 5.0), Y0[i], args=(RATES[i], 0.1), t_eval=times, **OPTIONS
        )
        np.testing.assert_allclose(sampled.y[i], one.y, rtol=0.0, atol=1e-8)


def test_a_condition_on_a_parameter():
    """One trajectory at a time solves the ensemble: the lanes of a vector have one formula."""

    def fun(t, y, a):
        return [y[1] if a > 0.3 else -y[1], -y[0]]

    rates = np.array([0.1, 0.4, 0.2])
    end = fastdyn.solve_ensemble(fun, (0.0, 1.0), np.ones((3, 2)), (rates,), **OPTIONS).y_end
    turned = [math.cos(1.0) + math.sin(1.0), math.cos(1.0) - math.sin(1.0)]
    decayed = [math.exp(-1.0)] * 2
    np.testing.assert_allclose(end, [decayed, turned, decayed], rtol=0.0, atol=1e-9)


def test_backwards_and_constant_components():
    def fun(t, y):
        return [1.0, t, -y[2] * y[0]]

    found = fastdyn.solve_ensemble(fun, (2.0, -1.0), np.ones((3, 3)), simd=True, **OPTIONS)
    np.testing.assert_allclose(found.y_end[:, :2], [[-2.0, -0.5]] * 3, rtol=0.0, atol=1e-14)


@pytest.mark.hunt
@pytest.mark.parametrize("number", range(6))
def test_functions_drawn_at_random(number):
    fun, args, y0 = drawn(500 + number)
    found = fastdyn.solve_ensemble(fun, (0.0, 2.0), [y0] * 3, args, simd=True, **OPTIONS)
    one = fastdyn.solve_ivp(fun, (0.0, 2.0), y0, "DOP853", args=args, rtol=1e-13, atol=1e-13)
    assert (found.y_end == found.y_end[0]).all()
    np.testing.assert_allclose(found.y_end[0], one.y[:, -1], rtol=1e-9, atol=1e-9)


def test_who_blows_up_or_raises_leaves_the_others_alone():
    def fun(t, y):
        return [y[0] * y[0] + math.sqrt(4.0 - t - y[1]), 0.0 * y[0]]

    y0 = np.array([[-1.0, 0.0], [1.0, 0.0], [-1.0, 3.0], [-2.0, 0.5]])
    found = fastdyn.solve_ensemble(fun, (0.0, 3.0), y0, simd=True, **OPTIONS)
    alone = fastdyn.solve_ensemble(fun, (0.0, 3.0), y0[[0, 3]], simd=True, **OPTIONS)
    assert (found.y_end[[0, 3]] == alone.y_end).all()
    assert np.isfinite(found.y_end).all()
    assert (found.t_end[1:3] < 3.0).all()
    assert found.t_end[2] == pytest.approx(1.0, abs=1e-6)


def test_the_apex_of_a_vertical_throw_is_no_silent_kink():
    """Drag c |v| v by sqrt(v^2), which goes on as v beyond the apex: stopped, or right."""

    def fun(t, y, drag):
        speed = math.sqrt(y[2] * y[2] + y[3] * y[3])
        return [y[2], y[3], -drag * speed * y[2], -9.81 - drag * speed * y[3]]

    y0 = np.array([[0.0, 0.0, v, 10.0] for v in (0.0, 1e-3, 5.0)])
    found = fastdyn.solve_ensemble(fun, (0.0, 1.5), y0, (0.1,), simd=True, **OPTIONS)
    for i, start in enumerate(y0):
        one = fastdyn.solve_ivp(
            fun, (0.0, 1.5), start, "DOP853", args=(0.1,), rtol=1e-12, atol=1e-12
        )
        right = np.allclose(found.y_end[i], one.y[:, -1], rtol=0.0, atol=1e-7)
        assert right or found.t_end[i] < 1.5
    assert found.t_end[2] == 1.5


def test_events_and_reductions_are_those_of_one_alone():
    def crossing(t, y, rate, damping):
        return y[0] - 0.7

    given = {"events": crossing, "reduce": ("final", "first_event")}
    lanes, alone = solved(**given), solved(simd=False, **given)
    assert "one by one" in lanes.reason
    np.testing.assert_allclose(
        lanes.reduced["first_event"], alone.reduced["first_event"], rtol=0.0, atol=1e-8
    )


def test_conditions_go_one_after_the_other():
    def fun(t, y):
        return [y[1], -abs(y[0])]

    found = fastdyn.solve_ensemble(fun, (0.0, 1.0), Y0, **OPTIONS)
    assert found.width == 1
    assert "conditions" in found.reason
