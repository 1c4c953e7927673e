"""np.linalg.solve on symbols: blocks, loops over large blocks, singular matrices, derivatives."""

import ctypes

import numpy as np
import pytest
import scipy.linalg

import fastdyn
from fastdyn.code_store import OFFERED
from fastdyn.code_store.target import STRAIGHT
from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.code import Traced
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.algebra.padded.storage import leading, length
from fastdyn.trace.functions.linear_systems import _blocks
from fastdyn.trace.graph.derivatives import jacobian
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.reverse import pullback
from fastdyn.trace.operations.linear import FACTORS, SOLUTION
from fastdyn.trace.paths.runs import trace
from support.long_arrays import in_batches

KERNEL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)
EPS = np.finfo(float).eps
GUARD = 7.25  # around the memory of a matrix


def called(name, *given):
    words = []
    for each in given:
        words += [each.ctypes.data, each.size] if isinstance(each, np.ndarray) else [each]
    words = np.array(words, np.int64)
    return KERNEL(OFFERED[name]().address)(words.ctypes.data)


def solved(a, b, symmetric=False, transposed=False):
    """(status, x, pivots) by the kernels."""
    n, ld = len(a), leading(len(a))
    rows = [np.full(size + 16, GUARD) for size in (length(n), 2 * n, ld)]
    stored, pivots, x = (row[8:-8] for row in rows)
    stored[:], x[:], pivots[:] = np.eye(ld).ravel(), 0.0, n + 6  # no rows
    stored.reshape(ld, ld)[:n, :n], x[:n] = a.T, b
    status = called(FACTORS, stored, pivots, int(symmetric))
    called(SOLUTION, stored, pivots, x, int(transposed))
    assert all((part == GUARD).all() for row in rows for part in (row[:8], row[-8:]))
    return status, x[:n], pivots


def backward_error(a, x, b):
    """The residual, in units of its rounding errors (W. Oettli and W. Prager, 1964)."""
    return np.max(np.abs(a @ x - b) / (np.abs(a) @ np.abs(x) + np.abs(b))) / EPS


@pytest.mark.parametrize("n", [1, 2, 5, 9, 10, 11, 12, 31, 60, 64])
@pytest.mark.parametrize("shape", ["full", "banded", "badly scaled"])
def test_kernels_solve(n, shape):
    rng = np.random.default_rng(n)
    a, b = rng.standard_normal((2, n, n)), rng.standard_normal(n)
    a, scale = a[0], 10.0 ** rng.integers(-8, 9, (n, 1))
    if shape == "banded":
        a *= np.abs(np.subtract.outer(np.arange(n), np.arange(n))) < 3
    if shape == "badly scaled":
        a *= scale
    for transposed in (False, True):
        status, x, pivots = solved(a, b, transposed=transposed)
        assert status == 0 and backward_error(a.T if transposed else a, x, b) < 4 * n * n
    np.testing.assert_array_equal(pivots[:n], scipy.linalg.lu_factor(a)[1])
    m = a @ a.T + np.eye(n)
    status, x, pivots = solved(m, b, symmetric=True)
    assert status == 0 and pivots[0] == -1 and backward_error(m, x, b) < 4 * n * n


def test_symmetric_matrices_without_sure_pivots_are_eliminated_with_exchanges():
    rng = np.random.default_rng(0)
    a = rng.standard_normal((12, 12))
    a, b = a + a.T, rng.standard_normal(12)
    for late in (False, True):
        if late:  # a leading block that is positive definite: the factors are begun, and put back
            a[:8, :8] += 40 * np.eye(8)
            a[9, 9] = -1.0
        status, x, pivots = solved(a, b, symmetric=True)
        assert status == 0 and backward_error(a, x, b) < 600
        np.testing.assert_array_equal(pivots[:12], scipy.linalg.lu_factor(a)[1])
    ones = np.ones((12, 12))
    assert solved(ones, b, symmetric=True)[0] == solved(ones, b)[0] == 1


def hard(name, n, rng):
    """A matrix that needs exchanges, or whose pivots are equal, or alike."""
    a = rng.standard_normal((n, n))
    return {
        "cyclic": np.roll(np.eye(n), 1, 0) + 1e-9 * a,
        "permutation": np.eye(n)[rng.permutation(n)],
        "signs": np.where(a > 0, 1.0, -1.0) + 0.1 * np.eye(n),
        "symmetric, zero diagonal": (a + a.T) * (1 - np.eye(n)),
        "symmetric, late": np.where(np.add.outer(*2 * [np.arange(n)]) < n, a @ a.T, a + a.T),
        "nearly singular": a - np.outer(a[:, 0] - (1 + 1e-13) * a[:, 1], np.eye(n)[0]),
        "scaled rows": a * 10.0 ** rng.integers(-150, 150, (n, 1)),
        "arrow": np.where(np.eye(n) > 0, 3.0, np.where(np.arange(n) == n - 1, 0.1, 0.0)),
    }[name]


@pytest.mark.parametrize("n", [9, 14, 33, 64])
def test_hard_matrices_are_solved_as_by_lapack(n):
    rng = np.random.default_rng(n)
    for name in (
        "cyclic", "permutation", "signs", "symmetric, zero diagonal", "symmetric, late",
        "nearly singular", "scaled rows", "arrow",
    ):  # fmt: skip
        a, b = hard(name, n, rng), rng.standard_normal(n)
        for symmetric in (False, True):
            if symmetric and not name.startswith("symmetric"):
                continue
            a = (a + a.T) / 2 if symmetric else a
            status, x, _ = solved(a, b, symmetric)
            assert status == 0 and backward_error(a, x, b) < 4 * n * n, name
            expected, size = np.linalg.solve(a, b), np.linalg.norm
            bound = 4 * n * np.linalg.cond(a / np.abs(a).max(1)[:, None]) * EPS
            assert size(x - expected) <= bound * size(expected), name


def test_infinite_and_missing_elements_stay_where_they_are():
    a = np.eye(9)
    a[4, 4] = np.inf
    assert (solved(a, np.ones(9))[1] == [1, 1, 1, 1, 0, 1, 1, 1, 1]).all()
    a[4, 4], a[0, 8] = 1.0, np.inf
    np.testing.assert_array_equal(solved(a, np.ones(9))[1], [-np.inf] + 8 * [1.0])
    a[0, 8] = np.nan
    np.testing.assert_array_equal(np.isnan(solved(a, np.ones(9))[1]), [True] + 8 * [False])


def test_tiny_and_odd_numbers():
    a = np.eye(10) * 1e-310
    np.testing.assert_allclose(solved(a, np.full(10, 1e-310))[1], 1.0)
    a[3, 4] = np.nan
    status, x, _ = solved(a, np.ones(10))
    assert status == 0 and np.isnan(x[3])


# -- blocks


def drawn(n, name, rng):
    """Where a matrix has elements."""
    i, j = np.indices((n, n))
    return {
        "full": i >= 0,
        "identity and full": np.where((i < n // 2) | (j < n // 2), i == j, True),
        "triangular": j >= i,
        "permuted": (j == (i + 1) % n) | (j == (i + 2) % n) & (i % 3 == 0),
        "two": (i < n // 3) == (j < n // 3),
        "coupled": (i < n // 3) <= (j < n // 3),
        "drawn": (rng.random((n, n)) < 2 / n) | (j == rng.permutation(n)[:, None]),
    }[name]


SHAPES = ["full", "identity and full", "triangular", "permuted", "two", "coupled", "drawn"]


@pytest.mark.parametrize("name", SHAPES)
def test_blocks_are_a_block_triangular_form(name):
    for n in (1, 2, 7, 20):
        where = drawn(n, name, np.random.default_rng(n))
        blocks, known = _blocks(where), set()
        for rows, columns in blocks:
            known.update(columns)
            assert len(rows) == len(columns)
            assert all(set(np.flatnonzero(where[i])) <= known for i in rows)
        assert sorted(i for rows, _ in blocks for i in rows) == sorted(known) == list(range(n))
    sizes = [len(rows) for rows, _ in _blocks(drawn(12, "identity and full", np.random))]
    assert sorted(sizes) == [1] * 6 + [6]


def test_a_matrix_that_is_singular_by_its_zeros_is_one_block():
    assert _blocks(np.zeros((3, 3), bool)) == [([0, 1, 2], [0, 1, 2])]


def function_of(where, seed=0):
    """A function that solves for a matrix with elements in given places."""
    n, rng = len(where), np.random.default_rng(seed)
    c = rng.standard_normal((3, n, n))

    def f(t, y):
        a = np.zeros((n, n)) * y[0]
        for i, j in np.argwhere(where).tolist():
            a[i, j] = c[0, i, j] + c[1, i, j] * y[j] + t * c[2, i, j] * y[i]
        return np.linalg.solve(a, np.sin(y))

    return f


def code_of(f, n, y0=None):
    """The compiled f(t, y); None where the code raises."""
    y0 = np.linspace(-1.0, 1.0, n) if y0 is None else y0
    bound = bind(f, (), DERIVATIVE, n, Near(0.0, 1.0, y0))
    assert bound.function is not None and bound.function.traced is not None
    return lambda t, y: machine_value(bound, t, y)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("n", [9, 24])
def test_answers_are_numpys(name, n):
    rng = np.random.default_rng(n)
    f = function_of(drawn(n, name, rng))
    code = code_of(f, n)
    for _ in range(5):
        t, y = rng.random(), rng.standard_normal(n)
        found, expected = code(t, y), f(t, y)
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def symmetric(t, y):
    return np.linalg.solve(np.outer(y, y) + np.eye(len(y)) * (1 + t), np.cos(y))


def unsymmetric(t, y):
    m = np.outer(y, np.cos(y)) + (2 + t) * np.eye(len(y))
    return np.linalg.solve(m, np.sin(y) * y[::-1])


def of_parts(t, y):  # complex right-hand sides, several of them, a known matrix beside
    b = np.column_stack([y, 1j * np.cos(y), y * y])
    x = np.linalg.solve(np.outer(y, np.sin(y)) + 3 * np.eye(len(y)), b)
    return x[:, 0].real + x[:, 1].imag + x[:, 2].real


def inverted(t, y):
    return np.linalg.inv(np.outer(y, np.sin(y)) + 3 * np.eye(len(y))) @ y


def test_all_that_is_written_out_is_optimised():
    """Code that is not takes more time than the loop over larger matrices: eight full rows."""
    numbers = np.random.default_rng(8).standard_normal((8, 8))
    places = np.add.outer(range(8), range(8)) % 8

    def full(t, y):
        return np.linalg.solve(numbers * (1.0 + 0.1 * y[places]), -y)

    text = Traced(trace(full, (), 8, (8,)), DERIVATIVE, 8).text("f")
    assert FACTORS not in text
    assert max(part.count("\n") for part in text.split("\ndefine ")) < STRAIGHT


FUNCTIONS = [symmetric, unsymmetric, of_parts, inverted]


@pytest.mark.parametrize("f", FUNCTIONS)
@pytest.mark.parametrize("n", [9, 20])
def test_derivatives_are_exact(f, n):
    found, rng = trace(f, (), n, (n,)), np.random.default_rng(n)
    g, t, y = found.graph, 0.3, rng.standard_normal(n)

    def values(nodes):
        return evaluate(g, nodes, np.array([t]), y[:, None], g.values)[0][:, 0]

    entries, own = jacobian(g, found.outputs, n), np.zeros((n, n))
    own[entries.rows, entries.columns] = values(entries.nodes)
    size = 1e-30
    if f is of_parts:  # takes no complex state
        size = 1e-6
        steps = np.eye(n) * size
        exact = np.array([(f(t, y + h) - f(t, y - h)) / (2 * size) for h in steps]).T
        tolerance = 1e-8
    else:
        exact = np.array([f(t, y + 1j * size * h).imag / size for h in np.eye(n)]).T
        tolerance = 1e-11
    np.testing.assert_allclose(own, exact, 0, tolerance * np.abs(exact).max())
    w = rng.standard_normal(n)
    ends = [g.const(v) for v in w]
    back = values(pullback(g, found.outputs, ends, [g.make("y", (), i) for i in range(n)]))
    np.testing.assert_allclose(back, w @ own, 0, 1e-11 * np.abs(w @ own).max())


@pytest.mark.parametrize("f", FUNCTIONS)
@pytest.mark.parametrize("n", [9, 40])
def test_long_arrays(f, n):
    code, rng = in_batches(f, n)[0], np.random.default_rng(1)
    for _ in range(3):
        y = rng.standard_normal(n)
        np.testing.assert_allclose(code(0.3, y), f(0.3, y), 1e-10, 1e-10)


def test_implicit_methods_get_exact_jacobians():
    y0 = np.linspace(0.1, 1.0, 10)
    exact = fastdyn.solve_ivp(unsymmetric, (0, 1), y0, method="DOP853", rtol=1e-12, atol=1e-12)
    for method in ("Radau", "Rodas5P"):
        found = fastdyn.solve_ivp(unsymmetric, (0, 1), y0, method=method, rtol=1e-8, atol=1e-8)
        assert found.success and found.nfev < 300
        np.testing.assert_allclose(found.y[:, -1], exact.y[:, -1], 1e-6)


# -- singular matrices


def matrix(y, kept, both):
    """A matrix of which row 3, and column 3 of a symmetric matrix, are 0 unless `kept`."""
    m = np.outer(y, y) + 2 * np.eye(len(y))
    m[3] = m[3] * kept
    if both:
        m[:, 3] = m[:, 3] * kept
    return m


@pytest.mark.parametrize("both", [False, True])
def test_a_singular_matrix_raises_as_numpy_does(both):
    def f(t, y):
        return np.linalg.solve(matrix(y, y[0] > 0.0, both), -y)

    y0 = np.linspace(0.5, 1.0, 10)
    code = code_of(f, 10, y0)
    np.testing.assert_allclose(code(0.0, y0), f(0.0, y0))
    assert code(0.0, -y0) is None
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        fastdyn.solve_ivp(f, (0, 1), -y0)


def test_a_matrix_that_becomes_singular_ends_the_solve():
    def f(t, y):
        return np.linalg.solve(matrix(y, t < 0.5, False), -y)

    assert code_of(f, 12)(0.6, np.ones(12)) is None
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        fastdyn.solve_ivp(f, (0, 1), np.ones(12), max_step=0.1)


def test_a_caught_exception_is_followed():
    def f(t, y):
        try:
            return np.linalg.solve(matrix(y, y[0] > 0.5, True), -y)
        except np.linalg.LinAlgError:
            return 0.1 * np.ones(len(y))

    code, y = code_of(f, 11, np.ones(11)), np.linspace(0.25, 0.5, 11)
    np.testing.assert_allclose(code(0.0, y), f(0.0, y))
    np.testing.assert_allclose(code(0.0, y + 1), f(0.0, y + 1))


def test_matrices_of_outside_numbers():
    m = np.eye(12) * 2.0
    m[0, 1:] = 0.1

    def f(t, y):
        return np.linalg.solve(m * (1.0 + t), -y)

    found = fastdyn.solve_ivp(f, (0, 1), np.ones(12), rtol=1e-10, atol=1e-10)
    m[0, 1:] = 0.3  # read again before each solve
    other = fastdyn.solve_ivp(f, (0, 1), np.ones(12), rtol=1e-10, atol=1e-10)
    t = np.log(2.0)  # of the integral of 1 / (1 + t)
    for result, corner in ((found, 0.1), (other, 0.3)):
        a = np.eye(12) * 2.0
        a[0, 1:] = corner
        exact = scipy.linalg.expm(-np.linalg.inv(a) * t) @ np.ones(12)
        np.testing.assert_allclose(result.y[:, -1], exact, 1e-8)


def test_the_gradient_by_radau_of_a_saddle_point():
    """Rows of its Jacobian read rows that the plan of loops does not keep."""
    n, c = 12, 5

    def constrained(t, y, k):
        q, v = y[:n], y[n:]
        matrix = np.zeros((n + c, n + c)) + 0 * y[0]
        matrix[:n, :n] = np.diag(np.linspace(1, 2, n))
        for i in range(c):
            matrix[n + i, i] = matrix[i, n + i] = q[i] + 1
            matrix[n + i, i + 1] = matrix[i + 1, n + i] = k * q[i + 1]
        right = np.concatenate((-q, -k * v[:c] ** 2))
        return np.concatenate((v, np.linalg.solve(matrix, right)[:n]))

    y0 = np.r_[np.linspace(0.5, 1, n), np.zeros(n)]
    given = {"rtol": 1e-9, "atol": 1e-11, "t_eval": [1.0], "args": (0.7,)}
    run = fastdyn.solve_ivp(constrained, (0, 1), y0, "Radau", adjoint="k", **given)
    exact = fastdyn.solve_ivp(constrained, (0, 1), y0, "Vern9", sensitivity="k", **given)
    found = run.vjp(np.ones((2 * n, 1)))["k"]
    assert found == pytest.approx(exact.sensitivity["k"].sum(), rel=1e-6)
