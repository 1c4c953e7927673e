"""Complex states as pairs of real numbers."""

import numpy as np

from fastdyn.compile.mode import COMPLEX_NUMBERS
from fastdyn.compile.sparse_jacobian import pattern_of
from fastdyn.kernels.methods import COMPLEX

from . import validate
from .options.table import refused_among


def on_pairs(asked, method):
    """The Problem for a complex state; None if the method or an option is for real states only.

    Parameters
    ----------
    asked : Arguments
        With a complex `y0`, of n numbers; tolerances that are arrays have n entries.
    method : Facts
        The method for real states.
    """
    on_complex_states = COMPLEX.get(method.name)
    if on_complex_states is None or refused_among(asked.options, "complex"):
        return None
    options = dict(asked.options)
    for name in ("rtol", "atol"):
        if np.shape(options.get(name, 0.0)) == asked.y0.shape:
            options[name] = np.repeat(options[name], 2)
    if method.n_matrices:
        _check_jacobian(options, asked)
    pairs = asked._replace(y0=asked.y0.view(float), options=options)
    return validate.problem(pairs, on_complex_states, COMPLEX_NUMBERS)


def _check_jacobian(options, asked):
    """Check the shape of a Jacobian and of its pattern, and drop both.

    A compiled function of complex numbers has an exact Jacobian, by real and imaginary parts.
    """
    jac, sparsity = options.pop("jac", None), options.pop("jac_sparsity", None)
    if callable(jac):
        jac = jac(asked.t0, asked.y0.copy(), *asked.args)
    for name, matrix in (("jac", jac), ("jac_sparsity", sparsity)):
        if matrix is not None and not isinstance(matrix, str):
            pattern_of(matrix, len(asked.y0), name)
