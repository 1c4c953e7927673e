"""Gauss-Legendre collocation to 40 digits: nodes, weights, integrals of Lagrange polynomials."""

import functools
from decimal import Decimal, localcontext

DIGITS = 40


def exactly(function):
    """Run a function with decimals of enough digits, and keep its results."""

    @functools.cache
    def precise(*args):
        with localcontext() as context:
            context.prec = DIGITS + 20
            return function(*args)

    return precise


def _legendre(n, x):
    """P_n and its derivative at x."""
    before, p = Decimal(1), x
    for k in range(2, n + 1):
        before, p = p, ((2 * k - 1) * x * p - (k - 1) * before) / k
    return p, n * (x * p - before) / (x * x - 1)


@exactly
def nodes_and_weights(s):
    """Nodes in [0, 1], ascending, and the weights."""
    import math

    nodes, weights = [], []
    for i in range(s):
        x = Decimal(-math.cos(math.pi * (i + 0.75) / (s + 0.5)))
        for _ in range(8):  # Newton: 16 digits, then 32, then all
            p, slope = _legendre(s, x)
            x -= p / slope
        _, slope = _legendre(s, x)
        nodes.append((1 + x) / 2)
        weights.append(1 / ((1 - x * x) * slope * slope))
    return tuple(nodes), tuple(weights)


def _times(p, root):
    """The polynomial p (coefficients of 1, x, ...) times (x - root)."""
    shifted = [Decimal(0), *p]
    return [a - root * b for a, b in zip(shifted, [*p, Decimal(0)], strict=True)]


@exactly
def lagrange(s):
    """Coefficients of 1, x, ... of each Lagrange polynomial on the nodes."""
    nodes, _ = nodes_and_weights(s)
    found = []
    for j, own in enumerate(nodes):
        p, scale = [Decimal(1)], Decimal(1)
        for k, other in enumerate(nodes):
            if k != j:
                p, scale = _times(p, other), scale * (own - other)
        found.append(tuple(a / scale for a in p))
    return tuple(found)


def value(p, x):
    """A polynomial at x."""
    total = Decimal(0)
    for a in reversed(p):
        total = total * x + a
    return total


def integral(p):
    """The integral of a polynomial from 0."""
    return [Decimal(0), *(a / (k + 1) for k, a in enumerate(p))]


@exactly
def collocation(s):
    """a[i][j] = integral of Lagrange polynomial j from 0 to node i."""
    nodes, _ = nodes_and_weights(s)
    integrals = [integral(p) for p in lagrange(s)]
    return tuple(tuple(value(p, c) for p in integrals) for c in nodes)


@exactly
def extrapolated(s):
    """Lagrange polynomial j at one plus node i: the next step's stages seen from this one."""
    nodes, _ = nodes_and_weights(s)
    return tuple(tuple(value(p, 1 + c) for p in lagrange(s)) for c in nodes)


@exactly
def nested(p):
    """Coefficients of p, with p(0) = 0, in x, x(1-x), x²(1-x), x²(1-x)², ...; see `dense.py`."""
    basis, product = [], [Decimal(0), Decimal(1)]
    for k in range(len(p) - 1):
        basis.append(product)
        product = (
            [-a for a in _times(product, Decimal(1))] if k % 2 == 0 else [Decimal(0), *product]
        )
    left, found = list(p), [Decimal(0)] * len(basis)
    for k in reversed(range(len(basis))):
        found[k] = left[k + 1] / basis[k][k + 1]
        padded = [*basis[k], *[Decimal(0)] * (len(left) - len(basis[k]))]
        left = [a - found[k] * b for a, b in zip(left, padded, strict=True)]
    return tuple(found)
