"""Calls of libraries that are not written out: compiled code calls them, once an evaluation."""

import contextlib
import subprocess
import sys
import threading

import numpy as np
import pytest
import scipy.fft
import scipy.fftpack
import scipy.integrate
import scipy.interpolate
import scipy.linalg
import scipy.ndimage
import scipy.signal
import scipy.sparse.linalg
import scipy.special
import scipy.stats

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import make as by_tracing
from fastdyn.trace.graph.refusal import Untraceable

pytestmark = pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
N = 24
GRID = np.linspace(0.0, 1.0, N)
WAVES = np.sin(2 * np.pi * GRID) + GRID
MATRIX = np.array([[0.0, 1.0], [-1.0, -0.1]])
MASS = 4 * np.eye(N) + np.diag(np.ones(N - 1), 1) + np.diag(np.ones(N - 1), -1)
LU = scipy.linalg.lu_factor(MASS)
SPARSE_LU = scipy.sparse.linalg.splu(scipy.sparse.csc_array(MASS))
BAND = np.vstack([np.full(N, -0.25), np.full(N, 1.5), np.full(N, -0.25)])
SURFACE = scipy.interpolate.RectBivariateSpline(GRID, GRID, np.outer(GRID, GRID**2))
TABLE = scipy.interpolate.RegularGridInterpolator((GRID, GRID), np.outer(GRID, GRID**2))
DELAY = scipy.stats.gamma(a=4.0, scale=1.5)


@pytest.fixture(autouse=True)
def _whatever_it_takes(monkeypatch):
    monkeypatch.setattr(by_tracing, "SLOWER", np.inf)


def derivative(u, L):
    return scipy.fftpack.diff(u, period=L)


FIELDS = {  # of N numbers
    "fft": lambda t, u: np.fft.ifft(1j * GRID * np.fft.fft(u, 4099)[:N]).real - u,
    "rfft2": lambda t, u: np.fft.irfft2(np.fft.rfft2(u.reshape(6, 4)) * 0.5).ravel() - u,
    "fftpack.diff": lambda t, u: -derivative(u, 2.0) - u,
    "fftconvolve": lambda t, u: scipy.signal.fftconvolve(np.tanh(u), WAVES, mode="same") / N - u,
    "gaussian": lambda t, u: scipy.ndimage.gaussian_filter1d(u**2, 2.0 + 0 * t) - u,
    "lu_solve": lambda t, u: scipy.linalg.lu_solve(LU, np.sin(u)) - u,
    "solve_banded": lambda t, u: scipy.linalg.solve_banded((1, 1), BAND, u) - u,
    "sort": lambda t, u: np.sort(np.concatenate([u, u]))[:N] - u,
    "eigvalsh": lambda t, u: np.linalg.eigvalsh(np.outer(u, u) + MASS) / 9 - u,
}
PAIRS = {  # of two numbers
    "expm": lambda t, y: scipy.linalg.expm(MATRIX * np.sin(t)) @ y - y,
    "eigh": lambda t, y: np.linalg.eigh(MATRIX + MATRIX.T + y[0])[1] @ y - 2 * y,
    "jv": lambda t, y: [y[1], scipy.special.jv(0, 2 * t) + scipy.special.j1(y[0]) - y[0]],
    "ellipk": lambda t, y: scipy.special.ellipk(np.sin(y) ** 2 / 2) - y,
    "lambertw": lambda t, y: [y[1], -scipy.special.lambertw(1.5 + y[0]).real],
}  # fmt: skip
OBJECTS = {  # whose methods are called: (type, function of two numbers)
    "splu": ("SuperLU", lambda t, y: SPARSE_LU.solve(np.sin(np.resize(y, N)))[:2] - y),
    "surface": (
        "RectBivariateSpline",
        lambda t, y: [SURFACE.ev(y[0] ** 2, t / 9), -y[1] - SURFACE.ev(0.2, 0.3, dx=1)],
    ),
    "table": ("RegularGridInterpolator", lambda t, y: [TABLE([[t / 9, y[1] ** 2]])[0], -y[1]]),
    "distribution": ("rv_continuous_frozen", lambda t, y: [DELAY.pdf(t) - y[0], -y[1]]),
}


def agrees(fun, y0, span=(0.0, 2.0), **options):
    theirs = scipy.integrate.solve_ivp(fun, span, y0, rtol=1e-6, **options)
    mine = fastdyn.solve_ivp(fun, span, y0, rtol=1e-6, **options)
    assert (mine.status, mine.nfev) == (theirs.status, theirs.nfev)
    np.testing.assert_allclose(mine.y, theirs.y, 1e-6, 1e-5 * np.abs(theirs.y).max())


@pytest.mark.parametrize("name", FIELDS)
def test_a_field(name):
    agrees(FIELDS[name], WAVES)


@pytest.mark.parametrize("name", PAIRS)
def test_a_pair(name):
    agrees(PAIRS[name], [0.5, 0.3])


@pytest.mark.parametrize("name", OBJECTS)
def test_methods_of_objects_run_in_python(name):
    kind, fun = OBJECTS[name]
    with pytest.warns(fastdyn.CompileWarning, match=f"{kind}.*line"):
        agrees(fun, [0.5, 0.3])


@pytest.mark.parametrize("n", [70, 200])
def test_long_arrays(n):
    """In batches: one array to the library, one back."""
    kernel = np.exp(-(np.linspace(-2, 2, 41) ** 2))
    agrees(lambda t, u: np.convolve(np.tanh(u), kernel, "same") / 41 - u, np.linspace(0, 1, n))
    agrees(lambda t, u: scipy.ndimage.laplace(u.reshape(-1, 10), mode="wrap").ravel() - u,
           np.sin(np.arange(n)))  # fmt: skip


@pytest.mark.parametrize("n", [100, 300])
def test_a_large_complex_state(n):
    rng = np.random.default_rng(n)
    H = rng.normal(size=(n, n)) + 1j * rng.normal(size=(n, n))
    H = (H + H.conj().T) / np.sqrt(8 * n)
    start = np.zeros(n, complex)
    start[0] = 1.0
    agrees(lambda t, psi: -1j * (H @ psi), start)


@pytest.mark.few(2)
@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA", "DOP853"])
def test_other_methods(method):
    """Without an exact Jacobian where a method wants one."""
    fun = PAIRS["expm"]
    theirs = scipy.integrate.solve_ivp(fun, (0, 2), [1.0, 0.5], method, rtol=1e-8, atol=1e-8)
    mine = fastdyn.solve_ivp(fun, (0, 2), [1.0, 0.5], method, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], 1e-6)


def test_what_it_is_given_is_read_anew():
    matrix, period = MATRIX.copy(), 2.0

    def turned(t, y):
        return scipy.linalg.expm(matrix * np.sin(t)) @ y - y

    def fun(t, u):
        return -derivative(u, period) - u

    agrees(turned, [1.0, 0.5])
    agrees(fun, WAVES)
    matrix[0, 1], period = 2.0, 3.0
    agrees(turned, [1.0, 0.5])
    agrees(fun, WAVES)


def test_another_function_of_the_same_form_is_another():
    def fun(t, u):
        return transform(u, 4099).real[:N] / N - u

    transform = np.fft.fft
    agrees(fun, WAVES)
    transform = scipy.fft.fft
    agrees(fun, WAVES)
    transform = np.fft.ifft
    agrees(fun, WAVES)


def test_an_exception_is_that_of_the_library():
    def fun(t, y):
        np.linalg.cholesky(np.array([[1.0, y[0]], [y[0], 1.0]]))
        return [1.0]

    def used(t, y):
        return [1.0 + 0 * np.linalg.cholesky(np.array([[1.0, y[0]], [y[0], 1.0]]))[1, 1]]

    for function in (fun, used):
        with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
            fastdyn.solve_ivp(function, (0, 5), [0.0])


def test_a_result_of_another_form_is_python_s():
    """Real eigenvalues turn complex: an array of another type, before NumPy 2.5."""

    def fun(t, y):
        return [np.abs(np.linalg.eigvals(np.array([[0.0, 1.0], [1.0 - y[0], 0.0]])))[0]]

    theirs = scipy.integrate.solve_ivp(fun, (0, 3), [0.0])
    one_type = np.iscomplexobj(np.linalg.eigvals(np.eye(2)))
    warned = pytest.warns(fastdyn.CompileWarning, match="could not go on")
    with contextlib.nullcontext() if one_type else warned:
        mine = fastdyn.solve_ivp(fun, (0, 3), [0.0])
    np.testing.assert_allclose(mine.y, theirs.y, 1e-6)


def test_threads():
    fun, found = PAIRS["expm"], {}

    def solve(i):
        found[i] = fastdyn.solve_ivp(fun, (0, 2), [1.0, 0.1 * i], rtol=1e-8).y

    fastdyn.solve_ivp(fun, (0, 2), [1.0, 0.0], rtol=1e-8)
    threads = [threading.Thread(target=solve, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i, y in found.items():
        theirs = scipy.integrate.solve_ivp(fun, (0, 2), [1.0, 0.1 * i], rtol=1e-8)
        np.testing.assert_allclose(y, theirs.y, 1e-8)


def test_an_ensemble():
    def fun(t, y, k):
        return scipy.linalg.expm(MATRIX * k) @ y - y

    k = np.linspace(0.5, 1.0, 5)
    mine = fastdyn.solve_ensemble(fun, (0, 2), np.tile([1.0, 0.5], (5, 1)), args=(k,), rtol=1e-8)
    for i in range(5):
        theirs = scipy.integrate.solve_ivp(fun, (0, 2), [1.0, 0.5], args=(k[i],), rtol=1e-10,
                                           atol=1e-10)  # fmt: skip
        np.testing.assert_allclose(mine.y[i], theirs.y[:, -1], 1e-4)


def test_there_is_no_series():
    with pytest.raises(ValueError, match="a call of a library"):
        fastdyn.solve_ivp(PAIRS["expm"], (0, 2), [1.0, 0.5], "Taylor")


def test_kept_code_holds_in_another_process():
    """Addresses of libraries lie in the block, and are those of the process."""
    script = (
        "import numpy as np, scipy.linalg, fastdyn\n"
        "A = np.array([[0.0, 1.0], [-1.0, -0.1]])\n"
        "def fun(t, y):\n    return scipy.linalg.expm(A * np.sin(t)) @ y - y\n"
        "print(repr(fastdyn.solve_ivp(fun, (0, 2), [1.0, 0.5]).y[:, -1].tolist()))\n"
    )
    found = [
        subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    theirs = scipy.integrate.solve_ivp(PAIRS["expm"], (0, 2), [1.0, 0.5]).y[:, -1]
    for each in found:  # in Python, where that took less time
        np.testing.assert_allclose(eval(each), theirs, 1e-10)


def test_what_is_slower_than_python_stays_there(monkeypatch):
    def fun(t, y):
        return scipy.linalg.expm(MATRIX * np.cos(t)) @ y - y

    monkeypatch.setattr(by_tracing, "SLOWER", 0.0)
    with pytest.raises(Untraceable, match="as long in Python"):
        by_tracing._traced(
            fun, (), DERIVATIVE, 2, by_tracing.Near(0.0, 1.0, np.ones(2)), (), "all", False
        )
