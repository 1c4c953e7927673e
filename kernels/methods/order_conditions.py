"""Order conditions of explicit Runge-Kutta methods, one for each rooted tree.

J. C. Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 31: a method
has order p if sum(b_i Phi_i(tree)) = 1 / gamma(tree) for every tree with at most p nodes, and its
interpolant has order p if sum(b_i(x) Phi_i(tree)) = x^n / gamma(tree), n the nodes of the tree.
"""

import functools
import math

import numpy as np

INSIDE = 0.3, 0.7  # shares of a step at which `check` examines an interpolant


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


def factors(tree):
    """What a condition multiplies b_i by: "c^2", "a c", "c (a c^2)"."""
    leaves = tree.count(())
    found = [f"c^{leaves}" if leaves > 1 else "c"] if leaves else []
    found += [f"a {factors(one)}" for one in tree if one]
    return " ".join(f"({one})" if len(found) > 1 and " " in one else one for one in found)


class Conditions:
    """The conditions of a tableau, as far as the digits of its coefficients can tell.

    Parameters
    ----------
    tableau : dict
        See `explicit.read_off`; the last stage of a step is the derivative at the end.
    accuracy : float
        Relative error of each coefficient, and of each operation.
    number : type
        float, or Fraction for exact sums.
    """

    def __init__(self, tableau, accuracy, number=float):
        self.n, self.fsal_stage = len(tableau["a"]), len(tableau["b"])
        self.accuracy = accuracy
        self.number = number
        self.a = np.array([self._padded(row) for row in tableau["a"]])
        self._sizes = abs(self.a).astype(float)
        self.b = self._padded(tableau["b"])
        self.errors = [self._padded(row) for row in tableau["e"]]
        self.extra = [self._padded(row) for row in tableau["d"]]
        self._stage_weights = functools.cache(self._stage_weights)

    def _padded(self, row):
        values = [self.number(x) for x in row.exact]
        return np.array(values + [self.number(0)] * (self.n - len(row)))

    def unit(self, i):
        return np.array([self.number(i == j) for j in range(self.n)])

    def _stage_weights(self, tree):
        """Product over subtrees of sum(a_ij Phi_j) for each stage i, and the same of |a_ij|."""
        exact = np.array([self.number(1)] * self.n)
        bound = np.ones(self.n)
        for inner, outer in map(self._stage_weights, tree):
            exact = exact * (self.a @ inner)
            bound = bound * (self._sizes @ outer)
        return exact, bound

    def order(self, b, sizes=None, x=1, most=10):
        """The order of the weights b, at most `most`, and the first tree that fails, with its sum.

        A weight is a sum of products of one coefficient a node; `sizes` bounds the sums of the b_i.
        """
        sizes = abs(b if sizes is None else sizes).astype(float)
        for n in range(1, most + 1):
            for tree in trees(n):
                exact, bound = self._stage_weights(tree)
                total = b @ exact
                allowed = n * self.accuracy * (sizes @ bound)
                if not abs(total - self.number(x) ** n / density(tree)) <= allowed:
                    return n - 1, (tree, total)
        return most, None

    def embedded(self, e):
        """The weights b - e of a method with the error e, and their `sizes`."""
        return self.b - e, abs(self.b) + abs(e)

    def interpolant(self, x):
        """The weights b_i(x) of the dense output, and their `sizes`."""
        first = self.unit(0)
        final = self.unit(self.fsal_stage)
        rise = abs(self.b)
        rows = [self.b, first - self.b, 2 * self.b - first - final, *self.extra]
        sizes = [rise, first + rise, 2 * rise + first + final, *map(abs, self.extra)]
        shares = [math.prod([x, 1 - x][i % 2] for i in range(j + 1)) for j in range(len(rows))]
        return tuple(
            sum(share * row for share, row in zip(shares, whole, strict=True))
            for whole in (rows, sizes)
        )


def check(name, tableau, accuracy, **orders):
    """Raise ValueError unless the method `name` has the orders that its file states.

    Error estimates from two rows are no weights of an embedded method: their order is not examined.
    """
    if orders["error_order"] and not tableau["e"]:
        raise ValueError(f"{name}: a pair needs a row of errors, got none")
    known = Conditions(tableau, accuracy)
    examined = [("order", "b", known.b, None, 1.0)]
    if len(known.errors) == 1:
        examined.append(("error_order", "(b - e)", *known.embedded(known.errors[0]), 1.0))
    examined += [("dense_order", f"b(x = {x})", *known.interpolant(x), x) for x in INSIDE]
    for option, weights, b, sizes, x in examined:
        stated = orders[option]
        found, failed = known.order(b, sizes, x, stated + 1)
        given = f"{name}: {option}={stated} is given, but the weights {weights}"
        if found > stated:
            raise ValueError(f"{given} satisfy the conditions of order {found}, too")
        if found < stated:
            tree, total = failed
            raise ValueError(
                f"{given} are of order {found}: sum({weights} {factors(tree)}) is {total:.16g} "
                f"instead of {x ** size(tree) / density(tree):.16g}; a coefficient or the order is "
                "wrong"
            )
