"""Units that are declared count: angles in degrees, forces without their mass."""

import math
import warnings

import pytest
from sympy import sin

from fastdyn import systems
from fastdyn.derive import Model, i, j, t
from fastdyn.derive.checks.units import dimension_of
from fastdyn.derive.pages import page
from support import few


@pytest.fixture
def board():
    board = Model("box")
    board.x, board.th = board.coordinates("x th", "m rad")
    board.m, board.g = board.parameters(m=(2.0, "kg"), g=(9.81, "m/s²"))
    board.box = board.body(board.m, board.x * j, 1, board.th, "box")
    return board


@pytest.mark.filterwarnings("ignore:`g` of box is used nowhere")
def test_degrees_are_refused_as_the_unit_and_taken_in_values(board):
    for declare in (
        lambda: board.initial(a=(60, "deg")),
        lambda: board.parameters(a=(60, "deg")),
        lambda: board.coordinates("a", "deg"),
        lambda: board.parameters(a=(33, "rpm")),
    ):
        with pytest.raises(ValueError, match=r"`a` is declared in .* angles are in radians"):
            declare()
    a = board.initial(a=("60 deg", "rad"))
    board.start(th=a, vth="30 rpm", x="2 m")
    assert board.lagrange().system().initial_state() == pytest.approx(
        (2.0, math.pi / 3, 0.0, math.pi)
    )


def test_a_start_that_seems_to_be_in_degrees_is_warned_of(board):
    for text in (60, "60"):
        with pytest.warns(UserWarning, match="start of `th` is 60 rad, more than a full turn"):
            board.start(th=text)
    with pytest.warns(UserWarning, match="default of `a` is 60 rad"):
        board.initial(a=(60, "rad"))
    with pytest.warns(UserWarning, match="`angle` of the tower is 45 rad"):
        systems.tower(angle="45")


@pytest.mark.parametrize("wrong", ["60 grad", "V0", "1 kg", float("nan"), float("inf"), 1j])
def test_a_start_that_is_no_number_is_refused(board, wrong):
    with pytest.raises(ValueError, match=r"start of `x`|is not in m"):
        board.start(x=wrong)


def no_mass(board):
    board.box.force(-board.g * j)


def mass_twice(board):
    board.gravity(-board.m * board.g * j)


def a_length_for_an_angle(board):
    board.box.force(board.m * board.g * sin(board.x) * i)


def a_force_for_a_torque(board):
    board.box.force(board.m * board.g * board.x * j)


def stiffness_without_length(board):
    board.spring(0, board.box, board.m * board.g, along=j)


def a_sum_of_two_units(board):
    board.constrain(board.x - board.g * board.m, "sum")


def the_speed_for_the_place(board):
    board.start(x=board.initial(V=(1.0, "m/s")))


def centimetres(board):
    board.box.force(board.m * board.g * board.x / board.parameters(l=(30.0, "cm")) * j)


def a_quantity_of_another_unit(board):
    board.quantity("power", board.m * board.g * board.x, "W")


WRONG = {
    no_mass: "A force on box of box is in m/s² where N is needed",
    mass_twice: "gravity of box is in kg m/s² where m/s² is needed, an acceleration: fastdyn mult",
    a_length_for_an_angle: "has sin of x, which is in m",
    a_force_for_a_torque: "force on box of box is in kg m²/s² where N is needed",
    stiffness_without_length: "energy of a spring, .* is in .* where J is needed|adds",
    a_sum_of_two_units: "`sum` of box adds .*, in (kg m/s²|m), to ",
    the_speed_for_the_place: "start of `x` of box is in m/s where m is needed",
    centimetres: "A force on box of box is in 100 kg m/s² where N is needed",
    a_quantity_of_another_unit: "quantity `power` of box is in kg m²/s² where W is needed",
}


@pytest.mark.filterwarnings("ignore:`g` of box is used nowhere")
@pytest.mark.parametrize("wrong", WRONG, ids=lambda one: one.__name__)
def test_units_that_do_not_agree_are_warned_of(board, wrong):
    wrong(board)
    with pytest.warns(UserWarning, match=WRONG[wrong]):
        board.lagrange()


def test_numbers_without_units_raise_no_alarm(board):
    board.gravity(-9.81 * j)
    board.box.force((-3 * board.x + 2 * sin(5 * t) + 1) * j - 0.5 * board.box.velocity())
    board.box.force((board.m * board.g + sin(t)) * j + sin(board.th) * i)  # 1 N
    board.spring(0, board.box, 100, 0.2, along=j)
    k = board.parameters(k=(1.0, "lbf/ft"))
    board.box.force(-k * board.x * j)
    board.quantity("half", board.m * board.g / 2, "J")  # the number may have a unit
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        board.lagrange()


UNITED = "projectile", "satellite", "suspension", "rod", "heavy_top", "building"


@pytest.mark.parametrize("name", few.hunts(UNITED, "projectile", "suspension", "rod"))
def test_no_page_raises_an_alarm(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        page(name).derive()


def test_units_are_read_as_they_are_written():
    for one, other in (
        ("N", "kg m/s²"), ("N m", "J"), ("N/m", "kg/s^2"), ("W", "N m s**-1"), ("1/s", "Hz"),
        ("J/(kg K)", "m² s⁻² K⁻¹"), ("N*m", "N·m"), ("rad/s", "1/s"),
    ):  # fmt: skip
        assert dimension_of(one).agrees(dimension_of(other)), (one, other)
    assert not dimension_of("cm").agrees(dimension_of("m"))
    for unknown in ("", "smoots", "N/m s", "%"):
        assert dimension_of(unknown) is None


def test_lengths_masses_times_and_forces_have_prefixes():
    given = {"m": "250 g", "L": "100 cm", "T": "5 ms", "F": "2 kN", "k": "3 kN/m", "v": "36 km/h"}
    units = {"m": "kg", "L": "m", "T": "s", "F": "N", "k": "N/m", "v": "m/s"}
    model = Model("prefixed")
    model.parameters(**{name: (text, units[name]) for name, text in given.items()})
    found = {str(one.symbol): one.default for one in model.numbers}
    expected = {"m": 0.25, "L": 1.0, "T": 0.005, "F": 2000.0, "k": 3000.0, "v": 10.0}
    assert found == pytest.approx(expected, rel=1e-15)
    assert systems.pendulum(l="50 cm").l == 0.5
    for text in ("100 g", "1 xm", "1 m/s"):
        with pytest.raises(ValueError, match="is not in m"):
            systems.pendulum(l=text)
    with pytest.raises(ValueError, match="is not in rad/s"):  # a frequency is no angular velocity
        systems.rod(omega="1 Hz")


def test_quantities_of_pint_are_converted():
    class Quantity:  # as pint's: to(text), magnitude, units
        def __init__(self, magnitude, units):
            self.magnitude, self.units = magnitude, units

        def to(self, unit):
            if (self.units, unit) != ("cm/s**2", "m/s**2"):
                raise TypeError(f"Cannot convert from {self.units} to {unit}")
            return Quantity(self.magnitude / 100, unit)

    assert systems.pendulum(g=Quantity(981.0, "cm/s**2")).g == pytest.approx(9.81)
    with pytest.raises(ValueError, match="Cannot convert"):
        systems.pendulum(l=Quantity(1.0, "kg"))


def test_a_number_may_be_called_w():
    model = Model("wide")
    x = model.coordinates("x", "m", rates="v")
    m, w = model.parameters(m=(1.0, "kg"), w=(4.0, "N/m"))
    model.particle(m, x * i).force(-w * x * i)
    wide = model.derive().system()
    assert wide.rhs(0.0, [1.0, 0.5], *wide.args) == [0.5, -4.0]
    run = wide.solve((0, 1), y0=[1.0, 0.0], rtol=1e-10, atol=1e-10)
    assert run.y[0, -1] == pytest.approx(math.cos(2.0), abs=1e-8)
    one = Model("one")
    q = one.coordinates("w", "m", rates="v")
    one.particle(1.0, q * i).force(-4.0 * q * i)
    assert one.derive().system().rhs(0.0, [1.0, 0.5]) == [0.5, -4.0]
