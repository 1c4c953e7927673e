"""The functions of a problem that is kept inside: its equations, events and Jacobian."""

import math
from typing import Any

import numpy as np

from fastdyn.compile.python_callback import derivative


def _named(fun):
    """A decorator: the name of a function for its form.

    `functools.wraps` takes 2 us, and gives the form attributes, which each call would compare.
    """

    def named(form):
        for name in ("__name__", "__qualname__"):
            setattr(form, name, getattr(fun, name, type(fun).__name__))
        return form

    return named


def of_states(fun):
    """A function for states of shape (n, k) as one for states of shape (n,)."""

    @_named(fun)
    def of_state(t, y, *args):
        return np.asarray(fun(t, y[:, None], *args))[:, 0]

    return of_state


def inside_only(fun, domain, n):
    """`fun` inside of the domain, and nan outside; `fun` cannot write to the state."""

    @_named(fun)
    def inside_only(t, y, *args):
        if domain(t, y, *args) > 0:
            return fun(t, y.copy(), *args)
        return np.full(n, math.nan)

    return inside_only


def inside_of(domain):
    """The function for the kernels, positive inside; 1.0 stands for True."""

    @_named(domain)
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

    @_named(fun)
    def of_clipped(t, y, *args):
        return fun(t, _clip(y, listed), *args)

    return of_clipped


def kept(fun, listed):
    """The equations, continued below zero; a result of a wrong shape is refused later."""
    shape = listed.shape

    @_named(fun)
    def kept(t, y, *args):
        rates = np.asarray(fun(t, _clip(y, listed), *args))
        if rates.shape != shape:
            return rates
        return np.where(listed & (y <= 0.0) & (rates < 0.0), 0.0, rates)

    return kept


def jacobian_inside(jac, domain, t0, y0):
    """`jac` inside of the domain; outside, where no step ends, `jac` at the start."""

    @_named(jac)
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
