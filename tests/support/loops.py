"""Elimination by loops over matrices stored by columns."""

import numba
import numpy as np

from fastdyn.kernels.algebra import factorise as kernels
from fastdyn.kernels.algebra import factorise_complex as complex_kernels


@numba.njit
def by_kernels(a, b, pivots, lower, upper):
    kernels.factorise(a.reshape(-1), len(b), pivots, len(b), lower, upper)
    kernels.solve(a.reshape(-1), len(b), pivots, b, len(b), lower, upper)


@numba.njit
def by_complex_kernels(re, im, b, c, pivots, lower, upper):
    re, im, n = re.reshape(-1), im.reshape(-1), len(b)
    complex_kernels.factorise_complex(re, im, n, pivots, n, lower, upper)
    complex_kernels.solve_complex(re, im, n, pivots, b, c, n, lower, upper)


def by_columns(a, lower, upper):
    """As kernels take it, NaN where they must not look."""
    i, j = np.indices(a.shape)
    inside = (i - j <= lower) & (j - i <= lower + upper)
    return np.ascontiguousarray(np.where(inside, a, np.nan).T)
