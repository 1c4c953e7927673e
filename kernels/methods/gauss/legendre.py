"""Gauss-Legendre collocation to 40 digits: nodes, weights, integrals of Lagrange polynomials."""

import functools
from decimal import Decimal, localcontext

import numpy as np
from numpy.polynomial.polynomial import polyfromroots, polyint, polymul, polyval

DIGITS = 40


def exactly(function):
    """Decorate a function to compute with decimals of enough digits, and to keep its results."""

    @functools.cache
    def precise(*args):
        with localcontext() as context:
            context.prec = DIGITS + 20
            return function(*args)

    return precise


def _legendre(n, x):
    """P_n and its derivative at x."""
    before = Decimal(1)
    p = x
    for k in range(2, n + 1):
        before, p = p, ((2 * k - 1) * x * p - (k - 1) * before) / k
    return p, n * (x * p - before) / (x * x - 1)


@exactly
def nodes_and_weights(s):
    """Nodes in [0, 1], ascending, and the weights."""
    import math

    nodes = []
    weights = []
    for i in range(s):
        x = Decimal(-math.cos(math.pi * (i + 0.75) / (s + 0.5)))
        for _ in range(8):  # Newton: 16 digits, then 32, then all
            p, slope = _legendre(s, x)
            x -= p / slope
        _, slope = _legendre(s, x)
        nodes.append((1 + x) / 2)
        weights.append(1 / ((1 - x * x) * slope * slope))
    return tuple(nodes), tuple(weights)


@exactly
def lagrange(s):
    """Coefficients of 1, x, ... of each Lagrange polynomial on the nodes."""
    nodes, _ = nodes_and_weights(s)
    products = [polyfromroots([x for x in nodes if x != own]) for own in nodes]
    return tuple(p / polyval(own, p) for own, p in zip(nodes, products, strict=True))


@exactly
def collocation(s):
    """a[i][j] = integral of Lagrange polynomial j from 0 to node i."""
    nodes, _ = nodes_and_weights(s)
    return tuple(tuple(polyval(c, polyint(p)) for p in lagrange(s)) for c in nodes)


@exactly
def extrapolated(s):
    """Lagrange polynomial j at 1 + node i, where the stages of the next step are."""
    nodes, _ = nodes_and_weights(s)
    return tuple(tuple(polyval(1 + c, p) for p in lagrange(s)) for c in nodes)


@exactly
def nested_integrals(s):
    """The integral of each Lagrange polynomial from 0, in the form of `dense_output.py`.

    The form has the coefficients of x, x(1-x), x²(1-x), x²(1-x)², ...
    """
    basis = [np.array([Decimal(0), Decimal(1)])]
    for k in range(s - 1):
        basis.append(polymul(basis[-1], [1, -1] if k % 2 == 0 else [0, 1]))
    found = [[Decimal(0)] * s for _ in range(s)]
    for row, p in zip(found, lagrange(s), strict=True):
        left = polyint(p)
        for k in reversed(range(s)):
            row[k] = left[k + 1] / basis[k][k + 1]
            left[: k + 2] -= row[k] * basis[k]
    return found
