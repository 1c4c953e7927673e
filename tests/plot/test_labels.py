"""Labels in pictures: Greek letters, units, dots at the steps."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from fastdyn import systems
from fastdyn.plot.scene import Scene, frame
from fastdyn.plot.solution import FEW
from fastdyn.words.letters import in_full, letters

NAMES = {
    "th": "θ", "th1": "θ₁", "theta_10": "θ₁₀", "vth2": "vθ₂", "vphi": "vφ", "omega": "ω",
    "V0": "V₀", "x": "x", "vx": "vx", "vspin": "vspin",
    "h2o": "h2o", "lambda_rod": "λ_rod", "k_on": "k_on",
    "mass": "mass", "lambda_": "λ", "y[0]": "y[0]",
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_drawn_in_letters(name):
    assert letters(name) == NAMES[name]


def test_a_short_name_is_set_by_tex_in_full():
    assert [in_full(name) for name in ("th0", "vph", "theta1", "x1", "psi", "tilt")] == [
        "theta0", "vphi", "theta1", "x1", "psi", "tilt"]  # fmt: skip


def test_axes_of_an_ensemble_have_letters_and_units():
    figure = systems.pendulum().ensemble(theta0=np.array([0.1, 0.2, 0.3])).plot()
    assert figure.axes[0].get_ylabel() == "θ at the end (rad)"
    assert figure.axes[-1].get_xlabel() == "θ₀ (rad)"
    plt.close(figure)


@pytest.mark.parametrize("t_end", [2.0, 100.0])
def test_an_invariant_is_drawn_at_the_steps_with_dots_where_they_are_few(t_end):
    run = systems.satellite(V=1.2).solve((0.0, t_end))
    figure = run.plot()
    energy = figure.axes[1].lines[0]
    assert len(energy.get_xdata()) == len(run.t)
    assert (energy.get_marker() == ".") == (len(run.t) <= FEW)
    plt.close(figure)


def test_the_picture_of_a_plane_begins_at_the_ground():
    disc = Scene([], [(x, y, 1.0) for x in (-5.0, 5.0) for y in (-5.0, 5.0)], [], ground=0.0)
    low, high = frame([disc])["zlim"]
    assert low == 0.0 and 1.0 < high < 3.0
    assert frame([disc._replace(ground=None)])["zlim"][0] < -2.0
