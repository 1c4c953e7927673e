"""lmfit's Parameters as arguments of a function."""

import numpy as np
import pytest

from fastdyn import CompileWarning, solve_ivp

lmfit = pytest.importorskip("lmfit")


def pendulum(t, y, p):
    return [y[1], -p["k"] * np.sin(y[0]) - p["c"].value * y[1]]


def by_dict(t, y, p):
    v = p.valuesdict()
    return [y[1], -v["k"] * np.sin(y[0]) - v["c"] * y[1]]


def plain(t, y, k, c):
    return [y[1], -k * np.sin(y[0]) - c * y[1]]


@pytest.mark.parametrize("fun", [pendulum, by_dict])
def test_they_compile_and_their_values_are_followed(fun):
    p = lmfit.Parameters()
    p.add("k", 9.0, min=0)
    p.add("c", 0.15)
    for k in (9.0, 8.0, 7.5):  # a warning would be an error
        p["k"].value = k
        found = solve_ivp(fun, (0, 5), [1.0, 0.0], args=(p,))
        assert np.array_equal(found.y, solve_ivp(plain, (0, 5), [1.0, 0.0], args=(k, 0.15)).y)


def test_expressions_run_in_python_and_are_right():
    p = lmfit.Parameters()
    p.add("k", 9.0)
    p.add("c", expr="k / 60")
    with pytest.warns(CompileWarning, match="asteval"):
        found = solve_ivp(pendulum, (0, 5), [1.0, 0.0], args=(p,))
    assert np.allclose(found.y, solve_ivp(plain, (0, 5), [1.0, 0.0], args=(9.0, 0.15)).y)
