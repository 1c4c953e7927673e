"""Each result draws itself, with names, units and legends that fit."""

import math

import numpy as np
import pytest
from matplotlib import pyplot

from fastdyn import systems
from fastdyn.analysis import (
    basin,
    continuation,
    equilibria,
    frequency_response,
    linearise,
    lyapunov,
    periodic_orbit,
    phase_portrait,
    poincare,
)


def swing(t, y, damping):
    return [y[1], -np.sin(y[0]) - damping * y[1]]


def hopf(t, y, mu):
    square = y[0] ** 2 + y[1] ** 2
    return [(mu - square) * y[0] - y[1], (mu - square) * y[1] + y[0]]


def forced(t, y, omega):
    return [y[1], -0.1 * y[1] - y[0] + math.cos(omega * t)]


def hopf_orbit():
    return periodic_orbit(hopf, [0.5, 0.1], 6.0, (0.25,))


RESULTS = {
    "modes": lambda: linearise(systems.building()),
    "one mode": lambda: linearise(lambda t, y: [-y[0]], [0.0]),
    "equilibria": lambda: equilibria(swing, [(-1, 4), (-1, 1)], args=(0.2,)),
    "no equilibrium": lambda: equilibria(lambda t, y: [1 + y[0] ** 2], [(-1, 1)]),
    "portrait": lambda: phase_portrait(systems.pendulum(), [(-7, 7), (-9, 9)], n_starts=30),
    "cycle": lambda: phase_portrait(hopf, [(-1, 1), (-1, 1)], (0.25,), n_starts=30),
    "a kink": lambda: linearise(lambda t, y: [-abs(y[0])], [0.0]),
    "kinks": lambda: equilibria(lambda t, y: [-abs(y[0])], guesses=[[0.0]]),
    "section": lambda: poincare(systems.pendulum(), section="bottom", n_points=3),
    "exponents": lambda: lyapunov(swing, [1.0, 0], (0.2,), t_end=50),
    "orbit": hopf_orbit,
    "branch": lambda: continuation(hopf_orbit(), "mu", 0.5),
    "response": lambda: frequency_response(forced, [0.5, 1.0, 1.5], args=(1.0,), y0=[0, 0]),
    "basin": lambda: basin(lambda t, y: [y[0] - y[0] ** 3, -y[1]], [(-2, 2)] * 2, n=5, t_end=20),
}


@pytest.mark.few(3)
@pytest.mark.parametrize("name", RESULTS)
def test_each_result_draws_itself(name, tmp_path):
    result = RESULTS[name]()
    figure = result.plot(figsize=(8, 5))
    figure.savefig(tmp_path / "picture.png", dpi=30)
    assert all(axes.get_xlabel() or axes.get_title("left") for axes in figure.axes[-1:])
    assert tuple(figure.get_size_inches()) == (8, 5) and str(result)
    given, (left, right) = pyplot.subplots(1, 2, figsize=(14, 6), layout="constrained")
    part = result.plot(ax=right)
    assert left in given.axes and (part is given or part.figure is given)
    given.savefig(tmp_path / "part.png", dpi=30)
    pyplot.close(given)


def test_names_and_units_of_a_system():
    axes = RESULTS["portrait"]().plot().axes[0]
    assert axes.get_xlabel() == "θ (rad)" and axes.get_ylabel() == "ω (rad/s)"
    assert "π" in axes.xaxis.get_major_formatter()(math.pi)


def test_angles_are_wrapped():
    found = poincare(lambda t, y: [1.0 + 0 * y[0], 0 * y[1]], [0.0, 1.0], period=1.0, n_points=50)
    (axes,) = found.plot(angles=0).axes
    drawn = axes.lines[0].get_xdata()
    assert np.abs(drawn).max() <= math.pi and np.ptp(drawn) > 6
    with pytest.raises(ValueError, match="no component 'theta'"):
        found.plot(("theta", 0))
    with pytest.raises(ValueError, match="must be two"):
        found.plot((0, 1, 0))


def test_a_small_part_of_a_turn_has_ticks():
    found = poincare(lambda t, y: [0.01 + 0 * y[0], 0 * y[1]], [0.1, 1.0], period=1.0, n_points=5)
    figure = found.plot(angles=0)
    figure.draw_without_rendering()
    low, high = figure.axes[0].get_xlim()
    assert sum(low <= tick <= high for tick in figure.axes[0].get_xticks()) >= 3


def test_a_result_is_printed_in_a_few_lines():
    for name in ("portrait", "cycle", "basin", "response", "section", "exponents"):
        assert len(str(RESULTS[name]()).splitlines()) < 20
