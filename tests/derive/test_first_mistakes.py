"""What students write at the first try: the sentence says what to write instead."""

import math
import warnings

import numpy as np
import pytest
import sympy as sp

from fastdyn.derive import Model, i, j, k, rotation, t


def particle(name="ball"):
    board = Model(name)
    x, y = board.coordinates("x y")
    m, g, l = board.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"), l=(1.0, "m"))
    ball = board.particle(m, x * i + y * j, "ball")
    board.gravity(-g * j)
    board.quantity("rod", l, "m")
    return board, ball, x, y, l


@pytest.mark.parametrize("inertia", [(1, 1, 5), (5.0, 1, 1), (0, 1, 0), (-1, 1, 1)])
def test_moments_of_inertia_that_no_body_has_are_refused(inertia):
    board = Model("top")
    a, b = board.coordinates("a b", "rad")
    board.body(1, 0 * i, inertia, rotation(a, i) * rotation(b, j), "stone")
    with pytest.raises(ValueError, match=r"stone has .*(sum of the other two|below zero)"):
        board.lagrange()


def test_moments_of_inertia_are_looked_at_with_the_numbers_of_each_system():
    board = Model("top")
    a, b = board.coordinates("a b", "rad")
    A, C = board.parameters(A=(1.0, "kg m²"), C=(2.0, "kg m²"))  # a thin disc
    board.body(1, 0 * i, (A, A, C), rotation(a, i) * rotation(b, j), "disc")
    system = board.lagrange().system
    assert system(C=1.5)
    with pytest.raises(ValueError, match=r"1, 1, 2\.1: no body has"):
        system(C=2.1)


def lifted(**options):
    board, ball, *_ = particle("lift")
    N = board.reactions("N")
    ball.force(30 * t * j)
    ball.slides(j, N, through=0 * i, **options)
    return board.newton().system()


@pytest.mark.parametrize("friction", [{}, {"friction": 0.3, "along": i}])
def test_a_contact_that_pulls_is_warned_of(friction):
    with pytest.warns(UserWarning, match=r"normal force N of the lift is negative.*ball would le"):
        lifted(**friction).solve((0, 2), max_step=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lifted(**friction).solve((0, 0.3))
        lifted(guided=True, **friction).solve((0, 2))


def wheel(*directions, **options):
    board = Model("wheel")
    x, y, th = board.coordinates("x y th", "m m rad")
    m, R, g = board.parameters(m=(1.0, "kg"), R=(0.3, "m"), g=(9.81, "m/s²"))
    rim = board.body(m, x * i + y * j, m * R**2 / 2, -th, "rim")
    board.gravity(-g * j)
    rim.rolls(*directions, at=x * i + (y - R) * j)
    for expression in options.get("held", ()):
        board.constrain(expression(y, R))
    return board


def test_a_wheel_that_rolls_begins_at_any_angle():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wheel(i, held=[lambda y, R: sp.Eq(y, R)]).lagrange()
    with pytest.warns(UserWarning, match=r"`slip2` of wheel .* y = 0, .*`constrain` the place of"):
        wheel(i, j).lagrange()


def test_an_equation_is_a_constraint():
    board, _, x, y, l = particle()
    board.constrain(sp.Eq(x**2 + y**2, l**2), "circle")
    board.guess(y=-1)
    assert board.lagrange().system().solve((0, 1)).success
    for wrong in (sp.Eq(l, l), x < 1, True):
        with pytest.raises(ValueError, match="an expression that is zero, or an equation"):
            board.constrain(wrong)


@pytest.mark.parametrize("function", [np.sin, math.sin, np.sqrt, np.arctan, math.exp])
def test_functions_of_numpy_are_refused_by_name(function):
    _, _, x, _, _ = particle()
    with pytest.raises(TypeError, match=r"x is a function of time .* `from sympy import"):
        function(x)


def test_a_start_that_is_sought_from_nothing_names_guess():
    board, _, x, y, l = particle()
    board.constrain(x**2 + y**2 - l**2)
    with pytest.raises(ValueError, match=r"Let `guess\(...\)` name values near the start"):
        board.lagrange()


@pytest.mark.parametrize("kind", ["spring", "damper", "central"])
def test_a_spring_without_length_is_refused(kind):
    board, ball, _, _, l = particle()
    given = {"spring": (10, l), "damper": (3,), "central": (lambda r: -1 / r,)}[kind]
    getattr(board, kind)(0, ball, *given)
    system = board.lagrange().system()
    with pytest.raises(ValueError, match="of the ball the two ends of a spring, a damper or"):
        system.solve((0, 1))
    assert system.solve((0, 1), [0.0, -1.0, 0.0, 0.0]).success


def test_a_spring_that_may_be_short_begins_at_zero():
    board, ball, *_ = particle()
    board.spring(0, ball, 10)
    assert board.lagrange().system().solve((0, 1)).success


@pytest.mark.parametrize("law", ["newton", "lagrange"])
def test_a_coordinate_that_nothing_uses_is_named(law):
    board, *_ = particle()
    board.coordinates("z")
    with pytest.raises(ValueError, match="Nothing moves with the coordinate `z` of ball"):
        getattr(board, law)()


def test_a_rolling_ball_of_rotations_is_not_accused():
    board = Model("hoop")
    x, th = board.coordinates("x th", "m rad")
    m, R = board.parameters(m=(1.0, "kg"), R=(0.3, "m"))
    board.body(m, x * i, (m * R**2 / 2, m * R**2 / 2, m * R**2), rotation(th, k)).rolls(
        i, at=x * i - R * j
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        board.lagrange()
