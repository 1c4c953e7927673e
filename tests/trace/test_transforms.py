"""Fourier transforms and convolutions: written out where they are small, refused at once else."""

import warnings

import numpy as np
import pytest
import scipy.fft
from scipy.integrate import solve_ivp as reference
from scipy.signal import convolve2d

import fastdyn
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import Graph
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace

RNG = np.random.default_rng(3)
GIVEN = [{}, {"norm": "ortho"}, {"norm": "forward"}, {"n": 11}, {"n": 4}]
LENGTHS = [1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 30, 31, 64, 100]


def agrees(fun, tolerance=4e-15):
    """The graph beside the function, at a state of one number."""

    def of_state(t, y):
        found = np.asarray(fun(y[0]))
        return np.concatenate([np.real(found).ravel(), np.imag(found).ravel()])

    theirs = of_state(0.0, [0.7])
    found = trace(of_state, (), 1, theirs.shape)
    at = np.zeros(1), np.full((1, 1), 0.7)
    mine = evaluate(found.graph, found.outputs, *at, found.graph.values)[0][:, 0]
    np.testing.assert_allclose(mine, theirs, 0, tolerance * np.abs(theirs).max())


@pytest.mark.few(12)
@pytest.mark.parametrize("module", [np.fft, scipy.fft], ids=["numpy", "scipy"])
@pytest.mark.parametrize("name", ["fft", "ifft", "rfft", "irfft"])
@pytest.mark.parametrize("n", LENGTHS)
def test_transforms(module, name, n):
    function = getattr(module, name)
    row = RNG.normal(size=n) + (0 if name == "rfft" else 1j * RNG.normal(size=n))
    for given in GIVEN if n < 20 else GIVEN[:1]:
        if name == "irfft" and n == 1 and "n" not in given:
            continue
        agrees(lambda v, given=given: function(row * v - 0.3, **given))
    if n < 10 and not (name == "irfft" and n == 1):
        rows = RNG.normal(size=(n, 3, n))
        agrees(lambda v: function(rows * v, axis=0))
        agrees(lambda v: function(rows * v, axis=-1))


@pytest.mark.parametrize("mode", ["full", "same", "valid"])
@pytest.mark.parametrize("boundary", ["fill", "wrap", "symm"])
def test_convolve2d(mode, boundary):
    for size, by in (((5, 6), (3, 3)), ((4, 7), (2, 3)), ((3, 3), (3, 2))):
        a, b = RNG.normal(size=size), RNG.normal(size=by)
        agrees(lambda v, a=a, b=b: convolve2d(a * v, b, mode, boundary))
        agrees(lambda v, a=a, b=b: convolve2d(a, b + v, mode=mode, boundary=boundary))
    agrees(lambda v: convolve2d(a * v, b, mode, "fill", 2))


def test_a_spectral_method():
    n = 64
    k = np.fft.fftfreq(n, 1 / n)

    def fun(t, y):
        return np.real(np.fft.ifft(-(k**2) * 0.01 * np.fft.fft(y)))

    y0 = np.sin(2 * np.pi * np.arange(n) / n) + 0.1
    with warnings.catch_warnings():
        warnings.simplefilter("error", fastdyn.CompileWarning)
        mine = fastdyn.solve_ivp(fun, (0.0, 1.0), y0)
    np.testing.assert_allclose(mine.y, reference(fun, (0.0, 1.0), y0).y, rtol=1e-9, atol=1e-12)


def of_another():
    matrix = np.ones((4000, 4000))
    return lambda t, y: matrix @ y - y


LARGE = {
    "transform": lambda t, y: np.real(np.fft.ifft(np.fft.fft(y))) - 2 * y,
    "product": lambda t, y: np.ones((4000, 4000)) @ y - y,
    "of another": None,  # made by the test: 128 MB
    "convolution": lambda t, y: convolve2d(y.reshape(50, 80), np.ones((5, 5)), "same").ravel(),
}


@pytest.mark.parametrize("name", LARGE)
def test_what_is_too_large_is_known_at_once(name, monkeypatch):
    fun = of_another() if name == "of another" else LARGE[name]
    called, call = [], Graph.call
    monkeypatch.setattr(Graph, "call", lambda *a, **data: called.append(1) or call(*a, **data))
    with pytest.raises(Untraceable) as refusal:
        trace(fun, (), 4000, (4000,))
    assert refusal.value.final
    assert not called
