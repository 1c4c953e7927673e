"""The Jacobian that a user gives, checked."""

import numpy as np

from fastdyn.compile.python_callback import matrix

MAX_DENSE = 2000  # 128 MB for Radau
SPARSE = "`jac` is sparse: give an array, `jac.toarray()`; its band is found from its entries."
DIFFERENCES = "2-point"  # as `scipy.optimize.minimize` calls them


def is_sparse(jac, sparsity, n):
    """Whether SciPy has to work with sparse matrices, as far as is known before `jac` is called.

    What `sparsity` says of a small matrix an exact one says, too, if there is one.
    """
    if sparsity is None or callable(jac):
        return hasattr(jac, "tocsc")
    return jac is not None or n > MAX_DENSE


def given(jac, n):
    """`jac` as a function, an array of (n, n) floats, or None; and whether by differences.

    Raises
    ------
    ValueError
    """
    if isinstance(jac, str):
        if jac != DIFFERENCES:
            raise ValueError(
                f"`jac={jac!r}` is unknown; give a function of (t, y), a matrix, None, or "
                f"{DIFFERENCES!r} for differences."
            )
        return None, True
    if jac is None or callable(jac):
        return jac, False
    if hasattr(jac, "tocsc"):
        raise ValueError(SPARSE)
    return matrix(np.array(jac, dtype=float), n), False
