"""M y' = f(t, y) by prepared solvers and by single steps: as solve_ivp, bit for bit."""

import math

import numpy as np
import pytest

from fastdyn import Stepper, prepare, solve_dae, solve_ivp
from support.masses import MASS, TAKE, decaying, root
from support.steppers import ended

GIVEN = {"rtol": 1e-8, "atol": 1e-10}


STARTS = [[x, root(x)] for x in (1.0, 0.5, 2.0, 1e-6)]


@pytest.mark.parametrize("method", TAKE)
def test_many_solves_are_those_of_a_loop_over_calls(method):
    solver = prepare(decaying, (0, 3), STARTS[0], method, args=(1.0,), mass=MASS, **GIVEN)
    ends = []
    for start in STARTS * 2:  # the first by Python, later ones in C
        for k in (1.0, 2.5):
            ends.append(solver(start, args=(k,)).y[:, -1])
            assert ends[-1][0] == pytest.approx(start[0] * math.exp(-3.0 * k), rel=1e-4, abs=1e-9)
    many = solver.many(np.repeat(STARTS, 2, axis=0), args=(np.tile([1.0, 2.5], 4),))
    assert np.array_equal(many.y, ends[:8]) and many.success.all()


@pytest.mark.parametrize("method", TAKE)
def test_a_start_that_is_not_consistent_is_refused_each_time(method):
    solver = prepare(decaying, (0, 3), STARTS[0], method, args=(1.0,), mass=MASS, **GIVEN)
    for _ in range(6):
        assert solver(STARTS[1]).success
        with pytest.raises(ValueError, match=r"component 1 is off by .* Start from \[0\.5, 0\.42"):
            solver([0.5, 0.5])
    with pytest.raises(ValueError, match="component 1 is off by"):
        solver.many([STARTS[0], [0.5, 0.5]])
    assert np.array_equal(solver.many([STARTS[1]]).y[0], solver(STARTS[1]).y[:, -1])
    with pytest.raises(ValueError, match="component 1 is off by"):
        Stepper(decaying, 0.0, [0.5, 0.5], 3.0, method=method, args=(1.0,), mass=MASS, **GIVEN)
    with pytest.raises(ValueError, match="no DAE of index 1"):
        prepare(lambda t, y: [y[1], y[0]], (0, 1), [0.0, 0.0], method, mass=MASS)()


def test_matrices_that_change_and_methods_without():
    def mass(t, y):
        return [[2.0 + y[1] ** 2, 0.5 * t], [y[0], 1.0 + t]]

    def fun(t, y):
        slope = -y[0], math.cos(t)
        return [
            (2.0 + y[1] ** 2) * slope[0] + 0.5 * t * slope[1], y[0] * slope[0] + (1 + t) * slope[1]
        ]  # fmt: skip

    for method in TAKE:
        run = prepare(fun, (0, 2), [1.0, 0.0], method, mass=mass, **GIVEN)()
        assert run.y[:, -1] == pytest.approx([math.exp(-2), math.sin(2)], abs=3e-6)
        stepper = ended(Stepper(fun, 0.0, [1.0, 0.0], 2.0, method=method, mass=mass, **GIVEN))
        assert np.array_equal(stepper.y, run.y[:, -1])
    with pytest.raises(ValueError, match="`mass` is not for Tsit5"):
        prepare(fun, (0, 2), [1.0, 0.0], "Tsit5", mass=mass)
    with pytest.raises(ValueError, match="`mass` is not for RK45"):
        Stepper(fun, 0.0, [1.0, 0.0], 2.0, mass=np.eye(2))


def test_a_singular_matrix_that_changes_is_for_solve_dae():
    """x' (1 + z) = -x (1 + z), 0 = z - x: the sentence says what to call."""

    def mass(t, y):
        return np.array([[1.0 + y[1], 0.0], [0.0, 0.0]])

    def fun(t, y):
        return np.array([-y[0] * (1.0 + y[1]), y[1] - y[0]])

    said = r"Take `solve_dae` with a function F\(t, y, yp\) that returns mass\(t, y\) @ yp - fun"
    with pytest.raises(ValueError, match=said):
        solve_ivp(fun, (0, 2), [1.0, 1.0], "Rodas5P", mass=mass)
    dae = solve_dae(
        lambda t, y, yp: mass(t, y) @ yp - fun(t, y), (0, 2), [1.0, 0.0], given="differential",
        **GIVEN,
    )  # fmt: skip
    assert dae.y[:, -1] == pytest.approx([math.exp(-2.0)] * 2, rel=1e-5)
