"""A derived system does what every system does: text, ensembles, drift, command line."""

import math
import re

import numpy as np
import pytest
from numba import cloudpickle

import fastdyn
from fastdyn.cli.find import PAGES as LISTED
from fastdyn.cli.main import main
from fastdyn.derive import Model, cross, dot, i, j, k, length, rate, rotation
from fastdyn.derive.pages import PAGES, page
from fastdyn.derive.pages.vehicle import drunk
from fastdyn.systems.vehicle import steady


def test_text_is_what_a_person_would_write():
    text = page("pendulum").newton().system.rhs.text
    assert text == (
        "def rhs(t, w, g, l, m):\n"
        "    theta, omega = w\n"
        "    theta_dd = -g*sin(theta)/l\n"
        "    return [omega, theta_dd]\n"
    )


def test_common_parts_are_computed_once():
    text = page("vehicle").newton().system.rhs.text
    for function in ("cos(alpha)", "sin(th)", "cos(th)", "sqrt("):
        assert text.count(function) == 1
    names = re.findall(r"^    (c\d+) =", text, re.M)
    assert names == [f"c{n + 1}" for n in range(len(names))]


def test_functions_take_one_state_and_many():
    system = page("heavy_top").newton().system()
    run = system.solve((0.0, 0.2))
    for name, function in (system.quantities | system.invariants).items():
        single = [function(t, y, *system.args) for t, y in zip(run.t, run.y.T, strict=True)]
        along = system.along(function, run.t, run.y)
        scale = np.abs(single).max()
        if name in system.invariants:  # nothing has to be solved
            assert np.shape(function(run.t, run.y, *system.args)) == run.t.shape
        assert along == pytest.approx(np.array(single), abs=1e-14 * scale), name


def test_right_hand_side_is_compiled(recwarn):
    for name in ("vehicle", "closed_chain"):
        system = page(name).derive().system()
        assert system.solve((0.0, 0.5), project=True).success
    assert not [w for w in recwarn if issubclass(w.category, fastdyn.CompileWarning)]


def test_ensemble_is_its_members():
    system = page("four_bar").derive().system()
    speeds = np.array([2.0, 4.0, 6.0])
    together = system.ensemble((0.0, 1.0), w0=speeds, project=True)
    for n, w0 in enumerate(speeds):
        alone = system.derivation.system(w0=w0).solve((0.0, 1.0), project=True)
        assert together.y[n] == pytest.approx(alone.y[:, -1], rel=1e-5)


def test_energy_drift_of_a_derived_system():
    system = page("double_pendulum").newton().system(a1=0.5, a2=0.3)
    study = fastdyn.energy_drift(system, "Gauss16", step=0.02, n_steps=500)
    assert "energy" in str(study)
    assert not study.message


def test_events_of_the_blackboard():
    system = page("pendulum").newton().system(V0=5.9)
    run = system.solve((0.0, 5.0), events="slack")
    assert run.status == 1
    theta = run.y[0, -1]
    assert math.cos(theta) == pytest.approx((2.0 - 5.9**2 / 9.81) / 3.0, rel=1e-5)


def test_drivers_are_exchanged():
    system = page("vehicle").newton().system
    assert system().driver is drunk
    car = system(driver=steady)
    run = car.solve((0.0, 120.0))
    speed = np.hypot(run.y[3, -1], run.y[4, -1])
    assert speed == pytest.approx(fastdyn.systems.vehicle().terminal_speed(0.1, 0.2), rel=1e-5)


def test_systems_travel_to_other_processes():
    system = page("four_bar").derive().system(w0=3.0)
    there = cloudpickle.loads(cloudpickle.dumps(system))
    assert there.initial_state() == system.initial_state()
    y = system.initial_state()
    assert there.rhs(0.0, y, *there.args) == system.rhs(0.0, y, *system.args)


def test_command_line_takes_pages_and_files(tmp_path, capsys):
    assert main(["run", "chaplygin_sleigh", "--w0", "1", "--t-end", "1", "--project"]) == 0
    assert "slip1 is off by" in capsys.readouterr().out
    assert tuple(LISTED) == PAGES
    file = tmp_path / "mine.py"
    file.write_text(
        "from fastdyn.derive import Model, j\n"
        "board = Model('fall')\n"
        "z = board.coordinates('z')\n"
        "m, g = board.parameters(m=(1.0, 'kg'), g=(9.81, 'm/s²'))\n"
        "board.particle(m, z * j)\n"
        "board.gravity(-g * j)\n"
    )
    assert main(["run", str(file), "--g", "2", "--t-end", "1"]) == 0
    assert "z = -1 m" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["run", "nothing"])
    assert "choose from" in capsys.readouterr().err
    file.write_text("x = 1\n")
    assert main(["run", str(file)]) == 2
    assert "must make one system or model; it makes none" in capsys.readouterr().err


def test_springs_and_dampers_between_bodies():
    """Two masses on a spring: the reduced mass swings, the damper takes energy."""
    board = Model("pair")
    x1, y1, x2, y2 = board.coordinates("x1 y1 x2 y2")
    m1, m2, s = board.parameters(m1=(2.0, "kg"), m2=(3.0, "kg"), s=(30.0, "N/m"))
    c = board.parameters(positive=False, c=(0.0, "N s/m"))
    a, b = board.particle(m1, x1 * i + y1 * j), board.particle(m2, x2 * i + y2 * j)
    board.spring(a, b, s, 1)
    board.damper(a, b, c)
    board.start(x2=1.1)
    board.quantity("centre", (m1 * x1 + m2 * x2) / (m1 + m2), "m")
    for law in (board.newton, board.lagrange):
        system = law().system
        assert "energy" in system.quantities  # for any c it is no invariant
        run = system().solve((0.0, 3.0), rtol=1e-10, atol=1e-12)
        w = math.sqrt(30.0 * (1 / 2.0 + 1 / 3.0))
        assert run.y[2] - run.y[0] == pytest.approx(1.0 + 0.1 * np.cos(w * run.t), abs=1e-8)
        assert run.quantities()["centre"] == pytest.approx(0.66, rel=1e-9)
        damped = system(c=1.0).solve((0.0, 3.0)).quantities()["energy"]
        assert damped[-1] < 0.9 * damped[0] and np.all(np.diff(damped) < 1e-9)


@pytest.mark.hunt
def test_a_free_body_in_space_keeps_its_angular_momentum():
    """Three moments of inertia: Euler's law in the frame of the body, H in the fixed one."""
    board = Model("stone")
    a, b, c = board.coordinates("a b c", "rad")
    A, B, C = board.parameters(A=(1.0, "kg m²"), B=(2.0, "kg m²"), C=(3.0, "kg m²"))
    stone = board.body(1, 0 * i, (A, B, C), rotation(a, k) * rotation(b, i) * rotation(c, k))
    H = stone.momentum()
    for n, axis in enumerate("xyz"):
        board.invariant(f"H{axis}", H[n], "kg m²/s")
    board.invariant("size", length(H), "kg m²/s")
    board.start(b=1.0, va=0.3, vb=0.1, vc=2.0)
    run = board.newton().system().solve((0.0, 3.0), rtol=1e-10, atol=1e-12)
    for values in run.invariants().values():
        assert np.ptp(values) <= 1e-8 * 6.0


def test_vectors_of_rotations():
    angle = rotation(math.pi / 2, k)
    assert [float(x) for x in angle * i] == pytest.approx([0, 1, 0], abs=1e-16)
    both = rotation(math.pi / 2, k) * rotation(math.pi / 2, i)
    assert [float(x) for x in both * j] == pytest.approx([0, 0, 1], abs=1e-15)
    assert dot(cross(i, j), k) == 1 and rate(3 * i) == 0 * i
