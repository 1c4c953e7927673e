"""Conditions on roots, and events of roots and angles: as many steps, the same times."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.taylor.recurrences.distances import without_root
from fastdyn.compile.taylor.recurrences.rewrite import Rewriter
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import Graph

TIGHT = {"method": "Taylor", "rtol": 1e-12, "atol": 1e-12}


def damped(inside):
    """An oscillator with other frequencies along x and y, damped where a condition holds."""

    def fun(t, s):
        x, y, u, v = s
        d = np.where(inside(x, y), 0.01, 0.0)
        return [u, v, -x - d * u, -2 * y - d * v]

    return fun


CONDITIONS = {  # each with one of squares alone
    "hypot": (lambda x, y: np.hypot(x, y) < 0.8, lambda x, y: x * x + y * y < 0.64),
    "difference": (
        lambda x, y: np.sqrt(x * x + y * y) - 0.8 < 0,
        lambda x, y: x * x + y * y < 0.64,
    ),
    "turned": (lambda x, y: 0.8 > math.hypot(x, y), lambda x, y: x * x + y * y < 0.64),
    "scaled": (lambda x, y: 1.0 - np.hypot(x, y) / 0.8 > 0, lambda x, y: x * x + y * y < 0.64),
    "away": (
        lambda x, y: np.linalg.norm(np.array([x - 2, y - 1])) < 1.5,
        lambda x, y: (x - 2) ** 2 + (y - 1) ** 2 < 2.25,
    ),
    "power": (lambda x, y: (x * x + y * y) ** 1.5 < 0.512, lambda x, y: x * x + y * y < 0.64),
    "two": (
        lambda x, y: np.hypot(x - 1, y) < np.hypot(x, y - 1),
        lambda x, y: (x - 1) ** 2 + y * y < x * x + (y - 1) ** 2,
    ),
    "varying": (
        lambda x, y: np.hypot(x, y) < 0.5 + x,
        lambda x, y: (0.5 + x > 0) & (x * x + y * y < (0.5 + x) ** 2),
    ),
}


@pytest.mark.filterwarnings("ignore::fastdyn.StiffnessWarning")
@pytest.mark.parametrize("name", CONDITIONS)
def test_a_condition_on_a_distance_costs_what_one_on_its_square_costs(name):
    of_roots, of_squares = (
        fastdyn.solve_ivp(damped(inside), (0, 20), [1.0, 0.0, 0.0, 0.9], **TIGHT)
        for inside in CONDITIONS[name]
    )
    assert of_roots.status == of_squares.status == 0
    assert len(of_roots.t) < 1.5 * len(of_squares.t)
    np.testing.assert_allclose(of_roots.y[:, -1], of_squares.y[:, -1], 1e-9, 1e-9)


@pytest.mark.parametrize("op", ["lt", "le", "eq"])
@pytest.mark.parametrize("exponent", [0.5, 1.5, 2.5])
def test_comparisons_keep_their_truth(op, exponent):
    g = Graph()
    t, x, y = g.make("t"), g.make("y", (), 0), g.make("y", (), 1)
    rewrite, compared = Rewriter(g), 0
    radicands = g.add(g.mul(x, x), g.mul(y, y)), g.add(t, x)
    grid = np.linspace(-2.0, 2.0, 9)
    at = np.array(np.meshgrid(grid, grid, grid)).reshape(3, -1)
    for base in radicands:
        power = g.power(base, exponent)
        for other in (*map(g.const, (-1.0, 0.0, 1.0, 1.37)), y, power):
            for a, b in ((power, other), (other, power)):
                found = without_root(rewrite, op, rewrite(a), rewrite(b))
                if found is None:
                    assert other is y and exponent != 0.5
                    continue
                plain = g.compare(a, b, op)
                mine, theirs = evaluate(g, [], at[0], at[1:], g.values, [found, plain])[1]
                np.testing.assert_array_equal(mine, theirs)
                compared += 1
    assert compared > 15


# -- events


def circle(t, s):
    """Two oscillators: x = cos t, y = sin t / 2."""
    x, y, u, v = s
    return [u, v, -x, -y]


START = [1.0, 0.0, 0.0, 0.5]
EVENTS = {
    "norm": lambda t, s: np.linalg.norm(s[:2]) - 0.8,
    "hypot": lambda t, s: np.hypot(s[0], s[1]) - 0.8,
    "sqrt": lambda t, s: math.sqrt(s[0] ** 2 + s[1] ** 2) - 0.8,
    "nearly": lambda t, s: math.sqrt(s[0] ** 2 + s[1] ** 2) - 0.500001,
    "far": lambda t, s: math.hypot(s[0] - 2, s[1] - 1) - 1.5,
    "angle": lambda t, s: np.arctan2(s[1], s[0]) - 0.5,
    "behind": lambda t, s: np.arctan2(s[1], s[0]) - 3.0,
    "arcsin": lambda t, s: np.arcsin(0.9 * s[0]) - 0.3,
    "math": lambda t, s: math.asin(0.9 * s[0]) - 0.3,
}


def exact(name):
    """The times in (0, 20) by a scan of the exact motion."""
    from scipy.optimize import brentq

    def g(t):
        return float(EVENTS[name](t, np.array([math.cos(t), math.sin(t) / 2, 0.0, 0.0])))

    grid = np.linspace(1e-9, 20.0, 40_001)
    values = np.array([g(t) for t in grid])
    crossed = np.flatnonzero((values[1:] > 0) != (values[:-1] > 0))
    jumps = np.abs(values[crossed + 1] - values[crossed]) > 1.0
    return [brentq(g, grid[i], grid[i + 1], xtol=1e-14) for i in crossed[~jumps]]


@pytest.mark.parametrize("name", EVENTS)
def test_events_of_distances_and_angles_are_found(name):
    found = fastdyn.solve_ivp(circle, (0, 20), START, events=EVENTS[name], **TIGHT)
    times = found.t_events[0]
    expected, places = np.array(exact(name)), 1e-8 if name == "nearly" else 1e-10
    assert len(expected) > 2
    if name in ("angle", "behind"):  # the jump from pi to -pi changes the sign, too, as for SciPy
        np.testing.assert_allclose(times[np.abs(times / np.pi % 2 - 1) < 1e-9] % np.pi, 0, 0, 1e-9)
        times = times[np.abs(times / np.pi % 2 - 1) > 1e-9]
    np.testing.assert_allclose(times, expected, 0, places)


def test_a_root_that_touches_zero_has_both_sides():
    """|x| by a distance on a line: the series of x would miss the crossings for x < 0."""

    def event(t, s):
        return math.sqrt(s[0] ** 2 + 0 * s[1] ** 2 + s[1] ** 2) - 0.1

    def line(t, s):
        return [s[2], 0.0, -s[0], 0.0]

    found = fastdyn.solve_ivp(line, (0, 6), [1.0, 0.0, 0.0, 0.0], events=event, **TIGHT)
    half, end = math.asin(0.1), np.pi / 2
    expected = np.array([end - half, end + half, 3 * end - half, 3 * end + half])
    np.testing.assert_allclose(found.t_events[0], expected, 0, 1e-9)


def test_events_with_conditions_are_refused():
    with pytest.raises(ValueError, match="conditions"):
        fastdyn.solve_ivp(
            circle, (0, 1), START, events=lambda t, s: np.where(s[0] > 0, s[0], s[1]), **TIGHT
        )
