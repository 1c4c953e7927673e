"""The option `mass`, checked."""

import numpy as np

from fastdyn.compile.mode import COLUMN, DERIVATIVE
from fastdyn.kernels.methods import COMPLEX

from . import domains

METHODS = "'Rodas5P', 'Radau' or 'BDF'"  # that take a mass matrix
OTHERWISE = f"take method={METHODS}, or solve for y' in `fun` where the matrix is regular"


def refuse(options, method, y0):
    """Raise ValueError if `mass` is given with another method, or with a complex state.

    `method` is the Facts of a compiled method, or None for a method of SciPy's.
    """
    takes_mass = method is not None and method.takes_mass
    given = options.get("mass") is not None
    if takes_mass and y0.dtype.kind == "c" and (given or not COMPLEX.get(method.name)):
        raise ValueError(
            f"{method.name} takes no complex `y0`{' with `mass`' if given else ''}: take "
            f"{'' if given else 'BDF, or '}real and imaginary parts as components."
        )
    if not given or takes_mass:
        return
    name = "this method" if method is None else method.name
    raise ValueError(f"`mass` is not for {name}: {OTHERWISE}.")


def refuse_sensitivity(options):
    """Raise ValueError if `sensitivity` is given with `mass`, `domain` or `nonnegative`."""
    domains.refuse_sensitivity(options)
    if options.get("mass") is not None:
        raise ValueError(
            "`sensitivity` and `mass` do not go together: solve for y' in `fun` where the matrix "
            "is regular."
        )


def given(options, method, mode, n):
    """`mass` as an array of (n, n) floats, or None.

    Raises
    ------
    ValueError
    """
    found = options.get("mass") if method.takes_mass else None
    if found is None:
        return None
    if mode not in (DERIVATIVE, COLUMN):
        raise ValueError("`mass` is for equations y' = fun(t, y), not for second order or pairs.")
    if callable(found):
        raise ValueError("`mass` must be a matrix that stays the same; a function is not taken.")
    matrix = np.array(found.toarray() if hasattr(found, "toarray") else found)
    if matrix.dtype.kind not in "fiub" or matrix.shape != (n, n) or not np.isfinite(matrix).all():
        raise ValueError(
            f"`mass` must be a matrix of {n} rows and columns of finite numbers; got an array of "
            f"{matrix.dtype} of shape {matrix.shape}."
        )
    matrix = matrix.astype(float)
    if is_singular(matrix):
        for name in ("on_event", "project"):
            if options.get(name) is not None:
                raise ValueError(
                    f"`{name}` does not go with a singular `mass`: the state behind it need not "
                    "fulfil the algebraic equations. Solve from one event to the next."
                )
    return matrix


def is_singular(matrix):
    """True if some equations are algebraic."""
    return np.linalg.matrix_rank(equilibrated(matrix)[0]) < len(matrix)


def equilibrated(matrix):
    """The matrix with rows and columns scaled to size 1 (rows of zeros stay), and the factors.

    Returns
    -------
    scaled : ndarray, shape (n, n)
        ``rows[:, None] * matrix * columns``.
    rows, columns : ndarray, shape (n,)
    """
    rows = _reciprocals(np.abs(matrix).max(axis=1))
    columns = _reciprocals((rows[:, None] * np.abs(matrix)).max(axis=0))
    return rows[:, None] * matrix * columns, rows, columns


def _reciprocals(sizes):
    return 1.0 / np.where(sizes > 0.0, sizes, 1.0)
