"""The tour: what it tells, draws and returns."""

import dataclasses
import math
from typing import ClassVar

import numpy as np
import pytest

from fastdyn.cli.main import main
from fastdyn.course import tour
from fastdyn.course.lessons import satellite
from fastdyn.course.tour import Board, Check
from fastdyn.systems import SYSTEMS, State, System, parameter, quantity


@pytest.mark.hunt
def test_tour_passes_and_writes_its_figures(told):
    status, text, board = told
    assert status == 0 and "FAIL" not in text
    names = {path.name for path in board.folder.iterdir()}
    assert {"satellite-orbits.png", "satellite-drift.png", "pendulum-regimes.png"} <= names
    assert all(path.stat().st_size > 10_000 for path in board.folder.iterdir())
    assert str(board.folder) in text


@pytest.mark.hunt
def test_tour_tells_the_published_numbers(told):
    _, text, _ = told
    for words in ("0.71032388", "0.027 %", "status -1", "velocity Verlet", "separatrix"):
        assert words.lower() in text.lower()
    assert all(system.title in text for system in SYSTEMS.values())


@pytest.mark.hunt
def test_a_failing_check_makes_the_status_one(tmp_path, monkeypatch, capsys):
    wrong = {**satellite.ODE45, 1e-3: (170, 0.71, "-40.39", "-15.60")}
    monkeypatch.setattr(satellite, "ODE45", wrong)
    assert main(["tour", "satellite", "--out", str(tmp_path)]) == 1
    text = capsys.readouterr().out
    assert text.count("FAILS") == 2 and "FAILED: ode45, RelTol 1e-3: steps: 169 inst" in text


@pytest.mark.parametrize(
    "computed, exact, tolerance, passes",
    [
        (1.0, 1.0, 0.0, True),
        (1.0, 1.1, 0.2, True),
        (1.1, 1.0, 0.05, False),
        (0.9, 1.0, 0.05, False),
        (math.nan, 1.0, 1.0, False),
        (1.0, 1.0, math.nan, False),
    ],
)
def test_a_check_passes_within_its_tolerance_only(computed, exact, tolerance, passes):
    check = Check("quantity", computed, exact, tolerance)
    assert check.passes is passes
    assert str(check).endswith("ok" if passes else "FAILS")


@quantity("m²/s²", "energy E/m")
def energy(t, w, g):
    x, v = w
    return 0.5 * v * v + g * x


@dataclasses.dataclass(frozen=True)
class Falling(System):
    """Free fall, a system without a lesson, whose exact solution may believe another g."""

    name = "falling"
    title = "Free fall"
    source = "none"
    states = (State("x", "m", "height"), State("v", "m/s", "velocity"))
    t_end = 1.0
    invariants: ClassVar = {"energy": energy}
    believed: ClassVar = 9.81

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    @staticmethod
    def rhs(t, w, g):
        _, v = w
        return [v, -g]

    def initial_state(self):
        return (10.0, 0.0)

    def exact(self, t):
        t = np.asarray(t)
        return np.array([10.0 - 0.5 * self.believed * t**2, -self.believed * t])


@pytest.mark.parametrize("believed, failed", [(9.81, 0), (9.8, 1)])
def test_a_system_without_a_lesson_gets_the_standard_one(believed, failed, tmp_path, monkeypatch):
    monkeypatch.setattr(Falling, "believed", believed)
    monkeypatch.setitem(SYSTEMS, "falling", Falling)
    lines = []
    assert tour.run(tmp_path, ["falling"], lines.append).n_failed == failed
    assert (tmp_path / "falling.png").exists()
    assert any("relative change of energy" in line for line in lines)


def test_board_wraps_and_counts(tmp_path):
    lines = []
    board = Board(tmp_path / "a" / "b", lines.append)
    board.heading("Title")
    board.say("word " * 60)
    board.check("good", 1, 1, 0)
    board.check("bad", 1, 2, 0)
    assert board.n_failed == 1 and max(map(len, lines)) <= 110 and board.folder.is_dir()
