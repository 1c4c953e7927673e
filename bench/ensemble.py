"""Trajectories a second: one function with many initial states or parameters, one core and two."""

import ctypes
import math

import numpy as np

from fastdyn import solve_ensemble
from fastdyn.systems import building

from .cpp import batches
from .timing import interleaved

RTOL, ATOL = 1e-6, 1e-9


def orbit(t, w, GM):
    """Point mass on a plane orbit: [x, y, vx, vy]."""
    x, y, vx, vy = w
    r2 = x * x + y * y
    c = -GM / (r2 * math.sqrt(r2))
    return [vx, vy, c * x, c * y]


def floors(t, w, k, m, omega, d, L, g):
    """The two-storey building: [y1, y2, v1, v2]."""
    y1, y2, v1, v2 = w
    s = d * math.sin(omega * t)
    lower, upper = 2.0 * k * (y1 - s - L), 2.0 * k * (y2 - y1 - L)
    return [v1, v2, (upper - lower) / m - g, -upper / m - g]


def orbits(count):
    """(function, end, states, parameters (count, n)) of satellites with many speeds."""
    y0 = np.zeros((count, 4))
    y0[:, 0], y0[:, 3] = 1.0, np.random.default_rng(0).uniform(0.8, 1.2, count)
    return orbit, 100.0, y0, np.ones((count, 1))


def buildings(count):
    """The same of buildings over ground of many frequencies."""
    system = building()
    parameters = np.tile(system.args[:6], (count, 1))
    parameters[:, 2] = np.linspace(1.0, 30.0, count)
    return floors, 20.0, np.tile(system.initial_state(), (count, 1)), parameters


PROBLEMS = {"satellite": orbits, "building": buildings}


def _fastdyn(fun, end, y0, parameters, lanes, threads, method="RK45", rtol=RTOL, atol=ATOL):
    same = (parameters == parameters[0]).all(axis=0)
    args = tuple(
        float(p[0]) if all_same else np.ascontiguousarray(p)
        for p, all_same in zip(parameters.T, same, strict=True)
    )
    options = {"rtol": rtol, "atol": atol, "lanes": lanes, "threads": threads}
    return lambda: solve_ensemble(fun, (0.0, end), y0, args, method, **options).y_end


def _scipy(fun, end, y0, parameters):
    from scipy.integrate import solve_ivp

    def run():
        return np.array([
            solve_ivp(fun, (0.0, end), y, args=tuple(p), rtol=RTOL, atol=ATOL).y[:, -1]
            for y, p in zip(y0, parameters, strict=True)
        ])  # fmt: skip

    return run


def _cyrk(fun, end, y0, parameters):
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


def _numbalsoda(fun, end, y0, parameters):
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


def _heyoka(fun, end, y0, parameters):
    import heyoka as hy

    n, m = y0.shape[1], parameters.shape[1]
    y = hy.make_vars(*(f"y{i}" for i in range(n)))
    p = [hy.par[i] for i in range(m)]
    if fun is orbit:
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


RIVALS = {"CyRK": _cyrk, "numbalsoda DOP853": _numbalsoda, "heyoka batch": _heyoka}


def _cpp(entry, number, end, y0, parameters):
    out = np.empty_like(y0)
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    places = [a.ctypes.data_as(pointer) for a in (y0, parameters, out)]

    def run():
        entry(number, ctypes.c_long(len(y0)), real(0.0), real(end), *places, real(RTOL), real(ATOL))
        return out

    return run


def _error(found, exact):
    """Median over the trajectories of the largest error of a component."""
    return float(np.nanmedian(abs(found - exact).max(axis=1)))


def _as_accurate(given, exact, rival):
    """fastdyn's pairs at the loosest tolerance that comes as close as the rival."""
    level, runs = _error(rival(), exact), {}
    for method in ("RK45", "DOP853", "Vern7", "Vern9"):
        for k in range(6, 12):
            run = _fastdyn(*given, "auto", 1, method, 10.0**-k, 10.0 ** -(k + 3))
            if _error(run(), exact) <= level:
                runs[f"fastdyn {method}, 1 core, heyoka's error (rtol 1e-{k})"] = run
                break
    return runs


def rows(quick):
    """One row a problem and solver."""
    count = 104 if quick else 10_000
    for number, (problem, make) in enumerate(PROBLEMS.items()):
        if quick and number > 0:
            return
        fun, end, y0, parameters = make(count)
        given = fun, end, y0, parameters
        tight = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
        exact = _fastdyn(*given, "scalar", None, **tight)()
        runs = {
            "fastdyn, 1 core": _fastdyn(*given, "auto", 1),
            "fastdyn, 2 cores": _fastdyn(*given, "auto", 2),
            "fastdyn one by one, 1 core": _fastdyn(*given, "scalar", 1),
        }
        for name, (each, lanes) in batches().items():
            runs[f"C++ {name}"] = _cpp(each, number, end, y0, parameters)
            runs[f"C++ {name}, 8 lanes by hand"] = _cpp(lanes, number, end, y0, parameters)
        for name, adapter in RIVALS.items():
            try:
                runs[name] = adapter(*given)
            except ImportError as error:
                print(f"skipped {name}: {error}")
        if "heyoka batch" in runs:
            runs |= _as_accurate(given, exact, runs["heyoka batch"])
        few = slice(0, count, max(1, count // (4 if quick else 20)))
        runs["SciPy"] = _scipy(fun, end, y0[few], parameters[few])
        errors = {}
        for name, run in runs.items():
            expected = exact[few] if name == "SciPy" else exact
            errors[name] = _error(run(), expected)
        times = interleaved(runs, 3 if quick else 9, 0.1 if quick else 60.0)
        for name, (least, median) in times.items():
            n = len(y0[few]) if name == "SciPy" else count
            yield {
                "problem": problem,
                "solver": name,
                "median_error": errors[name],
                "a_second": n / least,
                "a_second_median": n / median,
            }
