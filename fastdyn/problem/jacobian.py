"""The options `jac` and `jac_sparsity`, checked."""

import numpy as np

from fastdyn.compile.derivatives.sparse_jacobian import is_sparse, pattern_of
from fastdyn.compile.python_callback import matrix

DIFFERENCES = "2-point"  # the name of differences in `scipy.optimize.minimize`


def options_of(options, n):
    """The Jacobian, the choice of differences, and the sparsity from the options.

    Returns
    -------
    tuple
        A function, an array of (n, n) floats, a sparse matrix, or None; True for differences; the
        Entries that may differ from zero, or None.

    Raises
    ------
    ValueError
    """
    jac = options.get("jac")
    sparsity = options.get("jac_sparsity")
    entries = None if sparsity is None else pattern_of(sparsity, n, "jac_sparsity")
    if isinstance(jac, str):
        if jac != DIFFERENCES:
            raise ValueError(
                f"`jac={jac!r}` is unknown; give a function of (t, y), a matrix, None, or "
                f"{DIFFERENCES!r} for differences."
            )
        return None, True, entries
    if jac is None or callable(jac):
        return jac, False, entries
    if is_sparse(jac):
        pattern_of(jac, n)
        return jac.tocsc().astype(float), False, entries
    return matrix(np.array(jac, dtype=float), n), False, entries
