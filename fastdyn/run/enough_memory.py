"""Checks before allocation: do the arrays of a problem fit into this machine?"""

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


def check_room(count, of_what, advice, share=SHARE, error=MemoryError):
    """Raise an error if as many numbers exceed a share of the memory of this machine."""
    there = memory_of_machine()
    if 8 * count > share * there:
        raise error(
            f"{of_what} {8 * count / 1e9:.3g} GB, and this machine has {there / 1e9:.3g}: {advice}."
        )


def check_full_matrices(method, band, n, rows):
    """Raise MemoryError if matrices of n columns and `rows` rows exceed the memory."""
    how = (
        "give solve_ivp `lband` and `uband`" if method.name == LSODA
        else "name the elements of the Jacobian that are not zero by `jac_sparsity`, or return "
        "sparse matrices from `jac`"
    )  # fmt: skip
    check_room(
        n * method.rows(rows),
        f"{method.name} keeps {method.n_matrices} matrices of {rows} rows and {n} columns,",
        f"{how}, or take an explicit method",
        error=MemoryError if band == NO_BAND else KeepsBands,
    )
