"""Reactions between joined bodies, and directions of any length."""

import warnings

import numpy as np
import pytest
from sympy import cos, sin

from fastdyn.derive import Model, i, j, k, rate, rotation
from fastdyn.derive.pages import page


def double(lower, upper=None):
    """A double pendulum with the reaction R2 times `lower` on one mass, `upper` on the other."""
    board = Model("double")
    a, b = board.coordinates("a b", "rad")
    m, l, g = board.parameters(m=(1.0, "kg"), l=(1.0, "m"), g=(9.81, "m/s²"))
    R1, R2 = board.reactions("R1 R2")
    e, f = (sin(x) * i - cos(x) * j for x in (a, b))
    first, second = board.particle(m, l * e, "first"), board.particle(m, l * (e + f), "second")
    board.gravity(-g * j)
    first.force(-R1 * e + (R2 * upper * f if upper else 0 * i))
    second.force(R2 * lower * f)
    board.start(a=1.0)
    return board.newton()


def test_a_reaction_on_one_of_two_joined_bodies_is_warned_of():
    with pytest.warns(UserWarning, match="R2 of double, drawn on second alone, does work"):
        double(-1)
    with pytest.warns(UserWarning, match="R2 of double, drawn on first and second, does work"):
        double(-1, -1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        double(-1, 1)


@pytest.mark.hunt
def test_a_reaction_along_no_direction_of_length_one_is_warned_of():
    with pytest.warns(UserWarning, match=r"R2 of double .* length is not 1 \(but 2\)"):
        double(-2, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in ("double_pendulum", "heavy_top", "rolling_disc", "vehicle", "pendulum_xy"):
            page(name).newton()


def slope(friction=lambda N, mu: 0, friction_by_hand=lambda N, mu, v: 0, scale=1, **slides):
    board = Model("slope")
    x, y = board.coordinates("x y", "m")
    m, g = board.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"))
    mu = board.parameters(positive=False, mu=(0.3, "1"))
    N = board.reactions("N")
    block = board.particle(m, x * i + y * j, "block")
    board.gravity(-g * j)
    normal, along = scale * (3 * j - 4 * i) / 5, scale * (4 * j + 3 * i) / 5
    block.slides(normal, N, through=0 * i, friction=friction(N, mu), along=along, **slides)
    block.force(friction_by_hand(N, mu, rate(x)) * (4 * j + 3 * i) / 5)
    board.quantity("check", mu)
    board.start(x=0.3, vx=1.0)
    return board.newton()


def test_friction_by_hand_is_warned_of():
    with pytest.warns(UserWarning, match="force on block of slope with N as a factor does work"):
        slope(friction_by_hand=lambda N, mu, v: -mu * N)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        slope(friction_by_hand=lambda N, mu, v: -mu * N * v / (0.01 + v**2) ** 0.5)
        slope(friction=lambda N, mu: mu)


def test_friction_by_hand_in_one_force_is_warned_of():
    board = Model("table")
    x, y = board.coordinates("x y")
    m, g, mu = board.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"), mu=(0.3, "1"))
    N = board.reactions("N")
    board.particle(m, x * i + y * j).force(N * (j - mu * i))
    board.gravity(-g * j)
    board.constrain(y, "table")
    with pytest.warns(UserWarning, match="force on mass of table with N as a factor does work"):
        board.newton()


@pytest.mark.parametrize("scale", [2, 0.1])
def test_lengths_of_directions_do_not_count(scale):
    def motion(scale):
        run = slope(lambda N, mu: mu, scale=scale).system().solve((0, 0.5), rtol=1e-9)
        return [*run.y[:, -1], run.quantities()["N"][-1]]

    assert motion(scale) == pytest.approx(motion(1), rel=1e-12)


def test_lengths_of_other_directions_do_not_count():
    def motion(scale):
        board = Model("directions")
        x, y, th = board.coordinates("x y th", "m m rad")
        m, K = board.parameters(m=(1.0, "kg"), K=(3.0, "N/m"))
        F = board.reactions("F")
        body = board.body(m, x * i + y * j, 0.1, rotation(th, scale * k), "body")
        axle = scale * (cos(th) * j - sin(th) * i)
        body.rolls(axle, reactions=F)
        body.drag(0.1)
        board.spring(0, body, K, 1, along=scale * i)
        board.start(x=0.1, vx=1.0, vth=1.0)
        run = board.newton().system().solve((0, 1), rtol=1e-9)
        return [*run.y[:, -1], run.quantities()["F"][-1]]

    assert motion(3) == pytest.approx(motion(1), rel=1e-9)
    with pytest.raises(ValueError, match="the normal has no direction: it is 0"):
        page("rod").bodies[0].slides(0 * i, 1)


def test_friction_that_drives_is_refused():
    with pytest.raises(ValueError, match=r"of block is -0\.3; below zero"):
        slope(lambda N, mu: -0.3)
    system = slope(lambda N, mu: mu).system
    with pytest.raises(ValueError, match=r"at N of the slope is -0\.3; below zero"):
        system(mu=-0.3)
    with pytest.raises(ValueError, match="below zero"):
        page("rod").derive().system(mu=-0.1)
    assert system(mu=0.0)


def trailer(order):
    """A car whose wheels are straight at the start, and its trailer, joined by a hinge."""
    board = Model("trailer")
    x, y, th, ph = board.coordinates("x y th ph", "m m rad rad")
    m, L = board.parameters(m=(1.0, "kg"), L=(1.0, "m"))
    alpha = board.driver("alpha alpha'", lambda t, w: (0.3 * np.sin(t), 0.3 * np.cos(t)))
    reactions = dict(zip(order, board.reactions(" ".join(order)), strict=True))
    a, n = cos(th) * i + sin(th) * j, cos(th) * j - sin(th) * i
    b, nb = cos(ph) * i + sin(ph) * j, cos(ph) * j - sin(ph) * i
    front = cos(th + alpha) * j - sin(th + alpha) * i
    r = x * i + y * j
    hook = r - L / 2 * a
    car = board.body(m, r, m * L**2 / 12, th, "car")
    car.drag(0.1)
    car.rolls(front, at=r + L / 2 * a, reactions=reactions["R1"])
    car.rolls(n, at=hook, reactions=reactions["R2"])
    tail = board.body(m, hook - L / 2 * b, m * L**2 / 12, ph, "tail")
    tail.rolls(nb, at=hook - L * b, reactions=reactions["R3"])
    pull = reactions["X"] * i + reactions["Y"] * j
    car.force(pull, at=hook)
    tail.force(-pull, at=hook)
    board.start(vx=1.0)
    return board.newton().system()


@pytest.mark.few(1)
@pytest.mark.parametrize("order", [["R1", "R2", "R3", "X", "Y"], ["Y", "X", "R3", "R2", "R1"]])
def test_the_forces_of_a_hinge_are_known_in_every_position(order):
    """The axles are parallel at the start; the hinge's force is what accelerates the tail."""
    system = trailer(order)
    run = system.solve((0, 4), rtol=1e-10, atol=1e-12)
    found = run.quantities()
    assert all(np.isfinite(one).all() for one in found.values())
    _, _, th, ph, _, _, vth, vph = run.y
    rates = np.array([system.rhs(*one, *system.args) for one in zip(run.t, run.y.T, strict=True)]).T
    acceleration = (
        rates[4] + (rates[6] * np.sin(th) + vth**2 * np.cos(th)) / 2
        + (rates[7] * np.sin(ph) + vph**2 * np.cos(ph)) / 2
    )  # fmt: skip
    assert -found["X"] - found["R3"] * np.sin(ph) == pytest.approx(acceleration, abs=1e-9)
