"""Functions of (y, t), in the order of `odeint`, as functions of (t, y)."""

import numpy as np

from fastdyn.compile.python_callback import FORMS_OF_CODE

FORM = "y, t, *args"  # of the function, for sentences


def time_first(fun, tfirst):
    """The function of (t, y, *args) of a function that takes y first, unless `tfirst` is set.

    The user's function is the cell `fun` of the closure: its code is part of the keys of traces,
    and sentences name its lines.
    """
    if tfirst:
        return fun

    def turned(t, y, *args):
        return fun(y, t, *args)

    turned.__qualname__ = getattr(fun, "__qualname__", type(fun).__qualname__)  # for sentences
    return turned


FORMS_OF_CODE[time_first(abs, False).__code__] = FORM  # pyright: ignore


def as_jacobian(dfun, tfirst, col_deriv, shape):
    """``jac(t, y, *args)`` of a `Dfun`, whose result may be transposed.

    `shape` is that of the Jacobian, or of its diagonals; the Jacobian of one component may be a
    number or a row.
    """
    jac = time_first(dfun, tfirst)
    if not col_deriv and shape != (1, 1):
        return jac

    def of_columns(t, y, *args):
        found = jac(t, y, *args)
        return _rows(found, col_deriv, shape)

    return of_columns


def _rows(found, col_deriv, shape):
    if shape == (1, 1):
        return np.reshape(found, shape)
    return np.transpose(found) if col_deriv else found
