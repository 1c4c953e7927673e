"""Kernels that few solves of implicit methods need are compiled when a solve calls one."""

import ctypes

import numpy as np
import pytest

import fastdyn
from fastdyn.specialise import rare

METHODS = ("Radau", "BDF", "LSODA", "Rodas5P")


@pytest.fixture(params=range(len(rare.KERNELS)), ids=[name for name, _ in rare.KERNELS])
def cannot_be_compiled(request, monkeypatch):
    """One of the kernels is not loaded yet, and its compilation is interrupted."""

    def interrupted():
        raise KeyboardInterrupt

    at, before = request.param, rare.addresses.copy()
    monkeypatch.setattr(rare, "kernel_for_all", lambda name: interrupted)
    stand_in = rare._stand_in(at, *rare.KERNELS[at])
    rare.addresses[at] = ctypes.cast(stand_in, ctypes.c_void_p).value
    yield rare.KERNELS[at][0]
    rare.addresses[:] = before


def falling(t, y):
    return [-100.0 * y[0] + y[1], y[0] - y[1]]


def in_python(t, y):
    """Differences find a diagonal Jacobian, which our own elimination takes."""
    return [-100.0 * float(str(y[0])), -float(str(y[1]))]


def solve(fun, method):
    return fastdyn.solve_ivp(fun, (0, 1), [1.0, 2.0], method)


@pytest.mark.parametrize("method", METHODS)
def test_small_traced_equations_need_none(cannot_be_compiled, method):
    assert solve(falling, method).success


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:in_python")
def test_what_the_compilation_raises_ends_the_solve(cannot_be_compiled, method):
    lsoda = method == "LSODA" and cannot_be_compiled == "other jacobian"  # its own differences
    if lsoda or ("complex" in cannot_be_compiled and method != "Radau"):
        assert solve(in_python, method).success
        return
    with pytest.raises(KeyboardInterrupt):
        solve(in_python, method)
    assert not rare._failures


def test_all_implicit_methods_share_the_kernels():
    for method in METHODS:
        found = solve(in_python, method)
        assert np.allclose(found.y[1, -1], 2.0 * np.exp(-1.0), rtol=1e-2)
