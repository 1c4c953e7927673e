"""An exploration without a browser: values, ways to solve, numbers, and exported files."""

import dataclasses
import pathlib
import time

import numpy as np
import pytest

from fastdyn.cli.main import main
from fastdyn.explore import explore, export, pictures
from fastdyn.explore.exploration import Exploration, Way
from fastdyn.explore.sliders import slider
from fastdyn.explore.sources import known, named, of_file, of_system
from fastdyn.systems import SYSTEMS, pendulum, satellite


@pytest.fixture
def swing():
    found = Exploration(named("pendulum"))
    found.solve()
    return found


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_has_sliders_around_its_values_and_a_picture(name):
    found = Exploration(named(name))
    for one in found.sliders:
        assert one.low <= one.value <= one.high and 0.0 < one.step < one.high - one.low
        dataclasses.replace(found.system, **{one.name: one.low})  # every end is a value
        dataclasses.replace(found.system, **{one.name: one.high})
    found.t_end = min(found.t_end, 2.0)
    found.solve()
    (shown,) = found.shown
    assert shown.y.shape == (len(found.make.states), len(shown.t)) and "steps" in shown.numbers()
    limits, scene = found.stage()
    assert len(limits) in (2, 3)
    assert pictures.columns(scene(0.5 * shown.t[-1]))["points"]["x"].shape[0] >= 0


def test_a_slider_holds_the_value_that_it_begins_with():
    (length,) = (one for one in dataclasses.fields(pendulum) if one.name == "l")
    assert slider(length, 1.0)[3:7] == (1.0, pytest.approx(0.1), 3.0, 0.02)
    assert slider(length, 50.0).high >= 50.0


def test_the_numbers_are_those_of_the_solve(swing):
    run = pendulum(V0=4.0).solve(rtol=1e-6, atol=1e-9)
    (shown,) = swing.shown
    assert shown.numbers()["steps"] == str(run.n_accepted)
    assert shown.numbers()["evaluations"] == str(run.nfev)
    assert np.allclose(shown.y[:, -1], run.y[:, -1], rtol=1e-12)
    energy = run.invariants()["energy"]
    assert shown.kept[-1] == pytest.approx(energy[-1] / energy[0] - 1.0, rel=1e-6)


@pytest.mark.parametrize("name", ["building", "satellite", "cable", "double_pendulum"])
def test_no_chord_is_seen(name):
    found = Exploration(named(name))
    found.solve()
    (shown,) = found.shown
    middle = 0.5 * (shown.t[1:] + shown.t[:-1])
    off = np.abs(shown.run.sol(middle) - 0.5 * (shown.y[:, 1:] + shown.y[:, :-1]))
    seen = off > 2e-3 * np.ptp(shown.y, axis=1)[:, None]
    assert seen.any(axis=0).sum() <= 3  # jumps of a velocity
    assert len(shown.t) < 10_000


def test_the_time_of_a_solve_holds_no_compilation(monkeypatch):
    found, solved = Exploration(named("satellite")), []
    make = type(found.system)
    first = make.solve

    def slow(*given, **options):
        solved.append(options["method"])
        if solved.count(options["method"]) == 1:
            time.sleep(0.5)  # as a compilation
        return first(*given, **options)

    monkeypatch.setattr(make, "solve", slow)
    found.t_end, found.ways = 1.0, [Way(), Way("VelocityVerlet", step=0.05)]
    found.solve()
    assert max(one.seconds for one in found.shown) < 0.4
    found.solve()
    assert len(solved) == 6  # a solve that is warm is done once


def test_a_start_that_is_dragged_holds(swing):
    swing.drag(0.5, -1.0)
    swing.solve()
    assert swing.shown[0].y[:, 0].tolist() == [0.5, -1.0]
    assert swing.arguments(swing.ways[0])["y0"] == [0.5, -1.0]


def test_two_methods_side_by_side_spiral_and_stay():
    found = Exploration(named("satellite"))
    found.t_end = 60.0
    found.ways = [Way("ode45", rtol=1e-3), Way("VelocityVerlet", step=0.05)]
    found.solve()
    spiral, verlet = found.shown
    assert spiral.label == "ode45, rtol 1e-03" and verlet.label == "VelocityVerlet, h = 0.05 s"
    assert np.abs(spiral.kept).max() > 0.1 > 1e-3 > np.abs(verlet.kept).max()


def test_wrong_values_are_said_and_the_last_curves_stay(swing):
    before = swing.shown
    for name, value, sentence in (("l", -1.0, "greater than zero"), ("g", np.nan, "finite")):
        swing.values |= {name: value}
        with pytest.raises(ValueError, match=sentence):
            swing.solve()
        assert swing.shown is before
        swing.values |= {name: 1.0}
    swing.ways = [Way("RK4", step=1e-4)]
    swing.t_end = 1e3
    swing.solve()  # is cut off, and says so
    assert "max_steps" in swing.shown[0].numbers()["end"]


def test_the_exported_script_makes_the_figure_and_the_numbers(swing, tmp_path, monkeypatch):
    swing.values["V0"], swing.t_end = 3.0, 5.0
    swing.ways = [Way("DOP853", rtol=1e-8), Way("RK4", step=0.02)]
    swing.drag(0.2, 1.0)
    swing.solve()
    space = ran(export.script(swing), tmp_path, monkeypatch)
    assert (tmp_path / "pendulum.png").stat().st_size > 1000
    for shown, run in zip(swing.shown, space["runs"].values(), strict=True):
        assert np.array_equal(run.y, shown.run.y) and np.array_equal(run.t, shown.run.t)
    assert export.script(swing).splitlines()[0] == '"""Pendulum, as it was explored."""'
    lines = export.table(swing).splitlines()
    assert lines[0] == "t (s),theta (rad),omega (rad/s)" and lines[1] == "0,0.2,1"
    assert export.picture(swing).startswith(b"\x89PNG")


def ran(script, folder, monkeypatch):
    monkeypatch.chdir(folder)
    space = {}
    exec(compile(script, "script.py", "exec"), space)
    return space


def test_scripts_of_functions_of_derived_systems_and_of_files(tmp_path, monkeypatch):
    car = Exploration(named("vehicle"))
    car.values["driver"], car.t_end, car.project = car.choices["driver"]["steady"], 2.0, True
    car.solve()
    run = ran(export.script(car), tmp_path, monkeypatch)["run"]
    assert np.array_equal(run.y, car.shown[0].run.y)
    path = pathlib.Path(tmp_path, "blackboards.py")
    path.write_text(
        "from fastdyn.derive import Model, j\n"
        "def ball(name):\n"
        "    board = Model(name, 'A ball', t_end=1.0)\n"
        "    z = board.coordinates('z')\n"
        "    m, g = board.parameters(m=(1.0, 'kg'), g=(9.81, 'm/s²'))\n"
        "    board.particle(m, z * j)\n"
        "    board.gravity(-g * j)\n"
        "    return board\n"
        "one, other = ball('one'), ball('other')\n"
    )
    from fastdyn.cli.find import in_file

    with pytest.raises(ValueError, match="must make one system or model; it makes one, other"):
        in_file(str(path))
    with pytest.raises(ValueError, match="has no `third`"):
        in_file(f"{path}:third")
    ball = Exploration(of_file(f"{path}:other", in_file(f"{path}:other")))
    ball.values["g"] = 1.62
    ball.solve()
    run = ran(export.script(ball), tmp_path, monkeypatch)["run"]
    assert run.y[0, -1] == pytest.approx(-0.81) and np.array_equal(run.y, ball.shown[0].run.y)


def test_a_system_brings_its_values():
    source = of_system(satellite(V=1.2))
    assert source.values["V"] == 1.2 and Exploration(source).system == satellite(V=1.2)
    assert "double_pendulum" in known()


def test_words_of_the_command(capsys):
    assert main(["explore", "nonsense"]) == 2
    assert "No system is called nonsense" in capsys.readouterr().err


def test_without_panel_a_sentence(monkeypatch, capsys):
    import sys

    monkeypatch.setitem(sys.modules, "panel", None)
    monkeypatch.delitem(sys.modules, "fastdyn.explore.serve", raising=False)
    monkeypatch.delitem(sys.modules, "fastdyn.explore.page", raising=False)
    with pytest.raises(ImportError, match=r"fastdyn\[explore\]"):
        explore(pendulum())
    assert main(["explore", "pendulum"]) == 2
    assert "fastdyn[explore]" in capsys.readouterr().err


def test_other_work_of_the_machine_is_no_time_of_the_solve(swing, monkeypatch):
    first = type(swing.system).solve

    def waits(*given, **options):
        time.sleep(0.5)
        return first(*given, **options)

    monkeypatch.setattr(type(swing.system), "solve", waits)
    swing.solve()
    assert swing.shown[0].seconds < 0.4
