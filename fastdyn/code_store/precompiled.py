"""Compiled kernels of a wheel: object files for levels of a processor, named by content.

The files depend on the sources that make kernels and on the level, not on the versions of Python,
NumPy or Numba.  A kernel is compiled in the process if these sources have changed, if its file does
not load, or if the settings of Numba have changed.
"""

import functools
import hashlib

from .key.sources import OBJECTS, sources
from .numba_settings import changed

_V2 = ("cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3")
_V3 = (*_V2, "avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
_V4 = (*_V3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
_X86 = {"x86-64-v4": _V4, "x86-64-v3": _V3, "x86-64-v2": _V2}  # the System V ABI's, best first
_ARM = {"generic": ()}  # LLVM's name of Armv8-A with vectors of two numbers: any aarch64
LEVELS = {  # levels with their features, by LLVM's triple of the process
    "x86_64-unknown-linux-gnu": _X86,
    "x86_64-pc-linux-gnu": _X86,
    "aarch64-unknown-linux-gnu": _ARM,
}


@functools.cache
def level():
    """The level of this process; None without files, or with changed settings of Numba."""
    return None if changed() or not OBJECTS.is_dir() else best_level()


def best_level():
    """The best level that this processor supports; None on systems without levels.

    None, too, where the level lacks the processor's fused products and sums: kernels that are
    compiled in the process would have other bits.
    """
    import llvmlite.binding as llvm

    levels = LEVELS.get(llvm.get_process_triple(), {})
    features = llvm.get_host_cpu_features() if any(levels.values()) else {}
    best = next((k for k, needs in levels.items() if all(map(features.get, needs))), None)
    return best if best is None or not features.get("fma") or "fma" in levels[best] else None


def symbol_of(key, made_by, level):
    """The name of the code of a kernel for a level; `made_by` are the sources of the kernel."""
    text = f"precompiled {sources(made_by)} {level} {key}"
    return f"fastdyn_{hashlib.sha256(text.encode()).hexdigest()}"


def entry(key, made_by):
    """(bytes, symbol) of the file of a kernel; None if there is none for this processor."""
    found = level()
    if found is None:
        return None
    symbol = symbol_of(key, made_by, found)
    try:
        return (OBJECTS / found / f"{symbol.removeprefix('fastdyn_')}.o").read_bytes(), symbol
    except OSError:
        return None
