"""`solve_linear`, `constrained` and np.linalg.solve are traced: pivots follow the state."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace


def on_a_rod(t, w, m, g):
    x, y, vx, vy = w
    right = -2 * (vx * vx + vy * vy)
    ax, ay, _ = fastdyn.constrained((m, m), ((2 * x, 2 * y),), (0.0, -m * g), (right,))
    return vx, vy, ax, ay


def rotated(t, y):
    """A matrix whose diagonal vanishes on the way, for numpy's solver and ours."""
    c, s = np.cos(3 * t), np.sin(3 * t)
    matrix = np.array([[c, -s, 0.1], [s, c, 0.0], [0.0, 0.2, 1.0]])
    return np.linalg.solve(matrix, -y)


def rotated_by_hand(t, y):
    c, s = np.cos(3 * t), np.sin(3 * t)
    rows = ((c, -s, 0.1), (s, c, 0.0), (0.0, 0.2, 1.0))
    return fastdyn.linear_solvers.solve_linear(rows, (-y[0], -y[1], -y[2]))


START, ROD = [1.0, 0.5, -0.3], [0.0, -1.0, 1.5, 0.0]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("fun", "y0", "args"),
    [(on_a_rod, ROD, (2.0, 9.81)), (rotated, START, ()), (rotated_by_hand, START, ())],
)
def test_answers_are_those_of_python(fun, y0, args):
    near = Near(0.0, 4.0, np.array(y0))
    assert traced_function(fun, args, DERIVATIVE, len(y0), near) is not None
    given = {"args": args, "rtol": 1e-8, "atol": 1e-8}
    found, expected = (
        fastdyn.solve_ivp(fun, (0, 4), y0, **given),
        reference(fun, (0, 4), y0, **given),
    )
    assert found.nfev == expected.nfev
    # Other pivots round differently, which the first step, all of it round-off, hands to the rest.
    np.testing.assert_allclose(found.y, expected.y, rtol=1e-7, atol=1e-7)


def test_ensembles_run_on_vectors():
    y0 = np.array([[0.0, -1.0, v, 0.0] for v in np.linspace(0.5, 3, 11)])
    vectors, one_by_one = (
        fastdyn.solve_ensemble(on_a_rod, (0, 2), y0, (2.0, 9.81), simd=simd, rtol=1e-9)
        for simd in (True, False)
    )
    np.testing.assert_allclose(vectors.y_end, one_by_one.y_end, rtol=1e-7, atol=1e-8)


def test_a_singular_matrix_is_named():
    def fun(t, y, k):
        return fastdyn.linear_solvers.solve_linear(((1.0, k), (y[0], 2 * y[0])), (1.0, 1.0))

    assert fastdyn.solve_ivp(fun, (0, 1), [1.0, 1.0], args=(3.0,)).success
    with pytest.raises(fastdyn.SingularMatrixError, match="t = 0"):
        fastdyn.solve_ivp(fun, (0, 1), [1.0, 1.0], args=(2.0,))


def test_many_equations_are_left_to_lapack():
    def fun(t, y):
        return np.linalg.solve(np.outer(y, y) + np.eye(len(y)) * (1 + t), y)

    assert len(trace(fun, (), 4, (4,)).outputs) == 4
    with pytest.raises(Untraceable, match="12 equations"):
        trace(fun, (), 12, (12,))
    y0 = np.linspace(0.1, 1, 12)
    found, expected = fastdyn.solve_ivp(fun, (0, 1), y0), reference(fun, (0, 1), y0)
    np.testing.assert_allclose(found.y, expected.y, rtol=1e-9)
