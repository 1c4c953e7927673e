"""`solve_linear`, `constrained` and np.linalg.solve are traced: pivots follow the state."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.trace.graph.derivatives import jacobian
from fastdyn.trace.graph.evaluate import evaluate
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
    return fastdyn.solve_linear(rows, (-y[0], -y[1], -y[2]))


START, ROD = [1.0, 0.5, -0.3], [0.0, -1.0, 1.5, 0.0]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("fun", "y0", "args"),
    [(on_a_rod, ROD, (2.0, 9.81)), (rotated, START, ()), (rotated_by_hand, START, ())],
)
def test_answers_are_those_of_python(fun, y0, args):
    near = Near(0.0, 4.0, np.array(y0))
    assert traced_function(Attempt(fun, args, DERIVATIVE, len(y0)), near) is not None
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
        return fastdyn.solve_linear(((1.0, k), (y[0], 2 * y[0])), (1.0, 1.0))

    assert fastdyn.solve_ivp(fun, (0, 1), [1.0, 1.0], args=(3.0,)).success
    with pytest.raises(fastdyn.SingularMatrixError, match="t = 0"):
        fastdyn.solve_ivp(fun, (0, 1), [1.0, 1.0], args=(2.0,))


@pytest.mark.hunt
def many(y, solve, t=0.0):
    """A system whose rows are badly scaled, and need exchanges."""
    n = len(y)
    rows = [
        [10.0 ** (3 * i % 17 - 8) * (y[j] * (i + 1) + (3.0 * n + t if j == (i + 2) % n else 0.1))
         for j in range(n)]
        for i in range(n)
    ]  # fmt: skip
    return solve(tuple(map(tuple, rows)), tuple(-x for x in y))


@pytest.mark.parametrize("n", [9, 12, 30])
def test_many_equations_are_solved_in_a_loop(n):
    def fun(t, y):
        return many(y, fastdyn.solve_linear, t)

    found, rng = trace(fun, (), n, (n,)), np.random.default_rng(n)
    assert len(found.graph.nodes) < 20 * n * n  # written out they would be n**3
    code = bind(fun, (), DERIVATIVE, n, Near(0.0, 1.0, np.full(n, 0.5))).function
    assert code is not None
    y = rng.standard_normal(n)
    entries, own = jacobian(found.graph, found.outputs, n), np.zeros((n, n))
    nodes = [*found.outputs, *entries.nodes]
    values = evaluate(found.graph, nodes, np.array([0.3]), y[:, None], found.graph.values)[0][:, 0]
    own[entries.rows, entries.columns] = values[n:]
    exact = np.array(fun(0.3, y))
    np.testing.assert_allclose(values[:n], exact, 0, 1e-12 * np.abs(exact).max())
    steps = 1e-30j * np.eye(n)
    by_numpy = [
        many(y + h, lambda a, b: np.linalg.solve(np.array(a), np.array(b)), 0.3) for h in steps
    ]
    slopes = np.array([x.imag / 1e-30 for x in by_numpy]).T
    np.testing.assert_allclose(own, slopes, 0, 1e-11 * np.abs(slopes).max())


def test_many_equations_that_are_singular_to_working_precision():
    def fun(t, y):
        rows = [[float(i == j) for j in range(12)] for i in range(12)]
        rows[3][4], rows[4][3], rows[4][4] = 1.0, 1.0, 1.0 + y[0]
        return fastdyn.solve_linear(tuple(map(tuple, rows)), (*(0 * y[1:]), 1.0))

    assert fastdyn.solve_ivp(fun, (0, 1), [1e-14] + 11 * [1.0], "RK4", step=0.25).success
    for small in (0.0, 1e-16, float("nan")):
        code = bind(fun, (), DERIVATIVE, 12, Near(0.0, 1.0, np.ones(12)))
        assert machine_value(code, 0.0, np.array([small] + 11 * [1.0])) is None
    with pytest.raises(fastdyn.SingularMatrixError, match="t = 0"):
        fastdyn.solve_ivp(fun, (0, 1), [1e-16] + 11 * [1.0])


def test_many_constraints():
    n, k = 9, 3
    rng = np.random.default_rng(1)
    a, mass = rng.standard_normal((k, n)), rng.uniform(1, 2, n)
    m = np.diag(mass) + 0.1

    def fun(t, y):
        q, v = y[:n], y[n:]
        rows = tuple(tuple(x + 0.1 * y[0] for x in row) for row in a.tolist())
        given = tuple(map(tuple, m.tolist())), rows, tuple(-q), (0.0,) * k
        return [*v, *fastdyn.constrained(*given)[:n]]

    y0 = rng.standard_normal(2 * n)
    code = bind(fun, (), DERIVATIVE, 2 * n, Near(0.0, 1.0, y0))
    exact = np.array(fun(0.0, y0))
    np.testing.assert_allclose(machine_value(code, 0.0, y0), exact, 0, 1e-12 * np.abs(exact).max())


def test_more_equations_than_a_loop_takes_run_in_python():
    def fun(t, y):
        return many(y, fastdyn.solve_linear, t)

    with pytest.raises(Untraceable, match="65 linear equations"):
        trace(fun, (), 65, (65,))


def test_many_equations_are_left_to_lapack():
    def fun(t, y):
        return np.linalg.solve(np.outer(y, y) + np.eye(len(y)) * (1 + t), y)

    with pytest.raises(Untraceable, match="70 equations"):
        trace(fun, (), 70, (70,))
    y0 = np.linspace(0.1, 1, 70)
    found, expected = fastdyn.solve_ivp(fun, (0, 1), y0), reference(fun, (0, 1), y0)
    np.testing.assert_allclose(found.y, expected.y, rtol=1e-9)
