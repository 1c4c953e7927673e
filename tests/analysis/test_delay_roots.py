"""Characteristic roots of delay equations, beside Lambert's function and known borders."""

import numpy as np
import pytest
from scipy.special import lambertw

from fastdyn.analysis import characteristic_roots
from fastdyn.delays import solve_dde


def test_roots_of_one_delay_are_lamberts():
    """z = -a + W_k(b tau exp(a tau)) / tau for y' = -a y + b y(t - tau)."""
    a, b, tau = 0.5, -2.0, 0.7
    found = characteristic_roots(
        lambda t, y, past: [-a * y[0] + b * past(t - tau)[0]], [0.0], count=8
    )
    exact = -a + lambertw(b * tau * np.exp(a * tau), np.arange(-4, 4)) / tau
    assert np.abs(np.sort_complex(found.roots) - np.sort_complex(exact)).max() < 1e-12
    assert found.delays.tolist() == pytest.approx([tau], rel=1e-15)


def test_borders_of_stability():
    def hutchinson(t, y, past, rate):
        return [rate * y[0] * (1 - past(t - 1.0)[0])]

    assert characteristic_roots(hutchinson, [1.0], args=(np.pi / 2 - 1e-6,)).stable is True
    assert characteristic_roots(hutchinson, [1.0], args=(np.pi / 2 + 1e-6,)).stable is False
    assert characteristic_roots(hutchinson, [1.0], args=(np.pi / 2,)).stable is None

    def lathe(t, y, past, damping, depth, speed):
        late = past(t - 2 * np.pi / speed)[0]
        return [y[1], -2 * damping * y[1] - y[0] - depth * (y[0] - late)]

    # On the border z = i w: 1 - w^2 + k (1 - cos w T) = 0 and 2 d w + k sin w T = 0, whose lowest k
    # is 2 d (1 + d), at w^2 = 1 + 2 d and cos w T = d / (1 + d).
    damping = 0.02
    depth = 2 * damping * (1 + damping)
    w = np.sqrt(1 + 2 * damping)
    for k in (1, 2, 5):
        speed = 2 * np.pi * w / (2 * np.pi * k - np.arccos(damping / (1 + damping)))
        below, above = (
            characteristic_roots(lathe, [0, 0], (damping, depth * share, speed))
            for share in (1 - 1e-6, 1 + 1e-6)
        )
        assert below.stable is True and above.stable is False
        assert abs(below.roots[0].imag) == pytest.approx(w, rel=1e-5)


def test_growth_is_that_of_the_solution():
    def fun(t, y, past):
        late = past(t - 0.3)
        other = past(t - 0.9 - 0.1 * y[0] ** 2)
        return [np.sin(y[1]) - other[0], -y[0] - 0.8 * late[1] + 0.2 * other[1]]

    found = characteristic_roots(fun, [0.0, 0.0])
    z = found.roots[0]
    linear = solve_dde(
        lambda t, y, past: found.a @ y + found.b[0] @ past(t - 0.3) + found.b[1] @ past(t - 0.9),
        (0, 60), [1.0, 0.0], rtol=1e-10, atol=1e-12, dense_output=True,
    )  # fmt: skip
    period = np.pi / abs(z.imag)  # half of it: y turns its sign
    ratio = linear.sol(58.0) / linear.sol(58.0 - period)
    assert found.delays.tolist() == pytest.approx([0.3, 0.9])
    np.testing.assert_allclose(ratio, -np.exp(z.real * period), rtol=1e-6)


def test_without_delays_roots_are_eigenvalues():
    found = characteristic_roots(lambda t, y, past: [y[1], -4 * y[0] - past(t)[1]], [0.0, 0.0])
    np.testing.assert_allclose(np.sort_complex(found.roots), np.roots([1, 1, 4])[::-1], rtol=1e-13)
    assert found.plot().axes


def test_what_is_no_state_of_rest_is_refused():
    def fun(t, y, past):
        return [1.0 - past(t - 1.0)[0]]

    with pytest.raises(ValueError, match="no state of rest"):
        characteristic_roots(fun, [0.5])
    with pytest.raises(ValueError, match="neutral"):
        characteristic_roots(lambda t, y, past: past.derivative(t - 1.0), [0.0])
    with pytest.raises(ValueError, match="a delay is -1"):
        characteristic_roots(lambda t, y, past: -past(t + 1.0), [0.0])


def test_an_average_over_the_past():
    """Roots are those of the same delays read one by one; without a delay the past is y."""
    taus = np.array([0.0, 0.5, 1.0])
    together = characteristic_roots(lambda t, y, past: -past(t - taus)[0].sum() + 0 * y, [0.0])
    singly = characteristic_roots(lambda t, y, past: -y - past(t - 0.5) - past(t - 1.0), [0.0])
    np.testing.assert_allclose(together.roots, singly.roots, rtol=0, atol=1e-12)
