"""A check before allocation: do the full matrices of a problem fit into this machine?"""

import math
import os

from fastdyn.problem.lsoda import NAME as LSODA
from fastdyn.problem.lsoda import NO_BAND

SHARE = 0.9  # of the memory


class KeepsBands(MemoryError):
    """Full matrices do not fit, but SciPy's LSODA keeps only the given band."""


def memory_of_machine():
    """The memory of this machine in bytes; infinite if the system does not tell."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return math.inf


def check_full_matrices(method, band, n, rows):
    """Raise MemoryError if matrices of n columns and `rows` rows exceed the memory."""
    wanted = 8 * n * method.rows(rows)
    there = memory_of_machine()
    if wanted > SHARE * there:
        how = (
            "give solve_ivp `lband` and `uband`" if method.name == LSODA
            else "name the elements of the Jacobian that are not zero by `jac_sparsity`, or return "
            "sparse matrices from `jac`"
        )  # fmt: skip
        raise (MemoryError if band == NO_BAND else KeepsBands)(
            f"{method.name} keeps {method.n_matrices} matrices of {rows} rows and {n} columns, "
            f"{wanted / 1e9:.0f} GB, and this machine has {there / 1e9:.0f}: {how}, or take an "
            "explicit method."
        )
