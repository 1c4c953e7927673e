"""Functions that a series does not see from afar, and the comparison that finds them."""

import math

import numpy as np
import pytest
import scipy.integrate

from fastdyn import solve_ensemble, solve_ivp
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.recurrences.deceptive import is_deceptive
from fastdyn.compile.taylor.recurrences.plan import Plan
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.paths.runs import trace
from tests.support.detest import orbit

W = 0.05


def plan_of(fun, n):
    traced = Traced(trace(fun, (), n, (n,), (), "all", 0, False), DERIVATIVE, n)
    return Plan(traced.trace.graph, traced.stored, traced.trace.failing)


@pytest.mark.parametrize(
    ("fun", "n", "deceptive"),
    [
        (orbit, 4, False),
        (lambda t, y: [y[1], -math.sin(y[0]) + math.cos(2.0 * t)], 2, False),
        (lambda t, y: [y[0] * (1.0 - y[0]) / (1.0 + y[0] ** 2)], 1, False),
        (lambda t, y: [math.sqrt(1.0 + y[0] ** 2)], 1, False),
        (lambda t, y: [y[1], -y[0] - 0.1 * math.tanh(y[1])], 2, False),  # the argument is held
        (lambda t, y: [(1.0 + t * t) ** -6], 1, False),
        (lambda t, y: [math.exp(-t) ** 40], 1, True),
        (lambda t, y: [math.cos(t) ** 40], 1, True),
        (lambda t, y: [math.log(2.0 + y[0])], 1, True),
        (lambda t, y: [abs(y[0])], 1, True),
    ],
)  # fmt: skip
def test_plans_that_may_deceive(fun, n, deceptive):
    assert is_deceptive(plan_of(fun, n)) == deceptive


def driven(force):
    """An oscillator with a force that depends on its velocity or on its place."""
    return lambda t, y: [y[1], -y[0] + 0.1 * force(y)]


FORCES = {
    "tanh": lambda y: -math.tanh(y[1] / W),
    "logistic": lambda y: -1.0 / (1.0 + math.exp(-y[1] / W)),
    "erf": lambda y: -math.erf(y[1] / W),
    "atan": lambda y: -math.atan(y[1] / W),
    "pulse": lambda y: math.exp(-((y[0] / W) ** 2)),
    "sech": lambda y: 1.0 - math.tanh(y[0] / W) ** 2,
    "narrow pole": lambda y: W * W / (W * W + y[0] ** 2),
    "two poles": lambda y: W**3 / (W * W + y[0] ** 2) ** 1.5,
    "three poles": lambda y: (1.0 + (y[0] / W) ** 2) ** -3,
    "steep pole": lambda y: (1.0 + (y[0] / W) ** 2) ** -8,
    "saturated root": lambda y: -y[1] / math.sqrt(W * W + y[1] ** 2),
    "high power": lambda y: y[0] ** 12 / (1.0 + y[0] ** 12),
    "distance": lambda y: -math.sqrt(W * W + y[0] ** 2),
}


@pytest.mark.few(4)
@pytest.mark.parametrize("name", FORCES)
def test_forces_that_act_in_a_small_part_of_the_motion(name):
    fun, start, span = driven(FORCES[name]), [1.0, 0.3], (0.0, 12.0)
    exact = scipy.integrate.solve_ivp(
        fun, span, start, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.05
    ).y[:, -1]
    for tol in (1e-5, 1e-7, 1e-9, 1e-11):
        run = solve_ivp(fun, span, start, "Taylor", rtol=tol, atol=tol)
        assert run.status == 0 and np.abs(run.y[:, -1] - exact).max() < 1000 * tol


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["tanh", "pulse", "narrow pole", "high power"])
@pytest.mark.parametrize("how", ["among many", "in lanes"])
def test_the_same_in_vectors(name, how):
    span, n, force = (0.0, 12.0), 40, FORCES[name]
    exact = scipy.integrate.solve_ivp(
        driven(force), span, [1.0, 0.3], "DOP853", rtol=1e-12, atol=1e-13, max_step=0.05
    ).y[:, -1]
    if how == "in lanes":
        run = solve_ensemble(
            driven(force), span, [[1.0, 0.3]] * 9, method="Taylor", rtol=1e-9, atol=1e-9
        )
        found = run.y_end
    else:

        def many(t, y):
            pairs = [driven(force)(t, [y[i], y[n + i]]) for i in range(n)]
            return [v for v, _ in pairs] + [a for _, a in pairs]

        run = solve_ivp(many, span, [1.0] * n + [0.3] * n, "Taylor", rtol=1e-9, atol=1e-9)
        found = run.y[:, -1].reshape(2, n).T
    assert np.abs(found - exact).max() < 1e-6


def test_a_step_that_fails_is_taken_back():
    """The terms of y[1]^30 vanish at the start, and far from the tops of y[1]."""

    def fun(t, y):
        return [y[1] ** 30, -y[2], y[1]]

    options = {"method": "Taylor", "rtol": 1e-9, "atol": 1e-9}
    run = solve_ivp(fun, (0.0, 9.0), [0.0, 0.0, 1.0], **options)
    exact = scipy.integrate.quad(lambda t: math.sin(t) ** 30, 0.0, 9.0, epsabs=1e-13, limit=500)[0]
    assert run.n_rejected > 0 and np.all(np.diff(run.t) > 0)
    assert abs(run.y[0, -1] - exact) < 1e-7
    at = solve_ivp(fun, (0.0, 9.0), [0.0, 0.0, 1.0], t_eval=[9.0], **options)
    assert np.array_equal(at.y[:, -1], run.y[:, -1])  # in one call, or in many
    assert at.n_rejected == run.n_rejected
