"""One table of the options: what a function refuses, proposes and documents follows from it."""

import pathlib
import re

import pytest

import fastdyn
import fastdyn.fitting
from fastdyn import analysis
from fastdyn.analysis.flow import options_of
from fastdyn.kernels.methods import METHODS
from fastdyn.matlab.options import NAMES
from fastdyn.problem.options.table import (
    ALL_OPTIONS,
    OPTIONS,
    SITUATIONS,
    defaults_of,
    exact,
    taken_by,
)
from fastdyn.problem.validate import Problem
from support.edited import run_edited

PACKAGE = pathlib.Path(fastdyn.__file__).parent
BOTH = r"(?i)tol.{0,60}1e-3.{0,30}1e-6|tol.{0,40}1e-6.{0,30}1e-9"
TYPED_IN = r'"(rtol|atol)": 1e-\d+(?! \*)|\b(rtol|RTOL) = 1e-'
ONE = r'"(rtol|RelTol)", 1e-3|"(atol|AbsTol)", 1e-6'


def test_default_tolerances_stand_in_one_file():
    found = set()
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE).as_posix()
        lines = [line for line in path.read_text().splitlines() if ">>>" not in line]
        if any(re.search(BOTH, line) or re.search(ONE, line) for line in lines):
            found.add(name)
    found = {name for name in found if not name.startswith("course/")}
    assert found == {"problem/options/table.py"}


OTHERS = {
    "energy_drift": fastdyn.energy_drift, "fit": fastdyn.fitting.fit,
    **{name: getattr(analysis, name)
       for name in ("poincare", "periodic_orbit", "frequency_response", "lyapunov", "basin",
                    "phase_portrait")},
}  # fmt: skip


def test_defaults_of_other_solvers_stand_in_the_table():
    for folder in ("analysis", "drift", "fitting"):
        for path in (PACKAGE / folder).rglob("*.py"):
            assert not re.search(TYPED_IN, path.read_text()), path
    assert {who for option in ALL_OPTIONS for who in option.of} == {*OTHERS, "systems"}
    for who, function in OTHERS.items():
        text, defaults = function.__doc__, defaults_of(who)
        assert re.search(rf"(?s)default.{{0,40}}{exact(defaults['rtol'])}", text), who
        assert "atol" not in defaults or exact(defaults["atol"]) in text, who
        assert " of " + who not in text


@pytest.mark.parametrize("who", ["poincare", "lyapunov", "basin"])
def test_an_analysis_has_its_defaults_unless_others_are_given(who):
    options = options_of(OTHERS[who], "DOP853", {"rtol": 1e-3})
    assert options == {"method": "DOP853", **defaults_of(who), "rtol": 1e-3}
    assert options["max_steps"] == 1_000_000 and options["atol"] == defaults_of(who)["atol"]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # names that moved are names, too
def test_records_are_sound():
    assert len(OPTIONS) == len(ALL_OPTIONS) > 25
    for option in ALL_OPTIONS:
        for who in option.refused:
            assert who in SITUATIONS or callable(getattr(fastdyn, who)), (option.name, who)
        assert not option.matlab or option.matlab in NAMES
        if option.check is not None:
            assert option.name in Problem._fields
            option.check(option.default)
        assert option.scipys or option.default is None or option.check is not None


def test_each_option_has_an_entry_in_the_docstring():
    text = fastdyn.solve_ivp.__doc__
    for option in ALL_OPTIONS:
        assert re.search(rf"(?m)^(\w+, )*{option.name}(, \w+)*( : .*)?\n    \S", text), option.name
    assert "**options" not in text and "{" not in text.replace('{"', "").replace("{f", "")
    for name in ("prepare", "Stepper", "solve_ensemble", "solve_phases", "solve_dae"):
        assert "{options}" not in getattr(fastdyn, name).__doc__


@pytest.mark.parametrize("name", METHODS)
def test_each_method_takes_what_its_kind_takes(name):
    method = METHODS[name]
    taken = {option.name for option in ALL_OPTIONS if option.methods(method)}
    assert ("rtol" in taken) is bool(method.error_order) is ("step" not in taken)
    assert {"max_steps", "on_event", "callback"} <= taken
    assert ("mass" in taken) is (name in ("Rodas5P", "Radau", "BDF"))
    assert ("lband" in taken) is (name == "LSODA")


def test_who_takes_what():
    assert {*taken_by("solve_ivp")} == {*OPTIONS}
    assert "callback" not in taken_by("solve_ensemble") and "rtol" in taken_by("solve_ensemble")


RECORD = """    Option(
        "shyness", "float", "Shyness of the steps.", adaptive, default=0.5, matlab="Shyness",
        refused=_not("Stepper", solve_phases="phases are bold"), words="timidity",
    ),
"""
TRIED = """
import math, pickle, warnings
import pytest
import fastdyn
import fastdyn.fitting
from fastdyn import analysis
from fastdyn import matlab, systems

def decay(t, y):
    return [-y[0]]

def residual(t, y, yp):
    return [yp[0] + y[0]]

def crossing(t, y):
    return y[0] - 0.5
crossing.terminal = True

given = decay, (0, 1), [1.0]
plain = fastdyn.solve_ivp(*given)
assert (fastdyn.solve_ivp(*given, shyness=1.0).y == plain.y).all()
with pytest.warns(UserWarning, match="no effect for a chosen solver: `shyness`"):
    fastdyn.solve_ivp(*given, "RK4", step=0.1, shyness=1.0)
for word in ("shynes", "timidity"):
    with pytest.warns(UserWarning, match="did you mean `shyness`"):
        fastdyn.solve_ivp(*given, **{word: 1.0})
    for call in (
        lambda **o: fastdyn.prepare(*given, **o),
        lambda **o: fastdyn.solve_ensemble(*given, **o),
        lambda **o: fastdyn.energy_drift(decay, t_end=1.0, **o),
        lambda **o: systems.pendulum().solve(**o),
        lambda **o: systems.pendulum().ensemble(**o),
    ):
        with pytest.raises(TypeError, match=f"takes no `{word}`; did you mean `shyness`"):
            call(**{word: 1.0})
with pytest.raises(TypeError, match="a Stepper takes no `shyness`"):
    fastdyn.Stepper(decay, 0.0, [1.0], 1.0, shyness=1.0)
phase = fastdyn.Phase(decay, crossing, lambda t, y: ("one", y))
with pytest.raises(ValueError, match="phases take no `shyness`: phases are bold"):
    fastdyn.solve_phases({"one": phase}, "one", (0, 1), [1.0], shyness=1.0)
with pytest.raises(TypeError, match="did you mean `shyness`"):
    fastdyn.solve_dae(residual, (0, 1), [1.0], [-1.0], shynes=1.0)
assert fastdyn.solve_dae(residual, (0, 1), [1.0], [-1.0], shyness=1.0).success
prepared = fastdyn.prepare(*given, shyness=1.0)
assert (pickle.loads(pickle.dumps(prepared))().y == prepared().y).all()
assert fastdyn.solve_ensemble(*given, shyness=1.0).success.all()
assert systems.pendulum().solve((0, 1), shyness=1.0).success
sol = matlab.ode45(decay, [0, 1], [1.0], matlab.odeset("shyness", 2.0))
assert sol.call.options == {"Shyness": 2.0}
assert "shyness : float\\n    Shyness of the steps.\\n" in fastdyn.solve_ivp.__doc__
assert "`shyness`" in fastdyn.solve_ensemble.__doc__ and "`shyness`" in fastdyn.solve_phases.__doc__
assert "shyness" not in fastdyn.Stepper.__doc__
print("as told")
"""


def test_a_record_more_is_an_option_more():
    before = '    Option(\n        "compile", '
    edits = {"fastdyn.problem.options.table": (before, RECORD + before)}
    assert run_edited(TRIED, edits) == "as told\n"
