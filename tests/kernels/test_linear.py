"""Claims about the small linear solves: right, the same in Python and compiled, never silent."""

import math
import warnings

import numpy as np
import pytest
from numba import njit

import fastdyn
from fastdyn import SingularMatrixError, constrained, solve_ivp, solve_linear

EPS = np.finfo(float).eps


@njit
def compiled_linear(a, b):
    return solve_linear(a, b)


@njit
def compiled_constrained(mass, a, force, b):
    return constrained(mass, a, force, b)


def rows(matrix):
    return tuple(tuple(map(float, row)) for row in matrix)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
def test_solution_is_as_good_as_lapacks_and_the_same_compiled(n):
    rng = np.random.default_rng(n)
    for _ in range(30):
        a = rng.normal(size=(n, n)) * 10.0 ** rng.integers(-8, 8, size=(n, 1))
        b = rng.normal(size=n)
        x = solve_linear(rows(a), tuple(b))
        assert compiled_linear(rows(a), tuple(b.tolist())) == x
        # Backward stable: the residual is rounding of the terms, row by row.
        size = np.abs(a) @ np.abs(x) + np.abs(b)
        assert np.all(np.abs(a @ x - b) <= 2**n * n * EPS * size)


def test_pivots_are_chosen():
    assert solve_linear(((0.0, 1.0), (1.0, 0.0)), (2.0, 3.0)) == (3.0, 2.0)
    x = solve_linear(((1e-20, 1.0), (1.0, 1.0)), (1.0, 2.0))
    assert x == pytest.approx((1.0, 1.0), rel=4 * EPS)


@pytest.mark.parametrize(
    "a",
    [
        ((0.0,),),
        ((math.nan,),),
        ((1.0, 2.0), (2.0, 4.0)),
        ((1.0, 1.0 / 3.0), (3.0, 1.0)),
        ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0)),
    ],
)
def test_singular_matrices_are_reported_as_such(a):
    b = (1.0,) * len(a)
    with pytest.raises(SingularMatrixError, match="singular"):
        solve_linear(a, b)
    with pytest.raises(SingularMatrixError, match="singular"):
        compiled_linear(a, b)


def test_scale_alone_makes_no_matrix_singular():
    for size in (1e-200, 1e-20, 1e20, 1e200):
        assert solve_linear(((size, 0.0), (0.0, 1.0)), (size, 1.0)) == (1.0, 1.0)
        q, r = constrained((size,), ((1.0,),), (0.0,), (2.0,))
        assert q == 2.0 and r == pytest.approx(2.0 * size, rel=4 * EPS)
        q, r = constrained(((size,),), ((1.0,),), (0.0,), (2.0,))
        assert q == 2.0 and r == pytest.approx(2.0 * size, rel=4 * EPS)


@pytest.mark.few(3)
@pytest.mark.parametrize("n, k", [(1, 1), (2, 1), (3, 2), (5, 3), (4, 4)])
def test_constrained_solves_newtons_law_with_reactions(n, k):
    rng = np.random.default_rng(10 * n + k)
    for _ in range(10):
        mass, a = rng.uniform(0.1, 10.0, n), rng.normal(size=(k, n))
        force, b = rng.normal(size=n), rng.normal(size=k)
        given = rows(a), tuple(force.tolist()), tuple(b.tolist())
        by_masses = constrained(tuple(mass.tolist()), *given)
        by_matrix = constrained(rows(np.diag(mass)), *given)
        for x, m in ((by_masses, tuple(mass.tolist())), (by_matrix, rows(np.diag(mass)))):
            assert compiled_constrained(m, *given) == x
            q, r = np.array(x[:n]), np.array(x[n:])
            condition = np.linalg.cond(a) ** 2 * 100.0
            assert np.allclose(mass * q - a.T @ r, force, rtol=0, atol=1e3 * EPS * condition)
            assert np.allclose(a @ q, b, rtol=0, atol=1e3 * EPS * condition)


def test_a_massless_part_is_allowed_in_a_matrix():
    mass = ((1.0, 0.0), (0.0, 0.0))
    q1, q2, r = constrained(mass, ((1.0, 1.0),), (3.0, 0.0), (5.0,))
    assert (q1, q2, r) == (3.0, 2.0, 0.0)
    with pytest.raises(SingularMatrixError, match="do not determine"):
        constrained(mass, ((1.0, 0.0),), (3.0, 0.0), (5.0,))


def test_constraints_that_repeat_each_other_are_refused():
    with pytest.raises(SingularMatrixError, match="independent"):
        constrained((1.0, 1.0), ((1.0, 2.0), (2.0, 4.0)), (0.0, 0.0), (1.0, 2.0))


@pytest.mark.parametrize(
    "call",
    [
        lambda: solve_linear(((1.0, 2.0),), (1.0,)),
        lambda: solve_linear(((1.0,), (2.0,)), (1.0, 2.0)),
        lambda: constrained((1.0, 1.0), ((1.0,),), (0.0, 0.0), (1.0,)),
        lambda: constrained((1.0,), ((1.0, 1.0),), (0.0, 0.0), (1.0,)),
        lambda: constrained((1.0, 1.0), ((1.0, 1.0),), (0.0, 0.0), (1.0, 2.0)),
    ],
)
def test_shapes_that_do_not_fit_are_refused(call):
    with pytest.raises(ValueError, match="row"):
        call()


@pytest.mark.parametrize("tier", ["shared", "inlined"])
def test_a_matrix_that_becomes_singular_is_reported_with_the_time(tier):
    def fun(t, y):
        (a, _) = constrained((1.0,), ((2.0 - t,),), (0.0,), (1.0,))
        return [y[1], a]

    with pytest.raises(SingularMatrixError, match=r"At t = 2, the equations of motion"):
        solve_ivp(fun, (0, 4), [0.0, 1.0], "RK4", step=0.125, compile=tier)


def test_they_compile_inside_a_users_function_whatever_name_they_have():
    def by_module(t, w):
        return fastdyn.solve_linear(((2, 0), (0, 4)), (w[1], -w[0]))

    solve = solve_linear

    def by_closure(t, w):
        return solve(((2.0, 0.0), (0.0, 4.0)), (w[1], -w[0]))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs = [solve_ivp(f, (0, 5), [1.0, 0.0], rtol=1e-8) for f in (by_module, by_closure)]
    assert np.array_equal(runs[0].y, runs[1].y)
    assert runs[0].y[0, -1] == pytest.approx(math.cos(5 / math.sqrt(8)), abs=1e-6)
