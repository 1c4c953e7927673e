"""Order conditions of every table, in rational arithmetic, one for each rooted tree.

J. C. Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 31: a method
has order p if sum(b_i Phi_i(tree)) = 1 / gamma(tree) for every tree with at most p nodes.
"""

import functools
from fractions import Fraction

import pytest

from fastdyn.kernels import METHODS

TABLED = {name: m for name, m in METHODS.items() if m.tableau is not None}


@functools.cache
def trees(n):
    """Rooted trees of n nodes: each a sorted tuple of the subtrees at its root."""
    return tuple(sorted(set(_forests(n - 1, n - 1))))


@functools.cache
def _forests(n, largest):
    if n == 0:
        return ((),)
    found = []
    for size in range(1, min(n, largest) + 1):
        for first in trees(size):
            for rest in _forests(n - size, size):
                found.append(tuple(sorted((first, *rest))))
    return tuple(set(found))


def size(tree):
    return 1 + sum(map(size, tree))


@functools.cache
def density(tree):
    product = size(tree)
    for subtree in tree:
        product *= density(subtree)
    return product


class Table:
    """A tableau as fractions, with the elementary weights of its stages."""

    def __init__(self, tableau):
        self.a = [list(row.exact) for row in tableau["a"]]
        self.n = len(self.a)
        self.c = tableau["c"].exact
        self.b = self.padded(tableau["b"])
        self.errors = [self.padded(row) for row in tableau.get("e", ())]
        self.dense = [self.padded(row) for row in tableau.get("d", ())]
        self._weights = {}

    def padded(self, row):
        return list(row.exact) + [Fraction(0)] * (self.n - len(row))

    def stage_weights(self, tree):
        """Product over subtrees of sum(a_ij Phi_j), for each stage i."""
        if tree not in self._weights:
            product = [Fraction(1)] * self.n
            for subtree in tree:
                inner = self.stage_weights(subtree)
                for i in range(self.n):
                    product[i] *= sum(a * w for a, w in zip(self.a[i], inner, strict=False))
            self._weights[tree] = product
        return self._weights[tree]

    def residual(self, b, tree, x=1):
        weight = sum(w * p for w, p in zip(b, self.stage_weights(tree), strict=True))
        return weight - Fraction(x) ** size(tree) / density(tree)

    def worst(self, b, order, x=1):
        return max(abs(self.residual(b, tree, x)) for n in range(1, order + 1) for tree in trees(n))


@functools.cache
def table(name):
    return Table(TABLED[name].tableau)


def rounding(name):
    """What the printed digits of a table allow: nothing for fractions, 30 digits for DOP853."""
    return Fraction(1, 10**24) if name == "DOP853" else 0


def test_the_trees_are_counted_right():
    assert [len(trees(n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@pytest.mark.parametrize("name", TABLED)
def test_stage_times_are_row_sums(name):
    t = table(name)
    assert all(abs(sum(row) - c) <= rounding(name) for row, c in zip(t.a, t.c, strict=False))


@pytest.mark.parametrize("name", TABLED)
def test_order_is_as_stated_and_no_higher(name):
    t, order = table(name), TABLED[name].order
    assert t.worst(t.b, order) <= rounding(name)
    assert t.worst(t.b, order + 1) > Fraction(1, 10**6)


@pytest.mark.parametrize("name", [n for n, m in TABLED.items() if m.error_order])
def test_error_rows_belong_to_methods_of_lower_order(name):
    t = table(name)
    orders = {"DOP853": (5, 3)}.get(name, (TABLED[name].error_order,))
    for e, order in zip(t.errors, orders, strict=True):
        embedded = [b - x for b, x in zip(t.b, e, strict=True)]
        assert t.worst(embedded, order) <= rounding(name)
        assert t.worst(embedded, order + 1) > Fraction(1, 10**6)


@pytest.mark.parametrize("name", [n for n, m in TABLED.items() if m.error_order])
def test_last_stage_is_the_first_of_the_next_step(name):
    t, last = table(name), TABLED[name].last
    assert t.padded(TABLED[name].tableau["a"][last]) == t.b if last < t.n else True


def interpolant(name, x):
    """Weights b_i(x) of the dense output, from the nested form of kernels/dense.py."""
    t, method = table(name), TABLED[name]
    n = max(t.n, method.last + 1)
    unit = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
    b = t.b + [Fraction(0)] * (n - t.n)
    rows = [
        b,
        [k - rise for k, rise in zip(unit[0], b, strict=True)],
        [2 * r - k - e for r, k, e in zip(b, unit[0], unit[method.last], strict=True)],
        *(row + [Fraction(0)] * (n - t.n) for row in t.dense),
    ]
    total = [Fraction(0)] * n
    for j in reversed(range(len(rows))):
        factor = x if j % 2 == 0 else 1 - x
        total = [(r + s) * factor for r, s in zip(rows[j], total, strict=True)]
    return total


@pytest.mark.parametrize("name", TABLED)
def test_dense_output_has_its_order_everywhere_in_the_step(name):
    method = TABLED[name]
    full = Table(method.tableau | {"a": _with_end_stage(method), "c": method.tableau["c"]})
    for x in (Fraction(1, 7), Fraction(1, 2), Fraction(9, 10)):
        b = interpolant(name, x)
        assert full.worst(b, method.dense_order, x) <= rounding(name) * 1000
        assert full.worst(b, method.dense_order + 1, x) > Fraction(1, 10**8)


def _with_end_stage(method):
    """The rows of a, with the derivative at the end of the step in place `last`."""
    rows = list(method.tableau["a"])
    b = method.tableau["b"]
    if len(rows) <= method.last:
        return (*rows, b)
    if rows[method.last].exact != b.exact:
        rows.insert(method.last, b)
    return tuple(rows)
