"""Equilibria and linearisations beside those on paper."""

import math

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.analysis import equilibria, linearise


def swing(t, y, damping):
    return [y[1], -np.sin(y[0]) - damping * y[1]]


def lorenz(t, y, s, r, b):
    return [s * (y[1] - y[0]), y[0] * (r - y[2]) - y[1], y[0] * y[1] - b * y[2]]


def flat(t, y, A):
    return A @ y


@pytest.mark.parametrize(
    "matrix, kind, stable",
    [
        ([[-1, 0], [0, -2]], "stable node", True),
        ([[1, 0], [0, 2]], "unstable node", False),
        ([[-1, 3], [-3, -1]], "stable focus", True),
        ([[1, 3], [-3, 1]], "unstable focus", False),
        ([[1, 0], [0, -2]], "saddle", False),
        ([[0, 3], [-3, 0]], "centre", None),
        ([[0, 1], [0, -1]], "degenerate (an eigenvalue is zero)", None),
        ([[0, 1, 0], [-1, 0, 0], [0, 0, -1]], "stable directions and undamped oscillations", None),
        ([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], "unstable, with undamped oscillations", False),
    ],
)
def test_kinds(matrix, kind, stable):
    found = linearise(flat, np.zeros(len(matrix)), (np.array(matrix, float),))
    assert (found.kind, found.stable) == (kind, stable)
    assert np.array_equal(found.matrix, matrix) and found.autonomous


def test_a_damped_swing():
    one = linearise(swing, [0, 0], (0.1,)).modes[0]
    assert math.isclose(one.damping_ratio, 0.05, rel_tol=1e-14)
    assert math.isclose(one.frequency, math.sqrt(1 - 0.05**2), rel_tol=1e-14)
    assert math.isclose(one.natural_frequency, 1.0, rel_tol=1e-14) and "y[0]" in one.name
    over = linearise(swing, [0, 0], (3.0,))
    assert over.kind == "stable node" and all(mode.damping_ratio == 1.0 for mode in over.modes)


def test_the_modes_of_the_building():
    building = systems.building(k=120.0, m=1.5)
    low, high = linearise(building).modes
    found = np.array([low.frequency, high.frequency])
    assert np.allclose(found, building.frequencies, rtol=1e-13)
    golden = (1 + math.sqrt(5)) / 2
    assert np.allclose(low.shape[:2], [1 / golden, 1]) and low.name.endswith("y1 and y2 together")
    assert np.allclose(high.shape[:2], [1, -1 / golden]) and "against each other" in high.name


def test_a_derived_system():
    from fastdyn.derive import Model, i, j

    board = Model("bob")
    theta = board.coordinates("theta", "rad")
    g, l, m = board.parameters(g=(9.81, "m/s²"), l=(2.0, "m"), m=(1.0, "kg"))  # noqa: E741
    import sympy as sp

    board.particle(m, l * (sp.sin(theta) * i - sp.cos(theta) * j))
    board.gravity(-g * j)
    board.start(theta=0.0)
    made = board.lagrange().system()
    assert math.isclose(linearise(made).modes[0].frequency, math.sqrt(9.81 / 2), rel_tol=1e-12)
    assert [each.kind for each in equilibria(made, [(-1, 4), (-1, 1)])] == ["centre", "saddle"]


def test_the_equilibria_of_lorenz():
    r, b = 28.0, 8 / 3
    found = equilibria(lorenz, [(-20, 20), (-20, 20), (-5, 50)], args=(10.0, r, b))
    away = math.sqrt(b * (r - 1))
    exact = [[-away, -away, r - 1], [0, 0, 0], [away, away, r - 1]]
    assert np.allclose([each.y for each in found], exact, atol=1e-12)
    assert [each.kind for each in found] == ["saddle"] * 3 and "3 equilibria" in str(found)


def test_a_box_without_equilibrium_says_so():
    found = equilibria(lambda t, y: [1 + y[0] ** 2], [(-1, 1)])
    assert len(found) == 0 and "No equilibrium was found" in found.message
    assert len(equilibria(swing, [(1, 2), (-1, 1)], args=(0.1,))) == 0  # one lies outside


def test_guesses_and_a_line_of_equilibria():
    found = equilibria(swing, guesses=[[0.1, 0], [3, 0]], args=(0.1,))
    assert [each.kind for each in found] == ["stable focus", "saddle"]
    line = equilibria(lambda t, y: [-y[0], 0 * y[1]], guesses=[0.5, 0.7])
    assert line[0].kind.startswith("degenerate") and abs(line[0].y[0]) < 1e-12


def test_beside_an_equilibrium():
    found = linearise(swing, [1.0, 0.0], (0.1,))
    assert found.kind == "no equilibrium" and found.stable is None and not found.equilibrium
    assert np.allclose(found.rates, [0, -math.sin(1)])


@pytest.mark.parametrize(
    "arguments, kind, said",
    [
        ((systems.building,), TypeError, "is a class of systems: write building"),
        ((systems.building(), None, (1,)), TypeError, "set them by name"),
        ((systems.building(), [1.0]), ValueError, "must be 4 numbers .y1, y2, v1, v2."),
        ((3,), TypeError, "must be a function"),
        ((swing, [0.0, math.nan], (1.0,)), ValueError, "finite"),
        ((swing, None, (1.0,)), ValueError, "`y` is missing"),
        ((swing, [0.0, 1.0, 2.0], (1.0,)), ValueError, "must return 3 numbers"),
        ((lambda t, y: [math.sqrt(y[0])], [0.0]), ValueError, "not finite"),
        ((lambda t, y: [float(str(y[0]))], [1.0]), ValueError, "can be traced"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_what_is_refused(arguments, kind, said):
    with pytest.raises(kind, match=said):
        linearise(*arguments)


def test_a_state_of_the_wrong_length_is_named():
    with pytest.raises(IndexError) as caught:
        equilibria(swing, [(0, 1)], args=(0.1,))
    assert "`y` has 1 component" in caught.value.__notes__[0]


@pytest.mark.parametrize("box", [[0, 1], [(1, 0), (0, 1)], [(0, math.inf), (0, 1)], "no", [(0, 1)]])
def test_boxes_that_are_none(box):
    with pytest.raises(ValueError, match="`box` must have"):
        equilibria(systems.pendulum(), box)


@pytest.mark.few(4)
@pytest.mark.parametrize(
    "rate",
    [
        lambda x: x * x,
        lambda x: -x * x,
        lambda x: x**3,
        lambda x: -(x**5),
        lambda x: 1 - 2 * x + x * x,
        lambda x: (x - 1) ** 3,
        lambda x: np.cos(x) - 1,
        lambda x: np.sin(x) - x,
        lambda x: -x * abs(x),
    ],
)
def test_an_eigenvalue_that_vanishes(rate):
    """The search ends beside a multiple zero, where the Jacobian has any sign."""
    (found,) = equilibria(lambda t, y: [rate(y[0])], [(-2, 2.3)])
    assert found.kind.startswith("degenerate") and found.stable is None
    assert found.eigenvalues[0] == 0.0
    (beside,) = equilibria(lambda t, y: [rate(y[0]), -y[1]], [(-2, 2.3), (-1, 1)])
    assert beside.stable is None and np.allclose(beside.eigenvalues, [0, -1])
    zero = round(found.y[0])  # 0 or 1
    assert linearise(lambda t, y: [rate(y[0])], [zero]).kind == found.kind


def test_small_eigenvalues_are_told():
    """Slopes of any size decide, where the zero is a simple one."""
    for slope in (1.0, 1e-10, 1e-100):
        found = linearise(lambda t, y, slope: [slope * y[0] + y[0] ** 2], [0.0], (slope,))
        assert found.kind == "unstable node" and found.eigenvalues[0] == slope
    bent = [linearise(lambda t, y: [y[0] - 1e8 * y[0] ** 2], [at]) for at in (0.0, 1e-8)]
    assert [each.kind for each in bent] == ["unstable node", "stable node"]
    stiff = linearise(lambda t, y: [-1e6 * (y[0] + y[0] ** 3), -0.01 * y[1] + y[0]], [0, 0])
    assert stiff.kind == "stable node" and np.allclose(stiff.eigenvalues, [-0.01, -1e6])


@pytest.mark.parametrize(
    "rate",
    [
        lambda y, v: -y - 0.2 * np.sign(v),
        lambda y, v: -y - 0.2 * abs(v),
        lambda y, v: -y - 0.01 * abs(v) - 0.3 * v,
        lambda y, v: -y - max(v, 0.5 * y),
        lambda y, v: -(y if y > 0 else 2 * y),
        lambda y, v: -y - np.sqrt(y * y + v * v),
        lambda y, v: np.interp(y, [-1.0, 0.0, 1.0], [2.0, 0.0, -1.0]),
    ],
)
def test_kinks_and_jumps_are_told(rate):
    found = equilibria(lambda t, y: [y[1], rate(y[0], y[1])], guesses=[0.0, 0.0])
    assert "not differentiable at 1 of them" in found.message
    assert found[0].kind == "not differentiable there" and found[0].stable is None
    assert np.isnan(found[0].matrix).any() and not found[0].modes
    assert np.isnan(found[0].eigenvalues).all() and "not differentiable" in str(found)


@pytest.mark.parametrize(
    "rate",
    [
        lambda y, v: -y - abs(v) * v - v,
        lambda y, v: -1e6 * y - np.tanh(1e6 * v),
        lambda y, v: -y - v - 0.5 * abs(y - 0.001) + 0.0005,
        lambda y, v: -1e7 * y - 1e-3 * v + y * y,
    ],
)
def test_smooth_places_are_told_from_kinks(rate):
    found = linearise(lambda t, y: [y[1], rate(y[0], y[1])], [0.0, 0.0])
    assert np.isfinite(found.matrix).all() and found.kind.startswith("stable")


def test_a_centre_is_named_as_that_of_the_linear_part():
    found = linearise(lambda t, y: [y[1], -y[0] - y[1] ** 3], [0, 0])
    assert found.kind == "centre" and str(found).startswith("centre of the linear part at")


@pytest.mark.parametrize(
    "fun",
    [
        lambda t, y: [np.exp(-(y[0] ** 2)), -y[1]],
        lambda t, y: [2 * math.exp(-(y[0] ** 2)), y[0] / 1e9 * y[1] - y[1]],
    ],
)
def test_no_equilibrium_lies_where_a_function_underflows(fun):
    found = equilibria(fun, [(-100, 100), (-1, 1)], n_starts=40)
    assert len(found) == 0
    assert "further states `fun` is next to zero, or a number in it is too small" in found.message


@pytest.mark.parametrize(
    ("fun", "box"),
    [
        (lambda t, y: [-2 * y[0] * y[1], 2 * y[0] * y[1] - y[1]], [(0, 1)] * 2),  # an epidemic
        (lambda t, y: y * (1 - y[0] ** 2 - y[1] ** 2), [(0.2, 2)] * 2),  # a circle
        (lambda t, y: -np.maximum(y - 0.2, 0.0), [(-1, 0.1)]),
    ],
)
def test_equilibria_that_fill_a_curve_or_a_region_are_told(fun, box):
    found = equilibria(fun, box, n_starts=20)
    assert len(found) > 5 and "have further equilibria beside them" in found.message


@pytest.mark.parametrize(
    ("fun", "n"),
    [
        (lambda t, y: y**2, 1),
        (lambda t, y: -(y**3), 1),
        (lambda t, y: -y + 2 * y**3 * (1 + np.exp(-1e5 * y**2)), 3),  # the term underflows
    ],
)
def test_equilibria_that_stand_alone_are_told_as_before(fun, n):
    found = equilibria(fun, [(-1, 1)])
    assert len(found) == n and found.message.endswith("from 200 starts.")
