"""Long complex arrays that depend on the state: their code gives what NumPy gives."""

import numpy as np
import pytest
import scipy.fft
import scipy.sparse
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import COMPLEX_NUMBERS, DERIVATIVE
from fastdyn.compile.traced.make import Near

N = 96  # 8 rows of 12
RNG = np.random.default_rng(5)
H = RNG.normal(size=(N, N)) + 1j * RNG.normal(size=(N, N))
SMALL, REAL = H[:8, :8].copy(), H[:8, :8].real + 0j
V, K = np.linspace(0, 2, N), np.fft.fftfreq(N) * 20
L = scipy.sparse.diags([1.0, -2.0, 1.0], [-1, 0, 1], shape=(N, N), format="csr")
LC = (1j * L + scipy.sparse.eye(N)).tocsr()


def stencil(t, y):
    found = np.zeros_like(y)
    found[1:-1] = y[2:] - 2 * y[1:-1] + y[:-2]
    return 1j * found - 1j * (V + np.abs(y) ** 2) * y


def master(t, y):
    rho = y.reshape(8, 12)
    found = np.zeros((8, 12), dtype=complex)
    found += -1j * (SMALL @ rho) + REAL @ rho
    found -= 0.5 * SMALL.conj().T @ rho * np.cos(t)
    found[0, 1:3] = 2j * t
    return found.ravel()


def parts(t, y):
    found = y.copy()
    found.real[::2] = y.imag[::2]
    found.imag[1] = 3.0
    rows = found.reshape(8, 12)
    rows[2] *= 1j
    rows[:, 0] += y[:8].conj()
    return found


def through_real(t, y):
    both = y.view(float)
    return (np.sin(both) + 0.1).view(complex)


def spectral(t, y):
    u = np.fft.ifft(np.exp(1j * K * t) * y).real
    return -3j * K * np.exp(-1j * K * t) * np.fft.fft(u**2)


FUNCTIONS = {
    "a number": lambda t, y: -1j * y,
    "backwards": lambda t, y: np.conj(y)[::-1],
    "a dense matrix": lambda t, y: -1j * (H @ y) + y @ H + H.dot(y) * np.exp(1j * t),
    "a stencil": stencil,
    "matrices": master,
    "parts": parts,
    "through real": through_real,
    "spectral": spectral,
    "scipy.fft": lambda t, y: scipy.fft.ifft(y, norm="ortho") + scipy.fft.fft(y, norm="forward"),
    "rfft": lambda t, y: y + np.fft.irfft(np.fft.rfft(y.real) * y[:49], n=N),
    "irfft": lambda t, y: 1j * np.fft.irfft(y[:49]),
    "fft2": lambda t, y: np.fft.fft2(np.tile(y, 11)[: 32 * 32].reshape(32, 32)).ravel()[:N],
    "an axis": lambda t, y: np.fft.fft(np.tile(y, 4).reshape(32, 12), axis=0).ravel()[:N],
    "sparse": lambda t, y: L @ y + LC @ y,
    "einsum": lambda t, y: np.einsum("ij,jk->ik", SMALL, y.reshape(8, 12)).ravel() * np.vdot(y, y),
    "sums": lambda t, y: y * np.sum(y) + np.mean(y) * np.linalg.norm(y),
    "a trace": lambda t, y: y * np.trace(y.reshape(8, 12)),
    "where": lambda t, y: np.where(np.abs(y) > 1, y, 2j * y.conj()) + np.roll(y, 1).real,
    "joined": lambda t, y: np.concatenate([y[:40].imag, y[40:60], 1j * V[:36]]),
    "stacked": lambda t, y: np.hstack([y[1:], 0]) + np.vstack([y[:48], y[48:]]).T.ravel(),
    "functions": lambda t, y: np.angle(y) + np.sqrt(y) + np.log(y) / np.exp(np.sin(y / 9)) + y**3,
    "diff": lambda t, y: np.gradient(y, 0.1) + np.append(np.diff(y), 1j) + np.cumsum(y),
    "a list": lambda t, y: [1j * v for v in y[:48]] + list(y[48:] * 2),
    "outer": lambda t, y: np.outer(y[:8], y[:12].conj()).ravel() + np.array([1j] * N),
}  # fmt: skip


@pytest.mark.few(8)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_code_is_the_function(name):
    fun = FUNCTIONS[name]
    y = RNG.normal(size=N) + 1j * RNG.normal(size=N)
    bound = bind(fun, (), COMPLEX_NUMBERS, 2 * N, Near(0.0, 1.0, y.view(float), True))
    assert bound.function is not None
    assert bound.function.traced.in_batches
    for t in (0.0, 0.3):
        z = RNG.normal(size=N) + 1j * RNG.normal(size=N)
        expected = np.asarray(fun(t, z.copy()), complex)
        found = machine_value(bound, t, z.view(float)).view(complex)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_a_real_state_is_seen_as_a_complex_one():
    def fun(t, y):
        z = y.view(complex)
        dz = -1j * (1 + np.abs(z) ** 2) * z
        return dz.view(float)

    y = RNG.normal(size=N)
    bound = bind(fun, (), DERIVATIVE, N, Near(0.0, 1.0, y, True))
    assert bound.function is not None and bound.function.traced.in_batches
    np.testing.assert_allclose(machine_value(bound, 0.0, y), fun(0.0, y), rtol=1e-12)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("late", [False, True])
def test_a_store_behind_a_view_of_another_type_is_not_lost(late):
    def fun(t, y):
        z = (1j * y).copy()
        both = z.view(float)
        if late:
            z[0] = 7.0
        else:
            both[0] = 7.0
        return both.view(complex) if late else z

    y = RNG.normal(size=N) + 1j * RNG.normal(size=N)
    mine, theirs = (solver(fun, (0, 0.1), y) for solver in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9)


def test_a_real_matrix_of_complex_type_may_become_complex():
    matrix = RNG.normal(size=(N, N)).round(2)[:40, :40] + 0j

    def fun(t, y):
        return -1j * (matrix @ y)

    y = np.ones(40, complex)
    for entry in (0.5, 2j):
        matrix[3, 4] = entry
        mine, theirs = (solver(fun, (0, 0.1), y) for solver in (fastdyn.solve_ivp, reference))
        np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "BDF"])
def test_solutions_are_scipys(method):
    y = np.exp(-((np.arange(70) - 30) ** 2) / 20) + 0j

    def fun(t, y):
        return -1j * (np.roll(y, 1) + np.roll(y, -1) - 2 * y + np.abs(y) ** 2 * y)

    mine, theirs = (
        solver(fun, (0, 1.0), y, method=method, rtol=1e-7, atol=1e-9)
        for solver in (fastdyn.solve_ivp, reference)
    )
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-6, atol=1e-8)
    assert method == "BDF" or mine.nfev == theirs.nfev


def test_a_long_complex_state_that_is_traced_number_by_number():
    def fun(t, y):
        return [1j * a * abs(b) for a, b in zip(y, reversed(list(y)), strict=True)]

    y = RNG.normal(size=80) + 1j * RNG.normal(size=80)
    bound = bind(fun, (), COMPLEX_NUMBERS, 160, Near(0.0, 1.0, y.view(float)))
    assert bound.function is not None
    found = machine_value(bound, 0.0, y.view(float)).view(complex)
    np.testing.assert_allclose(found, fun(0.0, y), rtol=1e-12)
