"""Systems of linear equations: their factors, and solutions, are one node each.

Such a node has no number as its value: "entry" is one number of a solution, and "singular" tells
whether there is none.
"""

from typing import Any

import numpy as np

from .record import Operation, add

# Kinds of matrices.  Rows of a scaled matrix are divided by their largest element.
GENERAL = "general"
SYMMETRIC = "symmetric"
SCALED = "scaled"
FACTORS, SOLUTION = "fastdyn_factors", "fastdyn_solution"  # symbols of kernels
EQUATIONS = frozenset(("factors", "singular", "solution", "entry"))


def _matrix(data, *elements):
    """The matrices of the given elements, numbers or arrays of k numbers: shape (..., n, n)."""
    n, _ = data
    found = np.stack(np.broadcast_arrays(*map(np.asarray, elements)), -1)
    return found.reshape(*found.shape[:-1], n, n).astype(float)


def _solved(transposed, a, *right):
    """The solutions, shape (..., n); NaN for a singular matrix."""
    b = np.stack(np.broadcast_arrays(*map(np.asarray, right)), -1).astype(float)
    a = np.swapaxes(a, -1, -2) if transposed else a
    shape = np.broadcast_shapes(a.shape[:-2], b.shape[:-1])
    a = np.broadcast_to(a, (*shape, *a.shape[-2:]))
    b = np.broadcast_to(b, (*shape, b.shape[-1]))
    usual = np.where(_singular(GENERAL, a)[..., None, None], np.nan, a)
    return np.linalg.solve(usual, b[..., None])[..., 0]


def _singular(kind, a):
    """Whether LAPACK finds a pivot of zero; of a scaled matrix, one of n eps or less."""
    if kind != SCALED:
        return np.linalg.slogdet(a)[0] == 0.0
    from scipy.linalg import lu

    scaled = a / np.abs(a).max(-1)[..., None]
    usual = np.isfinite(scaled).all((-2, -1))
    upper: Any = lu(np.where(usual[..., None, None], scaled, 0.0), permute_l=True)[1]
    pivots = np.diagonal(upper, axis1=-2, axis2=-1)
    return np.abs(pivots).min(-1) <= a.shape[-1] * np.finfo(float).eps


add(
    Operation("factors", _matrix, inner=True, cost=1000, words="a large system of equations",
              c="double {v}[{n} * ({n} + 2)] = {{{args}}}; factorise({n}, {scaled}, {v});",
              js="factorise({n}, {scaled}, [{args}])"),
    Operation("singular", _singular, truth=True,
              c="is_singular({n}, {scaled}, {0})", js="is_singular({n}, {scaled}, {0})"),
    Operation("solution", _solved, inner=True, cost=100,
              c="double {v}[{n}] = {{{args}}}; solved({n}, {transposed}, {first}, {v});",
              js="solved({n}, {transposed}, {first}, [{args}])"),
    Operation("entry", lambda i, found: found[..., i], c="{0}[{data}]", js="{0}[{data}]"),
)  # fmt: skip
