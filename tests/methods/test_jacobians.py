"""The Jacobian of Radau and BDF: given, exact, by differences; banded, sparse, wrong."""

import warnings

import numpy as np
import pytest
import scipy.integrate
import scipy.sparse
from scipy.integrate._ivp.common import num_jac

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.calls.block import JACOBIAN
from fastdyn.run.solve_problem import run_of
from support.stiff import (
    PROBLEMS,
    counts,
    heat,
    robertson,
    robertson_jacobian,
    solved,
    spring,
    van_der_pol_jacobian,
)

pytestmark = pytest.mark.usefixtures("nothing_is_left_to_scipy")
METHODS = ("Radau", "BDF")
EPS = np.finfo(float).eps


class Jacobians:
    """Van der Pol's, in many forms."""

    rows = staticmethod(lambda t, y, mu: van_der_pol_jacobian(t, y, mu).tolist())
    array = staticmethod(van_der_pol_jacobian)

    @staticmethod
    def filled(t, y, mu):
        found = np.zeros((2, 2))
        i = 0
        while i < 2 and t < 1e9:  # for Numba
            found[0, i], i = i, i + 1
        found[1, 0] = -2 * mu * y[0] * y[1] - 1.0
        found[1, 1] = mu * (1 - y[0] ** 2)
        return found

    @staticmethod
    def in_python(t, y, mu):
        return np.array(eval("[[0.0, 1.0], [-2 * mu * y[0] * y[1] - 1.0, mu * (1 - y[0] ** 2)]]"))


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("form", ["rows", "array", "filled", "in_python"])
@pytest.mark.parametrize("method", METHODS)
def test_a_jacobian_in_any_form(method, form):
    p, jac = PROBLEMS["van der Pol"], getattr(Jacobians, form)
    theirs = solved(scipy.integrate.solve_ivp, p, method, jac=jac)
    assert counts(solved(solve_ivp, p, method, jac=jac)) == counts(theirs)


@pytest.mark.parametrize("method", METHODS)
def test_a_constant_jacobian(method):
    a = np.array([[-100.0, 1.0], [0.5, -1.0]])
    given = (lambda t, y: a @ y, (0, 10), [1.0, 1.0], method)
    theirs, ours = (f(*given, jac=a) for f in (scipy.integrate.solve_ivp, solve_ivp))
    assert counts(ours) == counts(theirs) and ours.njev == 0
    for wrong in (np.eye(3), lambda t, y: np.eye(3), lambda t, y: 1.0, "exact"):
        with pytest.raises(ValueError, match="`jac"):
            solve_ivp(*given, jac=wrong)


@pytest.mark.parametrize("method", METHODS)
def test_a_sparse_jacobian(method):
    p = PROBLEMS["Robertson"]

    def sparse(t, y):
        return scipy.sparse.csc_matrix(robertson_jacobian(t, y))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.CompileWarning)
        theirs = solved(scipy.integrate.solve_ivp, p, method, jac=sparse)
        assert counts(solved(solve_ivp, p, method, jac=sparse)) == counts(theirs)


@pytest.mark.parametrize("method", METHODS)
def test_a_pattern_is_not_needed_where_the_jacobian_is_exact(method):
    p, pattern = PROBLEMS["heat"], sum(np.eye(30, k=k) for k in (-1, 0, 1))
    theirs = solved(scipy.integrate.solve_ivp, p, method, jac_sparsity=pattern)
    assert counts(solved(solve_ivp, p, method, jac_sparsity=pattern)) == counts(theirs)
    ours = solved(solve_ivp, p, method, jac_sparsity=pattern, jac="2-point")
    assert counts(ours) == counts(theirs)
    assert solve_ivp(in_a_loop, (0, 1), [1.0], method, jac_sparsity=[[1]]).success


def in_a_loop(t, y):
    x = y[0]
    while x > 0.3:  # no graph: Numba compiles it
        x /= 2
    return [-x]


def transposed(t, y):
    return np.array(robertson_jacobian(t, y)).T


@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA", "Rodas5P"])
def test_a_wrong_jacobian_is_named_once_by_each_method(method):
    given = (robertson, (0, 1e-3), [1.0, 0.0, 0.0], method)
    with pytest.warns(UserWarning, match=r"not the Jacobian of `fun`: at t = 0, .* \(0, 1") as said:
        solve_ivp(*given, jac=transposed)
    assert max(len(str(each.message)) for each in said) < 220
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solve_ivp(*given, jac=transposed)
        solve_ivp(*given, jac=robertson_jacobian)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_wrong_jacobian_of_many_components_or_in_python_is_named_shortly():
    matrix = -np.diag(np.arange(1.0, 41.0))

    def in_python(t, y):
        return matrix @ y * float(format(2.0, ".1f"))

    for fun, jac in (
        (lambda t, y: matrix @ y, lambda t, y: -matrix),
        (in_python, lambda t, y: matrix),
        (lambda t, y: matrix @ y, lambda t, y: matrix * float(format(2.0, ".1f"))),
    ):
        with pytest.warns(
            UserWarning, match="`jac` is not the Jacobian of `fun`: at t = 0"
        ) as said:
            solve_ivp(fun, (0, 1), np.linspace(1, 2, 40), "BDF", jac=jac)
        assert len(str(said[-1].message)) < 240


@pytest.mark.filterwarnings("ignore")
def test_a_jacobian_that_is_not_finite_ends_the_run_with_a_sentence():
    run = solve_ivp(spring, (0, 9), [1.0, 0.0], "BDF", jac=lambda t, y: [[0, 1 / y[1]], [-1, 0]])
    assert run.status == -1 and "The Jacobian is nan or inf at t = 0" in run.message


def test_differences_where_no_derivative_is_finite():
    """y' = -sqrt(y) beside a component at rest, from 0: the exact Jacobian is infinite there."""

    def fun(t, y):
        return [-np.sqrt(np.abs(y[0])) - y[1], -y[1]]

    for method in METHODS:
        theirs, ours = (
            f(fun, (0, 1), [0.0, 1.0], method) for f in (scipy.integrate.solve_ivp, solve_ivp)
        )
        assert ours.status == theirs.status == 0 and ours.nfev == theirs.nfev


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_differences_are_scipys():
    """The derivative is asked for at the same places, to the last bit; where too small, again."""
    asked = []

    def fun(t, y):
        asked.append(tuple(y))
        return [1e4 * (y[1] - y[0]), 1.0 + 1e-20 * y[0], 1e12 + y[2]]

    y0, atol = np.array([1.0, 2.0, 1e-3]), 1e-6
    solve_ivp(fun, (0, 1), y0, "Radau", first_step=1e-9, max_steps=1, atol=atol)
    ours, f0 = asked[1:], np.array(fun(0.0, y0))
    asked.clear()
    num_jac(lambda t, y: np.array([fun(t, c) for c in y.T]).T, 0.0, y0, f0, atol, None)
    assert len(asked) > len(y0) and sorted(ours[: len(asked)]) == sorted(asked)


def test_bands_are_made_use_of():
    """400 components: elimination in full takes 10^7 operations a factorisation, and seconds."""
    y0 = np.ones(400)
    run = solve_ivp(heat, (0, 2), y0, "BDF", rtol=1e-4)
    run_of_it = run_of(fastdyn.prepare(heat, (0, 2), y0, "BDF", rtol=1e-4)._problem)
    run_of_it.solve(y0)
    (s,) = run_of_it.view("solve.state")
    assert (s["lower"], s["upper"]) == (1, 1) and run.success
    assert run_of_it.bounds[0].block[JACOBIAN] != 0  # an exact one


@pytest.mark.hunt
def test_many_components_with_full_matrices():
    n = 301
    a = -np.eye(n) - np.random.default_rng(0).random((n, n)) / n

    def mixing(t, y):
        return a @ y

    theirs = scipy.integrate.solve_ivp(mixing, (0, 1), np.ones(n), "BDF", jac=a)
    for options in ({}, {"jac": a}, {"jac": "2-point"}):
        assert (
            counts(solve_ivp(mixing, (0, 1), np.ones(n), "BDF", **options))[:2]
            == counts(theirs)[:2]
        )
