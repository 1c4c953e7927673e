"""Slips in the calls of fits, of analyses, and of MATLAB's functions."""

import numpy as np
import pytest

from fastdyn import Free, Record, analysis, fit, matlab
from support.slips import NUMBER, NUMBERS, fun, rows_of, said_to

RECORD = Record([0.0, 1.0], [1.0, 0.5], [1.0], (Free(1.0),), noise=0.1)
OF_FIT = {"fun": fun, "records": RECORD}
OF_RECORD = {"t": [0.0, 1.0], "values": [1.0, 0.5], "y0": [1.0]}
SOLUTION = matlab.ode45(lambda t, y: -y, [0.0, 1.0], [1.0])
ODE45 = {"odefun": fun, "tspan": [0.0, 1.0], "y0": [1.0, 0.0]}


def ode45_with_parameters(*parameters):
    return matlab.ode45(fun, [0.0, 1.0], [1.0, 0.0], None, *parameters)


ANALYSED = [
    ({"fun": None}, "`fun` must be a function of (t, y, *args), or a system; got None"),
    ({"fun": "f"}, "`fun` must be a function of (t, y, *args), or a system; got 'f'"),
]
TABLE = {
    "ode45": (matlab.ode45, ODE45, [
        ({"odefun": "f"}, "`odefun` must be a function of (t, y); got 'f'"),
        ({"odefun": lambda t, y, g: y}, "odefun(t, y): missing a required argument: 'g'. Parame"),
        ({"tspan": 10}, "`tspan` must be two or more finite times; got 10"),
        ({"tspan": "x"}, "`tspan` must be a sequence of times; got the text 'x'"),
        ({"y0": "x"}, "`y0` must be numbers"),
        ({"options": {"RelTlo": 1e-3}}, "did you mean RelTol?"),
        ({"options": {"RelTol": "x"}}, "RelTol"),
        ({"option": {}}, "did you mean `options`?"),
        ({"options": 3}, "`options` must be what `odeset(...)` returns, or a dict; got 3"),
    ]),
    "odeset": (lambda **given: matlab.odeset(*given["given"]), {}, [
        ({"given": ["RelTol"]}, "odeset takes names and values in turns; 'RelTol' has no partner"),
        ({"given": ["RelTlo", 1e-3]}, "there is no option 'RelTlo'; did you mean RelTol?"),
        ({"given": [3, 1e-3]}, "odeset takes names and values, or older options; got 3"),
        ({"given": ["RelTol", "x"]}, "RelTol must be"),
        ({"given": ["Events", lambda y: y]}, "`Events` is called as Events(t, y): too many"),
    ]),
    "odeget": (matlab.odeget, {"options": {}, "name": "RelTol"}, [
        ({"options": 3}, "`options` must be what `odeset(...)` returns, or a dict; got 3"),
        ({"name": 3}, "`name` must be a text; got 3"), ({"name": "RelTlo"}, "did you mean RelTol?"),
    ]),
    "deval": (matlab.deval, {"sol": SOLUTION, "xint": 0.5}, [
        ({"sol": [0.0, 1.0]}, "deval takes what `sol = ode45(...)` returned"),
        ({"xint": "x"}, f"`xint` {NUMBERS}the text 'x'"), ({"idx": "x"}, "`idx` must be numbers"),
        ({"xint": 3.0}, "deval knows the solution from 0 to 1; got 3.0"),
    ]),
    "odextend": (matlab.odextend, {"sol": SOLUTION, "tfinal": 2.0}, [
        ({"sol": [0.0, 1.0]}, "odextend continues what `sol = ode45(...)` returned"),
        ({"tfinal": "x"}, f"`tfinal` {NUMBER}the text 'x'"),
        ({"tfinal": 0.5}, "`tfinal` must lie beyond 1, where the solution ends"),
        ({"odefun": "f"}, "`odefun` must be a function of (t, y); got the text 'f'"),
        ({"options": 3}, "`options` must be what `odeset(...)` returns, or a dict; got 3"),
    ]),
    "fit": (fit, OF_FIT, [
        ({"records": 3}, "Record"),
        ({"records": [np.ones(99)] * 2}, "got [array([1., 1., "),
        ({"records": []}, "ecord"), ({"max_nfev": "x"}, "`max_nfev`"),
        ({"level": 95}, "`level` must be between 0 and 1"), ({"level": "x"}, "`level` must be"),
        ({"fun": None}, "`fun` must be a function of (t, y, *args), or a system; got None"),
        ({"method": "rk45"}, 'did you mean "RK45"?'),
        ({"rtol": "x"}, f"`rtol` {NUMBERS}the text 'x'"), ({"starts": "x"}, "`starts`"),
    ]),
    "Record": (Record, OF_RECORD, [
        ({"t": "x"}, "`t`"), ({"values": "x"}, "`values`"), ({"values": [1.0]}, "values"),
        ({"y0": "x"}, "`y0`"), ({"noise": "x"}, "`noise='x'` is unknown"),
    ]),
    "Free": (Free, {"start": 1.0}, [
        ({"start": "x"}, "`start`"), ({"high": "x"}, "`high`"),
        ({"min": 0}, "The call is Free(start, low, high, name, prior, log)."),
        ({"low": 2.0}, "is outside of its bounds 2.0"),
    ]),
    **{name: (getattr(analysis, name), {"fun": fun} | given, [*ANALYSED, *rows])
       for name, given, rows in (
        ("linearise", {"y": [1.0, 0.0]}, [
            ({"y": "x"}, "`y` must be numbers; got the text 'x'"),
            ({"y": [[1.0]]}, "It has shape (1, 1)"), ({"y": None}, "`y` is missing: only a system"),
            ({"rtol": 1e-6}, "The call is linearise(fun, y, args, t, inputs, outputs)."),
        ]),
        ("characteristic_roots", {"fun": lambda t, y, past: -past(t - 1.0), "y": [0.0]}, [
            ({"y": "x"}, "`y` must be numbers; got the text 'x'"), ({"y": None}, "`y` is missing"),
            ({"y": [1.0]}, "`y` is no state of rest"), ({"count": 0}, "`count` must be"),
            ({"fun": lambda t, y, past: -past(t + 1.0)}, "a delay is -1"),
            ({"rtol": 1e-6}, "The call is characteristic_roots(fun, y, args, count, t)."),
        ]),
        ("periodic_orbit", {"y0": [1.0, 0.0]}, [
            ({"y0": "x"}, "`y0` must be numbers"), ({"y0": None}, "`y0` is missing"),
            ({"t_evals": [1.0]}, "`periodic_orbit` takes no `t_evals`"),
        ]),
        ("lyapunov", {"y0": [1.0, 0.0]}, [
            ({"y0": "x"}, "`y0` must be numbers"), ({"y0": [[1.0]]}, "It has shape (1, 1)"),
            ({"tend": 10.0}, "`lyapunov` takes no `tend`; did you mean `t_end`?"),
            ({"t_eval": [1.0]}, "`t_eval` is no option here: the analysis sets it."),
        ]),
        ("frequency_response", {"frequencies": [1.0, 2.0], "y0": [1.0, 0.0], "args": (1.0,)}, [
            ({"frequencies": "x"}, f"`frequencies` {NUMBERS}the text 'x'"),
            ({"sweep": "x"}, "`sweep` must be both, up or down; got 'x'"),
            ({"reference": ["x"]}, "`reference` must be cos or sin; got ['x']"),
            ({"parameter": "omega"}, "There is no parameter 'omega'"),
            ({"transient": "x"}, f"`transient` {NUMBER}the text 'x'"),
            ({"method": 3}, "`method` must be the name of a method; got 3"),
            ({"refrence": "sin"}, "did you mean `reference`?"),
        ]),
        ("poincare", {"y0": [1.0, 0.0]}, [
            ({}, "Give a `section`, a function that is zero on it, or a `period`."),
            ({"nskipped": 9}, "`poincare` takes no `nskipped`; did you mean `n_skipped`?"),
        ]),
        ("equilibria", {"box": [(-1, 1)]}, [
            ({"box": "x"}, "`box` must have a pair (low, high) for each component; got 'x'"),
            ({"boxes": [(-1, 1)]}, "did you mean `box`?"),
            ({"t": "x"}, f"`t` {NUMBER}the text 'x'"),
            ({"guesses": "x"}, "`guesses` must be numbers; got the text 'x'"),
        ]),
        ("phase_portrait", {"box": [(-1, 1)] * 2}, [
            ({"box": (-1, 1)}, "`box` must have a pair (low, high) for each of the 2 components"),
            ({"nstarts": 9}, "`phase_portrait` takes no `nstarts`; did you mean `n_starts`?"),
        ]),
        ("basin", {"box": [(-1, 1)] * 2}, [
            ({"box": None}, "`box` must have a pair (low, high) for each of the 2 components"),
            ({"components": 0}, "`components` must be a list; got 0"), ({"n": "x"}, "`n`"),
            ({"at": "x"}, f"`at` {NUMBERS}the text 'x'"),
            ({"tol": 1e-6}, "`basin` takes no `tol`; did you mean `rtol`?"),
        ]),
    )},
}  # fmt: skip


@pytest.mark.parametrize(("call", "given", "words", "kind"), rows_of(TABLE))
def test_a_slip_is_answered(call, given, words, kind):
    assert words in said_to(call, given, kind)


def test_an_index_of_deval_beyond_the_components():
    with pytest.raises(IndexError) as found:
        matlab.deval(SOLUTION, 0.5, 1)
    assert found.value.__notes__ == ["`idx` counts components from 0 to 0; got 1."]


def test_the_bounds_of_a_free_are_shown():
    assert repr(Free(9.0, low=0, name="k")) == "Free(9.0, low=0, name='k')"


def test_a_solution_has_the_names_of_matlab():
    with pytest.raises(AttributeError, match="no `t`; it has x, y, xe"):
        SOLUTION.t  # noqa: B018


def test_parameters_behind_the_options_of_ode45():
    for parameters in ((1.0,), (1.0, 2.0)):
        with pytest.raises(TypeError) as found:
            ode45_with_parameters(*parameters)
        assert "Parameters go in by a closure: lambda t, y: odefun" in found.value.__notes__[0]
