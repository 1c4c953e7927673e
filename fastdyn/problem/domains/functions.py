"""The functions of a problem that is kept inside: its equations, events and Jacobian."""

import functools
import math
from typing import Any

import numpy as np

from fastdyn.compile.python_callback import derivative


def of_states(fun):
    """A function for states of shape (n, k) as one for states of shape (n,)."""

    @functools.wraps(fun)
    def of_state(t, y, *args):
        return np.asarray(fun(t, y[:, None], *args))[:, 0]

    return of_state


def inside_only(fun, domain, n):
    """`fun` inside of the domain, and nan outside; `fun` cannot write to the state."""

    @functools.wraps(fun)
    def inside_only(t, y, *args):
        if domain(t, y, *args) > 0:
            return fun(t, y.copy(), *args)
        return np.full(n, math.nan)

    return inside_only


def inside_of(domain):
    """The function for the kernels, positive inside; 1.0 stands for True."""

    @functools.wraps(domain)
    def inside(t, y, *args):
        return domain(t, y, *args) * 1.0

    return inside


def _clip(y, listed):
    return np.where(listed & (y < 0.0), 0.0, y)


def clipped(listed):
    """The function that sets the negative ones among the listed components to 0."""

    def clipped(t, y, *args):
        return _clip(y, listed)

    return clipped


def of_clipped(fun, listed):
    """A function of the state, called with 0 for negative components among those listed."""

    @functools.wraps(fun)
    def of_clipped(t, y, *args):
        return fun(t, _clip(y, listed), *args)

    return of_clipped


def kept(fun, listed):
    """The equations, continued below zero; a result of a wrong shape is refused later."""
    shape = listed.shape

    @functools.wraps(fun)
    def kept(t, y, *args):
        rates = np.asarray(fun(t, _clip(y, listed), *args))
        if rates.shape != shape:
            return rates
        return np.where(listed & (y <= 0.0) & (rates < 0.0), 0.0, rates)

    return kept


def jacobian_inside(jac, domain, problem):
    """`jac` inside of the domain; outside, where no step ends, `jac` at the start."""
    t0 = problem.t0
    y0 = problem.y0

    @functools.wraps(jac)
    def jacobian(t, y, *args):
        if domain(t, y, *args) > 0:
            return jac(t, y, *args)
        return jac(t0, y0.copy(), *args)

    return jacobian


def jacobian_of_kept(jac: Any, fun, listed):
    """The Jacobian of `kept` from `jac`, the Jacobian of `fun`, which is a function or a matrix."""
    n, of_state = len(listed), jac if callable(jac) else lambda t, y, *args: jac

    def jacobian(t, y, *args):
        clipped = _clip(y, listed)
        rates = derivative(fun(t, clipped, *args), n)
        rows = np.where(listed & (y <= 0.0) & (rates < 0.0), 0.0, 1.0)
        columns = np.where(listed & (y < 0.0), 0.0, 1.0)
        found = of_state(t, clipped, *args)
        if hasattr(found, "tocsc"):
            sparse: Any = found
            return sparse.multiply(rows[:, None]).multiply(columns).tocsc()
        return rows[:, None] * np.asarray(found) * columns

    return jacobian
