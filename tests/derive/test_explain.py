"""The nine steps: complete, right, and readable by what shows them."""

import re

import pytest
import sympy as sp
from matplotlib.mathtext import MathTextParser

from fastdyn.derive.explain import HEADINGS
from fastdyn.derive.pages import page

SHORT = ("pendulum", "pendulum_xy", "rod", "vehicle", "double_pendulum", "four_bar")


def explanation(name, law="derive"):
    return getattr(page(name), law)().explain()


@pytest.fixture(scope="module")
def pendulum():
    return explanation("pendulum_xy")


def test_text_has_nine_steps_and_the_lecturers_formulas(pendulum):
    text = str(pendulum)
    assert [line[3:] for line in text.splitlines() if re.match(r"\d\. ", line)] == list(HEADINGS)
    for formula in (
        "x i + y j",
        "x'' i + y'' j",
        "m x'' = -R x/l",
        "m y'' = -R y/l + g m",
        "x x''/l + y y''/l = -(x'² + y'²)/l",
        "x' = V0",
        "w' = [x', y', x'', y'']",
    ):
        assert formula in text, formula


def test_lagrange_explains_its_energies():
    text = str(explanation("pendulum", "lagrange"))
    assert "kinetic energy:  l² m theta'²/2" in text
    assert "potential energy:  -g l m cos(theta)" in text
    assert "theta'' = -g sin(theta)/l" in text and "R = " not in text


@pytest.mark.few(1)
@pytest.mark.parametrize("name", SHORT)
def test_formulas_are_latex(name):
    """Matplotlib reads what TeX and MathJax read."""
    found = re.findall(r"\\\[(.*?)\\\]", explanation(name).latex())
    assert len(found) > 10
    for formula in found:
        MathTextParser("agg").parse(f"${formula}$")


def test_notebooks_show_it(pendulum):
    assert pendulum._repr_html_().count("<li>") == len(HEADINGS)
    assert (
        r'<span class="math">\(\displaystyle m \ddot{x} = - \frac{R x}{l}\)</span>'
        in pendulum._repr_html_()
    )
    assert r"\[m \ddot{x} = - \frac{R x}{l}\]" in pendulum._repr_latex_()
    assert r"\dot{\alpha}" in explanation("vehicle").latex()
    angles = explanation("double_pendulum").latex()
    assert r"\ddot{\theta}_{1}" in angles and "th" not in re.sub(r"\\\w+", "", angles).split()


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SHORT)
def test_what_it_says_of_the_solution_is_what_is_solved(name):
    """The formulas of the last step satisfy the equations of the steps before."""
    derivation = page(name).derive()
    assert sum(len(step.unknowns) for step in derivation.steps) == len(derivation.unknowns)
    known, numbers = {}, {}
    for n, symbol in enumerate(
        sorted(derivation.r.free_symbols | derivation.K.free_symbols, key=str)
    ):
        numbers[symbol] = sp.Float(f"0.{31 + 7 * n % 60}", 30)
    for step in derivation.steps:
        if len(step.unknowns) == len(step.needs) == 1:
            known[step.unknown] = step.value.xreplace(known).xreplace(numbers).evalf(30)
        else:
            matrix, right = (
                part.xreplace(known).xreplace(numbers).evalf(30)
                for part in (step.matrix, step.right)
            )
            known |= dict(zip(step.unknowns, matrix.LUsolve(right), strict=True))
    for equation in derivation.residuals():
        terms = sp.Add.make_args(equation.xreplace(known).xreplace(numbers).evalf(30))
        assert abs(sum(terms)) < sp.Float("1e-20")


@pytest.mark.parametrize(
    ("name", "found", "given"),
    [
        ("chaplygin_sleigh", "y'", ("x = 0", "y = 0", "th = 0")),
        ("rolling_disc", "x', y'", ("yaw = 0", "spin = 0")),
        ("vehicle", "x', y', th'", ("x = 0", "y = 0", "th = 0")),
        ("pendulum_xy", "x, y'", ()),
    ],
)
def test_what_no_constraint_holds_is_not_found_from_the_constraints(name, found, given):
    """A blade holds a velocity; its place is free, and is given as 0."""
    lines = str(explanation(name)).splitlines()
    start = [line.strip() for line in lines[lines.index("8. Initial conditions") :]]
    assert f"found from the constraints: {found}" in start
    assert all(line in start for line in given)


def test_friction_has_its_law_of_rest():
    text = str(explanation("rod"))
    assert "friction_N is (mu) |N| against the slip; at rest it is what holds the body" in text
    assert "at most (mu) |N|" in text


def test_the_force_of_a_contact_is_no_newton():
    from fastdyn.derive.picture.figure import _words

    assert _words("friction_N") == "friction, contact N" and _words("R_x") == "R x"
