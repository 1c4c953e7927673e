"""Claims about signs in other words: "auto" slides along each as along np.sign."""

import math

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp

SIGNS = {
    "x / abs(x)": lambda x: x / abs(x),
    "guarded": lambda x: x / abs(x) if abs(x) > 1e-12 else 0.0,
    "x / sqrt(x * x)": lambda x: x / math.sqrt(x * x),
    "abs(x) / x": lambda x: abs(x) / x,
    "copysign": lambda x: math.copysign(1.0, x),
    "np.copysign": lambda x: np.copysign(1.0, x),
    "heaviside": lambda x: 2.0 * np.heaviside(x, 0.5) - 1.0,
    "x * (1 / abs(x))": lambda x: x * (1.0 / abs(x)),
    "2 * x / abs(x) / 2": lambda x: 2.0 * x / abs(x) / 2.0,
    "-x / -abs(x)": lambda x: -x / -abs(x),
    "x / hypot": lambda x: x / np.hypot(x, 0.0),
    "a number added": lambda x: x / (abs(x) + 1e-300),
    "x / max(x, -x)": lambda x: x / max(x, -x),
    "arctan2(x, 0)": lambda x: np.arctan2(x, 0.0) * 2.0 / np.pi,
    "arctan2(0, x)": lambda x: 1.0 - 2.0 * np.arctan2(0.0, x) / np.pi,
}


@pytest.mark.parametrize("name", SIGNS)
def test_a_relay_by_another_sign(name):
    sign = SIGNS[name]

    def fun(t, y):
        return [-2.0 * sign(y[0] - 0.3) + 0.5 * np.sin(t)]

    run = solve_ivp(fun, (0, 5), [1.0], "auto", rtol=1e-6, atol=1e-8)
    assert run.success and run.y[0, -1] == pytest.approx(0.3, abs=1e-6)
    assert run.nfev < 2000 and "Filippov" in run.reason


@pytest.mark.parametrize("name", SIGNS)
def test_friction_by_another_sign(name):
    """An oscillator with dry friction comes to rest where the spring is weaker than friction."""
    sign = SIGNS[name]

    def friction(t, y, sign):
        return [y[1], -y[0] - 0.2 * sign(y[1])]

    given = {"method": "auto", "rtol": 1e-6, "atol": 1e-8}
    run = solve_ivp(friction, (0, 20), [1.0, 0.5], args=(sign,), **given)
    right = solve_ivp(friction, (0, 20), [1.0, 0.5], args=(np.sign,), **given)
    assert run.success and run.nfev < 5000
    assert run.y[:, -1] == pytest.approx(right.y[:, -1], abs=1e-5)


@pytest.mark.parametrize("name", SIGNS)
@pytest.mark.parametrize("method", ["auto", "Taylor"])
def test_twisting_by_another_sign_at_the_default_tolerance(name, method):
    """Tsit5 is off by 0.13 there: steps that end at each switch are those of np.sign."""

    def twisting(t, y, sign):
        return [y[1], -2.2 * sign(y[0]) - sign(y[1])]

    run = solve_ivp(twisting, (0, 3), [1.0, 0.2], method, args=(SIGNS[name],))
    right = solve_ivp(twisting, (0, 3), [1.0, 0.2], method, args=(np.sign,))
    assert run.success and run.y[:, -1] == pytest.approx(right.y[:, -1], abs=1e-9)
    assert run.nfev <= 3 * right.nfev  # a guard has two borders, at each of which a step ends


def test_signs_within_signs_and_beside_signs():
    def several(t, y):
        a, b = y[0] / abs(y[0]), abs(y[1]) / y[1]
        return [-a * b + 0.1 * t, 0.3 * y[0] / abs(y[0]) * y[1] / abs(y[1]) - a / abs(a) + 0.2 * t]

    def plain(t, y):
        a, b = np.sign(y[0]), np.sign(y[1])
        return [-a * b + 0.1 * t, 0.3 * a * b - a + 0.2 * t]

    run, right = (solve_ivp(f, (0, 4), [1.0, 0.7], "auto", rtol=1e-6) for f in (several, plain))
    assert run.success and run.y[:, -1] == pytest.approx(right.y[:, -1], abs=1e-6)


@pytest.mark.parametrize("name", ["x / abs(x)", "arctan2(x, 0)", "arctan2(0, x)"])
def test_sensitivities_are_refused_at_a_jump_by_another_sign(name):
    sign = SIGNS[name]

    def fun(t, y, p):
        return [1.0 + 0.5 * sign(y[0] - p)]

    with pytest.raises(ValueError, match="`fun` jumps at t = "):
        solve_ivp(fun, (0, 2), [0.0], "Tsit5", args=(0.5,), sensitivity="p")


@pytest.mark.filterwarnings("ignore:Rodas5P took .*back and forth:fastdyn.StiffnessWarning")
@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_rodas5p_leaves_a_relay_whose_slope_is_zero_on_both_sides(rtol):
    """Differences of 1e-8 across the switch were slopes of -1e8, which held the state for ever.

    The solution leaves the level at t = 10 / 3; steps across the level end within 1000 tolerances.
    """

    def relay(t, y):
        return [-(1.0 if y[0] > 1.0 else -1.0) + 0.3 * t]

    solve = prepare(relay, (0, 6), [0.7], method="Rodas5P", rtol=rtol, atol=1e-3 * rtol)
    end = 1.0 - (6.0 - 10.0 / 3.0) + 0.15 * (36.0 - 100.0 / 9.0)
    assert abs(solve().y[0, -1] - end) < 1000.0 * rtol


RANDOM = (
    lambda t, y, s, a, b, c, w: [y[1], -a * s(y[0] - b)],
    lambda t, y, s, a, b, c, w: [y[1], -y[0] - 0.5 * b * s(y[1]) + c * np.cos(w * t)],
    lambda t, y, s, a, b, c, w: [-a * s(y[0]) + c * t, y[0] - b * s(y[1] - c)],
    lambda t, y, s, a, b, c, w: [y[1], -(a + b) * s(y[0]) - b * s(y[1])],
)


@pytest.mark.hunt
@pytest.mark.parametrize("name", SIGNS)
def test_random_jumps_in_each_spelling(name):
    """Radau takes tanh(x / 1e-6), whose solution differs from that of the jump by some 1e-6."""
    rng = np.random.default_rng(list(SIGNS).index(name))
    ways = (("auto", SIGNS[name], 1e-5), ("Radau", lambda x: np.tanh(x / 1e-6), 1e-8))
    for fun in RANDOM * 4:
        numbers = rng.uniform([1.5, 0.3, 0.2, 0.5], [3.0, 1.2, 1.5, 3.0])
        y0 = rng.uniform(0.3, 1.3, 2)
        run, right = (
            solve_ivp(fun, (0, 2), y0, method, args=(s, *numbers), rtol=rtol, atol=1e-3 * rtol)
            for method, s, rtol in ways
        )
        assert run.success and run.y[:, -1] == pytest.approx(right.y[:, -1], abs=1e-4)
