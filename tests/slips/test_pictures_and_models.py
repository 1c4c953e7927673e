"""Slips in the calls that draw, and in models of `fastdyn.derive`."""

import numpy as np
import pytest

import fastdyn
from fastdyn import plot, systems
from fastdyn.planets import outer_planets
from support.slips import NUMBER, NUMBERS, rows_of, said_to

sp = pytest.importorskip("sympy")
pytest.importorskip("matplotlib")

from fastdyn.derive import Model, cross, dot, i, j, k, length, rotation  # noqa: E402

RUN = fastdyn.OdeResult(t=np.array([0.0, 1.0]), y=np.zeros((2, 2)), sol=None)
PENDULUM = systems.pendulum()
A_RESULT = "`result` must be the result of a solve; got "
RESULTS = "must be the result of a solve, or a dict of results by label; got "
BOARD = Model("board")
X, Y = BOARD.coordinates("x y")
BALL = BOARD.particle(1, X * i + Y * j)


class Named:
    """What has a figure, as a Figure has, and is no Axes."""

    figure = True


def of_model(name):
    """The method of a new model with the coordinates x and y, and a ball."""

    def call(*, given=(), **named):
        model = Model("slips")
        x, y = model.coordinates("x y")
        model.particle(1, x * i + y * j)
        return getattr(model, name)(*given, **named)

    return call


def vector_of(what):
    return f"{what} must be a vector, a sum of multiples of i, j and k; got "


def expression_of(what):
    return f"{what} must be a number or an expression; got "


TABLE = {
    "plot": (plot.plot, {"result": RUN}, [
        ({"result": "x"}, f"`result` {RESULTS}the text 'x'"), ({"result": None}, RESULTS),
        ({"result": {"a": 3}}, f"{RESULTS}3"), ({"result": {}}, "does `t_eval` hold any?"),
        ({"ax": 3}, "`ax` must be one Axes of a grid, as of plt.subplots; got 3"),
        ({"ax": Named()}, "`ax` must be one Axes"), ({"kind": 3}, "or the options of plt.figure"),
        ({"label": 3}, "`label` must be a text; got 3"),
    ]),
    "components": (plot.components, {"results": {"a": RUN}}, [
        ({"results": 3}, f"`results` {RESULTS}3"), ({"results": {"a": "x"}}, RESULTS),
    ]),
    "drift": (plot.drift, {"results": {"a": RUN}}, [({"results": 3}, f"`results` {RESULTS}3")]),
    "curve": (plot.curve, {"result": RUN}, [
        ({"result": 3}, f"{A_RESULT}3"), ({"per_step": "x"}, f"`per_step` {NUMBER}the text 'x'"),
    ]),
    "relative_changes": (plot.relative_changes, {"result": RUN}, [({"result": 3}, A_RESULT)]),
    "exact_curve": (plot.exact_curve, {"system": PENDULUM, "t": [0.0, 1.0]}, [
        ({"system": "pendulum"}, "`system` must be a system; got the text 'pendulum'"),
        ({"t": "x"}, f"`t` {NUMBERS}the text 'x'"),
    ]),
    "column": (plot.column, {"n_panels": 1}, [
        ({"n_panels": "x"}, f"`n_panels` {NUMBER}the text 'x'"),
        ({"n_panels": 1.5}, "`n_panels` must be a whole number; got 1.5"),
    ]),
    "save": (plot.save, {"figure": None, "path": "x.png"}, [
        ({}, "`figure` must be a figure; got None"), ({"figure": RUN}, "`figure` must be a figure"),
    ]),
    "animate": (lambda **given: PENDULUM.solve((0.0, 0.1)).animate(**given), {}, [
        ({"path": "x.png"}, "`path='x.png'`: a moving picture ends in .gif, .html, .mp4"),
        ({"path": 3}, "`path` must be the path of a file; got 3"),
        ({"seconds": "x"}, f"`seconds` {NUMBER}the text 'x'"), ({"fps": "x"}, f"`fps` {NUMBER}"),
        ({"seconds": -1}, "`fps` and `seconds` must be positive; got 30 and -1"),
        ({"second": 3}, "did you mean `seconds`?"),
    ]),
    "plot of an ensemble": (lambda **given: ENSEMBLE.plot(**given), {}, [
        ({"of": "y_en"}, '`of=\'y_en\'` is not there; did you mean "y_end"?'),
        ({"of": 3}, "`of` must be a list; got 3"), ({"over": 3}, "`over` must be a list; got 3"),
        ({"over": "thet"}, "`over='thet'` does not vary"), ({"over": [3]}, "`over=3` does not"),
        ({"components": "omeg"}, "`components='omeg'` is unknown; did you mean `omega`?"),
        ({"components": None, "ax": 3}, "`ax` must be one Axes of a grid"),
    ]),
    "system": (systems.pendulum, {}, [
        ({"l": "x"}, "Parameter `l` of the pendulum (length of the cable, m) must be one real num"),
        ({"l": -1}, "must be greater than zero, but -1 was given"),
        ({"l": "6,5"}, "'6,5' has a comma; a decimal number has a point, '6.5'"),
        ({"l": "5 metres"}, "'5 metres' is not in m; did you mean 'm'?"),
        ({"m": "1 kgg"}, "'1 kgg' is not in kg; did you mean 'kg'?"),
        ({"theta0": "45 degg"}, "; did you mean 'deg'?"),
        ({"g": "9.81 m/sec²"}, "is not in m/s²; did you mean 'm/s²'?"),
        ({"l": "5 sec"}, "'5 sec' is not in m."),
        ({"l": [1, 2]}, "must be one real number, but [1, 2] was given"),
        ({"L": 1.0}, "pendulum has no parameter `L`; did you mean `l`?"),
        ({"length": 1.0}, "its parameters are g, l, V0, m, theta0"),
        ({"V0": "5 kg"}, "'5 kg' is not in m/s"),
    ]),
    "solve of a system": (PENDULUM.solve, {"t_span": (0, 1)}, [
        ({"t_span": 10}, "`t_span` must be start and end; got 10: (0, 10)?"),
        ({"y0": "x"}, "`y0` of the pendulum must be 2 numbers (theta, omega)"),
        ({"y0": "RK45"}, "got the text 'RK45'"),
        ({"method": "rk45"}, 'did you mean "RK45"?'), ({"events": 3}, "`events` must be a fun"),
        ({"events": "slak"}, "pendulum has no event 'slak'; did you mean `slack`?"),
        ({"rtoll": 3}, "`solve` of the pendulum takes no `rtoll`; did you mean `rtol`?"),
    ]),
    "ensemble of a system": (PENDULUM.ensemble, {"t_span": (0, 1)}, [
        ({"l": [1.0, 2.0], "g": [1.0, 2.0, 3.0]}, "one entry a trajectory: `l` has 2, `g` has 3"),
        ({"ll": [1.0, 2.0]}, "`ensemble` of the pendulum takes no `ll`; did you mean `l`?"),
        ({"l": "x"}, "must be one real number, but 'x' was given"),
        ({"l": ["1 m", "2 kg"]}, "'2 kg' is not in m"), ({"l": [None, 1]}, "one a trajectory; got"),
    ]),
    "sampled": (systems.building.sampled, {}, [
        ({"displacements": [0]}, "The call is sampled(times"),
    ]),
    "planets": (outer_planets().solve, {"t_span": (0, 1), "step": 1.0}, [
        ({"corector": 0}, "`corector`: did you mean `corrector`?"),
    ]),
    "Model": (Model, {"name": "m"}, [
        ({"name": "a b"}, "'a b' is no name that Python takes for a variable"),
        ({"name": 3}, "3 is no name"), ({"t_end": "x"}, f"`t_end` {NUMBER}the text 'x'"),
    ]),
    "coordinates": (of_model("coordinates"), {}, [
        ({"names": 3}, "`names` must be a text; got 3"), ({"names": ["u", "v"]}, "must be a text"),
        ({"given": ("u", "v")}, "several names are one text: coordinates('u v')"),
        ({"names": "u v", "units": "m rad s"}, "2 names (u v) have 3 of ['m', 'rad', 's']"),
        ({"names": "u", "units": "deg"}, "`u` is declared in deg, but angles are in radians here"),
        ({"names": "u", "units": "metr"}, "is no unit that fastdyn knows; did you mean 'm'?"),
        ({"names": "x"}, "The name `x` of slips is taken"), ({"names": "u-v"}, "'u-v' is no name"),
    ]),
    "parameters": (of_model("parameters"), {}, [
        ({"m": 3.0}, "`m` is declared by (default, unit) or (default, unit, meaning), as in m=("),
        ({"m": (1.0, "kgg")}, "declared in 'kgg', which is no unit known here; did you mean 'kg'?"),
        ({"g": (9.81, "m/sec²")}, "did you mean 'm/s²'?"),
        ({"m": (1.0, 3)}, "The unit of `m` must be a text; got 3"),
        ({"m": (1.0,)}, "`m` is declared by (default,"), ({"m": ("x", "kg")}, "got ('x', 'kg')"),
        ({"m": (-1.0, "kg")}, "The default of `m` is -1, but it is declared greater than zero"),
    ]),
    "particle": (of_model("particle"), {"mass": 1, "position": X * i}, [
        ({"mass": "x"}, f"{expression_of('the mass of mass 2')}'x'"),
        ({"mass": None}, expression_of("the mass of mass 2")),
        ({"position": 3}, f"{vector_of('the position of mass 2')}3"),
        ({"position": "x"}, vector_of("the position of mass 2")),
    ]),
    "body": (of_model("body"), {"mass": 1, "position": X * i, "inertia": 1, "turned": Y}, [
        ({"inertia": (1, 2)}, "body has three principal moments of inertia; got (1, 2)"),
        ({"inertia": "x"}, expression_of("a moment of inertia of body")),
        ({"turned": "x"}, expression_of("the angle of a rotation")),
        ({"turned": 0}, "body has a moment of inertia, but it does not turn"),
    ]),
    "gravity": (of_model("gravity"), {}, [
        ({"g": 9.81}, f"{vector_of('the acceleration of gravity')}9.81"),
        ({"g": "x"}, vector_of("")),
    ]),
    "spring": (of_model("spring"), {"a": 0 * i, "b": BALL, "stiffness": 1}, [
        ({"a": 3}, f"{vector_of('an end of a spring')}3"), ({"b": "x"}, vector_of("")),
        ({"b": j}, "a spring or a force between two places moves nothing"),
        ({"a": BALL}, "between two points whose distance never changes has no effect"),
        ({"stiffness": "x"}, f"{expression_of('the stiffness of a spring')}'x'"),
        ({"natural": None}, expression_of("the natural length of a spring")),
    ]),
    "damper": (of_model("damper"), {"a": 0 * i, "b": BALL, "c": 1}, [
        ({"c": "x"}, f"{expression_of('the constant of a damper')}'x'"),
    ]),
    "line": (of_model("line"), {}, [
        ({"given": (BALL,)}, "a line goes through two points or more"),
        ({"given": (3, 4)}, vector_of("an end of a spring")),
    ]),
    "constrain": (of_model("constrain"), {}, [
        ({"expression": "x"}, "A constraint is an expression that is zero, or an equation Eq(a, b"),
        ({"expression": X > 0}, "an equation Eq(a, b)"), ({"expression": None}, "got None"),
    ]),
    "start": (of_model("start"), {}, [
        ({"z": 3}, "`z` is no part of the state (x, y, vx, vy)"), ({"x": "a"}, "got 'a'"),
        ({"x": None}, expression_of("the start of `x`")),
        ({"x": 1 * i}, expression_of("the start of `x`")), ({"x": float("nan")}, "a finite number"),
    ]),
    "sums of vectors": (lambda call, given: call(given), {}, [
        ({"call": lambda x: x + Y * j, "given": X}, "A number is added to a vector: x(t)"),
        ({"call": lambda x: Y * j + x, "given": X}, "Each part of a vector has its direction"),
        ({"call": lambda x: i - x, "given": 1.0}, "A number is added to a vector"),
        ({"call": lambda x: x * j, "given": i}, "Two vectors are multiplied by dot(a, b), a numbe"),
    ]),
    "vectors": (lambda call, given: call(*given), {}, [
        ({"call": cross, "given": (3, j)}, vector_of("a vector")),
        ({"call": dot, "given": (i, "x")}, vector_of("a vector")),
        ({"call": length, "given": (3,)}, vector_of("a vector")),
        ({"call": rotation, "given": ("x", k)}, expression_of("the angle of a rotation")),
        ({"call": rotation, "given": (X, 3)}, vector_of("the axis of a rotation")),
    ]),
}  # fmt: skip
ENSEMBLE = PENDULUM.ensemble((0.0, 0.1), l=[1.0, 2.0, 3.0])


@pytest.mark.parametrize(("call", "given", "words", "kind"), rows_of(TABLE))
def test_a_slip_is_answered(call, given, words, kind):
    assert words in said_to(call, given, kind)


MOTION = PENDULUM.solve((0.0, 0.1))
WITHOUT = [  # what a result, an ensemble or a module does not have
    (lambda: MOTION["thetta"], "the result has no 'thetta'; did you mean `theta`?"),
    (lambda: MOTION.vjp, "the result has no 'vjp'; a result of a solve with `adjoint` has one."),
    (lambda: MOTION.tevents, "the result has no 'tevents'; did you mean `t_events`?"),
    (lambda: MOTION["zz"], "it has energy, message,"),
    (lambda: ENSEMBLE.ys, "'Trajectories' has no attribute 'ys'; did you mean `y`?"),
    (lambda: ENSEMBLE["theta"], "trajectories are numbered: ensemble[0]['theta']"),
    (lambda: systems.pendulm, "did you mean `pendulum`?"),
    (lambda: fastdyn.solve_ipv, "did you mean `solve_ivp`?"),
    (lambda: fastdyn.odeintt, "did you mean `odeint`?"),
    (lambda: PENDULUM.solve(params={"l": 2.0}), "are its parameters; set them by name, pendulum("),
]


@pytest.mark.parametrize(("asked", "words"), WITHOUT)
def test_a_name_that_is_not_there_is_answered(asked, words):
    with pytest.raises((KeyError, AttributeError, TypeError)) as found:
        asked()
    assert words in str(found.value)
