"""Angles in degrees are taken where they say so, and warned of where they seem to be meant."""

import math
import warnings

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.cli.main import main
from fastdyn.derive import Model, i
from fastdyn.systems import SYSTEMS


def angles(system):
    fields = system.__dataclass_fields__.values()
    return [one.name for one in fields if one.metadata.get("unit") == "rad"]


ANGLES = [(name, field) for name, system in SYSTEMS.items() for field in angles(system)]


def test_some_systems_have_angles():
    assert ("tower", "angle") in ANGLES and ("pendulum", "theta0") in ANGLES


@pytest.mark.parametrize(("name", "field"), ANGLES)
def test_an_angle_beyond_a_turn_is_warned_of_and_degrees_are_taken(name, field):
    system = SYSTEMS[name]
    with pytest.warns(UserWarning, match=rf"`{field}` of the {name} is 45 rad.*'45 deg'"):
        system(**{field: 45})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for text in ("45 deg", "45deg", "45°", "0.125 rev", " +4.5e1 deg ", f"{math.pi / 4} rad"):
            assert getattr(system(**{field: text}), field) == pytest.approx(math.pi / 4, rel=1e-15)
        assert getattr(system(**{field: "0.5"}), field) == 0.5
        assert getattr(system(**{field: "720 deg"}), field) == 4 * math.pi
        for turn in (6.28, -6.28, -1.0):
            system(**{field: turn})
    for wrong, sentence in (("45 grad", "not in rad or deg"), ("45 m", "not in rad")):
        with pytest.raises(ValueError, match=rf"`{field}` .*{sentence}"):
            system(**{field: wrong})
    for wrong in ("steep", "", "deg", "4 5 deg"):
        with pytest.raises((TypeError, ValueError), match=rf"`{field}` .*(one real number|not in)"):
            system(**{field: wrong})


def test_other_units_are_taken_where_they_are_known():
    assert systems.rod(omega="60 rpm").omega == pytest.approx(2 * math.pi)
    assert systems.rod(omega="180 deg/s").omega == pytest.approx(math.pi)
    assert systems.tower(h="71 m").h == 71.0
    with pytest.raises(ValueError, match="not in m"):
        systems.tower(h="71 ft")
    with pytest.raises(ValueError, match="greater than zero"):
        systems.tower(h="-71 m")


def test_derived_systems_take_degrees_too():
    board = Model("disc")
    angle, x = board.initial(a=(0.1, "rad")), board.coordinates("x")
    board.particle(board.parameters(m=(1.0, "kg")), x * i)
    board.start(x=angle)
    system = board.lagrange().system
    assert system(a="90 deg").initial_state()[0] == pytest.approx(math.pi / 2)
    with pytest.warns(UserWarning, match="`a` of the disc is 90 rad"):
        system(a=90)


@pytest.mark.filterwarnings("ignore:`angle` of the tower")
def test_ensembles_warn_too():
    with pytest.warns(UserWarning, match="`angle` of the tower is 80 rad"):
        systems.tower().ensemble((0, 1), angle=np.linspace(0.0, 80.0, 3))
    one = systems.tower().ensemble((0, 1), angle="45 deg", h=[71.0, 72.0])
    assert one.success.all()


@pytest.mark.filterwarnings("always:`angle` of the tower")
def test_the_command_line_takes_and_tells_degrees(capsys):
    assert main(["run", "tower", "--angle", "45deg"]) == 0
    in_degrees = capsys.readouterr().out
    assert main(["run", "tower", "--angle", str(math.pi / 4)]) == 0
    assert capsys.readouterr().out == in_degrees
    assert "best angle = 0.279" in in_degrees and "rad (16.0" in in_degrees
    assert main(["sweep", "tower", "--angle", "0deg:80deg:321", "--t-end", "100"]) == 0
    assert "at angle = 0.279253 (16°)" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["run", "tower", "--angle", "45 m"])
    assert "not in rad or deg" in capsys.readouterr().err
    assert main(["run", "tower", "--angle", "45"]) == 0
    assert "'45 deg'" in capsys.readouterr().err
