"""Many trajectories of one problem, by fastdyn and by each rival: functions that solve them all."""

import ctypes

import numpy as np

from fastdyn import solve_ensemble

RTOL, ATOL = 1e-6, 1e-9


def fastdyn(fun, end, y0, parameters, lanes, threads, method="RK45", rtol=RTOL, atol=ATOL):
    same = (parameters == parameters[0]).all(axis=0)
    args = tuple(
        float(p[0]) if all_same else np.ascontiguousarray(p)
        for p, all_same in zip(parameters.T, same, strict=True)
    )
    options = {"rtol": rtol, "atol": atol, "lanes": lanes, "threads": threads}
    return lambda: solve_ensemble(fun, (0.0, end), y0, args, method, **options).y_end


def by_scipy(fun, end, y0, parameters):
    from scipy.integrate import solve_ivp

    def run():
        return np.array([
            solve_ivp(fun, (0.0, end), y, args=tuple(p), rtol=RTOL, atol=ATOL).y[:, -1]
            for y, p in zip(y0, parameters, strict=True)
        ])  # fmt: skip

    return run


def cyrk(fun, end, y0, parameters):
    from CyRK import cyjit, nbsolve2_ivp
    from numba import carray, njit

    user, n, m = njit(fun), y0.shape[1], parameters.shape[1]
    to_tuple = _unpacker(m)

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
                address, (0.0, end), y0[i], "RK45", np.array([end]), args=parameters[i],
                rtol=RTOL, atol=ATOL,
            )  # fmt: skip
            out[i] = result.y[:, -1]
            result.free()
        return out

    return lambda: run(rates.address, y0, parameters)


def _unpacker(m):
    from numba import njit
    from numba.cpython.unsafe.tuple import tuple_setitem

    zeros = (0.0,) * m

    @njit
    def to_tuple(p):
        given = zeros
        for i in range(m):
            given = tuple_setitem(given, i, p[i])
        return given

    return to_tuple


def numbalsoda(fun, end, y0, parameters):
    from numba import carray, cfunc, njit
    from numbalsoda import dop853, lsoda_sig

    user, n, m, to_tuple = (
        njit(fun),
        y0.shape[1],
        parameters.shape[1],
        _unpacker(parameters.shape[1]),
    )

    @cfunc(lsoda_sig)
    def rates(t, y, d, p):
        found = user(t, carray(y, (n,)), *to_tuple(carray(p, (m,))))
        for i in range(n):
            d[i] = found[i]

    address, times = rates.address, np.array([0.0, end])

    @njit(nogil=True)
    def run(y0, parameters):
        out = np.empty_like(y0)
        for i in range(len(y0)):
            found, _ = dop853(address, y0[i], times, parameters[i], RTOL, ATOL)
            out[i] = found[-1]
        return out

    return lambda: run(y0, parameters)


def heyoka(fun, end, y0, parameters):
    import heyoka as hy

    n, m = y0.shape[1], parameters.shape[1]
    y = hy.make_vars(*(f"y{i}" for i in range(n)))
    p = [hy.par[i] for i in range(m)]
    if fun.__name__ == "orbit":
        r2 = y[0] * y[0] + y[1] * y[1]
        rates = [y[2], y[3], -p[0] * y[0] * r2**-1.5, -p[0] * y[1] * r2**-1.5]
    else:
        s = p[3] * hy.sin(p[2] * hy.time)
        lower, upper = 2.0 * p[0] * (y[0] - s - p[4]), 2.0 * p[0] * (y[1] - y[0] - p[4])
        rates = [y[2], y[3], (upper - lower) / p[1] - p[5], -upper / p[1] - p[5]]
    width = hy.recommended_simd_size()
    run_of = hy.taylor_adaptive_batch(
        list(zip(y, rates, strict=True)), np.zeros((n, width)), tol=RTOL, pars=np.zeros((m, width))
    )

    def run():
        out = np.empty_like(y0)
        for i in range(0, len(y0) - width + 1, width):
            run_of.set_time(0.0)
            run_of.state[:], run_of.pars[:] = y0[i : i + width].T, parameters[i : i + width].T
            run_of.propagate_until(end)
            out[i : i + width] = run_of.state.T
        return out

    return run


RIVALS = {"CyRK": cyrk, "numbalsoda DOP853": numbalsoda, "heyoka batch": heyoka}


def cpp(entry, number, end, y0, parameters):
    out = np.empty_like(y0)
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    places = [a.ctypes.data_as(pointer) for a in (y0, parameters, out)]

    def run():
        entry(number, ctypes.c_long(len(y0)), real(0.0), real(end), *places, real(RTOL), real(ATOL))
        return out

    return run
