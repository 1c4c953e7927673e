"""Derived systems are drawn from what their models say."""

import functools
import subprocess
import sys

import numpy as np
import pytest
from sympy import cos, sin

from fastdyn.derive import Model, i, j, rotation
from fastdyn.derive.pages import page
from fastdyn.plot.scene import frame


def scenes(system, n=5):
    run = system.solve((0.0, min(system.t_end, 2.0)))
    t = np.linspace(0.0, run.t[-1], n)
    return system.scenes(t, run.continuous()(t))


@functools.cache
def derived(name):
    """The class of the system on a page."""
    return page(name).derive().system


def length(line):
    """Of each piece of a polyline."""
    return np.linalg.norm(np.diff(np.array(line, float), axis=1), axis=0)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["satellite", "suspension", "heavy_top", "vehicle"])
def test_a_page_is_drawn_inside_its_frame(name):
    drawn = scenes(derived(name)())
    limits = frame(drawn)
    for scene in drawn:
        parts = [*scene.lines, *scene.points, *scene.bodies, *scene.fixed, scene.traced]
        assert len(parts) > 1
        for part in parts:
            for x, (a, b) in zip(part, limits.values(), strict=True):
                assert min(a, b) <= np.nanmin(x) and np.nanmax(x) <= max(a, b)


def test_rods_are_found_by_the_distances_that_stay():
    for scene in scenes(derived("double_pendulum")(l2=0.5)):
        assert sorted(float(length(line)[0]) for line in scene.lines) == pytest.approx([0.5, 1.0])
        assert scene.fixed == [(0.0, 0.0)] or np.allclose(scene.fixed, 0.0)
    chain = scenes(derived("closed_chain")())
    assert np.allclose([length(line)[0] for line in chain[-1].lines], 1.0)
    assert np.allclose(sorted(x for x, _ in chain[-1].fixed), [0.0, 2.5])


def test_hinges_of_a_linkage_are_found_from_its_constraints():
    scene = scenes(derived("four_bar")())[-1]
    bars = sorted(float(length(body)[0]) for body in scene.bodies)
    assert bars == pytest.approx([1.0, 2.5, 3.0])
    assert np.allclose(sorted(x for x, _ in scene.fixed), [0.0, 3.0])


def test_a_bar_that_hangs_is_drawn_along_its_pivot_and_centre():
    board = Model("bar")
    th = board.coordinates("th", "rad")
    m, l, g = board.parameters(m=(1.0, "kg"), l=(2.0, "m"), g=(9.81, "m/s²"))
    board.body(m, l / 2 * (sin(th) * i - cos(th) * j), m * l**2 / 12, turned=th)
    board.gravity(-g * j)
    board.start(th=1.0)
    system = board.derive().system()
    (bar,) = system.scene(0.0, [1.0, 0.0]).bodies
    assert length(bar)[0] == pytest.approx(2.0)
    assert np.allclose(
        np.array(bar)[:, [1, 2]].mean(axis=1), 2.0 * np.array([np.sin(1), -np.cos(1)])
    )


def test_a_top_moves_in_space_about_its_fixed_point():
    scene = scenes(derived("heavy_top")())[0]
    assert len(scene.traced) == 3 and np.allclose(scene.fixed, 0.0)
    rim = np.array(scene.bodies[0]).T
    centre = 0.1 * np.array([0.0, -np.sin(0.5), np.cos(0.5)])
    assert np.allclose(np.linalg.norm(rim - centre, axis=1), 0.1)  # sqrt(2 C / m)


def test_a_book_is_a_box_of_its_moments_of_inertia():
    board = Model("book")
    b, c = board.coordinates("b c", "rad")
    turned = rotation(b, i) * rotation(c, j)
    board.body(12, 0 * i, (4 + 9, 1 + 9, 1 + 4), turned)  # sides 1, 2 and 3 m
    board.start(vb=0.3, vc=0.5)
    scene = scenes(board.derive().system())[-1]
    sides = {round(float(x), 6) for face in scene.bodies for x in length(face)}
    assert sides == {1.0, 2.0, 3.0}


def test_springs_dampers_carts_and_lines_are_drawn():
    board = Model("cart")
    x, th = board.coordinates("x th", "m rad")
    m, K, c = board.parameters(m=(1.0, "kg"), K=(20.0, "N/m"), c=(1.0, "N s/m"))
    cart = board.body(m, x * i, name="cart")
    board.particle(m, x * i + sin(th) * i - cos(th) * j)
    board.spring(-3 * i, cart, K, 3)
    board.damper(-3 * i, cart, c)
    board.line(-3 * i, 3 * i)
    board.gravity(-10 * j)
    board.start(x=0.5, th=1.0)
    scene = scenes(board.derive().system())[0]
    assert len(scene.bodies) == 1 and len(scene.lines) == 5  # rod, spring, damper, line, floor
    ends = {tuple(np.round([line[0][0], line[0][-1]], 9)) for line in scene.lines}
    assert (-3.0, 3.0) in ends  # the rail; spring and damper end at the side of the cart
    side, foot = round(float(min(scene.bodies[0][0])), 9), min(scene.bodies[0][1])
    assert (-3.0, side) in ends and side < 0.5
    assert (0.5, 0.0) in scene.points  # the pivot of the rod
    assert np.allclose(scene.lines[-1][1], foot)
    with pytest.raises(ValueError, match="two points or more"):
        board.line(i)


def test_what_goes_far_is_drawn_larger_and_says_so():
    car = derived("vehicle")()
    run = car.solve((0.0, 60.0))
    first, *_, last = car.scenes(run.t, run.y)
    assert first.note == last.note == "drawn 5 times its size"
    apart = np.diff([np.nanmean(line, axis=1) for line in last.lines], axis=0)
    assert np.linalg.norm(apart) == pytest.approx(5.0)  # wheelbase 1 m


def test_downwards_is_down():
    swing = derived("pendulum_xy")()
    (scene,) = scenes(swing, 1)
    assert scene.down and frame([scene])["ylim"][0] > frame([scene])["ylim"][1]
    assert scene.axes[1] == "y (m), downwards"


def test_a_derived_system_moves_and_is_plotted(tmp_path):
    for name in ("double_pendulum", "heavy_top"):
        system = derived(name)()
        system.animate(tmp_path / f"{name}.gif", (0.0, 1.0), seconds=0.1)
        assert (tmp_path / f"{name}.gif").read_bytes().startswith(b"GIF8")
        figure = system.plot((0.0, 1.0))
        assert figure.axes[1].get_ylabel() == "coordinates (rad)"


def test_an_import_of_derive_brings_neither_scipy_nor_matplotlib():
    heavy = "{'scipy', 'matplotlib', 'panel', 'numba.core.compiler'} & set(sys.modules)"
    script = f"import sys; import fastdyn.derive; print({heavy})"
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert found.stdout.strip() == "set()", found.stderr


def test_a_wheel_that_rolls_leaves_the_trail_of_its_rim_on_a_slope():
    board = Model("wheel", t_end=3.0)
    x, th = board.coordinates("x th", "m rad")
    m, g, R = board.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"), R=(0.3, "m"))
    d, n = (4 * i - 3 * j) / 5, (3 * i + 4 * j) / 5
    board.body(m, x * d + R * n, m * R**2 / 2, -th).rolls(d, at=x * d)
    board.gravity(-g * j)
    system = board.lagrange().system()
    drawn = scenes(system, 400)
    trail = np.array([scene.traced for scene in drawn])
    assert drawn[0].note == ""
    assert np.diff(trail @ [0.8, -0.6]).min() > -1e-3  # a cycloid: cusps, no loops
    assert (trail @ [0.6, 0.8]).min() > -1e-9 and (trail @ [0.6, 0.8]).max() < 0.6 + 1e-9
    slope = np.array(drawn[0].lines[-1])
    assert np.allclose(np.array([0.6, 0.8]) @ slope, 0.0, atol=1e-9)
    (path, *_) = system.plot((0, 3)).axes[0].lines
    assert len(path.get_xdata()) > 800  # eight turns, each round


def crank():
    board = Model("crank")
    th, ph, x = board.coordinates("th ph x", "rad rad m")
    m, a, b, g = board.parameters(m=(1.0, "kg"), a=(0.5, "m"), b=(1.5, "m"), g=(9.81, "m/s²"))
    e, f = cos(th) * i + sin(th) * j, cos(ph) * i + sin(ph) * j
    board.body(m, a / 2 * e, m * a**2 / 12, th, "crank")
    board.body(m, a * e + b / 2 * f, m * b**2 / 12, ph, "rod")
    board.particle(2 * m, x * i, "piston")
    gap = a * e + b * f - x * i
    board.constrain(gap[0])
    board.constrain(gap[1])
    board.gravity(-g * j)
    board.start(th=0.5, vth=8.0)
    board.guess(x=1.9, ph=-0.1)
    return board.lagrange().system()


def test_a_rod_that_is_a_body_is_drawn_once():
    scene = scenes(crank())[0]
    assert len(scene.bodies) == 3 and len(scene.lines) == 1  # the floor of the piston


def test_earlier_positions_do_not_lie_on_top_of_each_other():
    from fastdyn.derive.picture.figure import _apart

    run = crank().solve((0.0, 8.0), rtol=1e-8)
    t = np.linspace(0.0, 8.0, 500)
    drawn = run.system.scenes(t, run.continuous()(t))
    chosen = _apart(drawn)
    assert chosen[-1] == len(drawn) - 1 and len(chosen) >= 4
    pins = np.array([np.mean(drawn[n].bodies[0], axis=1) for n in chosen])
    gaps = np.linalg.norm(pins[:, None] - pins[None], axis=2)
    assert gaps[~np.eye(len(pins), dtype=bool)].min() > 0.05  # the crank's centre, at 0.25 m


def test_bodies_in_space_are_filled():
    figure = derived("heavy_top")().plot((0.0, 0.2))
    assert len(figure.axes[0].collections) == 1


def test_a_disc_in_space_rolls_on_a_floor():
    drawn = scenes(derived("rolling_disc")())
    assert drawn[0].ground == pytest.approx(0.0, abs=1e-9) == frame(drawn)["zlim"][0]
    assert scenes(derived("heavy_top")())[0].ground is None


def test_a_body_lies_between_the_points_of_its_reactions():
    ladder = Model("ladder", t_end=0.5)
    x, y, th = ladder.coordinates("x y th", "m m rad")
    m, g, length_ = ladder.parameters(m=(5.0, "kg"), g=(9.81, "m/s²"), length_=(2.0, "m"))
    A, N = ladder.reactions("A N")
    r, half = x * i + y * j, length_ / 2 * (sin(th) * i - cos(th) * j)
    bar = ladder.body(m, r, inertia=m * length_**2 / 12, turned=th)
    bar.force(A * i, at=r - half)
    bar.force(N * j, at=r + half)
    ladder.constrain(x - length_ / 2 * sin(th), "wall")
    ladder.constrain(y - length_ / 2 * cos(th), "floor")
    ladder.gravity(-g * j)
    ladder.start(th=0.3)
    ladder.guess(x=0.3, y=0.95)
    (bodies,) = {len(scene.bodies) for scene in scenes(ladder.newton().system())}
    assert bodies == 1
    for scene in scenes(ladder.newton().system()):
        horizontal, vertical = np.array(scene.bodies[0])
        assert horizontal.min() < 0.1 and vertical.min() < 0.1  # at the wall, on the floor
