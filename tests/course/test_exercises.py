"""Worksheets that are handed in: what is right passes, and what is wrong is found where it is."""

import inspect

import numpy as np
import pytest

from fastdyn.cli.main import main
from fastdyn.course.exercises.call import ExerciseCall
from fastdyn.course.exercises.check import check
from fastdyn.course.exercises.compare import compare
from fastdyn.course.exercises.sheet import EXERCISES
from fastdyn.systems import SYSTEMS
from fastdyn.systems.base.units import product_of


def wrong(name, old, new):
    """The sentence about a solution in which a piece of text was replaced."""
    exercise = EXERCISES[name]
    text = inspect.getsource(exercise.solution)
    assert old in text
    space = {"np": np}
    exec(text.replace(old, new), space)
    return compare(exercise, space[name])


@pytest.mark.parametrize("name", EXERCISES)
def test_the_solution_is_right(name):
    assert compare(EXERCISES[name], EXERCISES[name].solution) == []


def test_there_are_twelve_in_the_order_of_the_chapter():
    assert list(EXERCISES) == [
        "projectile", "suspension", "rod", "normal_force", "pendulum", "tension", "drag", "wind",
        "satellite", "energy", "building", "pendulum_xy",
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["suspension", "rod", "satellite", "building"])
def test_the_references_are_the_systems_of_the_course(name):
    system, exercise = SYSTEMS[name](), EXERCISES[name]
    args = [getattr(system, {"w": "omega"}.get(one, one)) for one in exercise.parameters]
    y = np.linspace(0.3, 0.9, len(exercise.state))
    assert np.allclose(exercise.solution(0.7, y, *args), system.rhs(0.7, y, *system.args))


@pytest.mark.parametrize(("name", "old", "new", "sentences"), [
    ("projectile", "-g]", "g]", ["`vz'` has the wrong sign as a whole."]),
    ("suspension", "- g]", "+ g]", ["In `v'` the term of the weight has the wrong sign."]),
    ("suspension", "- g]", "]", ["In `v'` the term of the weight is missing."]),
    ("suspension", "(x - L0)", "(x + L0)", [
        "In `v'` the term of the natural length in the spring's force has the wrong sign."]),
    ("suspension", "- g]", "- m * g]", [
        "The term of the weight in `v'` has the wrong unit: m/s² is due, and it has kg too many."]),
    ("rod", "2 * mu", "mu", [
        "In `v'` the term of friction is too small, by the same factor everywhere."]),
    ("rod", "omega**2 * r - 2 * mu", "r - 2 * mu", [
        "The term of the centripetal acceleration in `v'` has the wrong unit: m/s² is due, and it "
        "has s²/rad² too many."]),
    ("pendulum", "np.sin(theta)", "np.sin(np.radians(theta))", [
        "`omega'` takes an angle for one in degrees: the state is in radians."]),
    ("pendulum", "np.sin(theta)", "theta", [
        "`omega'` is right for small angles only: theta for sin(theta)?"]),
    ("tension", "np.cos(theta)", "(1 - theta**2 / 2)", [
        "`R` is right for small angles only."]),
    ("drag", "speed * vx", "speed**2", [
        "In `vx'` the term of the drag has the square of the size, vx² + vz², in the place of "
        "sqrt(vx² + vz²) vx: it has no direction, and does not turn round with vx."]),
    ("pendulum", "g / l", "g", [
        "`omega'` as a whole has the wrong unit: rad/s² is due, and it has m too many."]),
    ("satellite", "[vx, vy, -GM * x / r**3, -GM * y / r**3]",
     "[vx, vy, -GM * y / r**3, -GM * x / r**3]", [
        "`vx'` has the value of `vy'`: the order of what is returned?",
        "`vy'` has the value of `vx'`: the order of what is returned?"]),
    ("satellite", "r = np.hypot(x, y)", "return [vx, vy]", [
        "It returns 2 numbers; 4 are asked for: x', y', vx', vy'."]),
    ("satellite", "r**3", "(r - r)**3", ["`vx'` and `vy'` are not finite at 60 states."]),
    ("building", "upper - lower - g", "-upper - lower - g", [
        "In `v1'` the term of the upper walls has the wrong sign."]),
])  # fmt: skip
def test_what_is_wrong_is_found_where_it_is(name, old, new, sentences):
    found = wrong(name, old, new)
    for sentence in sentences:
        assert sentence in found
    assert len(found) == len(sentences)


def test_what_has_no_name_is_said_by_what_it_depends_on():
    (found,) = wrong("pendulum", "np.sin(theta)", "np.sin(2 * theta)")
    assert found.startswith("`omega'` differs, most of all at theta =") and "theta" in found
    assert wrong("drag", "-c * speed * vx", "-c * vx * vx")[0].startswith("`vx'` differs")
    (still,) = wrong("building", "d * np.sin", "0 * np.sin")
    assert still.endswith("it should depend on d and omega and t, and does not.")


@pytest.mark.hunt
def test_a_worksheet_with_functions_and_a_model(tmp_path, capsys):
    path = tmp_path / "worksheet.py"
    path.write_text(
        "from math import cos, sin\n"
        "import sympy\n"
        "from fastdyn.derive import Model, i, j\n"
        "def tension(t, y, m, g, l):\n"
        "    theta, omega = y\n"
        "    return m * l * omega**2 - m * g * cos(theta)\n"
        "def projectile(t, y, g):\n"
        "    return [y[2], y[3], 0, -g]\n"
        "board = Model('pendulum')\n"
        "theta = board.coordinates('theta', 'rad', rates='omega')\n"
        "m, g, l = board.parameters(m=(1.0, 'kg'), g=(9.81, 'm/s²'), l=(1.0, 'm'))\n"
        "board.particle(m, l * (sympy.sin(theta) * i - sympy.cos(theta) * j))\n"
        "board.gravity(g * j)\n"
    )
    found = check(path).found
    assert found == {
        "projectile": [],
        "pendulum": ["`omega'` has the wrong sign as a whole."],
        "tension": ["In `R` the term of the weight has the wrong sign."],
    }
    assert main(["check", str(path)]) == 1
    assert "projectile: right" in capsys.readouterr().out
    path.write_text("x = 1\n")
    assert main(["check", str(path)]) == 2
    assert "answers no exercise" in capsys.readouterr().err


def test_a_lecturers_own_exercise(tmp_path, capsys):
    own, sheet = tmp_path / "mine.py", tmp_path / "sheet.py"
    own.write_text(
        "from fastdyn.course.exercises.exercise import Exercise\n"
        "def fall(t, y, g):\n"
        "    return [y[1], -g]\n"
        "stone = Exercise('fall', 'A stone falls.', {'z': 'm', 'v': 'm/s'}, {'g': 'm/s²'},\n"
        "    {\"z'\": 'm/s', \"v'\": 'm/s²'}, {\"z'\": {'the velocity': lambda t, y, p: y.v},\n"
        "    \"v'\": {'gravity': lambda t, y, p: -p.g}}, fall)\n"
    )
    sheet.write_text("def fall(t, y, g):\n    return [y[1], -2 * g]\n")
    assert main(["check", str(sheet), "--exercises", str(own)]) == 1
    assert "too large, by the same factor" in capsys.readouterr().out


def test_the_list_of_exercises_has_no_solutions_unless_asked_for(capsys):
    assert main(["check"]) == 0
    listed = capsys.readouterr().out
    assert "def pendulum(t, y, g, l):" in listed and "np.sin" not in listed
    assert main(["check", "--solutions"]) == 0
    assert "np.sin(theta)" in capsys.readouterr().out


def of_terms(exercise, change):
    """A student's function made of the reference's terms, {answer: {term: array}}, changed."""

    def function(t, y, *p):
        state = {name: np.array([v]) for name, v in zip(exercise.state, y, strict=True)}
        given = {name: np.array([v]) for name, v in zip(exercise.parameters, p, strict=True)}
        terms = exercise.at(np.array([t]), state, given)
        change(terms, given)
        return [sum(one.values())[0] for one in terms.values()]

    return function


TERMS = [
    (name, answer, term)
    for name, exercise in EXERCISES.items()
    for answer, terms in exercise.terms.items()
    for term in terms
    if term != "nothing"
]


@pytest.mark.few(12)
@pytest.mark.parametrize(("name", "answer", "term"), TERMS)
@pytest.mark.parametrize("kind", ["sign", "factor", "missing", "unit", "power"])
def test_a_mistake_in_a_term_is_named_once_where_it_is(name, answer, term, kind):
    exercise = EXERCISES[name]
    key = next(k for k, unit in exercise.parameters.items() if unit not in ("1", ""))

    def change(terms, p):
        factor = {"sign": -1.0, "factor": 2.0, "missing": 0.0, "unit": p[key], "power": 1 / p[key]}
        terms[answer][term] = factor[kind] * terms[answer][term]

    (said,) = compare(exercise, of_terms(exercise, change))
    whole = len(exercise.terms[answer]) == 1
    assert f"`{answer}`" in said and (whole or f"the term of {term}" in said.lower())
    expected = {
        "sign": "the wrong sign", "factor": "too large, by the same", "missing": "is missing",
        "unit": "the wrong unit", "power": "the wrong unit",
    }  # fmt: skip
    assert expected[kind] in said


@pytest.mark.parametrize("name", EXERCISES)
def test_right_answers_in_disguise_are_right(name):
    exercise = EXERCISES[name]
    solution, names = exercise.solution, list(exercise.parameters)
    exec(
        f"def reversed_order(t, y, {', '.join(names[::-1])}):\n"
        f"    return solution(t, y, {', '.join(names)})",
        space := {"solution": solution},
    )
    disguised = [
        space["reversed_order"],
        of_terms(exercise, lambda terms, p: None),
        lambda t, y, *p: np.array([np.atleast_1d(solution(t, y, *p))]).T,
        lambda t, y, *p: tuple(np.atleast_1d(solution(t, y.tolist(), *p)) + 1e-15),
    ]
    assert [compare(exercise, each) for each in disguised] == [[]] * 4


@pytest.mark.parametrize(("name", "old", "new", "sentences"), [
    ("suspension", "x - L0", "x - 0.3", ["`v'` has a number in the place of `L0`."]),
    ("building", "- g", "- 9.81", ["`v1'` and `v2'` have a number in the place of `g`."]),
    ("projectile", "-g]", "-9.81]", ["`vz'` has a number in the place of `g`."]),
    ("satellite", "r**3", "r**2", [
        "`vx'` and `vy'` as a whole have the wrong unit: m/s² is due, and they have m too many."]),
    ("drag", "c * speed * vx", "c * vx", [
        "`vx'` as a whole has the wrong unit: m/s² is due, and it has s/m too many."]),
    ("energy", "GM / np.hypot(x, y)", "GM / np.hypot(x, y) ** 2", [
        "The term of gravity in `E/m` has the wrong unit: J/kg is due, and it has 1/m too many."]),
    ("wind", "vx - W", "vx + W", ["`vx'` and `vz'` take `W` with the wrong sign."]),
    ("pendulum_xy", "-(vx**2) - vy**2", "0", [
        "In `R` the term of the motion on a circle is missing."]),
    ("building", "2 * k / m", "2 * k", [
        "A wrong power of `m`, in one place perhaps: the terms of the lower walls and the upper "
        "walls in `v1'` have kg too many (m/s² is due); the term of the upper walls in `v2'` has "
        "kg too many (m/s² is due)."]),
    ("pendulum_xy", "m * g", "g", [
        "A wrong power of `m`, in one place perhaps: the term of the weight in `vy'` has 1/kg too "
        "many (m/s² is due); the term of the weight in `R` has 1/kg too many (N is due)."]),
    ("pendulum_xy", "[[m, 0, x / l], [0, m, y / l]", "[[1, 0, x / l], [0, 1, y / l]", [
        "A wrong power of `m`, in one place perhaps: `vx'` and `vy'` as a whole have kg too many "
        "(m/s² is due); the term of the motion on a circle in `R` has 1/kg too many (N is due)."]),
    ("pendulum_xy", "m * g", "-m * g", [
        "In `vy'` and `R` the term of the weight has the wrong sign."]),
])  # fmt: skip
def test_a_cause_is_named_once(name, old, new, sentences):
    assert wrong(name, old, new) == sentences


@pytest.mark.parametrize(("powers", "unit"), [
    ({"m/s²": -1}, "s²/m"), ({"rad/s": -2}, "s²/rad²"), ({"kg": 1, "m/s²": 1}, "kg m/s²"),
    ({"1/m": 1}, "1/m"), ({"1/m": -1}, "m"), ({"m": 1, "kg m/s²": -1}, "s²/kg"), ({"N/m": 0}, ""),
    ({"kg": -1, "m": -1}, "1/(kg m)"),
])  # fmt: skip
def test_units_are_written_as_people_do(powers, unit):
    assert product_of(powers) == unit


def test_an_exception_comes_with_its_meaning():
    (said,) = compare(EXERCISES["energy"], lambda t, y, GM: GM * y[0] ^ 2)
    assert said.endswith("`^` is no power in Python: x squared is x**2.")


def test_parameters_of_other_names_are_told():
    call = ExerciseCall(EXERCISES["pendulum"], lambda t, y, length, gravity: y)
    assert call.notes == ["Its parameters are taken in order: length as g, gravity as l."]
