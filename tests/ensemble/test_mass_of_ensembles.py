"""Ensembles of M y' = f(t, y): each member is the single solve, in lanes and one at a time."""

import math

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from support.masses import TAKE, decaying, half, refill, root

GIVEN = {"rtol": 1e-7, "atol": 1e-10}
RATES = np.linspace(0.5, 3.0, 11)


def coupled(t, y, k):
    """Three capacitors between four nodes; nodes 2 and 3 have none of their own."""
    return [
        k * math.sin(t) - y[0] - (y[0] - y[3]), 0.5 * y[2] - y[1],
        y[1] - 2.0 * y[2] + 0.1 * y[2] ** 3, y[0] - 3.0 * y[3],
    ]  # fmt: skip


COUPLED = np.array([[2.0, -1.0, 0, 0], [-1.0, 3.0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]])
OF_NODES = np.array([[-2.0, 2.0], [2.0, -2.0]])
FULL = np.array([[2.0, 1.0, 0.0], [0.5, 3.0, 1.0], [0.0, 0.0, 4.0]])
STIFF = np.array([[-1.0, 100.0, 0.0], [0.0, -50.0, 1.0], [1.0, 0.0, -2.0]])


def nodes(t, y, k):
    u, w = y[0] - y[1], y[0] + y[1]
    return [k * u + w - 3.0, -k * u + w - 3.0]


def driven(t, y, k):
    a, b, c = y
    return [-a + 100.0 * b + k * math.sin(t), -50.0 * b + c, a - 2.0 * c + 1.0]


PROBLEMS = {
    "algebraic": (decaying, [1.0, root(1.0)], np.diag([1.0, 0.0])),
    "coupled": (coupled, [0.0, 0.0, 0.0, 0.0], COUPLED),
    "combinations": (nodes, [2.0, 1.0], OF_NODES),
    "regular": (driven, [1.0, 2.0, 3.0], FULL),
    "permuted": (lambda t, y, k: [-k * y[1], y[1]], [1.0, 0.5], np.array([[0.0, 1.0], [1.0, 0.0]])),
}


def member(fun, span, y0, method, k, **options):
    return solve_ivp(fun, span, y0, method, args=(k,), **GIVEN, **options)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("method", TAKE)
def test_each_member_is_the_single_solve(method, name):
    fun, y0, mass = PROBLEMS[name]
    times = np.linspace(0, 2, 5)
    many = solve_ensemble(
        fun, (0, 2), y0, (RATES,), method, mass=mass, t_eval=times, threads=2, **GIVEN,
    )  # fmt: skip
    assert many.success.all() and (many.width > 1) == (method == "Rodas5P"), many.reason
    for i, k in enumerate(RATES):
        one = member(fun, (0, 2), y0, method, k, mass=mass, t_eval=times)
        assert many.n_accepted[i] == one.n_accepted
        assert (abs(many.y[i] - one.y) <= 1e-2 * (1e-10 + 1e-7 * abs(one.y))).all()


@pytest.mark.parametrize("method", TAKE)
def test_actions_in_ensembles(method):
    given = {"mass": np.diag([1.0, 0.0]), "events": half, "on_event": refill}
    many = solve_ensemble(decaying, (0, 3), [1.0, root(1.0)], (RATES,), method, **given, **GIVEN)
    assert many.success.all() and (many.width > 1) == (method == "Rodas5P")
    for i, k in enumerate(RATES):
        times = (math.log(2.0) + math.log(4.0) * np.arange(9)) / k
        times = times[times < 3.0]
        assert many.t_events[0][i] == pytest.approx(times, abs=1e-4)
        one = member(decaying, (0, 3), [1.0, root(1.0)], method, k, **given)
        assert many.y_end[i] == pytest.approx(one.y[:, -1], rel=1e-8)


def test_starts_that_are_not_consistent_fail_alone():
    starts = [[1.0, root(1.0)], [1.0, 0.5], [0.3, root(0.3)]]
    many = solve_ensemble(
        decaying, (0, 1), starts, (1.0,), "Rodas5P", mass=np.diag([1.0, 0.0]), **GIVEN
    )
    assert many.status.tolist() == [0, -1, 0]
    said = many.message(1)
    assert said.startswith("Trajectory 1: `y0` does not fulfil the algebraic equations")
    assert "Start from [1.0, 0.68" in said and said.endswith("they hold; it ends after t = 0.")
    assert many.y_end[2, 0] == pytest.approx(0.3 * math.exp(-1.0), rel=1e-6)


def test_an_action_without_a_consistent_state_ends_its_trajectory_alone():
    def square(t, y, k):
        return [-y[0], y[1] ** 2 - (2.0 - y[0])]

    many = solve_ensemble(
        square, (0, 3), [1.0, 1.0], (np.array([2.0, 10.0]),), "Rodas5P", events=half,
        on_event=lambda t, y, k: [k * y[0], y[1]], mass=np.diag([1.0, 0.0]), **GIVEN,
    )  # fmt: skip
    assert many.status.tolist() == [0, -1]
    assert "equation 1 of `fun` stays different from 0" in many.message(1)


def test_extrema_and_other_methods():
    given = (0, 2), [1.0, root(1.0)], (RATES,)
    mass = np.diag([1.0, 0.0])
    many = solve_ensemble(decaying, *given, "Rodas5P", reduce=["max", "min"], mass=mass, **GIVEN)
    assert many.width == 1 and "slopes" in many.reason
    assert np.array_equal(many.reduced["min"], many.y_end)
    assert many.reduced["max"] == pytest.approx(np.tile([1.0, root(1.0)], (11, 1)), abs=1e-12)
    with pytest.raises(ValueError, match="`mass` is not for RK45"):
        solve_ensemble(decaying, *given, "RK45", mass=mass)
    with pytest.raises(ValueError, match="2 rows and columns"):
        solve_ensemble(decaying, *given, "Rodas5P", mass=np.eye(3))


@pytest.mark.parametrize("method", TAKE)
def test_a_matrix_that_changes(method):
    """y = (exp(-k t), sin(t)), of a full M of t, y and k."""

    def mass(t, y, k):
        return [[2.0 + y[1] ** 2, k * t], [y[0], 1.0 + t]]

    def fun(t, y, k):
        slope = -k * y[0], math.cos(t)
        return [
            (2.0 + y[1] ** 2) * slope[0] + k * t * slope[1], y[0] * slope[0] + (1 + t) * slope[1]
        ]  # fmt: skip

    many = solve_ensemble(fun, (0, 2), [1.0, 0.0], (RATES,), method, mass=mass, **GIVEN)
    assert many.y_end == pytest.approx(
        np.column_stack([np.exp(-2 * RATES), np.full(11, math.sin(2))]), abs=3e-5
    )


@pytest.mark.hunt
def test_means_along_trajectories():
    """The integrals of the moments stand beside M as y' = f does."""
    given = {"rtol": 1e-8, "atol": 1e-10, "reduce": ["mean", "rms"]}
    many = solve_ensemble(
        decaying, (0, 1), [1.0, root(1.0)], (RATES,), "Rodas5P", mass=np.diag([1.0, 0.0]), **given
    )
    mean, square = (1.0 - np.exp(-RATES)) / RATES, (1.0 - np.exp(-2.0 * RATES)) / (2.0 * RATES)
    assert many.reduced["mean"][:, 0] == pytest.approx(mean, rel=1e-6)
    assert many.reduced["rms"][:, 0] == pytest.approx(np.sqrt(square), rel=1e-6)


@pytest.mark.parametrize("name", ["constant", "of the state"])
def test_in_blocks_the_matrix_counts_once(name, tmp_path):
    """Workers get the equations as they are solved here: a function is divided by M already."""
    pytest.importorskip("zarr")

    def fun(t, y, k):
        return [-3.0 * k * y[0]]

    mass = np.array([[3.0]]) if name == "constant" else lambda t, y, k: [[3.0 + 0.0 * y[0]]]
    many = solve_ensemble(
        fun, (0, 1), [1.0], (RATES,), "Rodas5P", mass=mass, store=tmp_path / "m.zarr", block=4,
        **GIVEN,
    )  # fmt: skip
    assert np.ravel(many.y_end) == pytest.approx(np.exp(-RATES), rel=1e-5)
