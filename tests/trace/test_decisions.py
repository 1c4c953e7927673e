"""Each decision is two paths: schedules and ranges of time."""

import itertools
import operator
import types

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near
from fastdyn.trace.paths.runs import trace

ORDER = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
LIMITS = 1.0, 2.0, np.nextafter(2.0, 3.0), 3.0, -np.inf, np.nan


def scheduled(starts, long=1.0):
    doses = [types.SimpleNamespace(start=s, long=long, rate=i + 1.0) for i, s in enumerate(starts)]

    def rate(dose, t):
        if dose.start <= t < dose.start + dose.long:
            return dose.rate
        return 0.0

    def fun(t, y):
        return [sum(rate(dose, t) for dose in doses) - 0.3 * y[0]]

    return fun, doses


def solved(solver, fun, **more):
    return solver(fun, (0, 60), [0.5], max_step=0.25, **more)


def test_a_short_schedule_is_compiled():
    """Each dose is a choice of three paths: before, within, after."""
    fun, doses = scheduled([3.0, 7.0, 11.0])
    assert trace(fun, (), 1, (1,)).n_paths == 3 ** len(doses)
    for starts in ([3.0, 7.0, 11.0], [11.0, 3.0, 7.0], [3.0, 3.0, 7.0]):
        for dose, start in zip(doses, starts, strict=True):
            dose.start = start
        mine, theirs = solved(fastdyn.solve_ivp, fun), solved(reference, fun)
        np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9)


@pytest.mark.hunt
def test_a_long_schedule_runs_in_python():
    fun, _ = scheduled(np.arange(3.0, 60.0, 4.0))
    with pytest.warns(fastdyn.CompileWarning, match="it decides in too many ways"):
        mine = solved(fastdyn.solve_ivp, fun)
    # 240 steps, each with roundings of some eps, which depend on the order of BLAS's sums
    np.testing.assert_allclose(mine.y, solved(reference, fun).y, rtol=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_ranges_are_as_in_python(seed):
    rng = np.random.default_rng(seed)
    signs = list(ORDER)
    asked = [(signs[rng.integers(4)], LIMITS[rng.integers(len(LIMITS))], bool(rng.integers(2)))
             for _ in range(8)]  # fmt: skip

    def fun(t, y, limits):
        value = 0
        for i, ((sign, _, turned), limit) in enumerate(zip(asked, limits, strict=True)):
            compare = ORDER[sign]
            if compare(limit, y[0]) if turned else compare(y[0], limit):
                value += 2**i
        return [value]

    given = tuple(limit for _, limit, _ in asked)
    bound = bind(fun, (given,), DERIVATIVE, 1, Near(0.0, 1.0, np.array([1.5])))
    assert bound.function is not None
    for x in itertools.chain(LIMITS, (1.5, 2.5, 0.0, np.inf)):
        y = np.array([x])
        assert machine_value(bound, 0.0, y)[0] == fun(0.0, y, given)[0]


def test_a_path_that_decides_the_same_without_end_is_left_to_python():
    """No call takes the path, on which the loop does not end."""

    def fun(t, y):
        while True:
            if y[0] * np.sin(y[0]) > -1e9:
                break
        return [-y[0]]

    bound = bind(fun, (), DERIVATIVE, 1, Near(0.0, 1.0, np.array([1.0])))
    assert bound.function is not None and bound.function.traced.trace.n_paths == 2
    assert machine_value(bound, 0.0, np.array([0.5])).tolist() == [-0.5]
