"""The page without a browser: its widgets move the curves."""

import numpy as np
import pytest

pytest.importorskip("panel", reason="the extra `explore` is not installed")

from fastdyn.explore.page import Page
from fastdyn.explore.sources import named
from fastdyn.systems import pendulum


@pytest.fixture(scope="module")
def page():
    made = Page(named("pendulum"))
    made.panel()
    return made


def test_a_slider_moves_curves_numbers_and_picture(page):
    before, n = np.array(page.figures.curves[0].data["a"]), page.updates
    page.sliders["V0"].value = 2.0
    assert page.updates == n + 1
    after = page.figures.curves[0].data
    assert not np.array_equal(before, after["a"]) and after["b"][0] == pytest.approx(2.0)
    assert page.figures.start.data == {"x": [0.0], "y": [2.0]}
    assert str(page.exploration.shown[0].run.nfev) in page.numbers.object
    page.figures.move(1.0)
    x, y = (page.figures.parts["points"].data[axis][0] for axis in "xy")
    theta = page.exploration.shown[0].run.sol(1.0)[0]
    assert (x, y) == (pytest.approx(np.sin(theta)), pytest.approx(-np.cos(theta)))


def test_a_second_method_is_drawn_beside_the_first(page):
    method, _, step = page.methods[1]
    method.value = "RK4"
    assert step.visible and len(page.figures.curves[1].data["t"]) > 100
    assert "RK4, h = 0.01 s" in page.numbers.object
    method.value = "none"
    assert len(page.figures.curves[1].data["t"]) == 0 and not step.visible


def test_wrong_input_is_said_and_taken_back(page):
    before = page.figures.curves[0].data["a"]
    page.sliders["l"].value = -1.0
    assert page.trouble.visible and "greater than zero" in page.trouble.object
    assert page.figures.curves[0].data["a"] is before
    page.sliders["l"].value = 1.0
    assert not page.trouble.visible


def test_the_start_is_dragged_until_a_slider_sets_it(page):
    page.figures.start.data = {"x": [0.5], "y": [1.0]}
    assert page.exploration.shown[0].y[:, 0].tolist() == [0.5, 1.0]
    page.sliders["V0"].value = 1.5
    assert page.exploration.y0 is None and page.figures.start.data["y"] == [1.5]


def test_a_system_in_space_is_drawn():
    made = Page(named("spherical_pendulum"))
    made.figures.move(0.5)
    assert not made.figures.motion.axis[0].visible


def test_a_notebook_gets_the_panel():
    import panel

    assert isinstance(pendulum(V0=2.0).explore(), panel.viewable.Viewable)
