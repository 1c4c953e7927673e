"""The option `mass`, checked."""

import functools

import numpy as np

from fastdyn.compile.mode import COLUMN, DERIVATIVE
from fastdyn.compile.python_callback import value_of
from fastdyn.kernels.methods import COMPLEX

METHODS = "'Rodas5P', 'Radau' or 'BDF'"  # that take a mass matrix
OTHERWISE = f"take method={METHODS}, or solve for y' in `fun` where the matrix is regular"
DIVIDED = "__fastdyn_divided__"  # marks a function M \\ f


def refuse(options, method, y0):
    """Raise ValueError if `mass` is given with another method, or with a complex state.

    `method` is the Facts of a compiled method, or None for a method of SciPy's.
    """
    given = options.get("mass") is not None
    if method is not None and method.takes_mass:
        if y0.dtype.kind == "c" and (given or method.name not in COMPLEX):
            raise ValueError(
                f"{method.name} takes no complex `y0`{' with `mass`' if given else ''}: take "
                f"{'' if given else 'BDF, or '}real and imaginary parts as components."
            )
        return
    if given:
        name = "this method" if method is None else method.name
        raise ValueError(f"`mass` is not for {name}: {OTHERWISE}.")


def equations_of(asked, method, mode):
    """The equations, and `mass` as an array of (n, n) floats or None.

    If `mass` is a function, its matrix is regular, and the equations are solved for y'.

    Raises
    ------
    ValueError
    """
    fun = asked.fun
    y0 = asked.y0
    options = asked.options
    found = options.get("mass") if method.takes_mass else None
    n = len(y0)
    if found is None:
        return fun, None
    if mode not in (DERIVATIVE, COLUMN):
        raise ValueError("`mass` is for equations y' = fun(t, y), not for second order or pairs.")
    if callable(found):
        if hasattr(fun, DIVIDED):  # in a worker of an ensemble
            return fun, None
        first = _matrix(value_of(found, asked.args, "mass", asked.t0, y0.copy()), n)
        return _divided(fun, found, first, options, mode), None
    matrix = _matrix(found, n)
    if options.get("project") is not None and is_singular(matrix):
        raise ValueError(
            "`project` does not go with a singular `mass`: write the constraint among the "
            "algebraic equations, with an unknown that fulfils it. `solve_dae` takes constraints "
            "as they are, of any index."
        )
    return fun, matrix


def _divided(fun, mass, first, options, mode):
    """The function M \\ f of a regular matrix M(t, y), which is `first` at the start."""
    if is_singular(first):
        raise ValueError(
            "`mass` is singular at the start: only a matrix that stays the same may be, not a "
            "function of (t, y). Take `solve_dae` with a function F(t, y, yp) that returns "
            "mass(t, y) @ yp - fun(t, y), and with given='differential'."
        )
    if mode is COLUMN or options.get("jac") is not None:
        other = "vectorized" if mode is COLUMN else "jac"
        raise ValueError(
            f"`{other}` and a function `mass` do not go together: the equations are M(t, y) \\ f, "
            "whose Jacobian contains the derivatives of M."
        )

    @functools.wraps(fun)
    def divided(t, y, *args):
        return np.linalg.solve(np.array(mass(t, y, *args)), np.array(fun(t, y, *args)))

    setattr(divided, DIVIDED, True)
    return divided


def _matrix(found, n):
    """A matrix as an array of (n, n) floats."""
    matrix = np.array(found.toarray() if hasattr(found, "toarray") else found)
    if matrix.dtype.kind not in "fiub" or matrix.shape != (n, n) or not np.isfinite(matrix).all():
        raise ValueError(
            f"`mass` must be a matrix of {n} rows and columns of finite numbers; got an array of "
            f"{matrix.dtype} of shape {matrix.shape}."
        )
    return matrix.astype(float)


def is_singular(matrix):
    """True if some equations are algebraic."""
    return np.linalg.matrix_rank(equilibrated(matrix)[0]) < len(matrix)


def parts_of(matrix):
    """The pseudo-inverse of a matrix, rows x with x matrix = 0, and rows x with matrix x = 0.

    Rows and columns of zeros give unit vectors.  Components that no equation couples, directly or
    through others, stay apart.
    """
    n = len(matrix)
    units = np.eye(len(matrix))
    inverse = np.zeros((n, n))
    left = []
    right = []
    for rows, columns in _blocks(matrix):
        if len(rows) == len(columns) == 1:
            inverse[columns[0], rows[0]] = 1.0 / matrix[rows[0], columns[0]]
            continue
        u, sizes, v = np.linalg.svd(matrix[np.ix_(rows, columns)])
        rank = int(np.sum(sizes > n * np.finfo(float).eps * sizes.max(initial=0.0)))
        inverse[np.ix_(columns, rows)] = (v[:rank].T / sizes[:rank]) @ u[:, :rank].T
        left += list(u.T[rank:] @ units[rows])
        right += list(v[rank:] @ units[columns])
    return inverse, np.reshape(left, (-1, n)), np.reshape(right, (-1, n))


def _blocks(matrix):
    """(rows, columns) of each set of equations and components that elements connect."""
    diagonal = np.diag(matrix)
    none = np.arange(0)
    if not (matrix - np.diag(diagonal)).any():
        for i, element in enumerate(diagonal):
            place = np.array([i])
            yield from [(place, place)] if element else [(place, none), (none, place)]
        return
    from scipy.sparse import bmat, csr_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(matrix)
    pattern = csr_matrix(matrix != 0.0)
    count, label = connected_components(bmat([[None, pattern], [pattern.T, None]]), False)
    order = np.argsort(label, kind="stable")
    for members in np.split(order, np.searchsorted(label[order], np.arange(1, count))):
        yield members[members < n], members[members >= n] - n


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
