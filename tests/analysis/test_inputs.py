"""Inputs and outputs of linearised equations, beside exact matrices and python-control."""

import numpy as np
import pytest

from fastdyn.analysis import linearise
from fastdyn.systems.pendulum import Pendulum

EXACT = 1e-12  # of derivatives of formulas of size 10


def cart(t, y, force, m, M, L):
    """A pendulum upright on a cart."""
    _, angle, v, w = y
    s, c = np.sin(angle), np.cos(angle)
    d = M + m * s * s
    return [
        v,
        w,
        (force + m * s * (L * w * w - 9.81 * c)) / d,
        (-force * c - m * L * w * w * c * s + (M + m) * 9.81 * s) / (L * d),
    ]


ARGS = (0.0, 0.1, 1.0, 0.5)


def upright(**ports):
    return linearise(cart, [0.0, 0.0, 0.0, 0.0], ARGS, **ports)


def test_matrices_of_a_cart():
    """M x'' = u - m g a, M L a'' = (M + m) g a - u."""
    found, (_, m, M, L) = upright(inputs="force", outputs=[0, "y[1]"]), ARGS
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0
    A[2, 1], A[3, 1] = -m * 9.81 / M, (M + m) * 9.81 / (M * L)
    assert np.allclose(found.A, A, atol=EXACT) and found.A is found.matrix
    assert np.allclose(found.B, np.array([[0, 0, 1 / M, -1 / (M * L)]]).T, atol=EXACT)
    assert np.array_equal(found.C, np.eye(4)[:2]) and np.array_equal(found.D, np.zeros((2, 1)))
    assert found.inputs == ("force",) and found.outputs == ("y[0]", "y[1]")


def test_outputs_that_depend_on_state_and_input():
    def tip(t, y, force, m, M, L):
        return y[0] + L * np.sin(y[1])

    def power(t, y, force, m, M, L):
        return force * y[2]

    y, args = np.array([0.3, 0.2, 1.5, -0.4]), (2.0, *ARGS[1:])
    found = linearise(cart, y, args, inputs=["force", 3], outputs={"tip": tip, "power": power})
    assert found.inputs == ("force", "L") and found.outputs == ("tip", "power")
    assert np.allclose(found.C, [[1, 0.5 * np.cos(0.2), 0, 0], [0, 0, 2, 0]], atol=EXACT)
    assert np.allclose(found.D, [[0, np.sin(0.2)], [1.5, 0]], atol=EXACT)
    for k, place in enumerate((0, 3)):  # central differences of fourth order: error h^4, eps / h
        h, values = 1e-3, []
        for step in (-2, -1, 1, 2):
            moved = list(args)
            moved[place] += step * h
            values.append(np.array(cart(0.0, y, *moved)))
        slope = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)
        assert np.allclose(found.B[:, k], slope, rtol=1e-8, atol=1e-9)


def test_an_array_of_inputs_and_a_function_of_several_outputs():
    def tanks(t, y, u, k):
        return [u[0] - k * y[0], u[1] + k * y[0] - y[1]]

    def flows(t, y, u, k):
        return [k * y[0], y[1] + u[1]]

    found = linearise(tanks, [1.0, 2.0], ([0.5, 0.1], 0.3), inputs="u", outputs=flows)
    assert found.inputs == ("u[0]", "u[1]") and found.outputs == ("flows[0]", "flows[1]")
    assert np.allclose(found.B, np.eye(2)) and np.allclose(found.C, [[0.3, 0], [0, 1]])
    assert np.allclose(found.D, [[0, 0], [0, 1]])
    s = np.array([0.5j, 2j])
    transfer = found.transfer(s)
    exact = np.array([[0.3 / (s + 0.3), 0 * s], [0.3 / (s + 0.3) / (s + 1), 1 / (s + 1) + 1]])
    assert transfer.shape == (2, 2, 2) and np.allclose(transfer, exact, rtol=EXACT)
    assert np.allclose(found.transfer(0.5j), exact[..., 0], rtol=EXACT)


def test_a_system_and_its_names():
    found = linearise(Pendulum(theta0=0.1), inputs="l", outputs="theta")
    assert found.outputs == ("theta",) and np.isclose(found.B[1, 0], 9.81 * np.sin(0.1))


def test_a_kink_in_an_input_has_no_derivative():
    def valve(t, y, u):
        return [np.maximum(u, 0.0) - y[0]]

    found = linearise(valve, [0.0], (0.0,), inputs="u")
    assert np.isnan(found.B).all() and np.array_equal(found.A, [[-1.0]])
    assert np.array_equal(linearise(valve, [1.0], (1.0,), inputs="u").B, [[1.0]])


@pytest.mark.parametrize(
    ("ports", "kind", "said"),
    [
        ({"inputs": "torque"}, ValueError, "There is no parameter 'torque'"),
        ({"inputs": ["force", 0]}, ValueError, "names one argument twice"),
        ({"inputs": "force", "outputs": "y[7]"}, ValueError, "There is no component 'y"),
        ({"inputs": "force", "outputs": {"a": 1}}, TypeError, "has functions"),
        ({"outputs": [0]}, ValueError, "`outputs` are those of `inputs`"),
    ],
)
def test_what_is_refused(ports, kind, said):
    with pytest.raises(kind, match=said):
        upright(**ports)
    with pytest.raises(ValueError, match="There are no inputs: name them"):
        upright().transfer(1j)


def test_python_control():
    control = pytest.importorskip("control")
    found = upright(inputs="force", outputs=[0, 1])
    system = found.to_control()
    assert system.input_labels == ["force"] and system.output_labels == ["y_0", "y_1"]
    ours, theirs = (np.sort_complex(np.round(p, 9)) for p in (found.eigenvalues, system.poles()))
    assert np.allclose(ours, theirs, atol=1e-7)
    assert np.allclose(control.evalfr(system, 1j), found.transfer(1j), rtol=1e-10)
