"""The page without a browser: its widgets move the curves."""

import asyncio
import html
import importlib.util
import threading
import time

import numpy as np
import pytest

from fastdyn.explore import export
from fastdyn.explore.exploration import Exploration
from fastdyn.explore.sources import named
from fastdyn.systems import SYSTEMS, pendulum

if importlib.util.find_spec("panel") is None:
    pytest.skip("the extra `explore` is not installed", allow_module_level=True)


def page_of(name):
    from fastdyn.explore.page import Page  # imports Panel: only the worker that runs these tests

    return Page(named(name))


@pytest.fixture(scope="module")
def page():
    made = page_of("pendulum")
    made.panel()
    return made


def test_a_slider_moves_curves_numbers_and_picture(page):
    before, n = np.array(page.figures.curves[0].data["a"]), page.updates
    page.sliders["V0"].value = 2.0
    assert page.updates == n + 1
    after = page.figures.curves[0].data
    assert not np.array_equal(before, after["a"]) and after["b"][0] == pytest.approx(2.0)
    assert page.figures.start.data == {"x": [0.0], "y": [2.0]}
    assert str(page.drawn.shown[0].run.nfev) in page.numbers.object
    page.figures.move(1.0)
    x, y = (page.figures.parts["points"].data[axis][0] for axis in "xy")
    theta = page.drawn.shown[0].run.sol(1.0)[0]
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


@pytest.mark.parametrize("text", ["1,5", "abc", "", "nan", "1e999"])
def test_a_text_that_is_no_number_is_said_and_changes_nothing(page, text):
    slider = page.sliders["l"]
    slider.text.value = text
    assert page.trouble.visible and slider.value == 1.0
    assert (
        f"{text!r} is no " in html.unescape(page.trouble.object) and "l (m)" in page.trouble.object
    )
    assert ("with a point it is 1.5" in page.trouble.object) == (text == "1,5")
    slider.text.value = "1.5"
    assert not page.trouble.visible and page.exploration.values["l"] == 1.5
    slider.value = 1.0
    assert slider.text.value == "1" and slider.slider.value == 1.0
    page.t_end.text.value = "-1"
    assert page.trouble.visible and "end (s) must be greater than zero" in page.trouble.object
    page.t_end.text.value = "20"
    assert page.exploration.t_end == 20.0 and not page.trouble.visible


def test_the_second_method_moves_beside_the_first(page):
    page.methods[1][0].value = "RK4"
    page.figures.move(1.0)
    beside = page.figures.beside
    theta = page.drawn.shown[1].run.sol(1.0)[0]
    assert beside["points"].data["x"][0] == pytest.approx(np.sin(theta))
    page.methods[1][0].value = "none"
    page.figures.move(1.1)
    assert len(beside["points"].data["x"]) == len(beside["trail"].data["x"]) == 0


def test_a_trail_follows_the_motion_between_two_pictures():
    page = page_of("satellite")
    page.figures.move(0.0)
    for now in (1.5, 3.0, 4.5):
        page.figures.move(now)
    x, y = (np.array(page.figures.parts["trail"].data[axis]) for axis in "xy")
    assert np.hypot(0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])).min() > 0.99
    page.update()  # in the middle of the motion: no line goes back to the start
    page.figures.move(5.0)
    assert len(page.figures.parts["trail"].data["x"]) == 1


def test_components_of_one_unit_have_one_scale():
    page = page_of("satellite")
    assert not page.figures.phase.match_aspect
    page.axes[1].value = 1
    assert page.figures.phase.match_aspect
    assert page.figures.motion.match_aspect


def test_what_is_not_kept_has_no_figure():
    assert len(_figures(page_of("building"))) == 3
    satellite = page_of("satellite")
    assert len(_figures(satellite)) == 4
    assert "largest change of energy E/m (relative)" in satellite.numbers.object


def _figures(page):
    page.panel()
    return page._panes


def test_a_system_that_is_chosen_is_announced_before_it_is_made(monkeypatch):
    from fastdyn.explore import serve

    said = []
    monkeypatch.setattr(serve.pn.state, "_periodic", {})
    monkeypatch.setattr(serve, "ready", lambda first, name: said.append(_texts(shown)) or other)
    other = named("pendulum")
    shown = serve.application(named("satellite"))()
    asyncio.run(shown[0].param.watchers["value"]["value"][-1].fn(_Event("pendulum")))
    assert "pendulum is being made" in said[0]


class _Event:
    def __init__(self, new):
        self.new = new


def _texts(panel):
    return " ".join(str(one.object) for one in panel.select() if hasattr(one, "object"))


def test_a_start_that_was_dragged_makes_its_sliders_grey_until_it_is_reset(page):
    page.sliders["V0"].value = 1.5
    page.figures.start.data = {"x": [0.5], "y": [1.0]}
    assert page.drawn.shown[0].y[:, 0].tolist() == [0.5, 1.0]
    slider = page.sliders["V0"]
    assert slider.slider.disabled and slider.text.disabled and page.dragged.visible
    assert not page.sliders["l"].slider.disabled
    page.sliders["l"].value = 1.1  # is none of the start
    assert page.figures.start.data == {"x": [0.5], "y": [1.0]}
    page.dragged.clicks += 1
    assert page.exploration.y0 is None and page.figures.start.data["y"] == [1.5 / 1.1]
    assert not slider.slider.disabled and not page.dragged.visible
    page.sliders["l"].value = 1.0


def test_curves_that_no_longer_hold_are_grey_until_the_new_ones_are_there(page, monkeypatch):
    held, solve = threading.Event(), Exploration.solve

    def slow(self):
        held.wait(30.0)
        solve(self)

    monkeypatch.setattr(Exploration, "solve", slow)
    monkeypatch.setattr(page, "_ticking", True)
    before, updates = page.numbers.object, page.updates
    page.methods[0][0].value = "Vern7"
    page.tick()
    page.tick()
    assert "Vern7" in page.waiting.object and page.waiting.visible
    assert page._panes[0].styles["filter"] == "grayscale(1)"
    assert page.numbers.object == before and "RK45" in before
    page.sliders["g"].value = 1.62  # meanwhile
    page.sliders["g"].value = 3.7
    assert "RK45" in export.script(page.drawn) and "g=" not in export.script(page.drawn)
    held.set()
    end = time.monotonic() + 120.0
    while page.drawn.values["g"] != 3.7 and time.monotonic() < end:
        page.tick()
        time.sleep(0.01)
    assert not page.waiting.visible and page._panes[0].styles["filter"] == "none"
    assert "Vern7" in page.numbers.object and page.drawn.values["g"] == 3.7
    assert page.updates == updates + 2  # the value in between was not solved
    monkeypatch.undo()
    page.sliders["g"].value = 9.81
    page.methods[0][0].value = "RK45"


def test_a_motion_is_paused(page, monkeypatch):
    monkeypatch.setattr(page, "_ticking", True)
    page.pause.value = True
    page.tick()
    first = page.figures.motion.title.text
    page.tick()
    assert page.figures.motion.title.text == first
    page.pause.value = False
    page._last -= 1.0  # a second passes
    page.tick()
    assert page.figures.motion.title.text != first


def test_a_start_that_cannot_be_solved_is_said():
    from fastdyn.explore.page import Page

    made = Page(named("pendulum")._replace(values={"l": -1.0}))
    made.tick()
    assert made.trouble.visible and made.updates == 0


def test_a_system_in_space_is_drawn():
    made = page_of("spherical_pendulum")
    made.figures.move(0.5)
    figures = made.figures
    assert not figures.motion.axis[0].visible
    assert figures.names.data["name"] == ["x: 0.5 m", "y: 0.5 m", "z: 0.5 m"]
    lines = [np.diff([figures.arrows.data[c][n] for c in ("xs", "ys")]) for n in range(3)]
    x, y, z = (line.ravel() for line in lines)
    assert (
        x[0] > 0.0
        and y[0] > 0.0
        and z[0] == 0.0
        and z[1] == pytest.approx(0.5 * np.cos(0.349), 1e-3)
    )


def test_a_notebook_gets_the_panel():
    import panel

    assert isinstance(pendulum(V0=2.0).explore(), panel.viewable.Viewable)


@pytest.mark.parametrize("name", [name for name in SYSTEMS if SYSTEMS[name].explored])
def test_the_page_begins_with_a_motion_that_is_seen(name):
    first = named(name)
    assert first.values == SYSTEMS[name].explored
    assert np.ptp(Exploration(first).system.solve().y[0]) > 0.5


def test_a_slider_gives_the_number_that_it_shows():
    from fastdyn.explore.number import NumberSlider  # imports Panel

    slider = NumberSlider("g", 0.1, 0.0, 1.0, 0.1, print)
    slider.slider.value = 0.1 + 0.2  # as browsers add steps
    assert slider.value == 0.3 and slider.text.value == "0.3"


@pytest.mark.parametrize(("name", "ground"), [("tower", True), ("vehicle", False)])
def test_the_motion_has_a_title_the_ground_and_a_shape_of_its_own(name, ground):
    figures = page_of(name).figures
    figures.move(1.0)
    assert figures.motion.title.text.startswith(f"{SYSTEMS[name].title}, t = 1.00 s")
    assert ("car drawn 4 times its size" in figures.motion.title.text) == (name == "vehicle")
    assert bool(figures.ground.data["xs"]) == ground
    (x0, x1), (y0, y1) = (figures.corners.data[one] for one in "xy")
    shape = min(max((x1 - x0) / (y1 - y0), 0.8), 1.8)
    assert figures.motion.aspect_ratio == pytest.approx(shape) and figures.motion.height is None


def test_each_field_of_a_number_has_a_name(page):
    names = [one.text.placeholder for one in (*page.sliders.values(), page.t_end)]
    assert names[0] == "g (m/s²): acceleration of gravity" and all(names)
    assert page.sliders["theta0"].text.placeholder.startswith("θ₀ (rad)")


def test_the_title_has_room_before_the_first_picture():
    """A figure whose title is empty at first is laid out without room for the title."""
    made = page_of("heavy_top")
    assert made.figures.motion.title.text == made.exploration.make.title
    code = made.figures.kept.yaxis[0].formatter.code
    assert "toPrecision" in code  # Bokeh's own formatter writes 0.000e+0
