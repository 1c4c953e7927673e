"""The kernels of all methods as object files in the package, for a wheel.

    NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= python -m fastdyn.specialise.precompile

A process writes the files for one level of processor, given by the settings of Numba.
"""

import time

from fastdyn.code_store import Unsealable, emit_object, precompiled, target
from fastdyn.code_store.deferred import deferred
from fastdyn.code_store.key.sources import FUNCTIONS, KERNELS, OBJECTS, ship
from fastdyn.code_store.object_file import packed

from . import dispatchers
from .scalar import every_kernel


def write(level):
    """Write all files of a level; returns their number and size in bytes."""
    triple, cpu, features = target.processor()
    if (cpu, features) != (level, "") or level not in precompiled.LEVELS.get(triple, ()):
        raise Unsealable(f"Numba is set to {cpu} {features!r} on {triple}, not to {level}")
    folder = OBJECTS / level
    total = 0
    folder.mkdir(parents=True, exist_ok=True)
    for file in folder.iterdir():
        file.unlink()
    kernels = every_kernel()
    for key, recipe in kernels.items():
        symbol = precompiled.symbol_of(key, recipe.made_by, level)
        with deferred():
            dispatcher, signature = recipe.make(dispatchers)
            code, needs, arguments = emit_object.of(dispatcher, signature, symbol)
        if "malloc" in needs:  # memory that nothing would free: see kernels/jit/pipeline.py
            raise Unsealable(f"the kernel {key!r} allocates memory")
        data = packed({"symbol": symbol, "needs": needs, "arguments": arguments, "key": key}, code)
        (folder / f"{symbol.removeprefix('fastdyn_')}.o").write_bytes(data)
        total += len(data)
    ship(KERNELS, FUNCTIONS)
    return len(kernels), total


def main():
    """Write the files of the level in Numba's settings."""
    began = time.perf_counter()
    level = target.processor()[1]
    n, total = write(level)
    print(f"{level}: {n} kernels, {total / 1e6:.2f} MB, {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
