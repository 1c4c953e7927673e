"""The C++ sources, compiled by every compiler there is."""

import ctypes
import functools
import pathlib
import shutil
import subprocess
import tempfile

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
