"""Shorter forms of expressions, and linear equations of expressions."""

import functools
from graphlib import TopologicalSorter
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from sympy.simplify.fu import TR5, TR6

SHORT, MODERATE = 40, 1500  # operations: up to which common factors are sought, and any other form
GROWN = 100  # in an elimination, where longer ones are given up


@functools.lru_cache(10000)
def _size(expression):
    """Operations in an expression."""
    return sp.count_ops(expression)


def shortened(expression, most=MODERATE) -> Any:
    """The shortest of a few equal forms; as it is if it takes more than `most` operations."""
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda one: shortened(one, most))
    if not 2 <= _size(expression) <= most:
        return expression
    plain = sp.expand(expression)
    if _size(plain) > 3 * most:
        return expression
    forms = [plain, *_with_angles(plain)] if plain.has(sp.sin, sp.cos) else [plain]
    forms = sorted(forms, key=_size)[:2]
    best = min([expression, *forms, *map(sp.factor_terms, forms)], key=_size)
    if _size(best) <= SHORT and best.is_Add:
        best = min(best, sp.cancel(best), key=_size)
    return best


def _with_angles(plain):
    """Sines and cosines without their products, squares of one kind, half the angles."""
    sums = _of_sums(plain)
    return [sums, *map(sp.expand, (TR5(plain), TR6(plain))), *_halved(sums)]


def _of_sums(plain):
    """An expanded expression in which no sine or cosine is multiplied by another."""
    total = {}
    for term in sp.Add.make_args(plain):
        factors = sp.Mul.make_args(term)
        turning = [one for one in factors if _is_wave(one)]
        rest = sp.Mul(*[one for one in factors if not _is_wave(one)])
        waves = [(sp.S.One, sp.cos, sp.S.Zero)]
        for one in turning:
            base, power = one.as_base_exp()
            for _ in range(int(power)):
                waves = _product(waves, type(base), base.args[0])
        for amount, kind, angle in waves:
            wave = kind(angle) * rest
            total[wave] = total.get(wave, 0) + amount
    return sp.Add(*[amount * wave for wave, amount in total.items()])


def _is_wave(factor):
    base, power = factor.as_base_exp()
    return isinstance(base, sp.sin | sp.cos) and power.is_Integer and power > 0


def _product(waves, kind, b):
    """A sum of amounts of sin a or cos a, times sin b or cos b."""
    found = []
    half = sp.Rational(1, 2)
    for amount, own, a in waves:
        even = own is kind  # sin sin and cos cos are sums of cosines
        result = sp.cos if even else sp.sin
        sign = -1 if kind is sp.sin else 1  # of one of the two
        ahead, behind = (sign, 1) if even else (1, sign)
        found.append((ahead * half * amount, result, a + b))
        found.append((behind * half * amount, result, a - b))
    return found


def _halved(sums):
    """cos 2a by the square of sin a, and by that of cos a."""
    found = [c for c in sums.atoms(sp.cos) if _is_double(c.args[0])]
    if not found:
        return []
    halves = {c: c.args[0] / 2 for c in found}
    by_sine = {c: 1 - 2 * sp.sin(a) ** 2 for c, a in halves.items()}
    by_cosine = {c: 2 * sp.cos(a) ** 2 - 1 for c, a in halves.items()}
    return [sp.expand(sums.xreplace(each)) for each in (by_sine, by_cosine)]


def _is_double(angle):
    return all(term.as_coeff_Mul()[0] % 2 == 0 for term in sp.Add.make_args(angle))


def never_zero(expression):
    """An equal form that is evidently nonzero everywhere, or None."""
    if expression.is_nonzero:
        return expression
    if expression.has(sp.cos):
        return next((f for f in _halved(sp.expand(expression)) if f.is_nonzero), None)
    return None


def linear(expressions, unknowns) -> Any:
    """(K, r) with K unknowns = r, for expressions that are zero; None if one is not linear."""
    K = sp.Matrix([[sp.diff(e, u) for u in unknowns] for e in expressions])
    if K.free_symbols & set(unknowns):
        return None
    zero = dict.fromkeys(unknowns, 0)
    return K, sp.Matrix([-e.xreplace(zero) for e in expressions])


class Formula(NamedTuple):
    """An unknown as an expression of the state and of unknowns that are computed before."""

    unknown: sp.Symbol
    value: Any

    @property
    def unknowns(self):
        return [self.unknown]

    @property
    def needs(self):
        return [self.value]


class Elimination(NamedTuple):
    """Unknowns that the code computes by elimination: ``matrix * unknowns = right``."""

    unknowns: list[sp.Symbol]
    matrix: Any
    right: Any

    @property
    def needs(self):
        return [*self.matrix, *self.right]


def solved(K, r, unknowns, limit) -> list[Any]:
    """
    Solve K u = r by formulas, if the formulas are small, and by elimination in the code otherwise.

    Parameters
    ----------
    K, r : Matrix
    unknowns : list of Symbol
        u.
    limit : int
        The largest number of operations in a block of equations that is solved by formulas.

    Returns
    -------
    list of Formula and Elimination
        In an order in which they can be evaluated.
    """
    steps = []
    for rows, columns in _blocks(K):
        others = [c for c in range(len(unknowns)) if c not in columns]
        known = K.extract(rows, others) * sp.Matrix([unknowns[c] for c in others])
        right = r.extract(rows, [0]) - (known if others else sp.zeros(len(rows), 1))
        steps += _solved(K.extract(rows, columns), right, [unknowns[c] for c in columns], limit)
    return steps


def _blocks(K):
    """Rows and columns of the smallest systems that can be solved one after the other."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

    pattern = csr_array([[int(x != 0) for x in K.row(n)] for n in range(K.rows)])
    row_of = maximum_bipartite_matching(pattern, perm_type="row")  # row by column
    if (row_of < 0).any():
        raise ValueError("the equations of motion are singular")
    depends = pattern[row_of]
    count, label = connected_components(depends, connection="strong")
    before = {n: set() for n in range(count)}
    for c, other in zip(*depends.nonzero(), strict=True):
        before[label[c]] |= {label[other]} - {label[c]}
    for n in TopologicalSorter(before).static_order():
        columns = [int(c) for c in np.flatnonzero(label == n)]
        yield sorted(int(row_of[c]) for c in columns), columns


def _solved(K, r, unknowns, limit):
    """The steps of one block, which first take pivots that are nonzero everywhere."""
    rows = [[*K.row(n), r[n]] for n in range(len(r))]
    left = list(unknowns)
    formulas = []
    while _operations(rows) <= limit and (pivot := _pivot(rows)):
        p, c = pivot
        row = rows[p]
        row[c] = never_zero(row[c])
        others = [_reduced(line, row, c) for n, line in enumerate(rows) if n != p]
        if _operations(others) > limit:
            break
        known = sum((row[n] * u for n, u in enumerate(left) if n != c), start=sp.S.Zero)
        formulas.append(Formula(left.pop(c), shortened((row[-1] - known) / row[c])))
        rows = [[x for n, x in enumerate(line) if n != c] for line in others]
    rest = []
    if left:
        matrix = sp.Matrix([line[:-1] for line in rows])
        rest = [Elimination(left, matrix, sp.Matrix([line[-1] for line in rows]))]
    return rest + formulas[::-1]


def _reduced(line, row, c):
    """An equation minus a multiple of the pivot's equation, with column c eliminated."""
    if line[c] == 0:
        return line
    factor = line[c] / row[c]
    return [
        x if y == 0 else shortened(x - factor * y, GROWN) for x, y in zip(line, row, strict=True)
    ]


def _operations(rows):
    return sum(_size(x) for line in rows for x in line)


def _pivot(rows):
    """The place of an entry that is nonzero for all states, with the least fill-in."""
    best = None
    place = None
    for n, line in enumerate(rows):
        across = sum(x != 0 for x in line[:-1])
        for c, x in enumerate(line[:-1]):
            if x != 0 and never_zero(x) is not None:
                down = sum(other[c] != 0 for other in rows)
                cost = ((across - 1) * (down - 1), _size(x))
                if best is None or cost < best:
                    best = cost
                    place = (n, c)
    return place
