"""Functions in C and in JavaScript, compiled and compared with the functions themselves."""

import math
import re

import numpy as np
import pytest

import fastdyn
from fastdyn import systems
from fastdyn.cli.main import main
from fastdyn.systems.base.export import code
from fastdyn.trace.emit.source.files import Code, Named
from fastdyn.trace.emit.source.functions import Exported, NotExported
from fastdyn.trace.emit.source.language import LANGUAGES, helpers_of
from fastdyn.trace.operations import OPERATIONS
from support import few
from support.source import COMPILED

# glibc's and V8's elementary functions are within 1 ulp of the exact value, NumPy's within 4; the
# condition of a function at a drawn point is below 1e3, and a system has hundreds of operations.
ROUNDING = 1e3 * 8 * np.finfo(float).eps
HELPED = 1e-13  # erf, erfc, gamma on the page: the figure measured over the points below is 2e-14


@pytest.fixture(params=COMPILED)
def compiled(request, tmp_path):
    """``compiled(code)``: the functions of a Code, in C or in JavaScript."""
    tool, make = COMPILED[request.param]
    if tool is None:
        pytest.skip(f"no compiler for {request.param}")
    return lambda code: make(code, tmp_path)


def exported(function, n=1, args=(), shape=None, places=None):
    places = {i: i - 1 for i in range(1, len(args) + 1)} if places is None else places
    return Exported(function, args, n, shape, places, function.__name__)


def code_of(**functions):
    found = {name: (one, f"About {name} */ alert(1) //") for name, one in functions.items()}
    return Code("mine", "Mine\n */ int x;", [Named("y")], [Named("p", "m", "a */ b")], found)


def close(found, expected, rounding=ROUNDING):
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    scale = max(1.0, float(np.nanmax(np.abs(expected), initial=0.0)))
    return np.allclose(found, expected, rounding, rounding * scale, equal_nan=True)


# -- the records


def test_each_operation_has_a_form_or_a_name_in_messages():
    leaves = [one for one in OPERATIONS.values() if one.formula is None]
    assert len(leaves) > 60
    for language in LANGUAGES.values():
        known = helpers_of(language.field)
        for one in leaves:
            written = language.form(one)
            if written is None:
                assert one.words, one.name
                continue
            called = re.findall(r"(?<![.\w])(\w+)\(", written.replace("{side}", "left"))
            in_c = {one.name, "sqrt", "fabs", "floor", "ceil", "rint", "trunc"}
            assert all(f in known or (language.field == "c" and f in in_c) for f in called), written


POINTS = [-710.3, -3.7, -2.5, -1.5, -1.0, -0.5, -0.3, -0.0, 0.0, 1e-9, 0.3, 0.5, 1.0, 1.5, 2.0, 2.5,
          4.0, 30.25, 300.5, 1e300, math.inf, -math.inf, math.nan]  # fmt: skip
ELEMENTARY = [
    one.name for one in OPERATIONS.values()
    if one.formula is None and one.value is not None and one.c is not None and not one.tables
    and not one.inner and one.name not in ("singular", "entry", "and", "or", "not", "select")
]  # fmt: skip


def test_operations_give_their_values(compiled):
    functions, calls, expected = {}, [], []
    for name in ELEMENTARY:
        operands = 2 if name in ("pow", "atan2", "fmod") or OPERATIONS[name].sign else 1
        functions[f"of_{name}"] = one = exported(lambda t, y: y[0] + y[1], n=2)
        g = one.trace.graph
        one.outputs = [g.make(name, [g.make("y", (), i) for i in range(operands)])]
        for a in POINTS:
            for b in POINTS if operands == 2 else [0.0]:
                try:  # NumPy has its own (-0.0)**0.5 and (-inf)**0.5
                    value = math.pow if name == "pow" else OPERATIONS[name].value
                    with np.errstate(all="ignore"):
                        expected.append(float(value(*np.array([a, b])[:operands])))
                except (ValueError, OverflowError):
                    continue
                calls.append((f"of_{name}", 0.0, [a, b], [], 1))
    found = compiled(code_of(**functions))(calls)
    for (name, _, y, _, _), (_, (value,)), right in zip(calls, found, expected, strict=True):
        if name[3:] in ("tgamma", "lgamma", "erf", "erfc"):
            if not all(map(math.isfinite, y)) or not math.isfinite(right):
                continue  # where Python raises
            assert math.isclose(value, right, rel_tol=HELPED, abs_tol=HELPED), (name, y)
        elif math.isnan(right) or math.isinf(right):
            assert str(value) == str(right), (name, y)
        else:
            assert math.isclose(value, right, rel_tol=8 * 2.0**-52, abs_tol=1e-300), (name, y)
            if right == 0.0:
                assert math.copysign(1.0, value) == math.copysign(1.0, right), (name, y)


def of_tables(t, y, a):
    knots, heights = np.array([0.0, 1.0, 2.5, 4.0]), np.array([1.0, -1.0, 0.5, 7.0])
    found = np.interp(y[0], knots, heights) + a * heights[int(2.0 + y[1] % 2.0)]
    return [found, np.searchsorted(knots, y[0]), np.searchsorted(knots, y[1], "right")]


def of_splines():
    from scipy.interpolate import CubicSpline

    spline = CubicSpline([0.0, 1.0, 2.5, 4.0], [1.0, -1.0, 0.5, 7.0])

    def of_a_spline(t, y):
        return [spline(y[0]), t, y[1]]

    return of_a_spline


MATRIX = np.random.default_rng(2).uniform(-1.0, 1.0, (16, 16)) + 4.0 * np.eye(16)
RIGHT = np.linspace(1.0, 2.0, 14)


def solves(t, y):
    found = np.linalg.solve(MATRIX + y[0] * t, np.array([*y, *RIGHT]))
    return [found[0], found[1], found[15]]


@pytest.mark.parametrize("function", [of_tables, of_splines(), solves])
def test_tables_and_equations_are_helped(function, compiled):
    args = (0.75,) if function is of_tables else ()
    one = exported(function, 2, args, (3,))
    calls, expected = [], []
    for t in (0.5, 1.5):
        for x in (-1.0, 0.0, 0.25, 1.0, 2.75, 4.0, 5.0):
            calls.append(("fun", t, [x, 1.0 + 0.5 * x], args, 3))
            expected.append(function(t, np.array([x, 1.0 + 0.5 * x]), *args))
    for (raised, found), right in zip(compiled(code_of(fun=one))(calls), expected, strict=True):
        assert not raised and close(found, right)


def test_where_python_raises_the_numbers_are_nan(compiled):
    def root(t, y, a):
        return [math.sqrt(y[0]) + 1.0 / a, y[1]]

    run = compiled(code_of(root=exported(root, 2, (2.0,), (2,))))
    calls = [("root", 0.0, y, [a], 2) for y, a in (([4.0, 1.0], 2.0), ([-1.0, 1.0], 2.0),
                                                     ([4.0, 1.0], 0.0))]  # fmt: skip
    (fine, found), *wrong = run(calls)
    assert not fine and found.tolist() == [2.5, 1.0]
    assert all(raised and np.isnan(found).all() for raised, found in wrong)


# -- systems


@pytest.mark.few
@pytest.mark.parametrize("name", systems.SYSTEMS)
def test_systems_and_their_jacobians(name, compiled):
    system = systems.SYSTEMS[name]()
    found, n = code(system, jacobian=True), len(system.states)
    draws = np.random.default_rng(sum(map(ord, name)))
    numbers = [one.value for one in found.parameters]
    fields = [one.name for one in found.parameters]
    calls, expected = [], []
    for _ in range(3):
        y = np.array(system.initial_state()) + draws.uniform(0.1, 0.4, n)
        p, t = np.array(numbers) * draws.uniform(0.9, 1.1, len(numbers)), draws.uniform(0.0, 2.0)
        other = type(system)(**dict(zip(fields, p.tolist(), strict=True)))
        for part in [one for one in found.functions if one[:6] in ("rhs", "event_")]:
            function = system.rhs if part == "rhs" else system.events[part[6:]]
            calls.append((part, t, y, p, n if part == "rhs" else 1))
            expected.append(np.ravel(function(t, y, *other.args)))
        calls.append(("jacobian", t, y, p, n * n))
        h = 1e-6
        rows = [
            (np.array(system.rhs(t, y + e, *other.args)) - system.rhs(t, y - e, *other.args))
            / (2 * h)
            for e in h * np.eye(n)
        ]
        expected.append(np.array(rows).T.ravel())
    answers = compiled(found)(calls)
    for call, (raised, out), right in zip(calls, answers, expected, strict=True):
        assert not raised
        # central differences: third derivatives times h^2, and rounding over h
        assert close(out, right, 1e-6 if call[0] == "jacobian" else ROUNDING), call


@pytest.mark.parametrize("name", few.hunts(["double_pendulum", "rolling_disc"], "double_pendulum"))
def test_the_mass_matrix_of_a_derived_system(name, compiled):
    pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    from fastdyn.derive.pages import page

    system = page(name).derive().system()
    found = code(system, mass=True)
    m, p = len(system.states) // 2, [one.value for one in found.parameters]
    y = np.array(system.initial_state()) + 0.25
    ((raised, mass),) = compiled(found)([("mass", 0.0, y, p, m * m)])
    kinetic = 0.5 * y[m:] @ mass.reshape(m, m) @ y[m:]
    still = np.concatenate([y[:m], np.zeros(m)])
    energy = (system.invariants | system.quantities)["energy"]
    right = energy(0.0, y, *system.args) - energy(0.0, still, *system.args)
    assert not raised and math.isclose(kinetic, right, rel_tol=1e-12)


def test_the_phases_of_the_cable(compiled):
    system = systems.cable()
    found, y = code(system), [0.3, 0.4, 1.0, -2.0]
    p = [one.value for one in found.parameters]
    names = {"flight_rhs": 4, "flight_ends": 1, "cable_rhs": 4, "cable_ends": 1}
    answers = compiled(found)([(name, 0.0, y, p, n) for name, n in names.items()])
    assert answers[0][1].tolist() == [1.0, -2.0, 0.0, 9.81]
    assert close(answers[1][1], 0.3**2 + 0.4**2 - 1.0)
    assert close(answers[2][1], system.rhs(0.0, y, *system.args))


# -- what is not exported, and the command

MINE = """
import math
import random
from scipy import special

def bessel(t, y, a):
    x = a * y[0]
    return [special.j0(x), 1.0]

def draws(t, y):
    return [-y[0] * random.random()]

def swing(t, y, g, l):
    return [y[1], -g / l * math.sin(y[0])]

def down(t, y, g, l):
    return y[0]

def mass(t, y, g, l):
    return [[l, 0.0], [0.0, 1.0]]
"""


@pytest.fixture
def export(tmp_path, monkeypatch, capsys):
    (tmp_path / "mine.py").write_text(MINE, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))

    def ask(words):
        status = main(["export", *words.split()])
        return status, *capsys.readouterr()

    return ask


def test_the_command_writes_files(export, tmp_path):
    words = "mine.py:swing --args 9.81,1.0 --events down --mass mass --jacobian"
    assert export(words)[:2] == (0, "swing.h\nswing.c\n")
    header = (tmp_path / "swing.h").read_text()
    assert "p[0]  g  9.81" in header and "p[1]  l  1.0" in header
    for part in ("rhs", "event_down", "mass", "jacobian"):
        assert f"int swing_{part}(double t, const double *y" in header
    assert export("pendulum --language js --out p.js")[:2] == (0, "p.js\n")
    assert "p[1]  l  1.0  m  length of the cable" in (tmp_path / "p.js").read_text()


def test_a_whole_number_may_decide(compiled):
    def power(t, y, i, a):
        found = a
        for _ in range(i):
            found = found * y[0]
        return [found]

    run = compiled(code_of(power=exported(power, 1, (3, 2.5), (1,))))
    calls = [("power", 0.0, [2.0], [i, 2.5], 1) for i in (0, 2, 3, 10_000)]
    *found, (raised, beyond) = run(calls)
    assert [out[0] for _, out in found] == [2.5, 10.0, 20.0]
    assert raised and np.isnan(beyond).all()


def test_solutions_with_the_transposed_matrix(compiled):
    one = exported(solves, 2, (), (3,))
    g = one.trace.graph
    solution = next(node for node in g.nodes.values() if node.op == "solution")
    other = g.make("solution", solution.args, True)
    one.outputs = [g.make("entry", (other,), i) for i in range(16)]
    ((raised, found),) = compiled(code_of(fun=one))([("fun", 0.5, [0.3, 0.7], [], 16)])
    right = np.linalg.solve((MATRIX + 0.15).T, [0.3, 0.7, *RIGHT])
    assert not raised and close(found, right)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("mine.py:bessel --args 1.5", r"`bessel`: it has no form in C, because it uses a special "
         r"function of SciPy, j0 \(.*mine.py, line 8\)"),
        ("mine.py:draws --n 1", r"it cannot be exported, because .*mine.py, line 11\)"),
        ("pendulum --mass", "The pendulum has no mass matrix"),
        ("pendulum --y0 1,2", "`--y0` belongs to FILE:FUNCTION"),
        ("pendulu", "did you mean|pendulum"),
        ("mine.py:nothing", "has no"),
    ],
)  # fmt: skip
def test_a_refusal_says_why(words, said, export):
    status, out, err = export(words)
    assert (status, out) == (2, "") and re.search(said, err), err


def test_a_language_that_is_unknown(tmp_path):
    with pytest.raises(ValueError, match="choose from c, js"):
        fastdyn.systems.pendulum().export(tmp_path / "a.f90", language="fortran")
    with pytest.raises(NotExported, match="has no mass matrix"):
        fastdyn.systems.pendulum().export(tmp_path / "a.c", mass=True)
