"""Claims about the roots of a polynomial on (0, 1]: all, in order, with what happens at each."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from numba import njit

from fastdyn.kernels.output.series_roots.bernstein import WIDTH
from fastdyn.kernels.output.series_roots.polynomial_roots import (
    NOT_FINITE,
    PLACES,
    ROWS,
    TURNS,
    polynomial_roots,
)

EPS = np.finfo(float).eps
ROOM = np.full((ROWS, WIDTH), np.nan)


@njit
def search(c, room):
    return polynomial_roots(c, room)


def roots(c):
    """(places, signs behind them, sign behind 1)."""
    n, side = search(np.array(c, float), ROOM)
    assert n >= 0
    return ROOM[PLACES, :n].tolist(), ROOM[TURNS, :n].tolist(), side


def product(places, sign=1):
    """Coefficients of sign prod (x - place), exact."""
    c = [Fraction(sign)]
    for place in places:
        c = [a - Fraction(place) * b for a, b in zip([0, *c], [*c, 0], strict=True)]
    return c


def noise(c):
    """What cannot be told from zero, as the file derives it."""
    return (2 * len(c) + 6) * 0.5 * EPS * np.abs(np.array(c, float)).sum()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    "places, expected",
    [
        ([0.5], [(0.5, 1)]),
        ([0.25, 0.75], [(0.25, -1), (0.75, 1)]),
        ([1.0], [(1.0, 1)]),
        ([0.3, 1.0], [(0.3, -1), (1.0, 1)]),
        ([0.0], []),
        ([0.0, 0.0, 0.7], [(0.7, 1)]),
        ([2.0, 3.0, -1.0, -0.5], []),
        ([0.5, 0.5], [(0.5, 0)]),
        ([0.3, 0.3], [(0.3, 0)]),
        ([1.0, 1.0], [(1.0, 0)]),
        ([0.3, 0.3, 1.0, 1.0], [(0.3, 0), (1.0, 0)]),
        ([0.3, 0.3, 0.3], [(0.3, 1)]),
        ([0.5, 0.5, 0.5], [(0.5, 1)]),
        ([1.0, 1.0, 1.0], [(1.0, 1)]),
        ([0.3, 0.3, 0.3, 0.3], [(0.3, 0)]),
        ([0.3, 0.3001], [(0.3, -1), (0.3001, 1)]),
        ([0.3, 0.3 + 1e-9], [(0.3, 0)]),  # nothing between them can be told from zero
        ([0.3, 0.3, 0.31], [(0.3, 0), (0.31, 1)]),
        ([k / 8 for k in range(1, 9)], [(k / 8, (-1) ** k) for k in range(1, 9)]),
    ],
)
@pytest.mark.parametrize("others", [[], [1.5, -0.5, 2.0, 2.5] * 3])
def test_known_roots(places, expected, sign, others):
    c = product([*places, *others], sign)
    found, turns, side = roots(c)
    assert len(found) == len(expected)
    multiple = max(map(places.count, places))
    rest = np.abs(
        np.polyval(np.array(product(others), float)[::-1], [x for x, _ in expected] or 0.1)
    ).min()
    gap = min([abs(a - b) for a in places for b in places if a != b] or [1.0])
    slack = (2.0 * noise(c) / (rest * gap ** (len(set(places)) - 1))) ** (1.0 / multiple)
    assert found == pytest.approx([x for x, _ in expected], abs=slack)
    flips = sign * (-1) ** sum(x > 1.0 for x in others)
    assert turns == [turn * flips for _, turn in expected]
    assert side == flips


def test_a_root_at_zero_is_that_of_the_step_before():
    """The sign of c[0] is where it comes from: only leaving with the other one is news."""
    assert roots([0.0, 1.0, -2.0]) == ([0.5], [-1.0], -1.0)
    assert roots([1e-300, 1.0, -2.0]) == ([0.5], [-1.0], -1.0)
    assert roots([-1e-300, 1.0, -2.0]) == ([0.0, 0.5], [1.0, -1.0], -1.0)
    assert roots([-1e-300, 1.0]) == ([0.0], [1.0], 1.0)
    assert roots([1e-300, 0.0, 1.0]) == ([], [], 1.0)
    assert roots([1e-300, 1e-9, -1.0]) == ([1e-9], [-1.0], -1.0)


def test_what_turns_just_before_zero_or_just_behind():
    a = 0.37
    for n in range(2, 34, 6):
        c = np.zeros(n + 1)
        c[:3] = a * a, -2.0 * a, 1.0
        for offset, count in ((4.0, 0), (0.25, 1), (-4.0, 2)):
            d = c.copy()
            d[0] += offset * noise(c)
            places, turns, _ = roots(d)
            assert turns == [[], [0.0], [-1.0, 1.0]][count]
            half = math.sqrt(max(-offset, 0.0) * noise(c))
            assert places == pytest.approx([[], [a], [a - half, a + half]][count], rel=1e-7)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("n", [1, 2, 9, 35])
def test_what_is_not_finite_is_told(bad, n):
    for at in {0, n // 2, n - 1}:
        c = np.ones(n)
        c[at] = bad
        assert search(c, ROOM)[0] == NOT_FINITE


def test_zero_and_constants_have_no_roots():
    for n in (1, 2, 35):
        assert roots(np.zeros(n)) == ([], [], 0.0)
        for constant in (1.0, -1e-320, 1e308):
            assert roots([constant, *np.zeros(n - 1)]) == ([], [], np.sign(constant))


def test_the_scale_does_not_matter():
    rng = np.random.default_rng(2)
    for _ in range(50):
        c = rng.normal(size=rng.integers(2, 35))
        c[0] *= 0.1
        for power in (-960, -300, 300, 1010):
            assert roots(np.ldexp(c, power)) == roots(c)


def drawn(rng):
    """A polynomial such as steps have: a decaying one, a wave, or one with roots close by."""
    kind, n = rng.integers(3), int(rng.integers(12, 34))
    if kind == 0:
        c = rng.normal(size=n) * rng.uniform(0.2, 1.0) ** np.arange(n)
        c[0] *= rng.uniform()
        return c
    if kind == 1:
        w, phase = rng.uniform(1.0, 9.0), rng.uniform(0.0, 7.0)
        k = np.arange(n)
        return w**k * np.cos(phase + k * np.pi / 2) / [math.factorial(i) for i in k]
    places = list(rng.uniform(-0.1, 1.1, rng.integers(1, 6)))
    places += [places[0] + 10.0 ** rng.uniform(-7.0, -1.0), rng.uniform(1.3, 4.0), -1.0]
    return np.array(product(places), float)


def values(c, x):
    """In extended precision."""
    total = np.zeros(len(x), np.longdouble)
    for a in c[::-1]:
        total = total * x + np.longdouble(a)
    return total


@pytest.mark.parametrize("seed", range(4))
def test_random_polynomials_are_those_of_a_fine_scan(seed):
    """Between two points where the sign is beyond doubt, the roots change it if it changes."""
    rng, x, n_found = np.random.default_rng(seed), np.linspace(0.0, 1.0, 4001), 0
    for _ in range(250):
        c = drawn(rng) * 10.0 ** rng.uniform(-30.0, 30.0)
        places, turns, side = roots(c)
        assert places == sorted(places) and np.all(np.array(places) <= 1.0)
        assert np.all(np.abs(values(c, np.array(places))) <= noise(c))
        y = values(c, x)
        sure = np.abs(y) > 2.0 * noise(c)
        at, sign = x[sure], np.sign(y[sure])
        inside = np.searchsorted(at, [p for p, turn in zip(places, turns, strict=True) if turn])
        inside = inside[(inside > 0) & (inside < len(at))]
        flips = np.bincount(inside, minlength=len(at) + 1)[1 : len(at)] % 2
        assert np.array_equal(flips, sign[1:] != sign[:-1])
        assert side == sign[-1] or not sure[-1]
        changed = [turn for turn in turns if turn]
        assert all(one == -other for one, other in itertools.pairwise(changed))
        n_found += len(places)
    assert n_found > 200


def shifted(c, low, high):
    """The polynomial on [low, high] as one on [0, 1], exact."""
    c = [Fraction(a) for a in c]
    for j in range(len(c)):
        for k in range(len(c) - 2, j - 1, -1):
            c[k] += Fraction(low) * c[k + 1]
    return [a * (Fraction(high) - Fraction(low)) ** k for k, a in enumerate(c)]


@pytest.mark.parametrize("places", [[0.5], [0.25, 0.5], [0.5] * 2, [0.5] * 3, [0.3, 0.5, 0.7]])
@pytest.mark.parametrize("off", [0.0, 1e-18, -1e-18, 1e-15, -1e-15, 3e-9, -3e-9])
def test_nothing_gets_lost_or_doubled_between_two_steps(places, off):
    c = np.array(product([*places, -0.7, 1.9]), float)
    whole = roots(c)
    steps, side = [0.0, 0.25 + off, 0.5 + off, 0.75, 1.0], np.sign(c[0])
    found, turns = [], []
    for low, high in itertools.pairwise(steps):
        part = np.array(shifted(c, low, high), float)
        if not side * part[0] > 0.0:
            part[0] = 1e-300 * side  # as events.py goes on behind a root at the end
        x, turn, side = roots(part)
        found += [low + (high - low) * p for p in x]
        turns += turn
    assert turns == whole[1] and side == whole[2]
    spread = (10.0 * noise(c)) ** (1.0 / max(map(places.count, places)))
    assert found == pytest.approx(whole[0], abs=spread)
