"""What is wrong with a model is said in one sentence."""

import pytest
import sympy as sp

from fastdyn.derive import Model, i, j, k, rate, rotation, t
from fastdyn.derive.pages import page


def pendulum(reaction=True):
    board = Model("bob")
    x, y = board.coordinates("x y")
    g, l, m = board.parameters(g=(9.81, "m/s²"), l=(1.0, "m"), m=(1.0, "kg"))
    R = board.reactions("R") if reaction else 0
    mass = board.particle(m, x * i + y * j)
    board.gravity(-g * j)
    mass.force(-R * (x * i + y * j) / l)
    board.guess(y=-l)
    return board, mass, x, y, l


def circle(board, x, y, l, name="circle"):
    board.constrain(x**2 + y**2 - l**2, name)


def no_body(board, mass, x, y, l):
    board.bodies.clear()


def unknown_symbol(board, mass, x, y, l):
    circle(board, x, y, sp.Symbol("a"))


def other_time(board, mass, x, y, l):
    circle(board, x, y, l)
    mass.force(sp.sin(sp.Symbol("tau")) * i)


def unknown_function(board, mass, x, y, l):
    circle(board, x, y, l)
    mass.force(sp.besselj(0, x) * i)


def no_constraint(board, mass, x, y, l):
    pass


def twice_the_same(board, mass, x, y, l):
    circle(board, x, y, l)
    circle(board, 2 * x, 2 * y, 2 * l, "again")


def two_circles(board, mass, x, y, l):
    circle(board, x, y, l)
    circle(board, x, y, 2 * l, "larger")


def two_velocities(board, mass, x, y, l):
    board.constrain(rate(x) - 1, "one")
    board.constrain(rate(x) - t, "other")
    board.start(vx=1)


def pinned_wrongly(board, mass, x, y, l):
    circle(board, x, y, l)
    board.start(x=0, y=-2 * l)


def moving_off(board, mass, x, y, l):
    circle(board, x, y, l)
    board.start(x=0, y=-l, vx=1, vy=1)


def absolute_reaction(board, mass, x, y, l):
    circle(board, x, y, l)
    mass.force(-0.1 * sp.Abs(board.reaction_list[0].function) * i)


def no_coordinate(board, mass, x, y, l):
    circle(board, x, y, l)
    board.constrain(l - 2 * t, "nothing")


def on_forces(board, mass, x, y, l):
    board.constrain(board.reaction_list[0].function - 1, "strong")


def at_constant_speed(board, mass, x, y, l):
    board.reaction_list.clear()
    mass.forces.clear()
    board.constrain(rate(x) ** 2 + rate(y) ** 2 - 1, "fast", "m²/s²")
    board.start(vx=1)
    board.lagrange()


def no_invariant(board, mass, x, y, l):
    circle(board, x, y, l)
    board.invariant("momentum", rate(x), "m/s")


def rate_of_driver(board, mass, x, y, l):
    a = board.driver("a", lambda t, w: 0.1 * t)
    board.constrain(x - a, "moved")


def off_the_particle(board, mass, x, y, l):
    mass.force(i, at=2 * x * i)


def no_vector(board, mass, x, y, l):
    mass.force(x * y)


def no_state(board, mass, x, y, l):
    board.start(z=1)


def name_twice(board, mass, x, y, l):
    board.parameters(x=(1.0, "m"))


def name_of_a_system(board, mass, x, y, l):
    board.parameters(exact=(1.0, "m"))


def no_name(board, mass, x, y, l):
    board.coordinates("lambda")


def no_default(board, mass, x, y, l):
    board.parameters(a="1 m")


def zero_and_positive(board, mass, x, y, l):
    board.parameters(a=(0.0, "m"))


def turning_spring(board, mass, x, y, l):
    board.spring(0, mass, 1.0, along=(x * i + y * j) / sp.sqrt(x**2 + y**2))


def nowhere_defined(board, mass, x, y, l):
    circle(board, x, y, l)
    mass.force(sp.sqrt(-1 - x**2) * i)


def places_alone(board, mass, x, y, l):
    board.spring(0, i, 1.0)


def start_of_the_state(board, mass, x, y, l):
    circle(board, x, y, l)
    board.start(vx=x)


def gap_in_driver(board, mass, x, y, l):
    board.driver("a a''", lambda t, w: (0, 0))


def friction_without_direction(board, mass, x, y, l):
    mass.slides(j, board.reaction_list[0].function, friction=0.1)


def too_many_reactions(board, mass, x, y, l):
    R = board.reaction_list[0].function
    mass.rolls(j, reactions=[R, R])


def one_moment_in_space(board, mass, x, y, l):
    board.body(1, x * i, 1, rotation(y / l, i) * rotation(x / l, k))


WRONG = {
    no_body: "has no body",
    unknown_symbol: "bob uses a, which is none of its",
    other_time: "bob uses tau, which is none of its",
    unknown_function: "`besselj` in .* is no function that fastdyn compiles",
    no_constraint: "do not determine .*R: there are 3 unknowns and 2 independent equations",
    twice_the_same: "`circle` and `again` of bob depend on each other",
    two_circles: "violates `circle`|contradict each other",
    two_velocities: "`one` and `other` of bob contradict each other|violates",
    pinned_wrongly: "start of bob violates `circle` .by 3",
    moving_off: "start of bob violates `circle_rate` .by -2",
    absolute_reaction: "not linear in them",
    no_coordinate: "`nothing`.* says nothing of the motion",
    on_forces: "`strong` is of positions or velocities",
    at_constant_speed: "`fast` of bob is not linear in the velocities",
    no_invariant: "`momentum` of bob is no invariant",
    rate_of_driver: "need the rate of .*a.*, which nothing gives",
    off_the_particle: "is a particle, but something acts at another place",
    no_vector: "a force must be a vector",
    no_state: "`z` is no part of the state",
    name_twice: "The name `x` of bob is taken",
    name_of_a_system: "The name `exact` of bob is taken",
    no_name: "'lambda' is no name that Python takes",
    no_default: "`a` is declared by",
    zero_and_positive: "say positive=False",
    turning_spring: "does not turn with the coordinates",
    nowhere_defined: "cannot be evaluated near the start",
    places_alone: "moves nothing",
    start_of_the_state: "start of `vx` of bob depends on x",
    gap_in_driver: "must name a function, then its rates",
    friction_without_direction: "friction needs `along`",
    too_many_reactions: "have as many reactions; got 2",
    one_moment_in_space: "three moments of inertia",
}


@pytest.mark.parametrize("wrong", WRONG, ids=lambda one: one.__name__)
def test_wrong_models_get_a_sentence(wrong):
    given = pendulum()
    with pytest.raises((ValueError, TypeError), match=WRONG[wrong]) as refusal:
        wrong(*given)
        assert given[0].newton().system
    assert str(refusal.value).count("\n") == 0


def test_a_constraint_without_its_reaction_contradicts_newton():
    board, *given = pendulum(reaction=False)
    circle(board, *given[1:])
    with pytest.raises(ValueError, match=r"Newton's law of mass along i, .* A reaction is missing"):
        board.newton()
    multiplied = board.lagrange().system()
    assert list(multiplied.quantities) == ["lambda_circle"]


def test_friction_is_for_newton():
    with pytest.raises(ValueError, match="Newton's equations alone"):
        page("rod").lagrange()


def test_no_page_of_this_name():
    with pytest.raises(ValueError, match="'bulding'; did you mean \"building\""):
        page("bulding")
    with pytest.raises(ValueError, match="No page is called 'moon'; choose from building"):
        page("moon")


def test_a_small_weight_that_nothing_carries_is_noticed():
    """A speck beside a heavy block: what is tested has size 1 for both."""
    board = Model("speck")
    x, y = board.coordinates("x y")
    M, m, g = board.parameters(M=(1e6, "kg"), m=(1e-18, "kg"), g=(9.81, "m/s²"))
    board.particle(M, y * j, "block")
    board.particle(m, x * i, "speck")
    board.gravity(-g * j)
    with pytest.raises(ValueError, match="contradict each other: Newton's law of speck along j"):
        board.newton()
