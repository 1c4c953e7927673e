"""Calls of the C++ reference through ctypes."""

import ctypes

import numpy as np

from .build import SOURCE, libraries

MANY = ("satellite", "building")  # by their numbers in lanes.cpp


def solvers(problem, order, rtol, atol):
    """Solve `problem` by each compiler's code.

    Parameters
    ----------
    problem : Problem
        Its `code` names the C++ function.
    order : {5, 8}
        DOPRI5 or DOP853; springs and bodies of any number have DOPRI5 only.
    rtol, atol : float
        Tolerances, as for SciPy.

    Returns
    -------
    dict
        {name: function of nothing returning (y_end, counts)}, where counts holds evaluations,
        accepted and rejected steps.  Arguments are converted here once, so that calling costs a
        microsecond beside the C++; the arrays returned are the same at every call.
    """
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    y0 = np.array(problem.y0, dtype=float)
    p = np.array([value for value in problem.args if isinstance(value, float)])
    result = {}
    for compiler, library in libraries().items():
        y, counts = np.empty_like(y0), (ctypes.c_long * 3)()
        given = (
            ctypes.c_int(order), ctypes.c_int(y0.size), *map(real, problem.t_span),
            y0.ctypes.data_as(pointer), y.ctypes.data_as(pointer), p.ctypes.data_as(pointer),
            real(rtol), real(atol), counts,
        )  # fmt: skip
        entry = getattr(library, problem.code)
        entry.restype = None

        def run(entry=entry, given=given, y=y, counts=counts):
            entry(*given)
            return y, counts

        result[f"C++ {compiler}"] = run
    return result


def batches():
    """{compiler: (one trajectory after the other, eight at once)}, C functions of lanes.cpp."""
    found = {}
    for compiler, library in libraries(SOURCE.with_name("lanes.cpp")).items():
        found[compiler] = library.solve_each, library.solve_lanes
        for entry in found[compiler]:
            entry.restype = ctypes.c_long
    return found


def together(entry, many, rtol, atol):
    """A function of nothing that solves all trajectories by one of `batches`."""
    y0, parameters, out = many.y0, many.parameters, np.empty_like(many.y0)
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    places = [a.ctypes.data_as(pointer) for a in (y0, parameters, out)]
    number, count = MANY.index(many.name), ctypes.c_long(len(y0))

    def run():
        entry(number, count, real(0.0), real(many.t_end), *places, real(rtol), real(atol))
        return out

    return run


def delayed(given, tol):
    """The end state of a `problems.delays.Delayed` by the first compiler: a function of nothing."""
    library = next(iter(libraries(SOURCE.with_name("delays.cpp")).values()))
    pointer, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    delays, history = np.array(given.delays), np.array(given.history)
    y, counts = np.empty_like(history), (ctypes.c_long * 2)()
    arguments = (
        delays.ctypes.data_as(pointer), real(given.end), history.ctypes.data_as(pointer),
        y.ctypes.data_as(pointer), real(tol), real(tol), counts,
    )  # fmt: skip
    entry = getattr(library, given.code)
    entry.restype = None

    def run(kept=(delays, history)):
        entry(*arguments)
        return y

    return run
