"""solve_bvp: SciPy's own tests, SciPy's meshes and solutions, and what is left to SciPy."""

import pathlib
import types
import warnings

import numpy as np
import pytest
import scipy.integrate
from scipy.integrate.tests import test_bvp as suite

from fastdyn import CompileWarning, solve_bvp
from fastdyn.solve.boundary import solve

SOURCE = pathlib.Path(suite.__file__)


def _module():
    """SciPy's tests as functions of a user, which are compiled."""
    module = types.ModuleType("scipy_test_bvp")
    module.__file__ = str(SOURCE)
    exec(compile(SOURCE.read_text(), str(SOURCE), "exec"), module.__dict__)
    module.solve_bvp = solve_bvp
    return vars(module)


TESTS = [
    test for name, test in _module().items()
    if name.startswith("test_") and "solve_bvp" in test.__code__.co_names
]  # fmt: skip
MESH = np.linspace(0, 1, 5)
GUESS = np.zeros((2, 5))


@pytest.mark.parametrize("test", TESTS, ids=lambda test: test.__name__)
def test_scipys_own(test):
    assert len(TESTS) > 8
    with warnings.catch_warnings():
        warnings.simplefilter("error", CompileWarning)  # all of these functions are compiled
        test()


def ends(ya, yb):
    return np.array([ya[0], yb[0]])


def bratu(x, y):
    return np.vstack((y[1], -np.exp(y[0])))


def waves(x, y, p):
    return np.vstack((y[1], -(p[0] ** 2) * y[0]))


def of_waves(ya, yb, p):
    return np.array([ya[0], yb[0], ya[1] - p[0]])


def emden(x, y):
    return np.vstack((y[1], -(y[0] ** 5)))


def of_emden(ya, yb):
    return np.array([ya[1], yb[0] - (3 / 4) ** 0.5])


@pytest.mark.parametrize(
    ("fun", "bc", "y", "more"),
    [
        (bratu, ends, GUESS, {}),
        (waves, of_waves, np.array([[0, 1, 0, -1, 0.0], [0] * 5]), {"p": [6]}),
        (emden, of_emden, GUESS + 1, {"S": [[0, 0], [0, -2]]}),
    ],
)
def test_scipys_meshes_and_solutions(fun, bc, y, more, monkeypatch):
    given, tol = (fun, bc, MESH, y), 1e-6
    theirs = scipy.integrate.solve_bvp(*given, **more, tol=tol)
    monkeypatch.setattr(solve.integrate, "solve_bvp", None)  # ours alone
    ours = solve_bvp(*given, **more, tol=tol)
    assert np.array_equal(ours.x, theirs.x) and ours.niter == theirs.niter > 1
    for name in ("y", "yp", "p"):  # both iterations end far below the tolerance
        if theirs[name] is not None:
            assert np.abs(ours[name] - theirs[name]).max() < 1e-3 * tol
    x = np.linspace(0, 1, 50)
    assert np.abs(ours.sol(x) - theirs.sol(x)).max() < 1e-3 * tol
    assert np.abs(ours.rms_residuals - theirs.rms_residuals).max() < 1e-2 * tol
    assert ours.keys() == theirs.keys() and ours.message == theirs.message


def test_a_layer_that_grows_and_decays():
    """y'' = 1600 y: exp(40 x) and exp(-40 x), of which a march from one end loses one."""

    def stiff(x, y):
        return np.vstack((y[1], 1600 * y[0]))

    def one(ya, yb):
        return np.array([ya[0] - 1, yb[0] - 1])

    found = solve_bvp(stiff, one, MESH, GUESS, tol=1e-8, max_nodes=5000)
    exact = np.cosh(40 * (found.x - 0.5)) / np.cosh(20.0)
    assert found.success and np.abs(found.y[0] - exact).max() < 1e-8


def test_new_values_outside_are_used():
    given = {"k": 1.0}

    def fun(x, y):
        return np.vstack((y[1], -given["k"] * np.exp(y[0])))

    before = solve_bvp(fun, ends, MESH, GUESS).y[0].max()
    given["k"] = 2.0
    assert solve_bvp(fun, ends, MESH, GUESS).y[0].max() > 1.5 * before


def mixes(x, y):
    """The mean over the points of the mesh is nothing of one point."""
    return np.vstack((y[1], -np.exp(y[0] - y[0].mean())))


def reads_text(x, y):
    return np.vstack((y[1], [-float(str(each)) for each in y[0]]))


@pytest.mark.parametrize("fun", [mixes, reads_text])
def test_what_is_left_to_scipy_is_told(fun):
    with pytest.warns(CompileWarning, match=fun.__name__):
        found = solve_bvp(fun, ends, MESH, GUESS + 0.1)
    theirs = scipy.integrate.solve_bvp(fun, ends, MESH, GUESS + 0.1)
    assert np.array_equal(found.y, theirs.y)


def test_an_exception_is_the_users():
    def fun(x, y):
        if np.any(y[0] > 0.05):
            raise RuntimeError("too far")
        return np.vstack((y[1], -np.exp(y[0])))

    with pytest.raises(RuntimeError, match="too far"), warnings.catch_warnings():
        warnings.simplefilter("ignore", CompileWarning)
        solve_bvp(fun, ends, MESH, GUESS)
