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
COMMON = ["-std=c++17", "-O3", "-march=native", "-fPIC", "-shared"]


@functools.cache
def libraries():
    """{compiler: library} for the compilers that are installed."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="fastdyn-bench-"))
    found = {}
    for compiler, flags in COMPILERS.items():
        if shutil.which(compiler):
            out = folder / f"{compiler}.so"
            subprocess.run([compiler, *COMMON, *flags, str(SOURCE), "-o", str(out)], check=True)
            found[compiler] = ctypes.CDLL(str(out))
    if not found:
        print("no C++ compiler (clang++ or g++) found: rows have no C++ column")
    return found


def solvers(problem, order, rtol, atol):
    """{name: function returning (y_end, nfev)}, one for each compiler."""
    pointer = ctypes.POINTER(ctypes.c_double)
    real = ctypes.c_double
    result = {}
    for compiler, library in libraries().items():
        entry = getattr(library, problem.name)
        entry.argtypes = [
            ctypes.c_int, real, real, pointer, pointer, real, real, ctypes.POINTER(ctypes.c_long),
        ]  # fmt: skip
        entry.restype = None

        def run(entry=entry):
            y = np.array(problem.y0, dtype=float)
            p = np.array(problem.args)
            counts = (ctypes.c_long * 3)()
            entry(
                order, *problem.t_span, y.ctypes.data_as(pointer), p.ctypes.data_as(pointer),
                rtol, atol, counts,
            )  # fmt: skip
            return y, counts[0]

        result[f"C++ {compiler}"] = run
    return result
