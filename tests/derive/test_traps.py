"""What looks right on the blackboard and is not is accepted rightly, refused, or warned of."""

import warnings

import pytest
import sympy as sp
from sympy import cos, sin
from sympy.physics.mechanics import dynamicsymbols

import fastdyn.derive
from fastdyn.derive import Model, i, j, rate

TIMES = {
    "ours": fastdyn.derive.t,
    "symbols": sp.symbols("t"),
    "dynamicsymbols": dynamicsymbols._t,
    "real": sp.Symbol("t", real=True),
    "positive": sp.Symbol("t", positive=True),
    "nonnegative": sp.Symbol("t", nonnegative=True),
}


def damped(t, angle=lambda theta: theta):
    """A pendulum with damping and a push that both know the time by a symbol."""
    board = Model("damped")
    theta = board.coordinates("theta", "rad")
    g, l, m = board.parameters(g=(9.81, "m/s²"), l=(1.0, "m"), m=(1.0, "kg"))
    c = board.parameters(c=(0.3, "kg/s"))
    bob = board.particle(m, l * (sin(theta) * i - cos(theta) * j))
    board.gravity(-g * j)
    along, theta = cos(theta) * i + sin(theta) * j, angle(theta)
    bob.force(-c * l * theta.diff(t) * along + sin(t) * i)
    bob.force(-0.1 * theta.diff(t, 2) * along - rate(sin(2 * t) * i))
    board.start(theta=1.0)
    return board.lagrange().system().solve((0, 5)).y[:, -1]


@pytest.fixture(scope="module")
def expected():
    return damped(TIMES["ours"])


@pytest.mark.parametrize("name", TIMES)
def test_any_symbol_called_t_is_the_time(name, expected):
    assert damped(TIMES[name]) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("name", ["dynamicsymbols", "real"])
def test_a_function_of_another_t_is_the_coordinate_of_its_name(name, expected):
    t = TIMES[name]
    found = damped(t, lambda _: sp.Function("theta")(t))
    assert found == pytest.approx(expected, abs=1e-15)
    assert damped(t, lambda _: dynamicsymbols("theta").xreplace({dynamicsymbols._t: t}))[0]


def test_the_rate_of_an_absolute_time_is_short():
    t = sp.Symbol("t")
    assert rate(sp.Abs(t)) == sp.sign(t)


def plate(**options):
    board = Model("plate")
    x, theta = board.coordinates("x theta", "m rad")
    m, I = board.parameters(m=(1.0, "kg"), I=(2.0, "kg m²"))
    return board, x, theta, m, I


def test_a_body_that_does_not_turn_has_no_inertia():
    board, x, theta, m, I = plate()
    for turned in (0, sp.pi / 4):
        with pytest.raises(ValueError, match=r"body has a moment of inertia, but .* not turn"):
            board.body(m, x * i, I, turned)
        with pytest.raises(ValueError, match="a moment of inertia"):
            board.body(m, x * i, (I, I, I), turned)
    still = board.body(m, x * i)
    with pytest.raises(ValueError, match="body has a torque, but it does not turn"):
        still.torque(board.numbers[1].symbol * fastdyn.derive.k)
    assert board.body(m, x * i, I, theta).rigid


def test_numbers_that_nothing_uses_are_warned_of():
    board, x, theta, m, I = plate()
    board.initial(V=(1.0, "m/s"))
    board.body(m, x * i, 0, theta)
    body = board.body(m, x * i, I, theta)
    with pytest.warns(UserWarning, match="`V` of plate is used nowhere"):
        board.lagrange()
    board.start(vx=board.numbers[-1].symbol)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert board.lagrange()
    board.parameters(c=(1.0, "kg/m"))
    with pytest.warns(UserWarning, match="`c` of plate is used nowhere"):
        board.lagrange()
    body.drag(board.numbers[-1].symbol)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert board.lagrange()


def on_floor(through=None, start=None, also=None):
    board = Model("above")
    x, y = board.coordinates("x y")
    m, g = board.parameters(m=(1.0, "kg"), g=(9.81, "m/s²"))
    block = board.particle(m, x * i + y * j, "block")
    board.gravity(-g * j)
    N = board.reactions("N")
    block.slides(j, N, through=through)
    board.start(**(start or {}))
    return board


def test_a_floor_of_velocities_alone_is_warned_of():
    """The block at a height of 5 m slides there, on nothing."""
    with pytest.warns(UserWarning, match="`slip1` of above .* y = 5, .*`through=`"):
        board = on_floor(start={"y": 5.0}).newton()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert on_floor(through=0 * i).newton().start.default[1] == 0.0
    assert board


def test_a_position_in_disguise_is_warned_of():
    """A velocity of x² y that is zero holds x² y, wherever it begins."""
    board = Model("hidden")
    x, y = board.coordinates("x y")
    m = board.parameters(m=(1.0, "kg"))
    board.particle(m, x * i + y * j)
    board.constrain(rate(x**2 * y), "product", "m³/s")
    board.start(x=1.0, y=2.0)
    with pytest.warns(UserWarning, match="`product` of hidden .* as it starts, x = 1, y = 2"):
        board.lagrange()


@pytest.mark.hunt
def test_wheels_and_edges_are_not_warned_of():
    from fastdyn.derive.pages import page

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in ("vehicle", "chaplygin_sleigh", "rolling_disc", "rod", "four_bar"):
            page(name).derive()
