"""Steps of Radau and BDF that change the state more than the equations do are told of."""

import warnings

import numpy as np
import pytest

from bench.problems.stiff import STIFF
from fastdyn import Stepper, StiffnessWarning, prepare, solve_ensemble, solve_ivp
from fastdyn.compile import memory
from support.steppers import ended

Y0 = [-0.05390202547204295, 0.511536419917619, -1.2625710076466137, -0.6856061024344743]
ARGS = 2.7516039383159194, 1e-18, 4.0
SAID = "change the state more than `fun` does"
OTHER = [0.1, 0.0, 1e-3, 0.0]


def friction(t, y, mu, eps, k):
    """A mass on a spring in the plane, with dry friction mu v / |v| that has a guard."""
    n = np.sqrt(y[2] * y[2] + y[3] * y[3] + eps * eps)
    return [y[2], y[3], -mu * y[2] / n - k * y[0], -mu * y[3] / n - k * y[1]]


@pytest.fixture(autouse=True)
def nothing_is_told():
    """Forget compiled functions, and what they were told of."""
    memory.forget()


def told(solve):
    """The result of a solve, and how often it warned."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = solve()
    return result, sum(
        issubclass(each.category, StiffnessWarning) and SAID in str(each.message) for each in caught
    )


def test_a_wrong_end_is_told_once():
    call = (friction, (0, 10), Y0, "BDF")
    found, times = told(lambda: solve_ivp(*call, args=ARGS, rtol=1e-3))
    assert times == 1 and found.status == 0 and np.abs(found.y).max() > 1e6
    for _ in range(20):  # repeated solves, once each function and method
        again, times = told(lambda: solve_ivp(*call, args=ARGS, rtol=1e-3))
        assert times == 0 and np.array_equal(again.y, found.y)


def test_each_method_tells():
    others = (3.0, 1e-16, 0.0)
    for method, y0, args in (("BDF", Y0, ARGS), ("Radau", [0.0, 0.0, 1.0, 2.0], others)):
        call = (friction, (0, 10), y0, method)
        given = {"args": args, "rtol": 1e-3, "max_steps": 1000}
        assert told(lambda call=call, given=given: solve_ivp(*call, **given))[1] == 1


@pytest.mark.parametrize("ready", [0, 3, 40])  # solves before: by a Run, a ReadyRun, a builtin
def test_a_prepared_solver_tells_whenever_it_is_wrong(ready):
    solve = prepare(
        friction, (0, 10), OTHER, method="BDF", args=(0.1, 1.0, 4.0), rtol=1e-3, compile="shared"
    )
    for _ in range(ready):
        _, times = told(lambda: solve(OTHER, args=(0.1, 1.0, 4.0)))
        assert times == 0
    found, times = told(lambda: solve(Y0, args=ARGS))
    assert times == 1 and np.abs(found.y).max() > 1e6


def test_a_stepper_tells():
    stepper = Stepper(friction, 0.0, Y0, 10.0, method="BDF", args=ARGS, rtol=1e-3)

    def run():
        ended(stepper)

    assert told(run)[1] == 1


def test_ensembles_tell():
    starts = np.array([OTHER, Y0, OTHER])

    def solve():
        return solve_ensemble(friction, (0, 10), starts, method="BDF", args=ARGS, rtol=1e-3)

    assert [told(solve)[1] for _ in range(2)] == [1, 0]


def test_functions_in_python_tell():
    def python(t, y):
        return np.array(friction(t, np.array(y.tolist()), *ARGS))

    found, times = told(lambda: solve_ivp(python, (0, 10), Y0, "BDF", rtol=1e-3))
    assert times == 1 and np.abs(found.y).max() > 1e6


def relay(t, y):
    return [y[1], -np.sign(y[0] - 0.1) - 0.1 * y[1]]


def prothero(t, y):
    return [-1e6 * (y[0] - np.cos(t)) - np.sin(t)]


def pulses(t, y):
    return [-1e3 * (y[0] - np.sign(np.sin(t)))]


def fast_van_der_pol(t, y):
    return [y[1], 1e6 * (1.0 - y[0] ** 2) * y[1] - y[0]]


RIGHT = [(p.fun, p.t_span, p.y0, p.args) for p, *_ in STIFF if len(p.y0) < 50] + [
    (relay, (0, 20), [1.0, 0.0], ()),
    (prothero, (0, 20), [1.5], ()),
    (pulses, (0, 20), [1.0], ()),
    (fast_van_der_pol, (0, 1.5e6), [2.0, 0.0], ()),
]


@pytest.mark.parametrize("method", ["Radau", "BDF"])
@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-4, 1e-6])
def test_stiff_problems_are_not_told(method, rtol):
    for fun, t_span, y0, args in RIGHT:
        _, times = told(
            lambda f=fun, t=t_span, y=y0, a=args: solve_ivp(
                f, t, y, method, args=a, rtol=rtol, atol=1e-6 * rtol, max_steps=3000
            )
        )  # fmt: skip
        assert times == 0, fun
