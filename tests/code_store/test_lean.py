"""Kernels are compiled with less work than Numba's: without counts of references, which they lack.

A kernel that made an array would never free it, so that no kernel may need memory.
"""

import gc
import os
import subprocess
import sys

import pytest

from fastdyn.code_store import cache
from fastdyn.code_store.deferred import deferred
from fastdyn.code_store.folders import folders
from fastdyn.code_store.object_file import unpacked
from fastdyn.specialise import scalar

ALLOCATE = {"malloc", "realloc", "calloc"}


def needs_of(recipe):
    """The symbols that the kept code of a kernel calls; None if the kernel is not kept."""
    symbol = cache._symbol(recipe.key, recipe.made_by)
    for data in folders.entries(cache._file(symbol)):
        return set(unpacked(data, symbol)[0]["needs"])
    return None


def test_no_kernel_needs_memory():
    """Kernels on disk are examined here, and all kernels by `make wheel`."""
    for kernel in (scalar.watch_events_kernel, scalar.all_roots_kernel, scalar.whole_solve_kernel):
        kernel()
    kept = [needs_of(recipe) for recipe in scalar.every_kernel().values()]
    kept = [needs for needs in kept if needs is not None]
    assert len(kept) >= 3
    assert [needs & ALLOCATE for needs in kept if needs & ALLOCATE] == []


@pytest.mark.parametrize("collects", [True, False])
def test_no_garbage_is_collected_while_numba_compiles(collects):
    before = gc.isenabled()
    try:
        (gc.enable if collects else gc.disable)()
        with pytest.raises(ZeroDivisionError), deferred():
            with deferred():
                assert not gc.isenabled()
            assert not gc.isenabled()
            raise ZeroDivisionError
        assert gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()


SOLVE = """
import numba.core.compiler
if {missing}:
    del numba.core.typed_passes.BaseNativeLowering
import fastdyn
from fastdyn.kernels.jit.options import INTERNAL
assert ("pipeline_class" in INTERNAL) != {missing}
r = fastdyn.solve_ivp(lambda t, y: (y[1], -y[0]), (0, 9), [1.0, 0.0], events=lambda t, y: y[0])
print(r.y.tobytes().hex(), r.t_events[0].tobytes().hex())
"""


@pytest.mark.hunt
def test_without_the_inner_parts_of_numba_kernels_have_the_same_bits(tmp_path):
    def bits(missing):
        env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / str(missing))}
        text = SOLVE.format(missing=missing)
        return subprocess.run(
            [sys.executable, "-c", text], env=env, check=True, capture_output=True
        ).stdout

    assert bits(False) == bits(True) != b""
