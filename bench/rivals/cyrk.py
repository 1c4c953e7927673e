"""CyRK: its C++ solver called from Numba, the right-hand side a C function made by Numba."""

import functools

import numpy as np
from CyRK import cyjit, nbsolve2_ivp
from numba import carray, njit

from ..problems import in_place
from . import MAX_STEPS

METHODS = ("RK45", "DOP853", "Tsit5", "Vern7", "Vern8")


@njit
def _solve(address, t_span, y0, method, times, tol):
    result = nbsolve2_ivp(
        address, t_span, y0, method, times, rtol=tol, atol=tol, max_num_steps=MAX_STEPS
    )
    y = result.y[:, -1].copy() if result.success else np.full(y0.size, np.nan)
    result.free()
    return y


@functools.cache
def _address(into, n):
    @cyjit
    def rates(d, t, y, args):
        into(t, carray(y, n), carray(d, n))

    return rates


def solvers(problem):
    """The explicit methods of `nbsolve2_ivp`."""
    into = functools.cache(lambda: in_place(problem))
    return {f"CyRK {name}": functools.partial(_prepare, problem, into, name) for name in METHODS}


def _prepare(problem, into, method, tol, times=None):
    y0, span = np.array(problem.y0, dtype=float), problem.t_span
    rates = _address(into(), y0.size)
    times = np.array([span[1]] if times is None else times)
    return lambda: _solve(rates.address, span, y0, method, times, tol)
