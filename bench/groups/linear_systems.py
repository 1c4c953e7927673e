"""Elimination beside C, in functions and in implicit methods; SymPy's pendulums beside SciPy."""

import ctypes
import functools
import time

import numpy as np
import scipy.integrate

import fastdyn
from fastdyn.code_store import OFFERED
from fastdyn.trace.operations.linear import FACTORS, SOLUTION

from ..cpp.build import SOURCE, libraries
from ..report.table import markdown

SIZES = (9, 10, 11, 12, 16, 24, 32, 40, 60)
GENERAL, SYMMETRIC = "general", "symmetric"  # matrices of np.linalg.solve
IMPLICIT = "of implicit methods"
LINKS = (5, 10)
GIVEN = {"rtol": 1e-8, "atol": 1e-8}
REPEATS = 20


def best(function, count=REPEATS):
    return alternately({"": function}, count)[""]


def alternately(functions, count):
    """The least time of each function; they run in turn, so that a busy machine meets all."""
    times = {name: [] for name in functions}
    for _ in range(count):
        for name, function in functions.items():
            begun = time.perf_counter()
            function()
            times[name].append(time.perf_counter() - begun)
    return {name: min(each) for name, each in times.items()}


def elimination(n, matrix):
    """Microseconds of a solution by the kernels, by C and by NumPy."""
    rng, count = np.random.default_rng(n), 2 + 2 * 10**5 // n**3
    m, v = rng.standard_normal((n, n)), rng.standard_normal(n)
    m = m @ m.T + np.eye(n) if matrix == SYMMETRIC else m
    functions, arrays = {"fastdyn": _by_kernels(m, v, matrix, count)}, []
    for compiler, library in libraries(SOURCE.with_name("elimination.cpp")).items():
        arrays += [np.ascontiguousarray(m.T), v, np.empty((n, n)), np.empty(n)]
        places = [ctypes.c_void_p(a.ctypes.data) for a in arrays[-4:]]
        given = ctypes.c_long(count), ctypes.c_long(n), *places
        functions[compiler] = functools.partial(library.solve_many, *given)
    times = alternately(functions, 150)
    for found in arrays[3::4]:
        np.testing.assert_allclose(found, np.linalg.solve(m, v), 1e-6, 1e-6)
    row = {"n": n, "matrix": matrix}
    row |= {f"{name}_us": 1e6 * each / count for name, each in times.items()}
    row["numpy_us"] = 1e6 * best(lambda: np.linalg.solve(m, v))
    return row


def _by_kernels(m, v, kind, count):
    """Many solutions by the kernels, called from compiled code."""
    import numba

    from fastdyn.kernels.algebra.padded.storage import leading

    n, ld = len(m), len(m) if kind == IMPLICIT else leading(len(m))
    enlarged, b = np.eye(ld), np.zeros(ld)
    enlarged[:n, :n], b[:n] = m.T, v
    matrix, solve = enlarged.ravel(), _of_methods() if kind == IMPLICIT else _of_functions(kind)

    @numba.njit
    def run(count, a, pivots, x):
        for _ in range(count):
            for i in range(len(matrix)):
                a[i] = matrix[i]
            for i in range(len(b)):
                x[i] = b[i]
            solve(a, pivots, x)

    room = np.empty_like(matrix), np.empty(2 * n), np.empty_like(b)
    run(1, *room)
    np.testing.assert_allclose(room[2][:n], np.linalg.solve(m, v), 1e-6, 1e-6)
    return lambda: run(count, *room)


def _of_functions(kind):
    """The solution as traced functions call it."""
    import numba

    from fastdyn.kernels.calls.calling_convention import invoke

    factors, solution = (OFFERED[symbol]().address for symbol in (FACTORS, SOLUTION))
    symmetric = kind == SYMMETRIC

    @numba.njit
    def solve(a, pivots, x):
        invoke(factors, (a, pivots, symmetric))
        invoke(solution, (a, pivots, x, 0))

    return solve


def _of_methods():
    """The solution of Radau, BDF, LSODA and Rodas5P, of a full matrix."""
    import numba

    from fastdyn.kernels.algebra import factorise as kernels

    @numba.njit
    def solve(a, pivots, x):
        n = len(x)
        kernels.factorise(a, n, pivots, n, n - 1, n - 1)
        kernels.solve(a, n, pivots, x, n, n - 1, n - 1)

    return solve


def pendulum(links):
    """SymPy's pendulum of links on a cart: functions with the full and the reduced mass matrix."""
    import sympy as sp
    from sympy.physics.mechanics.models import n_link_pendulum_on_cart

    kane = n_link_pendulum_on_cart(links, True, False)
    state, n = [*kane.q, *kane.u], links + 1
    plain = sp.symbols(f"w:{2 * n}")
    names = kane.mass_matrix_full.free_symbols | kane.forcing_full.free_symbols
    known = {s: 9.81 if str(s) == "g" else 1.0 for s in names - {sp.Symbol("t")}}
    known |= {sp.Function("F")(sp.Symbol("t")): 0.0}
    known |= dict(zip(state, plain, strict=True))

    def code(*parts):
        return sp.lambdify(plain, [part.xreplace(known) for part in parts], "numpy", cse=True)

    whole, half = (
        code(kane.mass_matrix_full, kane.forcing_full),
        code(kane.mass_matrix, kane.forcing),
    )

    def full(t, w):
        m, f = whole(*w)
        return np.linalg.solve(m, f.ravel())

    def reduced(t, w):
        m, f = half(*w)
        return np.concatenate([w[n:], np.linalg.solve(m, f.ravel())])

    start = np.concatenate([[0.0], np.linspace(0.3, 1.2, links), np.zeros(n)])
    return {"full": full, "reduced": reduced}, start


def rows(quick):
    """One row a size and matrix, and one a pendulum and form."""
    for matrix in (GENERAL, SYMMETRIC, IMPLICIT):
        for n in SIZES[:4] if quick else SIZES:
            yield elimination(n, matrix)
    for links in LINKS[:1] if quick else LINKS:
        forms, start = pendulum(links)
        for form, fun in forms.items():
            given = fun, (0.0, 5.0), start
            solve = functools.partial(fastdyn.solve_ivp, *given, **GIVEN)
            found, theirs = solve(), scipy.integrate.solve_ivp(*given, **GIVEN)
            mine = best(solve)
            by_scipy = best(functools.partial(scipy.integrate.solve_ivp, *given, **GIVEN), 2)
            yield {
                "links": links, "matrix": form, "rows": len(start) if form == "full" else links + 1,
                "fastdyn_ms": 1e3 * mine, "SciPy_ms": 1e3 * by_scipy, "gain": by_scipy / mine,
                "off": float(np.abs(found.y[:, -1] - theirs.y[:, -1]).max()),
            }  # fmt: skip


def summary(found):
    """A line a row: times, and the quotient with the first of C."""
    lines = []
    for row in found:
        name = f"{row['n']} rows" if "n" in row else f"{row['links']} links, {row['rows']} rows"
        times = [f"{k} {v:.3g}" for k, v in row.items() if k.endswith(("us", "ms", "gain"))]
        lines.append([name, row["matrix"], "; ".join(times)])
    return "\n".join(markdown(["system", "matrix", "times"], lines))
