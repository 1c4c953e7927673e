"""The worksheets: every system has one, its commands run, its answers hold."""

import math
import pathlib
import re

import numpy as np
import pytest

from fastdyn.cli.main import _parser, main
from fastdyn.course.worksheets import exercises, sheet, turns
from fastdyn.systems import SYSTEMS
from fastdyn.systems.vehicle import Vehicle

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "worksheets.md"


@pytest.mark.hunt
@pytest.mark.filterwarnings("ignore::fastdyn.StiffnessWarning")  # the rod that slips is stiff
def test_the_page_is_what_the_command_prints(capsys):
    assert main(["worksheet", "--answers"]) == 0
    text = capsys.readouterr().out
    assert text == PAGE.read_text("utf-8"), "run `fastdyn worksheet --answers > docs/worksheets.md`"
    assert not re.search(r"\b(nan|inf)\b", text)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_has_exercises_whose_commands_are_words_of_the_command_line(name):
    assert exercises(name)
    for one in exercises(name):
        if one.command:
            options = _parser(SYSTEMS).parse_args(one.command.split())
            assert options.system is SYSTEMS[name]
    assert f"## {SYSTEMS[name].title}" in PAGE.read_text("utf-8")


ARE, AT, TO = (
    r"{} = (\S+)",
    r"{}: largest \S+ \S+ at \w+ = (\S+)",
    r"{} = \S+ .*\(from \S+ to (\S+)\)",
)
TOLD = {  # what a command prints, and what it is in the answer
    ("projectile", 0): {ARE.format("flight time"): 4 * 20 / 9.81, ARE.format("range"): 230.6566},
    ("projectile", 1): {ARE.format("range"): 349.2},
    ("nanoparticle", 0): {ARE.format("apex height"): 7.92e-9},
    ("nanoparticle", 1): {ARE.format("apex height"): 15.8e-3},
    ("tower", 0): {r"x: largest .* \((\S+)°\); smallest": 16.0},
    ("tower", 1): {ARE.format("range"): 218.6, ARE.format("best range"): 225.1,
                   r"best angle = .*\((\S+)°\)": 36.2},
    ("suspension", 0): {ARE.format("period"): 2 * 0.7024814731,
                        ARE.format("static deflection"): 4 * 0.122625},
    ("suspension", 1): {r"  x = (\S+)": 0.3774},
    ("rod", 0): {r"  r = (\S+)": 0.2347513},
    ("rod", 1): {ARE.format("growth rate"): 0.0333, r"  v = (\S+)": 0.0333 * 0.023325},
    ("pendulum", 0): {ARE.format("period"): 1.18034 * 2 * math.pi / math.sqrt(9.81),
                      r"largest angle = .*\((\S+)°\)": 90.0},
    ("pendulum", 1): {r"slack: not (\S+)": "reached"},
    ("cable", 0): {r"taut angle = .*\((\S+)°\)": 31.6,
                   r"energy = (\S+) J": (1 - 0.555) * 0.5 * 3 * 9.81},
    ("drag", 0): {r"x: largest (\S+) m at c = 0;": 40.77, r"smallest (\S+) m at c = 0.5": 2.866},
    ("drag", 1): {ARE.format("terminal speed"): 2.215, r"  vz = -(\S+)": 2.215},
    ("satellite", 0): {ARE.format("period"): math.sqrt(39.4784 * 1.785714**3)},
    ("satellite", 1): {r"energy has changed by -(\S+)": 0.5 * 0.027e-2},
    ("building", 0): {r"y2: largest \S+ m at omega = (\S+);": 12.36},
    ("building", 1): {r"y2: largest (\S+) m at omega = 9;": None},
    ("pendulum_xy", 0): {r"circle is off by (\S+) m at": 8.4e-2},
    ("pendulum_xy", 1): {r"  x = \S+ m  \(error (\S+)\)": None},
    ("vehicle", 0): {r"speed = (\S+)": None, r"omega = (\S+)": None},
    ("vehicle", 1): {r"front force = .* to (\S+)\)": None},
}  # fmt: skip


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_command_of_an_exercise_prints_its_answer(name, capsys):
    for number, one in enumerate(exercises(name)):
        if not one.command:
            continue
        assert main(one.command.split()) == 0
        out = capsys.readouterr().out
        assert not re.search(r"\b(nan|inf)\b", out)
        for pattern, expected in TOLD[name, number].items():
            found = re.search(pattern, out, re.MULTILINE)
            assert found, (one.command, pattern)
            if isinstance(expected, float):
                digits = 2 if expected < 1.0 else 3
                assert float(found[1]) == pytest.approx(expected, rel=2 * 10.0**-digits), pattern
            elif expected:
                assert found[1] == expected


@pytest.mark.hunt
def test_numbers_that_have_to_be_put_together(capsys):
    main(["run", "vehicle", "--driver", "tight", "--project", "--t-end", "300"])
    out = capsys.readouterr().out
    speed, omega = (float(re.search(rf"  {n} = (\S+)", out)[1]) for n in ("speed", "omega"))
    assert speed / omega == pytest.approx(Vehicle().circle_radius(0.2), rel=1e-4)
    main(["run", "vehicle"])
    low, high = re.search(
        r"front force = \S+ N  \(from (\S+) to (\S+)\)", capsys.readouterr().out
    ).groups()
    needed = max(-float(low), float(high)) / (0.5 * 9.81)
    answer = exercises("vehicle")[1].answer().text
    assert f"needs {needed:.1g}" in answer or f"needs {needed:.2g}" in answer
    main(["sweep", "building", "--omega", "9,60", "--reduce", "max", "min"])
    rows = re.findall(r"^ +(?:9|60) +\S+ +(\S+) ", capsys.readouterr().out, re.MULTILINE)
    highest, high, lowest, low = map(float, rows)
    assert (highest - lowest) / 2 == pytest.approx(4.0, rel=0.02)
    assert (high - low) / 2 == pytest.approx(0.025, rel=0.05)


def test_an_answer_that_does_not_hold_makes_the_status_one(monkeypatch, capsys):
    wrong = sheet.exercises("rod")[0]._replace(answer=lambda: turns.Answer("no", False))
    monkeypatch.setattr(sheet, "exercises", lambda name: [wrong])
    assert main(["worksheet", "rod", "--answers"]) == 1
    assert main(["worksheet", "rod"]) == 0
    assert "Answers" not in capsys.readouterr().out.split("no")[-1]
    assert main(["worksheet", "moon"]) == 2


@pytest.mark.hunt
@pytest.mark.filterwarnings("ignore::fastdyn.StiffnessWarning")
def test_a_car_that_grips_is_the_car_that_rolls():
    """With all the grip in the world the wheels hardly slide, and the circle is that of rolling."""
    ((speed, radius),) = turns.skid_circles([0.2], mu=30.0)
    rolling = Vehicle()
    assert radius == pytest.approx(rolling.circle_radius(0.1), rel=1e-3)
    assert speed == pytest.approx(rolling.terminal_speed(0.1, 0.2), rel=1e-3)


def test_friction_only_takes_energy_from_the_skidding_car():
    """Without thrust and drag: kinetic energy of the mass and the chassis, against the wheels."""
    car, w = Vehicle(), np.array([0.0, 0.0, 0.3, 2.0, 0.5, -1.0])
    rate = turns.skidding(0.0, w, car.m, car.L, 0.0, 0.3, 9.81, 0.1, 0.0)
    inertia = car.m * car.L**2 / 12.0
    power = car.m * (w[3] * rate[3] + w[4] * rate[4]) + inertia * w[5] * rate[5]
    s, cs, sf, cf = math.sin(0.3), math.cos(0.3), math.sin(0.4), math.cos(0.4)
    rear = s * w[3] + cs * w[4] + 0.5 * car.L * w[5]
    front = sf * w[3] + cf * w[4] - 0.5 * car.L * math.cos(0.1) * w[5]
    hold = 0.5 * 0.3 * car.m * 9.81
    taken = sum(hold * x * x / math.hypot(x, turns.SLIDING) for x in (rear, front))
    assert power == pytest.approx(-taken, rel=1e-12)
