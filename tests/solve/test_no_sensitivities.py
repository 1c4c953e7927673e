"""What has no derivatives, or none that are known, is refused in sentences."""

import math
import random

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn import solve_ivp


def friction(t, y, mu):
    return [y[1], -y[0] - mu * np.sign(y[1])]


def test_a_jump_on_the_way_is_refused_and_one_that_is_not_passed_is_not():
    given = {"args": (0.1,), "sensitivity": "mu", "rtol": 1e-8, "atol": 1e-8}
    with pytest.raises(ValueError, match=r"jumps at t = 0\.2662"):
        solve_ivp(friction, (0, 10), [1.0, 0.3], **given)
    r = solve_ivp(friction, (0, 0.2), [1.0, 0.3], t_eval=[0.1, 0.2], **given)
    assert np.allclose(r.sensitivity["mu"], [np.cos([0.1, 0.2]) - 1, -np.sin([0.1, 0.2])])

    def rest(t, y, mu):
        return y[1]

    rest.terminal = True
    assert solve_ivp(friction, (0, 10), [1.0, 0.3], events=rest, **given).status == 1


@pytest.mark.parametrize(
    ("fun", "sensitivity"),
    [
        (lambda t, y, p: [np.floor(3 * y[0]), 1.0], "y0"),
        (lambda t, y, p: [y[1] % 0.3, 1.0], "y0"),
        (lambda t, y, p: [np.arctan2(0.3 - y[1], -1.0), 1.0], "y0"),
        (lambda t, y, p: [1.0 if t < p else 2.0, 1.0], "p"),
        (lambda t, y, p: [[1.0, 2.0, 3.0][min(int(2 * y[1]), 2)], 1.0], "y0"),
    ],
)
def test_all_that_jumps(fun, sensitivity):
    with pytest.raises(ValueError, match="jumps at t ="):
        solve_ivp(fun, (0, 1), [0.4, 0.2], args=(0.5,), sensitivity=sensitivity)


def free(t, y, a, flag, b, name):
    return [-a * y[0] * b[0]]


@pytest.mark.parametrize(
    ("sensitivity", "error", "words"),
    [
        ("zz", ValueError, "choose from 'y0', 'args', 'a', 'flag', 'b', 'name'"),
        (3, ValueError, "unknown"),
        ([], ValueError, "names nothing"),
        ("flag", TypeError, "got bool"),
        ("name", TypeError, "got str"),
        ("args", TypeError, "'flag' needs a number"),
    ],
)
def test_what_is_no_direction(sensitivity, error, words):
    with pytest.raises(error, match=words):
        solve_ivp(free, (0, 1), [1.0], args=(1.0, True, np.ones(3), "s"), sensitivity=sensitivity)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": OdeSolver}, "not for .*OdeSolver"),
        ({"y0": [1j, 0]}, "real states"),
        ({"callback": print}, "`callback` do not go together"),
        ({"project": lambda t, y: y}, "`project` do not go together"),
        ({"fun": lambda t, y: [random.random(), 1.0]}, "random"),
        ({"fun": lambda t, y: [math.gamma(y[0]), 1.0]}, "tgamma"),
    ],
)
def test_what_has_no_sensitivities_is_told(options, words):
    given = {"fun": lambda t, y: [y[1], -y[0]], "t_span": (0, 1), "y0": [1.0, 0.0]}
    with pytest.raises(ValueError, match=words):
        solve_ivp(**{**given, **options}, sensitivity="y0")


def test_other_solvers_refuse_it():
    fun, given = (lambda t, y: [y[1], -y[0]]), {"sensitivity": "y0"}
    with pytest.raises(TypeError, match="no `sensitivity`"):
        fastdyn.Stepper(fun, 0, [1.0, 0.0], 1, **given)


def test_a_failure_says_which_components_it_counts():
    r = solve_ivp(lambda t, y: [np.sqrt(y[0])], (0, 1), [0.0], sensitivity="y0")
    assert r.status == -1 and "sensitivities" in r.message
