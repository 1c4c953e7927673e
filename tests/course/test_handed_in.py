"""Answers as students write them: every right form passes, what hangs or ends Python is said."""

import numpy as np
import pytest
from numba import njit

from fastdyn.cli.main import main
from fastdyn.course.exercises.check import check
from fastdyn.course.exercises.compare import compare
from fastdyn.course.exercises.reading import read
from fastdyn.course.exercises.sheet import EXERCISES, exercises_of, judged

# ruff: noqa: E741 - the course calls the length l
RIGHT = "def projectile(t, y, g):\n    return [y[2], y[3], 0, -g]\n"


def of_text(text, folder, **options):
    path = folder / "worksheet.py"
    path.write_text(text)
    return check(path, **options)


def chapter(t, y, m, g, l):
    x, y, vx, vy = y
    r = np.sqrt(x**2 + y**2)
    M = np.eye(5)
    M[2, 4], M[3, 4], M[4] = x / (m * r), y / (m * r), [0, 0, x, y, 0]
    return np.linalg.solve(M, [vx, vy, 0, g, -(vx**2) - vy**2])[2:]


def closed(t, y, m, g, l):
    x, y, vx, vy = y
    R = m * (vx**2 + vy**2) / l + m * g * y / l
    return [-R * x / (m * l), g - R * y / (m * l), R]


@njit
def jitted(t, y, g, l):
    return np.array([y[1], -g / l * np.sin(y[0])])


@pytest.mark.parametrize(("name", "function"), [
    ("pendulum_xy", chapter),
    ("pendulum_xy", closed),
    ("normal_force", lambda t, y, m, omega: 2 * m * omega * abs(y[1])),
    ("rod", lambda t, y, mu, omega: [y[1], omega**2 * abs(y[0]) - 2 * mu * abs(omega * y[1])]),
    ("suspension", lambda t, y, m, k, L0, g: [y[1], -k / m * (abs(y[0]) - L0) - g]),
    ("pendulum", lambda t, y, l, g: [y[1], -g / l * np.sin(y[0])]),
    ("pendulum", lambda t, y, L, g: [y[1], -g / L * np.sin(y[0])]),
    ("pendulum", lambda t, y, *p: [y[1], -p[0] / p[1] * np.sin(y[0])]),
    ("pendulum", lambda t, y, g, l: [[y[1]], [-g / l * np.sin(y[0])]]),
    ("pendulum", lambda t, y, g, l: np.array([[y[1], -g / l * np.sin(y[0])]])),
    ("pendulum", jitted),
    ("energy", lambda t, y, GM: (y[2]**2 + y[3]**2) / 2 - GM / np.hypot(y[0], y[1]) + GM / 6.4),
    ("tension", lambda t, y, m, g, l: [[m * l * y[1] ** 2 + m * g * np.cos(y[0])]]),
])  # fmt: skip
def test_every_right_form_is_right(name, function):
    assert compare(EXERCISES[name], function) == []


def test_one_array_that_is_filled_anew_is_read_each_time():
    out = np.empty(2)

    def pendulum(t, y, g, l):
        out[:] = y[1], -g / l * np.sin(y[0])
        return out

    assert compare(EXERCISES["pendulum"], pendulum) == []


@pytest.mark.parametrize(("name", "function", "sentence"), [
    ("energy", lambda t, y, GM: (y[2]**2 + y[3]**2) / 2 + GM / np.hypot(y[0], y[1]),
     "In `E/m` the term of gravity has the wrong sign."),
    ("suspension", lambda t, y, m, k, L0, g: [y[1], -k * (y[0] - L0) - g],
     "The terms of the position in the spring's force and the natural length in the spring's "
     "force in `v'` have the wrong unit: m/s² is due, and they have kg too many."),
    ("suspension", lambda t, y, m, k, L0, g: [y[1], -k * (y[0] - L0) + g],
     "The terms of the position in the spring's force and the natural length in the spring's "
     "force in `v'` have the wrong unit: m/s² is due, and they have kg too many; the term of the "
     "weight has the wrong sign."),
    ("pendulum", lambda t, y, g, l: [y[1], -np.sin(y[0])],
     "`omega'` as a whole has the wrong unit: rad/s² is due, and it has s² too many."),
    ("drag", lambda t, y, g, c: [y[2], y[3], -c * y[2]**2, -g - c * np.hypot(y[2], y[3]) * y[3]],
     "it should depend on vz, and does not."),
    ("pendulum", lambda t, y, g, l: [y[1], -g / l * y[0]], 
     "`omega'` is right for small angles only: theta for sin(theta)?"),
    ("pendulum", lambda t, y, g, l: [y[1], -g * np.sin(y[0] / l)],
     "`omega'` is right for small angles only."),
    ("pendulum", lambda t, y, g, l: [y[1], -g / l * np.sin(2 * y[0])],
     "differs, most of all at theta ="),
    ("tension", lambda t, y, m, g, l: [m * l * y[1] ** 2 + m * g],
     "`R` is right for small angles only: 1 for cos(theta)?"),
    ("pendulum", lambda t, y, g, l: [y[1], -g / l * np.sin(y[0]) - 0.1 * y[1]],
     "it depends on omega, and should not."),
    ("building", lambda t, y, m, k, L, d, omega, g: [y[2], y[3], 2 * k / m * (
        y[1] - 2 * y[0] + d) - g, -2 * k / m * (y[1] - y[0] - L) - g],
     "it should depend on omega and t, and does not."),
    ("pendulum", lambda t, y, g: [0, 0],
     "It takes (t, y, g); asked for is `def pendulum(t, y, g, l):`"),
    ("pendulum", lambda y, t, g, l: [0, 0], "It takes `y` before t"),
    ("pendulum", lambda t, y, g, l: {1, 2}, "It returns a set that is no list of numbers; 2 are"),
    ("pendulum", lambda t, y, g, l: {"omega": 1}, "It returns a dict that is no list of numbers"),
    ("pendulum", lambda t, y, g, l: (n for n in y), "It returns a generator that is no list"),
    ("pendulum", lambda t, y, g, l: "12", "It returns a str that is no list of numbers"),
    ("pendulum", lambda t, y, g, l: [1j, 1], "It returns a list that is no list of numbers"),
    ("pendulum", lambda t, y, g, l: None, "It returns None: is a `return` missing?"),
    ("pendulum", lambda t, y, g, l: 1.0, "It returns 1 number; 2 are asked for: theta', omega'."),
    ("satellite", lambda t, y, GM: np.ones((2, 2)), "It returns a matrix of 2 by 2; 4 are asked"),
    ("tension", lambda t, y, m, g, l: [1, 2], "It returns 2 numbers; 1 is asked for: R."),
    ("tension", lambda t, y, m, g, l: exit(0), "It ends Python, by exit, quit or sys.exit."),
])  # fmt: skip
def test_what_is_wrong_is_said(name, function, sentence):
    (found,) = compare(EXERCISES[name], function)
    assert sentence in found


def test_no_warning_reaches_the_student(recwarn, capfd):
    compare(EXERCISES["pendulum"], lambda t, y, g, l: np.array([0.0, 1.0]) / 0.0)
    (found,) = compare(EXERCISES["pendulum"], lambda t, y, g, l: [y[1], 1.0])
    assert "it should depend on theta and g and l, and does not" in found
    assert not recwarn.list and not capfd.readouterr().err


MODELS = (
    "from sympy import sin\nfrom fastdyn.derive import Model, j, t\n"
    "b = Model('suspension')\nx = b.coordinates('x', rates='v')\n"
    "m, k, L0, g = b.parameters(m=(1., 'kg'), k=(1., 'N/m'), L0=(1., 'm'), g=(1., 'm/s²'))\n"
    "p = b.particle(m, x * j)\nb.gravity(-g * j)\nb.spring(0 * j, p, k, L0)\n"
    "b = Model('building')\ny1, y2 = b.coordinates('y1 y2', rates='v1 v2')\n"
    "m, k, L, d, omega, g = b.parameters(m=(1., 'kg'), k=(1., 'N/m'), L=(1., 'm'), d=(1., 'm'),\n"
    "    omega=(1., 'rad/s'), g=(1., 'm/s²'))\n"
    "p, q = b.particle(m, y1 * j), b.particle(m, y2 * j)\nb.gravity(-g * j)\n"
    "b.spring(d * sin(omega * t) * j, p, 2 * k, L)\nb.spring(p, q, 2 * k, L)\nother = b\n"
)


def test_models_with_springs_are_right(tmp_path):
    text = MODELS.replace("b = Model('building')", "first = b\nb = Model('building')")
    assert of_text(text, tmp_path).found == {"suspension": [], "building": []}


def test_notes_say_where_the_order_of_parameters_differs(tmp_path, capsys):
    path = tmp_path / "worksheet.py"
    path.write_text("from math import sin\ndef pendulum(t, y, l, g):\n"
                    "    return [y[1], -g / l * sin(y[0])]\n")  # fmt: skip
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert (
        said.startswith("pendulum: right\n") and "taken by name: l, g; asked for are g, l." in said
    )


@pytest.mark.few(2)
@pytest.mark.parametrize(("text", "sentence"), [
    ("import sys\nsys.exit(0)\n", "worksheet.py, line 2: exit ends Python here"),
    ("import os\nos._exit(0)\n", "could not be read. It ends Python."),
    ("while True:\n    pass\n", "could not be read. It took longer than 3 s."),
    ("def pendulum(t, y, g, l)\n    return 1\n", "worksheet.py, line 1: expected ':'."),
    ("\0\1", "null bytes"),
    ("def pendulm(t, y, g, l):\n    return y\n", "did you mean pendulum?"),
    ("def tower(t, y, m):\n    return y\n", "the system tower has no exercise."),
    ("x = input()\n", "worksheet.py, line 1: EOFError"),
    ("x = 1 / 0\n", "worksheet.py, line 1: ZeroDivisionError: division by zero"),
])  # fmt: skip
def test_a_worksheet_that_cannot_be_judged_is_refused(text, sentence, tmp_path, capsys):
    path = tmp_path / "worksheet.py"
    path.write_text(text)
    assert main(["check", str(path), "--limit", "3"]) == 2
    assert sentence in capsys.readouterr().err
    assert main(["check", str(tmp_path / "none.py")]) == 2


@pytest.mark.hunt
def test_what_hangs_or_ends_python_costs_the_other_answers_nothing(tmp_path, capsys):
    path = tmp_path / "worksheet.py"
    path.write_text(
        "import os, sys\nprint('pendulum: right')\n" + RIGHT +
        "def rod(t, y, mu, omega):\n    while True:\n        pass\n"
        "def drag(t, y, g, c):\n    os._exit(0)\n"
        "def tension(t, y, m, g, l):\n    sys.exit(0)\n"
        "def pendulm(t, y, g, l):\n    return y\n"
        "def helper(t):\n    return t\n"
        "sys.exit(0)\n"
    )  # fmt: skip
    assert main(["check", str(path), "--limit", "3"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "projectile: right", "rod: It took longer than 3 s.",
        "tension: It ends Python, by exit, quit or sys.exit.", "drag: It ends Python.",
        f"{path}, line 16: exit ends Python here; what follows is not read.",
        "`pendulm` answers no exercise; did you mean pendulum?",
    ]  # fmt: skip


@pytest.mark.parametrize("text", [
    "from fastdyn.course.exercises.first_half import projectile\n",
    "from fastdyn.course.exercises import first_half\n"
    "def projectile(t, y, g):\n    return first_half.projectile(t, y, g)\n",
    "def projectile(t, y, g):\n    from fastdyn.course.exercises.first_half import projectile\n"
    "    return projectile(t, y, g)\n",
    "from fastdyn.course.exercises.sheet import EXERCISES\n"
    "projectile = EXERCISES['projectile'].solution\n",
    "from fastdyn.course.exercises.sheet import EXERCISES\n"
    "def ours(*given):\n    return EXERCISES['projectile'].solution(*given)\n"
    "def projectile(t, y, g):\n    return ours(t, y, g)\n",
    "from fastdyn.systems import projectile as theirs\n"
    "def projectile(t, y, g):\n    return theirs.rhs(t, y, g)\n",
])  # fmt: skip
def test_a_reference_that_is_imported_is_no_answer(text, tmp_path):
    (tmp_path / "worksheet.py").write_text(text)
    made, _ = read(str(tmp_path / "worksheet.py"))
    exercise = EXERCISES["projectile"]
    (wrong,), _ = judged(exercise, made["projectile"], [exercise.solution])
    assert "no answer of one's own" in wrong


OWN = """
from fastdyn.course.exercises.exercise import Exercise
def fall(t, y, g):
    return [y[1], -g]
stone = Exercise("fall", "A stone falls.", {"z": "m", "v": "m/s"}, {"g": "m/s²"},
    {"z'": "m/s", "v'": "m/s²"}, {"z'": {"the velocity": lambda t, y, p: y.v},
    "v'": {"gravity": lambda t, y, p: -p.g}}, fall)
"""


@pytest.mark.parametrize(("old", "new", "sentence"), [
    ("-p.g", "p.g", "Its terms say of its solution: `v'` has the wrong sign as a whole."),
    ("-p.g", "-p.G", "The term of gravity in `v'` raises AttributeError: The exercise has no `G`."),
    ("-p.g", "None", "The term of gravity in `v'` is no finite number everywhere."),
    (", fall)", ", fall, ranges={'v': (1, 0)})", "itself. ValueError: high - low < 0."),
    ('"fall"', '"a fall"', "No function can have its name, 'a fall'."),
    ('"v\'": {', '"a": {', "It asks for z', v' and has terms of z', a."),
    (", fall)", ", fall, ranges={'x': (0, 1)})", "It has a range of x,"),
    (", fall)", ", fall, free_zero=['E'])", "The zero of E is free, which is not asked for."),
])  # fmt: skip
def test_an_exercise_that_contradicts_itself_is_refused(old, new, sentence, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(OWN)
    assert list(exercises_of(path)) == ["fall"]
    path.write_text(OWN.replace(old, new))
    with pytest.raises(ValueError, match=r"the exercise .*fall contradicts itself") as said:
        exercises_of(path)
    assert sentence in str(said.value)


def test_a_term_may_be_written_for_numbers(tmp_path):
    (path := tmp_path / "mine.py").write_text(
        "import math\n" + OWN.replace("-p.g", "-p.g if y.v > 0 else -math.sqrt(p.g**2)")
    )
    assert list(exercises_of(path)) == ["fall"]


def test_two_exercises_of_one_name_are_refused(tmp_path):
    (path := tmp_path / "mine.py").write_text(f"{OWN}\nother = stone._replace(question='')\n")
    with pytest.raises(ValueError, match="two exercises have one name of fall"):
        exercises_of(path)
