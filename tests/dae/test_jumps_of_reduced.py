"""Algebraic components that nonlinear equations determine jump, by all methods as by BDF."""

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp

TIGHT = {"rtol": 1e-8, "atol": 1e-10}
METHODS = ("BDF", "Radau", "Rodas5P", "DOP853", "Vern9")


def cubic(t, y, yp):
    level = 2.0 if t < 5 else 1010.0  # y1 = 1, then 10
    return [yp[0] + y[0] - y[1], y[1] ** 3 + y[1] - level]


def pulse(t, y, yp):
    return [yp[0] - y[1], y[1] + y[1] ** 5 - (34.0 if 5 < t < 5.2 else 0.0)]  # y1 = 2 in the pulse


def coupled(t, y, yp):
    return [yp[0] + y[1], np.sinh(y[1]) - y[0] - (1.0 if t < 5 else -2.0)]


def of_cubic(t):
    first = 1 - np.exp(-t)
    return np.where(t <= 5, first, 10 + (1 - np.exp(-5.0) - 10) * np.exp(5.0 - t))


@pytest.mark.parametrize("method", METHODS)
def test_a_component_of_a_cubic_jumps(method):
    given = {"given": "differential", "dense_output": True, **TIGHT}
    found = solve_dae(cubic, (0, 10), [0.0, 1.0], method=method, **given)
    assert found.status == 0
    before, behind = np.flatnonzero(found.t == 5.0)
    assert behind == before + 1
    assert found.y[1, [before, behind]] == pytest.approx([1.0, 10.0], rel=1e-9)
    rounding = 8 * np.finfo(float).eps * 10  # of the times beside the breakpoint; |y0'| < 10
    assert found.y[0, before] == pytest.approx(found.y[0, behind], abs=rounding, rel=0)  # held
    assert found.y[0] == pytest.approx(of_cubic(found.t), abs=1e-6)
    t = np.array([4.999, 5.0, 5.001, 7.0])
    assert found.sol(t)[0] == pytest.approx(of_cubic(t), abs=1e-6)
    assert found.sol(t)[1, [0, 2, 3]] == pytest.approx([1.0, 10.0, 10.0], rel=1e-6)
    at = solve_dae(cubic, (0, 10), [0.0, 1.0], method=method, t_eval=t, **given)
    assert at.t.tolist() == t.tolist()
    assert at.y[1, [0, 2, 3]] == pytest.approx([1.0, 10.0, 10.0], rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_of_a_derivative_is_found(method):
    found = solve_dae(pulse, (0, 10), [0.0, 0.0], method=method, given="differential", **TIGHT)
    assert found.status == 0 and found.y[0, -1] == pytest.approx(0.4, rel=1e-6)
    for _ in range(3):
        again = solve_dae(pulse, (0, 10), [0.0, 0.0], method=method, given="differential", **TIGHT)
        assert np.array_equal(again.y, found.y)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("way", [1, -1])
def test_jumps_of_a_component_that_depends_on_the_state(method, way):
    """Backwards in time, too; the reference is the equation solved for y1 by hand."""

    def explicit(t, y):
        return [-np.arcsinh(y[0] + (1.0 if t < 5 else -2.0))]

    span = (0, 10)[::way]
    start = float(np.arcsinh(0.5 + (1.0 if way > 0 else -2.0)))
    right = solve_ivp(explicit, span, [0.5], "Vern9", **TIGHT).y[0, -1]
    found = solve_dae(coupled, span, [0.5, start], method=method, given="differential", **TIGHT)
    assert found.status == 0 and found.y[0, -1] == pytest.approx(right, rel=1e-5)


def test_events_beside_a_jump_are_those_of_the_user():
    def high(t, y):
        return y[1] - 5.0

    def slow(t, y):
        return y[0] - 5.0

    found = solve_dae(
        cubic, (0, 10), [0.0, 1.0], method="Radau", given="differential", events=[high, slow],
        **TIGHT,
    )  # fmt: skip
    assert len(found.t_events) == 2 and len(found.t_events[1]) == 1
    right = 5.0 + np.log((10 - 1 + np.exp(-5.0)) / 5.0)
    assert found.t_events[1] == pytest.approx([right], abs=1e-6)
