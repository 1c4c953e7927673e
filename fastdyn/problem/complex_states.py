"""Complex states as pairs of real numbers."""

import numpy as np

from fastdyn.compile.derivatives.sparse_jacobian import pattern_of
from fastdyn.compile.mode import COMPLEX_COLUMN, COMPLEX_NUMBERS
from fastdyn.kernels.methods import COMPLEX

from . import validate
from .options.table import refused_among


def on_pairs(asked, method):
    """The Problem for a complex state.

    Parameters
    ----------
    asked : Arguments
        With a complex `y0`, of n numbers; tolerances that are arrays have n entries.
    method : Facts
        The method for real states.

    Raises
    ------
    ValueError
        If the method or an option is for real states only.
    """
    on_complex_states = COMPLEX.get(method.name)
    if on_complex_states is None:
        raise ValueError(
            f"`method={method.name!r}` takes no complex states; {', '.join(COMPLEX)} do."
        )
    if refused := refused_among(asked.options, "complex"):
        names = ", ".join(f"`{name}`" for name, _ in refused)
        raise ValueError(
            f"{names}: for real states only; give real and imaginary parts as a real state of "
            "twice the length."
        )
    options = dict(asked.options)
    for name in ("rtol", "atol"):
        if np.shape(options.get(name, 0.0)) == asked.y0.shape:
            options[name] = np.repeat(options[name], 2)
    if method.n_matrices:
        _check_jacobian(options, asked)
    pairs = asked._replace(y0=asked.y0.view(float), options=options)
    mode = COMPLEX_COLUMN if asked.vectorized else COMPLEX_NUMBERS
    return validate.problem(pairs, on_complex_states, mode)


def _check_jacobian(options, asked):
    """Check the shape of a Jacobian and of its pattern, and drop both.

    A compiled function of complex numbers has an exact Jacobian, by real and imaginary parts.
    """
    jac = options.pop("jac", None)
    sparsity = options.pop("jac_sparsity", None)
    if callable(jac):
        jac = jac(asked.t0, asked.y0.copy(), *asked.args)
    for name, matrix in (("jac", jac), ("jac_sparsity", sparsity)):
        if matrix is not None and not isinstance(matrix, str):
            pattern_of(matrix, len(asked.y0), name)
