"""CyRK: its C++ solver called from Numba, the right-hand side a C function made by Numba."""

import functools

import numpy as np
from CyRK import cyjit, nbsolve2_ivp
from numba import carray, njit

from ..problems import in_place
from ..problems.hybrids import in_place_with_discrete
from . import MANY_ATOL, MANY_RTOL, MAX_STEPS
from .parameters import to_tuple_of

METHODS = ("RK45", "DOP853", "Tsit5", "Vern7", "Vern8")
FIRST_CALL = {
    "CyRK": (
        "import numpy as np; from CyRK import cyjit, nbsolve2_ivp",
        """
@cyjit
def fun(d, t, y, args):
    d[0] = y[1]
    d[1] = -{k} * y[0] - y[1] ** {power}
def solve():
    nbsolve2_ivp(fun.address, (0.0, 5.0), np.array([1.0, 0.0]), "RK45").free()
""",
    ),
}


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


def trajectories(many):
    """RK45, one after the other inside compiled code."""
    user, t_end, n, m = njit(many.fun), many.t_end, many.y0.shape[1], many.parameters.shape[1]
    to_tuple = to_tuple_of(m)

    @njit
    def into(d, t, y, p):
        rates = user(t, y, *p)
        for i in range(n):
            d[i] = rates[i]

    @cyjit
    def rates(d, t, y, args):
        into(carray(d, n), t, carray(y, n), to_tuple(carray(args, m)))

    @njit(nogil=True)
    def run(address, y0, parameters):
        out = np.empty_like(y0)
        for i in range(len(y0)):
            result = nbsolve2_ivp(
                address, (0.0, t_end), y0[i], "RK45", np.array([t_end]), args=parameters[i],
                rtol=MANY_RTOL, atol=MANY_ATOL,
            )  # fmt: skip
            out[i] = result.y[:, -1]
            result.free()
        return out

    return {"CyRK": lambda: run(rates.address, many.y0, many.parameters)}


def hybrid(given):
    """RK45 and DOP853 by a compiled loop over the samples."""
    h, n, m = given, len(given.y0), len(given.d0)
    if h.period is None:
        return {}
    n_samples, period, begin = round(h.end / h.period), h.period, np.array(h.d0)

    @functools.cache
    def loop():
        into, act, start = in_place_with_discrete(h.fun, n), njit(h.act(np)), np.array(h.y0)

        @cyjit
        def rates(d, t, y, args):
            into(t, carray(y, n), carray(args, m), carray(d, n))

        @njit
        def run(address, method, tol):
            y, d = start.copy(), begin.copy()
            for k in range(n_samples):
                state, numbers = act(k * period, y, d)
                for i in range(n):
                    y[i] = state[i]
                for i in range(m):
                    d[i] = numbers[i]
                span = (k * period, (k + 1) * period)
                result = nbsolve2_ivp(
                    address, span, y, method, np.array([span[1]]), args=d, rtol=tol, atol=tol
                )
                y = result.y[:, -1].copy()
                result.free()
            return y

        return run, rates.address

    def prepare(method, tol):
        run, address = loop()
        return lambda: run(address, method, tol)

    names = ("RK45", "DOP853", "Tsit5")
    return {f"CyRK {name} in a loop": functools.partial(prepare, name) for name in names}
