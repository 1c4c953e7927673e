"""The curves on which beads slide, and sizes that inertias do not decide."""

import numpy as np
import pytest
import sympy as sp
from sympy import cos, sin

from fastdyn.derive import Model, i, j, k, rotation, t


def board(name, coordinates, units="m"):
    made = Model(name)
    made.gravity(-9.81 * j)
    return made, made.coordinates(coordinates, units)


def lines_of(model, span=2.0):
    """The lines of the last scene of a run, shape (n, dimensions) each, and the scene."""
    system = model.derive().system()
    run = system.solve((0.0, span))
    scene = system.scenes(run.t, run.y)[-1]
    return [np.array(line, float).T for line in scene.lines], scene


def on_circle(line):
    return np.allclose((line * line).sum(axis=1), 1.0)


def test_a_wire_is_drawn_beyond_the_way_of_its_bead():
    made, x = board("wire", "x")
    made.particle(1, x * i + 2 * x**2 * j)
    made.start(x=1.0)
    (line,), scene = lines_of(made)
    assert np.allclose(line[:, 1], 2 * line[:, 0] ** 2)
    assert line[0, 0] < -1.0 and line[-1, 0] > 1.0 and len(scene.points) == 1


@pytest.mark.parametrize("y_there", [0.0, -0.6])
def test_a_curve_that_a_constraint_leaves_is_followed(y_there):
    """An ellipse, of a bead that goes around, or nearly so; and one that swings at the bottom."""
    made, (x, y) = board("ellipse", "x y")
    made.particle(1, x * i + y * j)
    made.constrain(x**2 / 4 + y**2 - 1)
    made.start(x=2.0 * np.sqrt(1.0 - y_there**2), vy=-0.01 if y_there == 0.0 else 0.0)
    made.guess(y=y_there)
    (line,), _ = lines_of(made, 4.0)
    assert np.allclose(line[:, 0] ** 2 / 4 + line[:, 1] ** 2, 1.0, atol=1e-9)
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.max() < 0.1 and (line[:, 0].min() < -1.6)


def test_a_circle_is_a_rod_unless_the_model_says_that_it_is_a_hoop():
    for hoop in (False, True):
        made, th = board("circle", "th", "rad")
        bead = made.particle(1, sin(th) * i - cos(th) * j)
        made.start(th=0.5)
        if hoop:
            made.guide(bead)
        (line,), scene = lines_of(made)
        assert len(line) == (121 if hoop else 2) and len(scene.fixed) == (0 if hoop else 1)
        assert on_circle(line) == hoop
        if hoop:
            assert np.allclose(line[0], line[-1])  # a full turn, though the bead swings


def test_a_hoop_that_turns_turns_with_its_bead():
    made = Model("turned")
    th = made.coordinates("th", "rad")
    made.particle(1, sin(th) * (cos(5 * t) * i + sin(5 * t) * j) - cos(th) * k)
    made.gravity(-9.81 * k)
    made.start(th=0.5)
    system = made.derive().system()
    run = system.solve((0.0, 1.0))
    for time, scene in zip(run.t, system.scenes(run.t, run.y), strict=True):
        (line,) = (np.array(line).T for line in scene.lines)
        bead = np.array(scene.points[0])
        assert on_circle(line) and np.linalg.norm(line - bead, axis=1).min() < 0.05, time


def test_a_straight_guide_is_drawn_where_it_turns():
    turning, x = board("turning", "x")
    turning.particle(1, x * (cos(t) * i + sin(t) * j))
    turning.start(x=0.2)
    still, x = board("still", "x")
    still.particle(1, x * i)
    still.start(x=0.2, vx=1.0)
    assert len(lines_of(turning)[0]) == 1 and lines_of(still)[0] == []


def test_what_hangs_on_a_bead_leaves_its_guide():
    made, (x, th) = board("hanging", "x th", "m rad")
    place = x * i + x**2 / 2 * j
    made.particle(1, place)
    made.particle(1, place + sin(th) * i - cos(th) * j)
    made.start(x=1.0)
    rod, guide = lines_of(made)[0]
    assert len(rod) == 2 and len(guide) == 121


def test_a_guide_is_of_a_particle_with_one_coordinate():
    made, (x, y) = board("free", "x y")
    free = made.particle(1, x * i + y * j)
    with pytest.raises(TypeError, match="`body` must be a particle of free"):
        made.guide(x)
    made.guide(free)
    with pytest.warns(UserWarning, match="mass of free slides on no guide"):
        made.derive()


@pytest.mark.parametrize("inertia", [1e-9, 1.0 / 12.0, 100.0])
def test_a_pendulum_is_as_long_as_its_geometry(inertia):
    made, th = board("bar", "th", "rad")
    made.body(1, 0.5 * (sin(th) * i - cos(th) * j), inertia, turned=th)
    made.start(th=1.0)
    system = made.derive().system()
    scene = system.scene(0.0, [1.0, 0.0])
    drawn = [*scene.bodies, *scene.lines]
    far = max(np.linalg.norm(np.array(one), axis=0).max() for one in drawn)
    assert far == pytest.approx(0.5 if inertia == 1e-9 else 1.0, rel=1e-3)


@pytest.mark.hunt
def test_bodies_on_springs_and_in_space_are_as_large_as_what_holds_them():
    made, (x, y, th) = board("sprung", "x y th", "m m rad")
    r, e = x * i + y * j, cos(th) * i + sin(th) * j
    plank = made.body(1, r, 50, th)
    for side in (-0.3, 0.3):
        made.spring(plank.at(r + side * e), side * i + j, 100, 0.5)
    made.start(th=0.3)
    (bar,) = made.derive().system().scene(0.0, np.zeros(6)).bodies
    assert np.ptp(np.array(bar)[0]) == pytest.approx(0.6)
    top = Model("top")
    p, q = top.coordinates("p q", "rad")
    turned = rotation(p, k) * rotation(q, i)
    top.body(1, 0.5 * (turned * sp.Matrix([0, 0, 1])), (20, 20, 40), turned)
    top.start(q=0.5)
    bodies = top.derive().system().scene(0.0, [0.0, 0.5, 0.0, 0.0]).bodies
    assert max(np.abs(np.array(one)).max() for one in bodies) < 1.5
