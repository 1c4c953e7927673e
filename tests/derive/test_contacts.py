"""Contacts with friction of turning bodies, several at once, and those that have no motion."""

import numpy as np
import pytest
from sympy import cos, sin

from fastdyn.derive import Model, i, j, k, rotation

EPS, G, MU = np.finfo(float).eps, 9.81, 0.5
TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
TIMES = 1e3 * EPS  # relative: rounding of motions that a polynomial of the method has exactly


def changes(run):
    return [name for name, *_ in run.phases], [begin for _, begin, _ in run.phases[1:]]


def test_two_contacts_change_each_for_itself():
    board = Model("two")
    x, y, u, z = board.coordinates("x y u z")
    m, g, mu = board.parameters(m=(1.0, "kg"), g=(G, "m/s²"), mu=(MU, "1"))
    A, B = board.reactions("A B")
    board.gravity(-g * j)
    for across, up, N in ((x, y, A), (u, z, B)):
        block = board.particle(m, across * i + up * j)
        block.slides(j, N, through=0 * i, friction=mu, along=i)
    board.start(vx=1.0, vu=-2.0)
    run = board.newton().system().solve((0, 1), **TIGHT)
    names, times = changes(run)
    assert names == ["A slips, B slips back", "A rests, B slips back", "A rests, B rests"]
    assert times == pytest.approx([1 / (MU * G), 2 / (MU * G)], rel=TIMES)
    assert run.y[[0, 2], -1] == pytest.approx([0.5 / (MU * G), -2 / (MU * G)], rel=TIMES)


def test_a_ladder_at_rest_does_not_determine_its_friction():
    board = Model("ladder")
    x, y, th = board.coordinates("x y th", "m m rad")
    m, g, l, mu = board.parameters(m=(1.0, "kg"), g=(G, "m/s²"), l=(1.0, "m"), mu=(0.9, "1"))
    A, B = board.reactions("A B")
    board.gravity(-g * j)
    half = l * (cos(th) * i + sin(th) * j)
    ladder = board.body(m, x * i + y * j, m * l**2 / 3, th, "ladder")
    ladder.slides(j, A, at=x * i + y * j - half, through=0 * i, friction=mu, along=i)
    ladder.slides(-i, B, at=x * i + y * j + half, through=0 * i, friction=mu, along=j)
    board.start(th=1.0)
    board.guess(x=-0.5, y=0.8)
    system = board.newton().system()
    with pytest.raises(ValueError, match="depend on each other"):
        system.solve((0, 1))


def test_rough_rigid_bodies_may_have_no_motion():
    """Painlevé's rod, pushed along rough ground with its tip ahead: no sign of N agrees."""
    board = Model("tip")
    x, y, th = board.coordinates("x y th", "m m rad")
    m, g, l, mu = board.parameters(m=(1.0, "kg"), g=(G, "m/s²"), l=(1.0, "m"), mu=(0.5, "1"))
    N = board.reactions("N")
    board.gravity(-g * j)
    rod = board.body(m, x * i + y * j, m * l**2 / 3, th, "rod")
    tip = x * i + y * j - l * (cos(th) * i + sin(th) * j)
    rod.slides(j, N, at=tip, through=0 * i, friction=mu, along=i)
    board.start(th=1.1, vx=-1.0, vth=0)
    board.guess(y=0.9)
    system = board.newton().system
    assert system().solve((0, 0.05)).success
    with pytest.raises(ValueError, match="Painlevé"):
        system(mu=3.0).solve((0, 0.05))


def test_an_axis_of_a_turning_body_may_rub():
    """A wheel set down on the floor skids until it rolls: v = w0 R / 3 for a disc."""
    board = Model("wheel")
    x, y, th = board.coordinates("x y th", "m m rad")
    m, g, R, mu = board.parameters(m=(1.0, "kg"), g=(G, "m/s²"), R=(0.5, "m"), mu=(0.2, "1"))
    N = board.reactions("N")
    board.gravity(-g * j)
    wheel = board.body(m, x * i + y * j, m * R**2 / 2, rotation(-th, k), "wheel")
    wheel.slides(j, N, at=x * i + y * j - R * j, through=0 * i, friction=mu, along=i)
    board.start(vth=12.0)
    run = board.newton().system().solve((0, 3), **TIGHT)
    names, (rolls,) = changes(run)
    assert names == ["slips back", "rests"]
    assert rolls == pytest.approx(12.0 * 0.5 / (3 * 0.2 * G), rel=TIMES)
    assert run.y[3, -1] == pytest.approx(2.0, rel=TIMES)
    assert run.y[3, -1] == pytest.approx(0.5 * run.y[5, -1], rel=TIMES)
