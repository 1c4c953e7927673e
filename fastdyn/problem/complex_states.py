"""Complex states as pairs of real numbers."""

import numpy as np

from fastdyn.compile.mode import COMPLEX_NUMBERS
from fastdyn.compile.sparse_jacobian import pattern_of
from fastdyn.kernels.methods import COMPLEX

from . import validate
from .options.table import refused_among


def on_pairs(fun, t0, tf, y0, method, *, t_eval, dense_output, events, args, options):
    """The Problem for a complex state; None if the method or an option is for real states only.

    Parameters
    ----------
    fun : callable
    t0, tf : float
    y0 : ndarray of complex, shape (n,)
    method : Method
        The method for real states.
    t_eval, dense_output, events, args, options
        As in `solve_ivp`; tolerances that are arrays have n entries.
    """
    on_complex_states = COMPLEX.get(method.name)
    if on_complex_states is None or refused_among(options, "complex"):
        return None
    options, pairs = dict(options), y0.view(float)
    for name in ("rtol", "atol"):
        if np.shape(options.get(name, 0.0)) == y0.shape:
            options[name] = np.repeat(options[name], 2)
    if method.n_matrices:
        _check_jacobian(options, t0, y0, validate.extra_arguments(args))
    return validate.problem(
        fun, t0, tf, pairs, on_complex_states, t_eval, dense_output, events, args, COMPLEX_NUMBERS,
        options,
    )  # fmt: skip


def _check_jacobian(options, t0, y0, args):
    """Check the shape of a Jacobian and of its pattern, and drop both.

    A compiled function of complex numbers has an exact Jacobian, by real and imaginary parts.
    """
    jac, sparsity = options.pop("jac", None), options.pop("jac_sparsity", None)
    if callable(jac):
        jac = jac(t0, y0.copy(), *args)
    for name, matrix in (("jac", jac), ("jac_sparsity", sparsity)):
        if matrix is not None and not isinstance(matrix, str):
            pattern_of(matrix, len(y0), name)
