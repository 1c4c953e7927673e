"""Compiled Jacobians: the entries beside differences in sixty digits, and the block they share."""

import ctypes

import numpy as np
import pytest

from fastdyn.code_store import COUNTS
from fastdyn.compile.bind import bind, rebind
from fastdyn.compile.derivatives.jacobian import jacobian
from fastdyn.compile.mode import COMPLEX_NUMBERS, DERIVATIVE
from fastdyn.compile.python_callback import SIGNATURE
from fastdyn.compile.traced.make import Near
from fastdyn.systems import SYSTEMS
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat
from support.in_digits import differences

EPS = np.finfo(float).eps


def bound(fun, y0, args=(), mode=DERIVATIVE):
    return bind(fun, args, mode, len(y0), Near(0.0, 1.0, np.asarray(y0, float)))


def called(found, block, t, y):
    """(dense matrix, df/dt) by the machine code."""
    n, y = len(y), np.ascontiguousarray(y, dtype=float)
    out = np.full(found.size, np.nan)
    call = ctypes.cast(found.function.address, SIGNATURE)
    call(None, None, t, y.ctypes.data, n, block.ctypes.data, out.ctypes.data)
    matrix = np.zeros((n, n))
    matrix[found.rows, found.columns] = out[: len(found.rows)]
    return matrix, out[len(found.rows) :]


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_systems_of_the_course(name):
    """Each entry is off by what the roundings of its terms come to."""
    system = SYSTEMS[name]()
    y = np.asarray(system.initial_state(), float) + 0.01
    one = bound(system.rhs, y, system.args)
    matrix, by_time = called(jacobian(one.function, time=True), one.block, 0.3, y)
    g = one.function.traced.trace.graph
    wrt = [*[("y", i) for i in range(len(y))], ("t", 0)]
    values = flat([value for _, value in one.values])  # the graph may be of another test
    expected = differences(g, one.function.traced.stored, 0.3, y, values, wrt).astype(float)
    bound_ = 256 * EPS * np.abs(expected).max()
    assert np.abs(matrix - expected[:, :-1]).max() <= bound_
    assert np.abs(by_time - expected[:, -1]).max() <= bound_


def waves(t, u, c, shape):
    return c * (np.roll(u, 1) - 2 * np.sin(u) + np.roll(u, -1)) + shape * t


def test_large_ones_in_loops_with_new_parameters():
    n, rng = 300, np.random.default_rng(0)
    u, shape = rng.normal(size=n), rng.normal(size=n)
    one = bound(waves, u, (2.0, shape))
    found = jacobian(one.function, time=True)
    assert found.size == 3 * n + n
    for c in (2.0, -0.75):
        assert rebind(one, waves, (c, shape + c))
        matrix, by_time = called(found, one.block, 0.0, u)
        expected = np.diag(-2 * c * np.cos(u))
        for i in range(n):
            expected[i, i - 1] = expected[i, (i + 1) % n] = c
        assert np.abs(matrix - expected).max() <= 8 * EPS * abs(c)
        assert np.array_equal(by_time, shape + c)


def test_complex_states_have_the_jacobian_of_their_pairs():
    def fun(t, z):
        return [1j * z[0] * z[0] - z[1], z[0].conjugate() * (2 + t)]

    one = bound(fun, [0.3, 0.4, -0.2, 0.5], mode=COMPLEX_NUMBERS)
    matrix, by_time = called(jacobian(one.function, True), one.block, 0.5, [0.3, 0.4, -0.2, 0.5])
    d = 2j * (0.3 + 0.4j)
    assert np.allclose(matrix[:2, :2], [[d.real, -d.imag], [d.imag, d.real]], rtol=1e-15)
    assert np.array_equal(matrix[:2, 2:], -np.eye(2))
    assert np.array_equal(matrix[2:], [[2.5, 0, 0, 0], [0, -2.5, 0, 0]])
    assert np.array_equal(by_time, [0.0, 0.0, 0.3, -0.4])


def test_it_is_compiled_once_and_kept(monkeypatch):
    def fun(t, y, a):
        return [y[1], -a * np.sin(y[0]) + 0.123456789 * t]

    one = bound(fun, [0.1, 0.2], (2.0,))
    found = jacobian(one.function)
    assert jacobian(one.function) is found
    assert jacobian(one.function, time=True).size == found.size + 2
    one.function.notes.clear()
    before = COUNTS.copy()
    assert jacobian(one.function).function.key == found.function.key
    assert COUNTS["compiled"] == before["compiled"] and COUNTS["loaded"] > before["loaded"]


def test_the_dispatcher_has_the_bits_of_the_kept_code():
    from numba import njit

    from fastdyn.kernels.calls.user_function import inlined

    def fun(t, y, a):
        return [a * y[0] * np.sin(y[1]), -y[0] / (1 + y[1] ** 2)]

    y = [0.3, 0.7]
    one = bound(fun, y, (1.7,))
    found = jacobian(one.function)
    assert found.size == 4
    build = found.function.build()

    @njit
    def use(t, y, block):
        return inlined(build, t, y, block)

    mine = use(0.0, (0.3, 0.7, 0.0, 0.0), one.block)  # as many numbers out as in
    matrix, _ = called(found, one.block, 0.0, y)
    assert np.array_equal(np.array(mine), matrix.T.ravel())


def test_what_has_no_trace_has_none():
    def in_numba(t, y):
        total = 0.0
        for _ in range(int(abs(y[0]) * 10)):
            total += y[0]
        return [total]

    assert jacobian(bound(in_numba, [1.0]).function) is None
    assert jacobian(None) is None


def test_what_has_no_derivative_is_refused():
    import math

    one = bound(lambda t, y: [math.gamma(2.0 + y[0])], [0.5])
    with pytest.raises(Untraceable, match="tgamma"):
        jacobian(one.function)
