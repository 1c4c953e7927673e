"""Options of LSODA beside tolerances: the shortest step, and the band of the Jacobian."""

import operator

import numpy as np

from fastdyn.compile.python_callback import OtherMatrix

NAME = "LSODA"
NO_BAND = -1, -1
ORDERS = 12, 5  # the highest orders of Adams' formulas and of BDF


def options_of(asked, method):
    """The options of the Jacobian, `min_step`, and (`lband`, `uband`) or NO_BAND, of any method.

    Raises
    ------
    ValueError
    """
    options = asked.options
    if method.name != NAME:
        return options if method.n_matrices else {}, 0.0, NO_BAND
    jac = options.get("jac")
    h_least = _shortest_step(options)
    band = _band(options)
    if callable(jac) and band != NO_BAND:
        jac = unpacked(jac, band, asked)
    return {"jac": jac}, h_least, band


def _shortest_step(options):
    """`min_step` of LSODA."""
    h_least = options.get("min_step", 0.0)
    if not h_least >= 0:
        raise ValueError("`min_step` must be nonnegative.")
    return float(h_least)


def _band(options):
    """`lband` and `uband` of LSODA; if only one is given, the other is zero."""
    given = options.get("lband"), options.get("uband")
    if given == (None, None):
        return NO_BAND
    found = tuple(0 if width is None else operator.index(width) for width in given)
    if min(found) < 0:
        raise ValueError(f"`lband` and `uband` must not be negative; got {found}.")
    return found


def unpacked(jac, band, asked):
    """Convert a function that returns diagonals, as for SciPy's LSODA, to one that returns rows.

    ``packed[i - j + uband][j]`` is the element in row i and column j.  ValueError for other shapes.
    """
    (lband, uband), n = band, len(asked.y0)
    shape = lband + uband + 1, n
    found = np.shape(jac(asked.t0, asked.y0.copy(), *asked.args))
    if found != shape:
        raise OtherMatrix(
            f"`jac` is expected to have shape {shape}, the diagonals from `uband` above to `lband` "
            f"below, but actually has {found}."
        )

    def rows(t, y, *args):
        packed = jac(t, y, *args)
        return [
            [packed[i - j + uband][j] if -uband <= i - j <= lband else 0.0 for j in range(n)]
            for i in range(n)
        ]

    return rows
