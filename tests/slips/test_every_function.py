"""Each argument of each public function is refused, by its name, if it is of another kind."""

import inspect
import warnings

import pytest
from slips import (
    test_doors,
    test_fits_and_analyses,
    test_other_solvers,
    test_pictures_and_models,
    test_solve_ivp,
)

import fastdyn
from fastdyn import analysis, dae, drift, ensemble, matlab, plot, solve
from support.slips import Reached

FILES = (
    test_solve_ivp, test_other_solvers, test_fits_and_analyses, test_pictures_and_models,
    test_doors,
)  # fmt: skip
TABLE = {name: entry for file in FILES for name, entry in file.TABLE.items()}
RESULTS = {"Fit", "OdeResult", "OdeSolution", "Solution", "Reduction", "Trajectories", "Drift"}
RESULTS |= {"BoundarySolution"}
OF_MATLAB = {"ode15s", "ode23", "ode23s", "ode23t", "ode23tb", "ode78", "ode89", "ode113"}
OF_MATLAB |= {"bvp4c", "bvp5c", "bvpinit", "dde23", "ddesd", "ode15i", "odeplot"}
OF_SCIPY = {"odeint", "ode", "complex_ode"}  # whose own sentences these have, and its own tests
ELSEWHERE = {  # what has its slips where it is taken
    "Phase": "solve_phases", "Fold": "solve_ensemble", "Shared": "solve_ensemble",
    "invariants": "plot", "legend": "plot", "own_legend": "plot", "plane": "plot", "slides": "plot",
    "pictures_and_panels": "plot", "continuation": "periodic_orbit",
}  # fmt: skip


def functions_of(module):
    """The public functions, and classes that a user makes, of a module."""
    found = {name: getattr(module, name) for name in module.__all__}
    return {
        name for name, one in found.items()
        if callable(one) and not (isinstance(one, type) and issubclass(one, Exception))
    }  # fmt: skip


PUBLIC = set.union(*map(functions_of, (fastdyn, matlab, solve, plot, drift, dae, ensemble)))
PUBLIC |= {name for name in functions_of(analysis) if name[0].islower()}
# Those of MATLAB have the checks of ode45, and of the solvers that they call.
PUBLIC -= RESULTS | OF_MATLAB | OF_SCIPY | {"Study"}


def test_each_public_function_has_rows():
    assert {ELSEWHERE.get(name, name) for name in PUBLIC} - TABLE.keys() == set()
    assert len(PUBLIC) > 40 and sum(len(rows) for *_, rows in TABLE.values()) > 500


WRONG = {"text": "zzz", "None": None, "object": object(), "table": [[["x"]]]}
SAID = {  # (function, argument): what the sentence has instead of the name
    ("Stepper", "vectorized"): "in the fifth place", ("at", "times"): "`at`",
    ("every", "period"): "`every`", ("solve_phases", "first"): "there is no phase",
    ("frequency_response", "parameter"): "no parameter", ("deval", "sol"): "deval takes",
    ("odextend", "sol"): "odextend continues", ("compare_drift", "methods"): "`method",
    ("solve_separable", "force"): "`velocity` and `force`",
    ("solve_linear", "a"): "a matrix is a tuple", ("solve_linear", "b"): "a matrix is a tuple",
    **{("constrained", name): "a matrix is a tuple" for name in ("mass", "a", "force", "b")},
}  # fmt: skip
FLAGS = {"dense_output", "vectorized", "progress", "differences", "rounding", "log"}  # None is one
TAKEN = {  # a value of the kind; and what is told of in other words
    ("Free", "name", "text"), ("Record", "name", "text"), ("plot", "label", "text"),
    ("Stepper", "vectorized", "text"),
    ("energy_drift", "checkpoint", "text"), ("compare_drift", "checkpoint", "text"),
    ("poincare", "section", "text"), ("odeget", "name", "text"), ("odeget", "options", "None"),
    ("solve_ensemble", "store", "text"), ("lyapunov", "method", "text"),
    ("frequency_response", "method", "text"), ("periodic_orbit", "method", "text"),
    *{("linearise", name, kind) for name in ("inputs", "outputs") for kind in WRONG},
}  # fmt: skip
HEAVY = {"basin", "odeset", "save"}  # a value that is taken takes seconds; rows of other forms
ANYTHING = {("odeget", "default"), ("column", "sharex"), ("compare_drift", "progress")}


def wrong_values(name):
    """(argument, kind, value) of all arguments of a function."""
    for one in inspect.signature(TABLE[name][0]).parameters.values():
        if one.kind in (one.VAR_KEYWORD, one.VAR_POSITIONAL) or (name, one.name) in ANYTHING:
            continue
        for kind, value in WRONG.items():
            default = value is None and (one.default is None or one.name in FLAGS)
            taken = (name, one.name, kind) in TAKEN
            taken |= one.name == "args" and kind in ("None", "table")  # no, or one, argument
            if not (default or taken):
                yield one.name, kind, value


def said_with(call, given):
    """The message of the exception, or of the first warning, and its notes."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            call(**given)
        except Reached:
            pass
        except (TypeError, ValueError, UserWarning) as error:
            return "\n".join([str(error), *getattr(error, "__notes__", ())])
    return ""


@pytest.mark.parametrize("name", sorted(PUBLIC & TABLE.keys() - HEAVY))
def test_another_kind_is_refused_by_the_name_of_the_argument(name):
    call, given, _ = TABLE[name]
    unsaid = [
        (argument, kind, said)
        for argument, kind, value in wrong_values(name)
        for said in [said_with(call, given | {argument: value})]
        if SAID.get((name, argument), f"`{argument}") not in said
    ]
    assert unsaid == []
