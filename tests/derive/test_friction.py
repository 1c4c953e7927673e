"""Friction slips and rests: closed solutions, the times of the changes between the two."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from sympy import cos, sin

from fastdyn import systems
from fastdyn.derive import Model, i, j, rate, t
from fastdyn.derive.pages import page

EPS = np.finfo(float).eps
G, MU, STEEP = 9.81, 0.5, 0.3
TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
TIMES = 1e3 * EPS  # relative: rounding of motions that a polynomial of the method has exactly


def board_with_block(name, through=0 * i, **contact):
    board = Model(name)
    x, y = board.coordinates("x y")
    m, g = board.parameters(m=(2.0, "kg"), g=(G, "m/s²"))
    mu = board.parameters(positive=False, mu=(MU, "1"))
    block = board.particle(m, x * i + y * j, "block")
    board.gravity(-g * j)
    return board, block, board.reactions("N"), mu


def incline():
    board, block, N, mu = board_with_block("incline")
    a = board.parameters(positive=False, a=(STEEP, "rad"))
    V = board.initial(V=(3.0, "m/s"))
    along = cos(a) * i + sin(a) * j
    block.slides(-sin(a) * i + cos(a) * j, N, through=0 * i, friction=mu, along=along)
    board.start(vx=V * cos(a), x=0)
    return board.newton().system


def floor(name="floor", force=0, over=0, **contact):
    board, block, N, mu = board_with_block(name)
    block.slides(j, N, through=0 * i, friction=mu, along=i, over=over, **contact)
    block.force(force * i if force != 0 else 0)
    return board, block, N


@pytest.fixture(scope="module")
def slope():
    return incline()


def changes(run):
    return [name for name, *_ in run.phases], [begin for _, begin, _ in run.phases[1:]]


def test_a_block_pushed_up_an_incline_stops_and_rests(slope):
    """Steep enough to slide it would come back; at tan a < mu it rests where it stops."""
    run = slope().solve((0, 5), **TIGHT)
    braking = G * (math.sin(STEEP) + MU * math.cos(STEEP))
    names, (stop,) = changes(run)
    assert names == ["slips", "rests"]
    assert stop == pytest.approx(3.0 / braking, rel=TIMES)
    assert np.hypot(*run.y[:2, -1]) == pytest.approx(4.5 / braking, rel=TIMES)
    assert np.abs(run.y[2:, -1]).max() <= EPS
    forces = run.quantities()
    assert forces["friction_N"][-1] == pytest.approx(2.0 * G * math.sin(STEEP), rel=TIMES)
    assert forces["friction_N"][0] == pytest.approx(-2.0 * MU * G * math.cos(STEEP), rel=TIMES)


def test_where_friction_is_too_small_the_block_comes_back(slope):
    mu = 0.2
    run = slope(mu=mu).solve((0, 5), **TIGHT)
    up, down = (G * (math.sin(STEEP) + sign * mu * math.cos(STEEP)) for sign in (1, -1))
    names, (turn,) = changes(run)
    assert names == ["slips", "slips back"]
    assert turn == pytest.approx(3.0 / up, rel=TIMES)
    place = 4.5 / up - down * (5.0 - 3.0 / up) ** 2 / 2
    assert run.y[0, -1] / math.cos(STEEP) == pytest.approx(place, rel=TIMES)


def test_without_friction_nothing_stops_it(slope):
    run = slope(mu=0.0).solve((0, 5), **TIGHT)
    assert changes(run) == (["slips"], [])
    place = 15.0 - G * math.sin(STEEP) * 12.5
    assert run.y[0, -1] / math.cos(STEEP) == pytest.approx(place, rel=TIMES)


def test_a_start_at_rest_rests_or_sets_off(slope):
    for steep, name in ((0.3, "rests"), (0.6, "slips back")):
        run = slope(V=0.0, a=steep).solve((0, 1), **TIGHT)
        assert changes(run) == ([name], [])
        down = G * (math.sin(steep) - MU * math.cos(steep)) * (name != "rests")
        assert np.hypot(*run.y[:2, -1]) == pytest.approx(down / 2, rel=TIMES)


def shaken():
    board, block, N, mu = board_with_block("shaken")
    A, omega = board.parameters(A=(0.1, "m"), omega=(12.0, "rad/s"))
    table = rate(A * sin(omega * t)) * i
    block.slides(j, N, through=0 * i, friction=mu, along=i, over=table)
    board.start(vx=A * omega)
    return board.newton().system


def test_a_block_on_a_shaking_table():
    """It rides while A w² |sin wt| < mu g, then slides until the table has its speed again."""
    A, omega, limit = 0.1, 12.0, MU * G
    names, (first, second, *_) = changes(shaken()().solve((0, 2), **TIGHT))
    assert names[:3] == ["rests", "slips", "slips back"]
    leaves = math.asin(limit / (A * omega**2)) / omega
    assert first == pytest.approx(leaves, rel=TIMES)

    def slip(time):
        speed = A * omega * math.cos(omega * leaves) - limit * (time - leaves)
        return speed - A * omega * math.cos(omega * time)

    caught = brentq(slip, leaves + 0.1, leaves + 0.6, xtol=1e-15)
    assert second == pytest.approx(caught, rel=TIMES)
    gentle = shaken()(omega=4.0).solve((0, 2), **TIGHT)
    assert changes(gentle) == (["rests"], [])
    assert gentle.y[0] == pytest.approx(A * np.sin(4.0 * gentle.t), abs=1e-9)


def test_a_force_on_a_block_at_rest_is_followed():
    """Nothing moves, so nothing but the force tells the steps when to be short."""
    board, *_ = floor("pushed", force=1.1 * MU * 2.0 * G * sin(3 * t))
    names, (first, *_) = changes(board.newton().system().solve((0, 20)))
    assert names[:3] == ["rests", "slips", "rests"]
    assert first == pytest.approx(math.asin(1 / 1.1) / 3.0, rel=1e-6)
    assert len(names) >= 4 * 9  # two pushes a period


def belt():
    board = Model("belt")
    x, y = board.coordinates("x y")
    m, g, K = board.parameters(m=(1.0, "kg"), g=(10.0, "m/s²"), K=(100.0, "N/m"))
    v, mu, static = board.parameters(v=(0.1, "m/s"), mu=(0.2, "1"), static=(0.4, "1"))
    N = board.reactions("N")
    block = board.particle(m, x * i + y * j, "block")
    board.gravity(-g * j)
    board.spring(0 * i, block, K, along=i)
    block.slides(j, N, through=0 * i, friction=mu, static=static, along=i, over=v * i)
    board.start(x=0, vx=v)
    return board.newton().system()


def test_a_block_on_a_belt_sticks_and_slips():
    """Rides to mu_s m g / K, springs back until it has the belt's speed again, and so on."""
    run = belt().solve((0, 5), **TIGHT)
    names, times = changes(run)
    far, middle, omega, v = 0.04, 0.02, 10.0, 0.1
    slipping = 2.0 / omega * (math.pi - math.atan((far - middle) * omega / v))
    riding = 2.0 * (far - middle) / v
    assert names[:4] == ["rests", "slips back"] * 2
    assert times[0] == pytest.approx(far / v, rel=TIMES)
    assert len(times) >= 10
    error = 1e3 * TIGHT["rtol"]  # of positions of 0.04, in a motion at the speed 0.1
    for n, duration in enumerate(np.diff(times)):
        assert duration == pytest.approx(riding if n % 2 else slipping, abs=error), n
    friction = run.quantities()["friction_N"]
    assert friction.max() == pytest.approx(4.0, rel=1e-9)  # at the end of a ride
    assert friction.min() >= 0.0


def test_the_block_on_the_rod_slides_inwards_and_out_again():
    """The rod pushes on its other side where the block moves inwards: mu |N| against the slip."""
    derived, written = page("rod").newton().system(), systems.rod()
    for y0 in (None, [1.0, -1.5]):
        ours, theirs = (one.solve((0, 2), y0, **TIGHT) for one in (derived, written))
        assert ours.y[:, -1] == pytest.approx(theirs.y[:, -1], rel=1e3 * TIGHT["rtol"])
        forces = ours.quantities()
        against = np.sign(forces["slip_N"]) * forces["friction_N"]
        assert against == pytest.approx(-0.3 * np.abs(forces["N"]), rel=1e-9, abs=1e-12)
    v = np.array([-1.5, 0.5])
    assert np.all(written.friction_force(0.0, [1.0, v], *written.args) * v >= 0.0)


def test_events_and_times_of_output_see_the_state_alone(slope):
    def half(t, w, *args):
        _, _, vx, vy = w
        return math.hypot(vx, vy) - 1.5

    system = slope()
    run = system.solve((0, 2), t_eval=[0.1, 1.0], events=half, dense_output=True, **TIGHT)
    stop = 3.0 / (G * (math.sin(STEEP) + MU * math.cos(STEEP)))
    assert run.t_events[0] == pytest.approx([stop / 2], rel=1e-9)
    assert run.y.shape == (4, 2) and run.y_events[0].shape == (1, 4)
    assert run.sol(1.0) == pytest.approx(run.y[:, 1], abs=1e-12)
    assert system.solve((0, 2), atol=[1e-9] * 4).success


def test_what_is_solved_in_phases_says_what_it_cannot(slope):
    with pytest.raises(ValueError, match="solved one by one"):
        slope().ensemble(mu=[0.1, 0.2])
    with pytest.raises(ValueError, match="True or False"):
        slope().solve(project=lambda t, w: w)


def test_a_start_off_the_surface_is_taken_to_it():
    board, *_ = floor("off")
    board.start(x=1.0)
    board.guess(y=0.7)
    assert board.newton().system().initial_state() == (1.0, 0.0, 0.0, 0.0)
    board.start(x=1.0, y=0.5)
    with pytest.raises(ValueError, match=r"start of off violates `gap1` .by 0.5"):
        board.newton()


def test_a_change_of_mode_that_the_step_has_left_behind_counts():
    """DOP853 goes from 0.3 to 0.7 in a step; the slip would end at 0.358, and again at 0.553."""
    names, times = changes(shaken()().solve((0, 0.7), **TIGHT))
    assert names == ["rests", "slips", "slips back", "slips"]
    whole = changes(shaken()().solve((0, 0.7), **{**TIGHT, "method": "Vern9"}))
    assert times == pytest.approx(whole[1], rel=TIMES)
