"""Order conditions of every table, in rational arithmetic, one for each rooted tree.

J. C. Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 31: a method
has order p if sum(b_i Phi_i(tree)) = 1 / gamma(tree) for every tree with at most p nodes, and its
interpolant has order p if the same holds for b_i(x) and x^n / gamma(tree), n the nodes of the tree.
"""

import functools
import math
from fractions import Fraction

import numba
import numpy as np
import pytest

from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.output.dense_output import hermite, polynomial
from fastdyn.kernels.state.record import Y_OLD, K, Y

EPS = float(np.finfo(float).eps)
TABLED = {name: m for name, m in METHODS.items() if "a" in (m.tableau or {})}
PAIRS = [name for name, m in TABLED.items() if m.error_order]
EMBEDDED = {name: (m.error_order,) for name, m in TABLED.items()} | {"DOP853": (5, 3)}

# Significant digits of the shortest rounded coefficients in a source that prints decimals.
DIGITS = {"DOP853": 28, "Tsit5": 39, "Vern7": 33, "Vern9": 33}


@functools.cache
def trees(n):
    """Rooted trees of n nodes: each a sorted tuple of the subtrees at its root."""
    return tuple(sorted(set(_forests(n - 1, n - 1))))


@functools.cache
def _forests(n, largest):
    if n == 0:
        return ((),)
    found = set()
    for size_of_first in range(1, min(n, largest) + 1):
        for first in trees(size_of_first):
            for rest in _forests(n - size_of_first, size_of_first):
                found.add(tuple(sorted((first, *rest))))
    return tuple(found)


@functools.cache
def size(tree):
    return 1 + sum(map(size, tree))


@functools.cache
def density(tree):
    return size(tree) * math.prod(map(density, tree))


class Table:
    """A tableau as fractions, with the derivative at the end of the step among its stages."""

    def __init__(self, name):
        method, tableau = TABLED[name], TABLED[name].tableau
        a, c = [row.exact for row in tableau["a"]], list(tableau["c"].exact)
        self.b_alone, self.fsal_stage = tableau["b"].exact, method.fsal_stage
        if len(a) <= self.fsal_stage:
            a, c = [*a, self.b_alone], [*c, Fraction(1)]
        self.n = len(a)
        self.a, self.c = [self.padded(row) for row in a], c
        self.b = self.padded(self.b_alone)
        self.errors = [self.padded(row.exact) for row in tableau.get("e", ())]
        self.extra = [self.padded(row.exact) for row in tableau.get("d", ())]
        self.digit = Fraction(10) ** (1 - DIGITS[name]) if name in DIGITS else Fraction(0)
        self._sizes = [[abs(x) for x in row] for row in self.a]
        self._weights = {}

    def padded(self, row):
        return [*row, *[Fraction(0)] * (self.n - len(row))]

    def unit(self, i):
        return [Fraction(int(i == j)) for j in range(self.n)]

    def stage_weights(self, tree):
        """Product over subtrees of sum(a_ij Phi_j) for each stage i, and the same of |a_ij|."""
        if tree not in self._weights:
            exact, bound = [Fraction(1)] * self.n, [Fraction(1)] * self.n
            for inner, outer in map(self.stage_weights, tree):
                exact = [p * dot(row, inner) for p, row in zip(exact, self.a, strict=True)]
                bound = [p * dot(row, outer) for p, row in zip(bound, self._sizes, strict=True)]
            self._weights[tree] = exact, bound
        return self._weights[tree]

    def holds(self, tree, b, sizes=None, x=1):
        """Whether the condition of a tree holds, as far as the printed digits can say.

        A weight is a sum of products of one coefficient a node, each off by `digit` at most.
        """
        exact, bound = self.stage_weights(tree)
        residual = dot(b, exact) - Fraction(x) ** size(tree) / density(tree)
        allowed = dot(sizes or map(abs, b), bound)
        return abs(residual) <= ((1 + self.digit) ** size(tree) - 1) * allowed

    def order(self, b, sizes=None, x=1):
        """The order of the weights b, at most 10."""
        for n in range(1, 11):
            if not all(self.holds(tree, b, sizes, x) for tree in trees(n)):
                return n - 1
        return 10

    def interpolant(self, x):
        """Weights b_i(x) of the dense output, and a bound on the sum of what they are made of."""
        first, final = self.unit(0), self.unit(self.fsal_stage)
        rows = [
            self.b,
            [k - rise for k, rise in zip(first, self.b, strict=True)],
            [2 * r - k - e for r, k, e in zip(self.b, first, final, strict=True)],
            *self.extra,
        ]
        factors = [math.prod([x, 1 - x][i % 2] for i in range(j + 1)) for j in range(len(rows))]
        b = [dot(factors, column) for column in zip(*rows, strict=True)]
        sizes = [[abs(v) for v in row] for row in (self.b, *self.extra)]
        sizes[1:1] = [
            [k + r for k, r in zip(first, sizes[0], strict=True)],
            [2 * r + k + e for r, k, e in zip(sizes[0], first, final, strict=True)],
        ]
        return b, [dot(factors, column) for column in zip(*sizes, strict=True)]


def dot(a, b):
    return sum((p * q for p, q in zip(a, b, strict=True) if p and q), Fraction(0))


@functools.cache
def table(name):
    return Table(name)


def test_the_trees_are_counted_right():
    assert [len(trees(n)) for n in range(1, 11)] == [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]


def test_the_densities_count_the_orderings_of_the_trees():
    # n! / (gamma sigma) orderings of a tree of n nodes; over all trees they sum to (n - 1)!.
    def symmetry(tree):
        kinds = set(tree)
        return math.prod(
            math.factorial(tree.count(k)) * symmetry(k) ** tree.count(k) for k in kinds
        )

    for n in range(1, 11):
        orderings = [Fraction(math.factorial(n), density(t) * symmetry(t)) for t in trees(n)]
        assert sum(orderings) == math.factorial(n - 1)


@pytest.mark.parametrize("name", TABLED)
def test_every_stage_uses_those_before_it(name):
    t = table(name)
    assert all(x == 0 for i, row in enumerate(t.a) for x in row[i:])
    assert len(t.a) == len(t.c) == TABLED[name].n_rows


@pytest.mark.parametrize("name", TABLED)
def test_stage_times_are_row_sums(name):
    t = table(name)
    for row, c in zip(t.a, t.c, strict=True):
        assert abs(sum(row) - c) <= t.digit * (sum(map(abs, row)) + c)


@pytest.mark.parametrize("name", TABLED)
def test_order_is_as_stated_and_no_higher(name):
    t = table(name)
    assert t.order(t.b) == TABLED[name].order


@pytest.mark.parametrize("name", PAIRS)
def test_error_rows_are_differences_to_methods_of_lower_order(name):
    t = table(name)
    for e, order in zip(t.errors, EMBEDDED[name], strict=True):
        embedded = [b - x for b, x in zip(t.b, e, strict=True)]
        sizes = [abs(b) + abs(x) for b, x in zip(t.b, e, strict=True)]
        assert abs(sum(e)) <= t.digit * sum(map(abs, e))
        assert t.order(embedded, sizes) == order


@pytest.mark.parametrize("name", TABLED)
def test_last_stage_is_the_derivative_at_the_end_of_the_step(name):
    t = table(name)
    assert t.a[t.fsal_stage] == t.b and t.c[t.fsal_stage] == 1
    assert TABLED[name].n_stages == t.fsal_stage  # stage 0 is the last of the step before


@pytest.mark.parametrize("x", [Fraction(1, 7), Fraction(1, 2), Fraction(9, 10)], ids=str)
@pytest.mark.parametrize("name", TABLED)
def test_dense_output_has_its_order_inside_the_step(name, x):
    t, order = table(name), TABLED[name].dense_order
    b, sizes = t.interpolant(x)
    assert t.order(b, sizes, x) == order


@pytest.fixture(scope="module")
def value():
    """`polynomial`, callable from Python."""

    @numba.njit
    def called(d, x, out):
        polynomial(d, x, out)

    return called


@pytest.mark.parametrize("name", TABLED)
def test_the_compiled_interpolant_is_the_one_examined(name, value):
    # Stages e_1 ... e_n, so that component i of the state shows the weight of stage i.
    t, h = table(name), 0.25
    work, d = np.zeros((K + t.n, t.n)), np.zeros((4 + len(t.extra), t.n))
    work[K:], work[Y] = np.eye(t.n), 0.5 + h * np.array(t.b, dtype=float)
    work[Y_OLD] = 0.5
    hermite.py_func(h, t.fsal_stage, work, d)
    d[4:] = h * np.array(t.extra, dtype=float).reshape(-1, t.n)
    found = np.empty(t.n)
    for x in (Fraction(0), Fraction(1, 8), Fraction(1, 2), Fraction(7, 8), Fraction(1)):
        value(d, float(x), found)
        b, _ = t.interpolant(x)
        allowed = 4 * EPS * len(d) * np.abs(d).sum(axis=0)
        assert (np.abs(found - 0.5 - h * np.array(b, dtype=float)) <= allowed).all()
    assert TABLED[name].n_dense == len(d) - 1
