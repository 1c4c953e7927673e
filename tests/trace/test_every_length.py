"""An expression of NumPy is taken at every length of its arrays, or refused at every length."""

import contextlib
from typing import Any

import numpy as np
import pytest

from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace
from support.long_arrays import in_batches

LENGTHS = 3, 40, 100
EXPRESSIONS = """
np.sum(y)
y.sum()
sum(y)
np.mean(y)
np.average(y)
np.average(y, weights=y * y)
np.std(y)
np.std(y, ddof=1)
np.var(y)
np.prod(0.9 + 0.01 * y)
np.max(y)
np.min(y)
max(y)
min(y)
np.ptp(y)
np.median(y) * y
np.sort(y)
np.argmax(y)
np.argmin(y)
y[np.argmax(y)]
y[np.argmin(np.abs(y))]
np.argsort(y)
np.cumsum(y)
np.cumprod(0.9 + 0.01 * y)
np.diff(y)
np.diff(y, n=2)
np.diff(y, prepend=0.0)
np.ediff1d(y)
np.gradient(y)
np.gradient(y, 0.1)
np.gradient(y, edge_order=2)
np.trapezoid(y)
np.trapezoid(y, dx=0.5)
np.unwrap(y)
np.interp(y, [-1.0, 0.0, 2.0], [0.0, 1.0, 4.0])
np.searchsorted([-1.0, 0.0, 1.0], y)
np.digitize(y, [-1.0, 0.0, 1.0])
np.polyval([1.0, -2.0, 0.5], y)
np.polyval(y, 0.5)
np.convolve(y, [0.25, 0.5, 0.25])
np.convolve(y, [0.25, 0.5, 0.25], "same")
np.correlate(y, [1.0, 2.0])
np.dot(y, y)
y @ y
np.inner(y, y)
np.vdot(y, y)
np.outer(y, y)
np.outer(y, y) @ y
np.kron(y, [1.0, 2.0])
np.cross(y[:3], y[-3:])
np.einsum('i,i', y, y)
np.einsum('i,j->ij', y, y)
np.linalg.norm(y)
np.linalg.norm(y, 1)
np.linalg.norm(y, np.inf)
np.linalg.norm(y - y.mean())
np.tensordot(y, y, 1)
np.roll(y, 1)
np.flip(y)
y[::-1]
np.tile(y, 2)
np.repeat(y, 2)
np.concatenate([y, y])
np.hstack([y, 1.0])
np.append(y, 1.0)
np.insert(y, 1, 2.0)
np.delete(y, 1)
np.pad(y, 1)
np.pad(y, 1, mode="edge")
np.stack([y, -y])
np.vstack([y, -y])
np.column_stack([y, -y])
np.r_[0.0, y, 1.0]
np.c_[y, y]
np.diag(y)
np.diagflat(y)
np.tril(np.outer(y, y))
np.triu(np.outer(y, y), 1)
np.trace(np.outer(y, y))
np.meshgrid(y, y)[0]
np.split(y[:2], 2)[0]
np.array_split(y, 2)[1]
np.atleast_2d(y)
np.expand_dims(y, 0)
np.take(y, [0, 2])
np.where(y > 0, y, -y)
np.select([y > 1, y > 0], [y, 2 * y], 0.0)
np.piecewise(y, [y > 0], [lambda x: x, lambda x: -x])
np.clip(y, -1, 1)
np.maximum(y, 0.0)
np.fmin(y, 0.5)
np.heaviside(y, 0.5)
np.sign(y)
np.abs(y)
np.square(y)
np.cbrt(y)
np.hypot(y, 1.0)
np.arctan2(y, 1.0)
np.logaddexp(y, 0.0)
np.exp2(y)
np.log1p(np.abs(y))
np.sinc(y)
np.deg2rad(y)
np.floor(y)
np.round(y, 2)
np.mod(y, 0.7)
np.floor_divide(y, 0.7)
np.fmod(y, 0.7)
np.copysign(1.0, y)
np.nan_to_num(y)
np.isfinite(y) * 1.0
np.isclose(y, 0.0) * 1.0
np.allclose(y, y) * 1.0
np.any(y > 1) * 1.0
np.all(y > -9) * 1.0
np.count_nonzero(y > 0)
np.sum(y > 0)
np.sum(y, where=y > 0)
np.nansum(y)
np.nanmax(y)
np.real(y * 1j)
np.imag(np.exp(1j * y))
np.angle(np.exp(0.1j * y))
np.abs(np.fft.fft(y))
np.fft.ifft(np.fft.fft(y)).real
np.fft.rfft(y).real
np.linalg.solve(np.eye(len(y)) + 0.01 * np.outer(y, y), y)
np.linalg.det(np.eye(len(y)) + 0.01 * np.outer(y, y)) * y
np.vectorize(lambda v: v * v)(y)
np.apply_along_axis(np.sum, 0, y)
np.full_like(y, 2.0) * y
np.linspace(y[0], y[1], 5)
np.zeros_like(y) + y
np.ones(len(y)) * y[0]
np.arange(len(y)) * y
np.maximum.accumulate(y)
np.add.reduce(y)
np.multiply.outer(y, y)
np.logical_and(y > 0, y < 1) * 1.0
np.bitwise_or(y > 0, y < -1) * 1.0
np.quantile(y, 0.3)
np.histogram(y, 3)[0]
np.unique(y)
np.cov(y, y * y)
np.corrcoef(y, y * y)
""".strip().splitlines()

SHORT = {  # formulas that grow with a power of the length, for short arrays only
    each
    for each in EXPRESSIONS
    if any(name in each for name in ("np.sort", "median", "linalg.solve", "linalg.det"))
}


def numbers(expression):
    """The function ``f(t, y)`` whose result begins with the values of an expression."""
    space: dict = {}
    exec(
        "import numpy as np\ndef f(t, y):\n"
        f"    found = np.ravel({expression})[:len(y)]\n"
        "    result = np.zeros(len(y))\n    result[:len(found)] = found\n    return result\n",
        space,
    )
    return space["f"]


def agree(compiled, f, n, seed, tolerance):
    """The code and the function have the same values at a drawn state."""
    y = np.random.default_rng(seed).normal(size=n)
    np.testing.assert_allclose(compiled(0.3, y), f(0.3, y), rtol=tolerance, atol=tolerance)


@pytest.mark.few(24)
@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_an_expression_is_taken_at_every_length_or_at_none(expression):
    f, taken = numbers(expression), {}
    for n in LENGTHS:
        taken[n] = False
        with contextlib.suppress(Untraceable):
            compiled = in_batches(f, n)[0]
            taken[n] = True
        if taken[n]:
            for seed in range(3):
                agree(compiled, f, n, seed, 1e-9)
        elif expression in SHORT:
            taken[n] = True
            bound = bind(f, (), DERIVATIVE, n, Near(0.0, 1.0, np.linspace(-1.0, 1.0, n)))
            assert bound.function is not None  # by Numba
            agree(lambda t, y, bound=bound: machine_value(bound, t, y), f, n, 0, 1e-9)
    assert len(set(taken.values())) == 1, taken


WRITTEN_IN_PYTHON = """
np.cov(y, y * y)
np.fft.fftshift(y)
np.kron(y, y)
np.linalg.norm(np.outer(y, y), axis=1)
np.median(y[:5])
np.nansum(y)
np.pad(y, 1, mode="linear_ramp")
np.select([y > 1.0], [y], y * y)
np.tensordot(np.outer(y, y), y, 1)
np.unwrap(y)
""".strip().splitlines()


@pytest.mark.parametrize("expression", WRITTEN_IN_PYTHON)
@pytest.mark.parametrize("n", [5, 40])
def test_the_source_of_numpy_is_traced(expression, n):
    f = numbers(expression)
    compiled: Any = in_batches(f, n)[0]
    agree(compiled, f, n, n, 1e-12)


def test_numbers_from_outside_stay_parameters_in_the_source_of_numpy():
    a, b = np.array([1.0, 2.0, 3.0]), np.array([0.5, -1.0, 2.0])
    found = trace(lambda t, y: y + np.cross(a, b), (), 3, (3,))
    changed = [float(v) for v in found.graph.values]  # pyright: ignore
    assert changed[:6] == [*a, *b]
    changed[3:6] = [1.0, 1.0, -1.0]
    at = np.zeros(1), np.zeros((3, 1))
    theirs = evaluate(found.graph, found.outputs, *at, changed)[0][:, 0]
    np.testing.assert_allclose(theirs, np.cross(a, changed[3:6]))
