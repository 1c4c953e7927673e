"""Functions of libraries without a formula run in Python, and a warning names them."""

import contextlib

import numpy as np
import pytest
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

N = 24
GRID = np.linspace(0.0, 1.0, N)
WAVES = np.sin(2 * np.pi * GRID) + GRID
MATRIX = np.array([[0.0, 1.0], [-1.0, -0.1]])
MASS = 4 * np.eye(N) + np.diag(np.ones(N - 1), 1) + np.diag(np.ones(N - 1), -1)
LU = scipy.linalg.lu_factor(MASS)
SPARSE_LU = scipy.sparse.linalg.splu(scipy.sparse.csc_array(MASS))
BAND = np.vstack([np.full(N, -0.25), np.full(N, 1.5), np.full(N, -0.25)])
SURFACE = scipy.interpolate.RectBivariateSpline(GRID, GRID, np.outer(GRID, GRID**2))
TABLE = scipy.interpolate.RegularGridInterpolator((GRID, GRID), np.outer(GRID, GRID**2), "pchip")
DELAY = scipy.stats.gamma(a=4.0, scale=1.5)


def derivative(u, L):
    return scipy.fftpack.diff(u, period=L)


FIELDS = {  # of N numbers, by the name of the function of the library
    "fft": lambda t, u: np.fft.ifft(1j * GRID * np.fft.fft(u, 4099)[:N]).real - u,
    "diff": lambda t, u: -derivative(u, 2.0) - u,
    "fftconvolve": lambda t, u: scipy.signal.fftconvolve(np.tanh(u), WAVES, mode="same") / N - u,
    "gaussian_filter1d": lambda t, u: scipy.ndimage.gaussian_filter1d(u**2, 2.0 + 0 * t) - u,
    "lu_solve": lambda t, u: scipy.linalg.lu_solve(LU, np.sin(u)) - u,
    "solve_banded": lambda t, u: scipy.linalg.solve_banded((1, 1), BAND, u) - u,
}
PAIRS = {  # of two numbers
    "expm": lambda t, y: scipy.linalg.expm(MATRIX * np.sin(t)) @ y - y,
    "lambertw": lambda t, y: [y[1], -scipy.special.lambertw(1.5 + y[0]).real],
}  # fmt: skip
OBJECTS = {  # whose methods are called: (type, function of two numbers)
    "splu": ("SuperLU", lambda t, y: SPARSE_LU.solve(np.sin(np.resize(y, N)))[:2] - y),
    "surface": (
        "BivariateSpline",
        lambda t, y: [SURFACE([y[0] ** 2, y[0] ** 2 + 0.1], 0.2)[0, 0], -y[1]],
    ),
    "table": ("RegularGridInterpolator", lambda t, y: [TABLE([[t / 9, y[1] ** 2]])[0], -y[1]]),
    "distribution": ("rv_continuous_frozen", lambda t, y: [DELAY.pdf(t) - y[0], -y[1]]),
}


def agrees(fun, y0, span=(0.0, 2.0), **options):
    theirs = scipy.integrate.solve_ivp(fun, span, y0, rtol=1e-6, **options)
    mine = fastdyn.solve_ivp(fun, span, y0, rtol=1e-6, **options)
    assert (mine.status, mine.nfev) == (theirs.status, theirs.nfev)
    np.testing.assert_allclose(mine.y, theirs.y, 1e-6, 1e-5 * np.abs(theirs.y).max())


@pytest.mark.parametrize("name", FIELDS | PAIRS)
def test_a_function_of_a_library(name):
    with pytest.warns(fastdyn.CompileWarning, match=f"it calls {name}.*line"):
        agrees((FIELDS | PAIRS)[name], WAVES if name in FIELDS else [0.5, 0.3])


@pytest.mark.parametrize("name", OBJECTS)
def test_methods_of_objects_run_in_python(name):
    kind, fun = OBJECTS[name]
    with pytest.warns(fastdyn.CompileWarning, match=f"{kind}.*line"):
        agrees(fun, [0.5, 0.3])


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("n", [70, 200])
def test_long_arrays(n):
    kernel = np.exp(-(np.linspace(-2, 2, 41) ** 2))
    agrees(lambda t, u: np.convolve(np.tanh(u), kernel, "same") / 41 - u, np.linspace(0, 1, n))
    agrees(lambda t, u: scipy.ndimage.laplace(u.reshape(-1, 10), mode="wrap").ravel() - u,
           np.sin(np.arange(n)))  # fmt: skip


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("n", [100, 300])
def test_a_large_complex_state(n):
    rng = np.random.default_rng(n)
    H = rng.normal(size=(n, n)) + 1j * rng.normal(size=(n, n))
    H = (H + H.conj().T) / np.sqrt(8 * n)
    start = np.zeros(n, complex)
    start[0] = 1.0
    named = pytest.warns(fastdyn.CompileWarning, match="a large complex matrix")
    with contextlib.nullcontext() if n == 100 else named:
        agrees(lambda t, psi: -1j * (H @ psi), start)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_an_exception_is_that_of_the_library():
    def fun(t, y):
        np.linalg.cholesky(np.array([[1.0, y[0]], [y[0], 1.0]]))
        return [1.0]

    def used(t, y):
        return [1.0 + 0 * np.linalg.cholesky(np.array([[1.0, y[0]], [y[0], 1.0]]))[1, 1]]

    for function in (fun, used):
        with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
            fastdyn.solve_ivp(function, (0, 5), [0.0])
