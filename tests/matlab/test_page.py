"""The scripts of the page "From MATLAB", beside what the chapter prints and the systems say."""

import pathlib
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from fastdyn import systems

PAGE = (pathlib.Path(__file__).parents[2] / "docs" / "matlab.md").read_text("utf-8")
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
PYTHON, MATLAB = (rf"```{language}\n(.*?)```" for language in ("python", "matlab"))


def run(section):
    """The variables that the scripts of a section leave."""
    scope = {}
    for block in re.findall(PYTHON, SECTIONS[section], re.DOTALL):
        exec(block, scope)
    plt.close("all")
    return scope


@pytest.mark.parametrize(
    ("section", "name", "rtol"),
    [
        ("Building", "building", 1e-3),
        ("Pendulum with a constraint", "pendulum_xy", 1e-3),
        ("Vehicle", "vehicle", 1e-5),
    ],
)
def test_a_script_is_the_system(section, name, rtol):
    """The same equations in another form: the same steps, apart by rounding that grows."""
    scope = run(section)
    result = systems.SYSTEMS[name]().solve(method="ode45", rtol=rtol)
    assert np.array_equal(scope["t"][::4].shape, result.t.shape)
    off = np.abs(scope["w"][::4].T - result.y).max()
    # Each evaluation adds a rounding, as its form is another, and shifts the phase of all steps.
    growth = result.nfev * len(result.t)
    assert off <= np.finfo(float).eps * growth * np.abs(result.y).max()


def test_the_projectile_and_where_it_lands():
    scope = run("Projectile with air resistance")
    landed = systems.drag().solve(method="ode45", events="ground")
    assert scope["te"] == pytest.approx(landed.t_events[0], rel=1e-12)
    assert scope["landing_speed"] == pytest.approx(4.249, abs=5e-4)
    assert scope["t"][-1] == scope["te"][0]


def test_the_satellite_spirals_in_and_is_repaired():
    """The chapter: it spirals inwards at the default tolerance; at 1e-5 of order 0.01 %."""
    scope = run("Satellite")
    r, energy, momentum = scope["r"], scope["energy"], scope["angularm"]
    assert len(r) == 677 and r[-1] == pytest.approx(0.710, abs=5e-4)
    revolutions = [r[i : i + 40].mean() for i in range(0, 640, 40)]
    assert (np.diff(revolutions) < 0).all()
    assert energy[-1] / energy[0] - 1 > 0.4 and momentum[-1] < 0.9
    repaired = scope["repaired"]
    assert 1e-5 < np.abs(repaired / repaired[0] - 1).max() < 1e-3  # "of order 0.01 %"
    assert np.abs(np.hypot(*scope["w"].T[:2]) - 1).max() < 1e-3  # "perfectly circular"


def test_both_columns_are_there_and_name_the_same_solver():
    scripts = {name: text for name, text in SECTIONS.items() if "```matlab" in text}
    assert len(scripts) == 5
    for text in scripts.values():
        ours, theirs = (re.findall(language, text, re.DOTALL) for language in (PYTHON, MATLAB))
        assert len(ours) == len(theirs) >= 1
        for a, b in zip(ours, theirs, strict=True):
            assert a.count(" = ode45(") == b.count(" = ode45(")
