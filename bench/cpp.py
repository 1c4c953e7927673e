"""The C++ reference: compiled by every compiler there is, called through ctypes."""

import ctypes
import functools
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np

SOURCE = pathlib.Path(__file__).with_name("reference.cpp")
COMPILERS = {"clang++": [], "g++": ["-fno-tree-slp-vectorize"]}
COMMON = ["-std=c++17", "-Wno-psabi", "-O3", "-march=native", "-fPIC", "-shared"]


@functools.cache
def libraries(source=SOURCE):
    """{compiler: library} of a source for the compilers that are installed."""
    found = {}
    with tempfile.TemporaryDirectory(prefix="fastdyn-bench-") as folder:
        for compiler, flags in COMPILERS.items():
            if shutil.which(compiler):
                out = pathlib.Path(folder, f"{compiler}.so")
                subprocess.run([compiler, *COMMON, *flags, str(source), "-o", str(out)], check=True)
                found[compiler] = ctypes.CDLL(str(out))  # loaded, it needs its file no more
    if not found:
        print("no C++ compiler (clang++ or g++) found: rows have no C++ column")
    return found


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
