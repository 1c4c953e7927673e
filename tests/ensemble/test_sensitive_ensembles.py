"""Ensembles with `sensitivity`: the bits of single solves, and what is refused."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from fastdyn.ensemble import Shared

M = 5
RNG = np.random.default_rng(0)
STARTS, A = RNG.uniform(1.0, 3.0, (M, 2)), RNG.uniform(0.3, 3.0, M)


def prey(t, y, a, rates):
    return [a * y[0] - rates[0] * y[0] * y[1], rates[1] * y[0] * y[1] - rates[2] * y[1]]


RATES = np.array([1.0, 0.9, 3.0])
WANTED = {"sensitivity": ("y0", "args")}


def assert_same(single, result, i):
    k = len(single.t)
    assert np.array_equal(single.y, result[i].y)
    assert (single.status, single.nfev) == (result[i].status, result[i].nfev)
    for name, found in single.sensitivity.items():
        assert np.array_equal(found, result[i].sensitivity[name])
        assert np.array_equal(found, result.sensitivity[name][i][..., :k])


@pytest.mark.parametrize("method", ["RK45", "Rodas5P", "RK4"])
def test_the_bits_of_single_solves(method):
    """Starts and arguments above 1, and below, have their own tolerances."""
    how = {"method": method, "t_eval": np.linspace(0, 5, 6)}
    how |= {"step": 0.05} if method == "RK4" else {"rtol": 1e-6}
    result = solve_ensemble(prey, (0, 5), STARTS, (A, Shared(RATES)), threads=2, **WANTED, **how)
    assert {k: v.shape[1:] for k, v in result.sensitivity.items()} == {
        "y0": (2, 2, 6), "a": (2, 6), "rates": (2, 3, 6),
    }  # fmt: skip
    for i in range(M):
        assert_same(
            solve_ivp(prey, (0, 5), STARTS[i], args=(A[i], RATES), **WANTED, **how), result, i
        )


def test_without_times_of_output_they_are_those_at_the_ends():
    result = solve_ensemble(prey, (0, 5), STARTS[0], (A, Shared(RATES)), sensitivity="a")
    for i in range(M):
        single = solve_ivp(prey, (0, 5), STARTS[0], args=(A[i], RATES), sensitivity="a")
        assert np.array_equal(result.sensitivity["a"][i], single.sensitivity["a"][:, -1])
        assert np.array_equal(result[i].sensitivity["a"][:, 0], single.sensitivity["a"][:, -1])


def test_events_that_act_and_events_that_end():
    def ball(t, y, g):
        return [y[1], -g]

    def floor(t, y, g):
        return y[0]

    def high(t, y, g):
        return y[0] - 3.0

    floor.direction, high.terminal = -1, True
    g, heights = np.array([5.0, 9.81, 20.0]), np.array([[1.0, 0.0], [2.0, 1.0], [0.5, 15.0]])
    how = {
        "events": [floor, high], "on_event": [lambda t, y, g: [0.0, -0.8 * y[1]], None],
        "t_eval": np.linspace(0, 2, 9), **WANTED,
    }  # fmt: skip
    result = solve_ensemble(ball, (0, 2), heights, (g,), **how)
    assert list(result.status) == [0, 0, 1]
    for i in range(3):
        single = solve_ivp(ball, (0, 2), heights[i], args=(g[i],), **how)
        assert_same(single, result, i)
        for k in range(2):
            assert np.array_equal(single.t_events[k], result.t_events[k][i])
            assert np.array_equal(single.y_events[k].reshape(-1, 2), result.y_events[k][i])
    assert np.isnan(result.sensitivity["g"][2][:, -1]).all()  # it ended before


def test_a_trajectory_fails_alone():
    def grows(t, y, a):
        return [a * y[0] ** 2]

    result = solve_ensemble(grows, (0, 1), [[0.5], [2.0], [np.nan]], (1.0,), **WANTED)
    assert list(result.status) == [0, -1, -1]
    assert abs(result.sensitivity["y0"][0, 0, 0] - 1 / (1 - 0.5) ** 2) < 0.02
    assert "initial state" in result.message(2)


@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"reduce": "max"}, ValueError, "final"),
        ({"simd": True}, ValueError, "no form for vectors"),
        ({"store": "there"}, ValueError, "no `store`"),
        ({"mass": np.eye(2), "method": "Radau"}, ValueError, "no `mass`"),
        ({"y0": np.ones((0, 2)), "args": (1.0,)}, ValueError, "needs a trajectory"),
        ({"discrete": [1.0]}, ValueError, "no `discrete`"),
        ({"method": "VelocityVerlet", "step": 0.1}, ValueError, "VelocityVerlet"),
        ({"sensitivity": "z"}, ValueError, "unknown"),
        ({"y0": np.ones((2, 2), complex)}, ValueError, "real states"),
        ({"fun": lambda t, y, a: [1.0 if y[0] > 0.5 else y[1], a]}, ValueError, "decides"),
        ({"fun": lambda t, y, a: [float(str(y[0])), a]}, ValueError, "traced"),
    ],
)
def test_what_is_not_covered(more, error, words):
    given = {
        "fun": lambda t, y, a: [y[1], -a * y[0]], "t_span": (0, 1), "y0": np.ones((2, 2)),
        "args": (np.array([1.0, 2.0]),), **WANTED,
    }  # fmt: skip
    with pytest.raises(error, match=words):
        solve_ensemble(**{**given, **more})
