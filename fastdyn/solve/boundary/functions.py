"""The functions of a boundary value problem, and their derivatives, compiled."""

from typing import NamedTuple

import numpy as np

from fastdyn.compile.bind import bind
from fastdyn.compile.derivatives.compare import compare_sensitivities
from fastdyn.compile.derivatives.sensitivities import bind_variational
from fastdyn.compile.functions import Bound
from fastdyn.compile.mode import COLUMN, DERIVATIVE
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.problem.sensitivities import Variational

APART = 1e-8  # difference from the function in Python, relative to the largest value
COMPARED = "compared as a boundary value problem"  # a key of a Function's notes


class Compiled(NamedTuple):
    """The Bounds of a function of (t, y), and of its values and derivatives by y."""

    values: Bound
    derivatives: Bound


def compiled(fun, mode, near):
    """The Compiled of ``fun(t, y)``, which returns as many numbers as y has.

    Raises
    ------
    Uncompilable
        If the function cannot be traced, or has no derivatives.
    Different
        If its derivatives are others than those of the function in Python.
    """
    n = len(near.y0)
    values = bind(fun, (), mode, n, near)
    if values.function is None or values.function.traced is None:
        raise Uncompilable(Attempt(fun, (), mode, n).why() or "it cannot be traced")
    equations = Variational(fun, mode, n, (0,), n, n)
    derivatives = bind_variational(equations, (), near)
    notes = values.function.notes
    if COMPARED not in notes:
        states = [longer(near.y0)] * 3
        compare_sensitivities(derivatives, equations, (), [near.t0] * 3, states)
        notes[COMPARED] = True
    return Compiled(values, derivatives)


def longer(y):
    """A state, followed by the rows of the unit matrix."""
    return np.concatenate([y, np.eye(len(y)).ravel()])


def of_columns(fun, x, y, p):
    """The Compiled of SciPy's ``fun(x, y, p)`` as a function of x and [y, p] at one point."""
    n, zeros = len(y), [[0.0]] * len(p)

    def at_point(t, both):
        given = (both[n:, 0],) if zeros else ()
        found = fun(np.array([t]), both[:n], *given)
        return np.vstack([*found, *zeros])

    start = np.concatenate([y[:, 0], p])
    return compiled(at_point, COLUMN, Near(float(x[0]), float(x[-1]), start))


def of_ends(bc, ya, yb, p):
    """The Compiled of ``bc(ya, yb, p)`` as a function of [ya, yb, p]."""
    n, zeros, parameters = len(ya), [0.0] * len(ya), len(p) > 0

    def conditions(t, both):
        given = (both[2 * n :],) if parameters else ()
        return np.concatenate([bc(both[:n], both[n : 2 * n], *given), zeros])

    return compiled(conditions, DERIVATIVE, Near(0.0, 1.0, np.concatenate([ya, yb, p])))


def differ(found, real):
    """Whether compiled values, (n, m), differ from those in Python by more than rounding."""
    with np.errstate(all="ignore"):
        size = np.abs(real).max(axis=1, keepdims=True, initial=0.0)
        near = np.abs(found - real) <= APART * size
    return not (near | (np.isnan(found) & np.isnan(real)) | (found == real)).all()
