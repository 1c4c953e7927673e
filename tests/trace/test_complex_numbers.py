"""Functions of complex states: a graph of pairs has the values of NumPy."""

import cmath

import numpy as np
import pytest

from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace
from fastdyn.trace.reads.program import reader

RNG = np.random.default_rng(0)
SX = np.array([[0, 1], [1, 0]], complex)
SZ = np.diag([1.0, -1.0]).astype(complex)
SM = np.array([[0, 1], [0, 0]], complex)
HERMITIAN = RNG.standard_normal((4, 4)) + 1j * RNG.standard_normal((4, 4))
HERMITIAN = HERMITIAN + HERMITIAN.conj().T
RATE = 0.3 - 0.2j


def matrix_product(t, psi):
    return -1j * (0.5 * SZ + 0.2 * np.cos(t) * SX) @ psi


def unpacked(t, c):
    a, b = c
    return [-RATE * b, -1j * a + (-2j - 0.05) * b]


def density(t, y):
    rho = y.reshape(2, 2)
    commute = lambda a, b: a @ b - b @ a  # noqa: E731
    change = -1j * commute(0.5 * SZ + 0.5 * SX, rho)
    loss = SM.conj().T @ SM
    change += 0.1 * (SM @ rho @ SM.conj().T - 0.5 * (loss @ rho + rho @ loss))
    return change.flatten() + np.trace(rho)


def einsum_and_dot(t, y):
    return np.einsum("ij,j->i", HERMITIAN, y) * -1j + HERMITIAN.dot(y)


def kronecker(t, y):
    return (np.kron(SX, np.eye(2)) - np.kron(np.eye(2), SX.T)) @ y


def grid(t, psi):
    lap = np.zeros(len(psi), dtype=complex)
    lap[1:-1] = psi[2:] - 2 * psi[1:-1] + psi[:-2]
    return -1j * (-0.5 * lap + (psi * np.conj(psi)).real * psi)


def stored(t, y):
    d = np.empty(2, dtype=np.complex128)
    d[0], d[1] = 1j * y[1], -y[0].conjugate()
    return d


def elementary(t, z):
    found = np.sin(z) + np.cos(z) * 1j + np.tan(z) + np.exp(-z) + np.log(z) + np.log10(z)
    return found + np.sinh(z) / np.cosh(z) + np.tanh(z) + np.sqrt(z) + np.sqrt(-z)


def powers(t, z):
    return z**3 + z**-2 + z**0.5 + 2.0**z + z**z + np.square(z) + np.abs(z) ** 2 * z


def parts_and_angles(t, z):
    a, b = z[0].real, z[0].imag
    size = np.linalg.norm(z) + np.vdot(z, z).real
    return np.array([complex(a, b) * 2j, z[1] * np.exp(1j * np.angle(z[0])) * size])


def of_cmath(t, z):
    r, phi = cmath.polar(z[0])
    return [cmath.exp(z[0]) * cmath.rect(r, phi), abs(z[1]) * cmath.sqrt(z[0]) + cmath.phase(z[1])]


def branches(t, z):
    if abs(z[0]) > 1.0:
        return np.where(np.abs(z) > 1, -z, 1j * z)
    return 1j * z


def real_result(t, z):
    return np.abs(z)


FUNCTIONS = {
    matrix_product: 2, unpacked: 2, density: 4, einsum_and_dot: 4, kronecker: 4, grid: 6, stored: 2,
    elementary: 3, powers: 2, parts_and_angles: 2, of_cmath: 2, branches: 2, real_result: 2,
}  # fmt: skip


@pytest.mark.parametrize(("fun", "m"), FUNCTIONS.items(), ids=lambda v: getattr(v, "__name__", v))
def test_values(fun, m):
    """Some hundred operations at most, each of a few units of the last place."""
    found = trace(fun, (), m, (m,), complex_state=True)
    t, y = RNG.standard_normal(20), RNG.standard_normal((2 * m, 20))
    values = evaluate(found.graph, found.outputs, t, y, np.array(found.graph.values))[0]
    for i in range(20):
        expected = np.asarray(fun(t[i], np.ascontiguousarray(y[:, i]).view(complex)), complex)
        bound = 500 * np.finfo(float).eps * np.abs(expected).max()
        assert np.abs(values[:, i] - expected.reshape(-1).view(float)).max() <= bound


def test_complex_numbers_from_outside_are_parameters():
    matrix = SX.copy()
    found = trace(lambda t, y, a, m: a * (m @ y), (0.5j, matrix), 2, (2,), complex_state=True)
    fun = found.reads.roots[0]
    matrix[0, 1] = 3.0 + 1.0j
    other = reader(found.reads)(fun, (2.0 - 1j, matrix))
    assert [list(v) for v in other] == [[2.0, -1.0], [0, 0, 3, 1, 1, 0, 0, 0]]
    assert reader(found.reads)(fun, (2.0, matrix)) is None
    assert reader(found.reads)(fun, (2.0j, matrix[:1])) is None


@pytest.mark.parametrize("kind", [np.complex64, np.clongdouble])
def test_numbers_that_are_rounded_otherwise_are_numpys(kind):
    """Their operations on each other are NumPy's own; beside the state they are refused."""
    number = kind(1 + 1j) / kind(3)
    found = trace(lambda t, y, a: [float(abs(a)) * y[0]], (number,), 1, (1,))
    assert not found.reads.groups
    values, _ = evaluate(found.graph, found.outputs, np.zeros(1), np.ones((1, 1)), np.empty(0))
    assert float(values[0].item()) == float(abs(number))
    assert reader(found.reads)(found.reads.roots[0], (2 * number,)) is None
    assert reader(found.reads)(found.reads.roots[0], (number + kind(0),)) is not None
    with pytest.raises(Untraceable, match=number.dtype.name):
        trace(lambda t, y, a: a * y, (number,), 1, (1,), complex_state=True)


@pytest.mark.parametrize(
    "fun",
    [lambda t, z: z.sort(), lambda t, z: np.floor(z), lambda t, z: [1j * z[0], int(z[1])]],
)
def test_what_is_refused(fun):
    with pytest.raises(Untraceable):
        trace(fun, (), 2, (2,), complex_state=True)


def test_a_real_state_with_complex_results_is_refused():
    with pytest.raises(Untraceable, match="complex"):
        trace(lambda t, y: 1j * y, (), 2, (2,))
