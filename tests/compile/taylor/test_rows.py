"""Series in rows: the same as online, whatever is alike, in loops or not."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.coefficients import looped
from fastdyn.compile.taylor.coefficients.bundles import Bundles
from fastdyn.compile.taylor.kernel import OfElements
from fastdyn.compile.taylor.recurrences.operations import Power
from fastdyn.compile.taylor.recurrences.plan import Plan
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.paths.runs import trace
from support.steppers import ended
from tests.support.smooth import drawn, write_in_rows

EPS = np.finfo(float).eps


def bodies(count):
    def fun(t, s):
        q, v = s.reshape(2, count, 3)
        a = np.zeros((count, 3))
        for i in range(count):
            for j in range(i):
                d = q[j] - q[i]
                w = (d @ d) ** -1.5
                a[i] += (j + 1.0) * w * d
                a[j] -= (i + 1.0) * w * d
        return np.concatenate([v.ravel(), a.ravel()])

    rng = np.random.default_rng(count)
    return fun, np.concatenate([3.0 * rng.normal(size=3 * count), rng.normal(size=3 * count)])


def chain(n):
    """Springs that are not quite linear between two walls, driven by a force; n is even."""

    def fun(t, s):
        q, v = s[: n // 2], s[n // 2 :]
        e = np.diff(np.concatenate([[0.0], q, [np.sin(t)]]))
        g = e + 0.2 * e**3
        return np.concatenate([v, g[1:] - g[:-1]])

    return fun, 0.3 * np.random.default_rng(n).normal(size=n)


def last(fun, y0, method="Taylor", tol=1e-12, t_end=0.5, args=()):
    found = fastdyn.solve_ivp(fun, (0.0, t_end), y0, method=method, args=args, rtol=tol, atol=tol)
    assert found.status == 0, found.message
    return found.y[:, -1], found.n_accepted


def plan_of(traced):
    graph = traced.trace.graph
    return Plan(graph, traced.stored, graph.false)


def text_of(fun, n):
    found = trace(fun, (), n, (n,), (), "all", 0, False)
    plan = Bundles(plan_of(Traced(found, DERIVATIVE, n)), 8)
    return OfElements(plan, 17, 8, False, False, "fma", 6)("kernel", set())


@pytest.mark.few(2)
@pytest.mark.parametrize("number", range(8))
def test_one_step_is_that_of_the_other_generator(monkeypatch, number):
    """Each of p coefficients is a sum of at most p products, each rounded once or twice."""
    fun, args, y0 = drawn(number)
    ends, order, h = [], 25, 2.0**-6
    for rows in (False, True):
        write_in_rows(monkeypatch, rows)
        y, steps = last(fun, y0, t_end=h, args=args)
        assert steps == 1
        ends.append(y)
    size = max(abs(ends[0]).max(), abs(np.array(fun(0.0, y0, *args))).max())
    np.testing.assert_allclose(ends[1], ends[0], rtol=0.0, atol=2 * order**2 * EPS * size * h)


@pytest.mark.few(1)
@pytest.mark.parametrize("n", [1, 2, 3, 7, 8, 9, 17])
def test_any_number_of_components(monkeypatch, n):
    fun, args, y0 = drawn(1000 + n, n)
    write_in_rows(monkeypatch, rows=True)
    expected, _ = last(fun, y0, "DOP853", 1e-13, 2.0, args)
    found, _ = last(fun, y0, t_end=2.0, args=args)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.few(1)
@pytest.mark.parametrize("count", [5, 9])
def test_loops_do_what_code_one_by_one_does(monkeypatch, count):
    """To the bit: in both each vector is computed by the same operations."""
    fun, y0 = bodies(count)
    ends = []
    for fewest in (1, 10**6):
        monkeypatch.setattr(looped, "FEWEST", fewest)
        monkeypatch.setattr(looped, "FEWEST_OF_MANY", fewest)
        write_in_rows(monkeypatch, rows=True)
        ends.append(last(fun, y0)[0])
    assert (ends[0] == ends[1]).all()
    expected, _ = last(fun, y0, "DOP853", 1e-13)
    np.testing.assert_allclose(ends[0], expected, rtol=1e-11, atol=1e-11)


def test_a_thousand_states():
    fun, y0 = chain(1000)
    expected, _ = last(fun, y0, "DOP853", 1e-13)
    np.testing.assert_allclose(last(fun, y0)[0], expected, rtol=1e-11, atol=1e-11)


def test_text_does_not_grow_with_what_is_alike():
    few, many = (text_of(chain(n)[0], n).count("\n") for n in (300, 600))
    assert many == few


def test_differences_of_either_sign_share_a_recurrence():
    """The force of body i on body j, and of j on i, as one writes them in a loop."""

    def fun(t, y):
        pull = lambda d: d / (d**2 + 0.1) ** 1.5  # noqa: E731
        return [sum(pull(b - a) for j, b in enumerate(y) if j != i) for i, a in enumerate(y)]

    found = trace(fun, (), 4, (4,), (), "all", 0, False)
    steps = plan_of(Traced(found, DERIVATIVE, 4)).steps
    assert sum(isinstance(step, Power) for step in steps) == 6  # of 12 terms


@pytest.mark.hunt
def test_parts_of_one_solve_give_its_bits():
    fun, y0 = chain(200)
    whole = last(fun, y0, t_end=2.0)[0]
    stepper = ended(fastdyn.Stepper(fun, 0.0, y0, 2.0, method="Taylor", rtol=1e-12, atol=1e-12))
    assert (stepper.y == whole).all()


def test_where_large_functions_raise():
    """The roots of all components end at t = 1 or before."""

    def fun(t, y):
        return [math.sqrt(1.0 - t - 0.01 * k * v * v) for k, v in enumerate(y)]

    found = fastdyn.solve_ivp(fun, (0.0, 2.0), np.zeros(70), method="Taylor", rtol=1e-9, atol=1e-9)
    assert found.status == -1


@pytest.mark.hunt
def test_a_condition_on_a_parameter_of_a_large_system():
    """Rows have no conditions: the other generator writes the series."""

    def fun(t, y, a):
        return [y[i - 1] * y[i] if a > 0.3 else -y[i] for i in range(80)]

    rates, options = np.array([0.1, 0.4]), {"rtol": 1e-10, "atol": 1e-10, "simd": False}
    found = fastdyn.solve_ensemble(
        fun, (0.0, 0.5), np.ones((2, 80)), (rates,), method="Taylor", **options
    )
    exact = [[math.exp(-0.5)] * 80, [2.0] * 80]  # of y' = -y and of y' = y^2
    np.testing.assert_allclose(found.y_end, exact, rtol=1e-8)
