"""Complex states as pairs of real numbers."""

import numpy as np

from fastdyn.kernels.methods import COMPLEX
from fastdyn.problem import validate

REFUSED = ("breakpoints", "project", "checkpoint", "callback", "on_event")


def on_pairs(fun, t0, tf, y0, method, *, t_eval, dense_output, events, args, options):
    """The Problem for a complex state; None if the method or an option has no such form.

    Parameters
    ----------
    fun : callable
    t0, tf : float
    y0 : ndarray of complex, shape (n,)
    method : Method
        For real states.
    t_eval, dense_output, events, args, options
        As in `solve_ivp`; tolerances that are arrays have n entries.
    """
    on_complex_states = COMPLEX.get(method.name)
    if on_complex_states is None or any(options.get(name) is not None for name in REFUSED):
        return None
    options, pairs = dict(options), y0.view(float)
    for name in ("rtol", "atol"):
        if np.shape(options.get(name, 0.0)) == y0.shape:
            options[name] = np.repeat(options[name], 2)
    return validate.problem(
        fun, t0, tf, pairs, on_complex_states, t_eval, dense_output, events, args, "complex",
        options,
    )  # fmt: skip
