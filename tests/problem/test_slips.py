"""Ordinary slips, each with the words that answer it: add a row for a slip that you made.

A row is what differs from a right call, and a part of the message, or of its note, or of the
warning.  Each slip is answered before anything is compiled: `fun` is never called in this file.
"""

import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn import Free, Phase, Record, analysis, matlab


class Reached(Exception):
    """Raised by a function that no slip should reach."""


def fun(t, y, *args):
    raise Reached


def hit(**attributes):
    def hit(t, y):
        raise Reached

    vars(hit).update(attributes)
    return hit


NUMBER, NUMBERS = "must be a number; got ", "must be a number, or a number for each component; got "
SPAN, FLAG = "`t_span` must be start and end; got ", "must be True or False; got "
FUNCTION = "`fun` must be a function of (t, y)"
EVENTS = "`events` must be a function of (t, y), or a sequence of functions; got "
TERMINAL = "`terminal` attribute of each event must be a boolean or positive integer; that of `hit`"
DIRECTION = "1 for rising, -1 for falling and 0 for both; that of `hit` is"
MATRIX = "must be a matrix of numbers"
OF_IVP = {"fun": fun, "t_span": (0, 1), "y0": [1.0, 0.0]}
RK4, LSODA, RADAU, BDF = [{"method": name} for name in ("RK4", "LSODA", "Radau", "BDF")]

METHOD = [
    ({"method": "rk45"}, 'did you mean "RK45"?'),
    ({"method": "Rk 45"}, 'did you mean "RK45"?'),
    ({"method": "RK54"}, 'did you mean "RK45"?'),
    ({"method": "taylor"}, 'did you mean "Taylor"?'),
    ({"method": "verlet"}, 'did you mean "VelocityVerlet"?'),
    ({"method": "leapfrog"}, 'did you mean "VelocityVerlet"?'),
    ({"method": "gauss"}, 'did you mean "Gauss4", "Gauss8" or "Gauss16"?'),
    ({"method": "ode15s"}, 'did you mean "BDF"?'),
    ({"method": "dopri5"}, 'did you mean "RK45"?'),
    ({"method": "foo"}, "one of auto, RK23, RK45"),
    ({"method": "Auto"}, 'did you mean "auto"?'),
    ({"method": 3}, "`method=3` is unknown: `method` must be one of auto,"),
    ({"method": None}, "`method=None` is unknown"),
    ({"method": ["RK45"]}, "`method=['RK45']` is unknown"),
]
ARGUMENTS = [
    ({"fun": None}, f"{FUNCTION}; got None"),
    ({"fun": "pendulum"}, f"{FUNCTION}; got the text 'pendulum'"),
    ({"fun": [0.0, 1.0]}, f"{FUNCTION} (the function itself, not what it returns); got [0.0"),
    ({"fun": np.zeros(2)}, "not what it returns); got an array of shape (2,)"),
    ({"t_span": 10}, f"{SPAN}10: (0, 10)?"),
    ({"t_span": 2.5}, f"{SPAN}2.5: (0, 2.5)?"),
    ({"t_span": None}, f"{SPAN}None."),
    ({"t_span": "01"}, f"{SPAN}the text '01'"),
    ({"t_span": ("0", "1")}, f"{SPAN}('0', '1')"),
    ({"t_span": (0, "x")}, f"{SPAN}(0, 'x')"),
    ({"t_span": (0, 1, 2)}, "times of output are `t_eval`"),
    ({"t_span": np.linspace(0, 1, 5)}, "times of output are `t_eval`"),
    ({"t_span": (0,)}, f"{SPAN}(0,)."),
    ({"t_span": np.eye(2)}, f"{SPAN}an array of shape (2, 2)"),
    ({"t_span": {0, 1}}, SPAN),
    ({"t_span": fun}, SPAN),
    ({"y0": 1.0}, "y0=[1.0]"),
    ({"y0": None}, "`y0` must be numbers; got None"),
    ({"y0": "1, 0"}, "`y0` must be numbers; got the text '1, 0'"),
    ({"y0": ["1", "0"]}, "`y0` must be numbers; got ['1', '0']"),
    ({"y0": [1.0, "x"]}, "`y0` must be numbers; got [1.0, 'x']"),
    ({"y0": [1.0, None]}, "All components of the initial state `y0` must be finite"),
    ({"y0": {"x": 1.0}}, "`y0` must be numbers; got {'x': 1.0}"),
    ({"y0": fun}, "`y0` must be numbers; got <function"),
    ({"y0": [[1.0], [0.0]]}, "It has shape (2, 1): a row or a column becomes a state by np.ravel"),
    ({"y0": [[1.0, 0.0]]}, "It has shape (1, 2): a row or a column"),
    ({"y0": np.ones((3, 2))}, "It has shape (3, 2): one solve has one state; fastdyn.solve_ensemb"),
    ({"y0": [[1.0], [2.0, 3.0]]}, "`y0` must be numbers in a row; got [[1.0]"),
    ({"t_eval": "abc"}, "`t_eval` must be a sequence of times; got the text 'abc'"),
    ({"t_eval": ["0.5"]}, "`t_eval` must be a sequence of times; got ['0.5']"),
    ({"t_eval": [None]}, "`t_eval` must be a sequence of times; got [None]"),
    ({"t_eval": [1j]}, "`t_eval` must be a sequence of times; got [1j]"),
    ({"t_eval": {0.5}}, "`t_eval` must be a sequence of times; got {0.5}"),
    ({"t_eval": 10}, "For 10 times: t_eval=np.linspace(0, 1, 10)."),
    ({"t_eval": 0.5}, "One time is t_eval=[0.5]."),
    ({"t_eval": [[0.1], [0.2]]}, "It has shape (2, 1); times in a row are np.ravel(t_eval)."),
    ({"t_eval": [0.5, 3.0]}, "`t_eval` goes from 0.5 to 3, `t_span` from 0 to 1."),
    ({"t_eval": [0.5, 0.2]}, "They must rise, each once, from 0 to 1."),
    ({"t_eval": [0.2, 0.5], "t_span": (1, 0)}, "They must fall, each once, from 1 to 0."),
    ({"dense_output": "yes"}, f"`dense_output` {FLAG}the text 'yes'"),
    ({"vectorized": "no"}, f"`vectorized` {FLAG}the text 'no'"),
    ({"args": 9.81}, "args=(9.81,)"),
    ({"args": "abc"}, "`args` must be a tuple, args=('abc',)"),
    ({"args": {"g": 9.81}}, "`args` must be a tuple, args=({'g': 9.81},)"),
]
OF_EVENTS = [
    ({"events": 3}, f"{EVENTS}3"),
    ({"events": "hit"}, f"{EVENTS}the text 'hit'"),
    ({"events": ["hit"]}, f"{EVENTS}the text 'hit'"),
    ({"events": [None]}, f"{EVENTS}None"),
    ({"events": [hit(), 0.5]}, f"{EVENTS}0.5"),
    ({"events": hit(terminal="yes")}, f"{TERMINAL} is the text 'yes'"),
    ({"events": hit(terminal=[1])}, f"{TERMINAL} is [1]"),
    ({"events": hit(terminal=1.5)}, f"{TERMINAL} is 1.5"),
    ({"events": hit(terminal=-1)}, f"{TERMINAL} is -1"),
    ({"events": hit(terminal=float("inf"))}, f"{TERMINAL} is inf"),
    ({"events": hit(direction="up")}, f"{DIRECTION} the text 'up'"),
    ({"events": hit(direction=None)}, f"{DIRECTION} None"),
    ({"events": hit(direction=[1, 2])}, f"{DIRECTION} [1, 2]"),
    ({"events": hit(direction=1j)}, f"{DIRECTION} 1j"),
    (
        {"events": hit(Terminal=True)},
        "`Terminal` of the event `hit` has no effect; did you mean",
    ),
    ({"events": hit(terminate=True)}, "did you mean `terminal`?"),
    ({"events": hit(terminals=True)}, "did you mean `terminal`?"),
    ({"events": hit(termnial=True)}, "did you mean `terminal`?"),
    ({"events": hit(isterminal=1)}, "did you mean `terminal`?"),
    ({"events": hit(stop=True)}, "did you mean `terminal`?"),
    ({"events": hit(dir=1)}, "`dir` of the event `hit` has no effect; did you mean `direction`?"),
    ({"events": hit(Direction=1)}, "did you mean `direction`?"),
    ({"events": hit(derection=1)}, "did you mean `direction`?"),
    ({"events": hit(), "on_event": "bounce"}, "`on_event` must be a function of (t, y) that"),
    ({"events": hit(), "on_event": 3}, "`on_event` must be a function of (t, y) that"),
    ({"events": hit(), "on_event": [fun, fun]}, "it has 2, and there are 1 events"),
    ({"on_event": fun}, "for each event: it has 1, and there are 0 events"),
]
OPTIONS = [
    ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"rtol": True}, f"`rtol` {NUMBERS}True"),
    ({"rtol": None}, f"`rtol` {NUMBERS}None"),
    ({"rtol": 1j}, f"`rtol` {NUMBERS}1j"),
    ({"rtol": {"x": 1.0}}, f"`rtol` {NUMBERS}{{"),
    ({"rtol": [1e-3] * 3}, "It has shape (3,), and `y0` has 2 components."),
    ({"atol": "small"}, f"`atol` {NUMBERS}the text 'small'"),
    ({"atol": ["1e-3", "1e-3"]}, f"`atol` {NUMBERS}['1e-3', '1e-3']"),
    ({"atol": [1e-3, None]}, f"`atol` {NUMBERS}[0.001, None]"),
    ({"atol": [1, 2], "y0": [0.0] * 3}, "It has shape (2,), and `y0` has 3 components."),
    ({"atol": [[1e-3], [1e-3]]}, "It has shape (2, 1), and `y0` has 2 components."),
    ({"max_step": "x"}, f"`max_step` {NUMBER}the text 'x'"),
    ({"max_step": [0.1, 0.2]}, f"`max_step` {NUMBER}[0.1, 0.2]"),
    ({"max_step": True}, f"`max_step` {NUMBER}True"),
    ({"max_step": 1j}, f"`max_step` {NUMBER}1j"),
    ({"first_step": "a"}, f"`first_step` {NUMBER}the text 'a'"),
    ({"first_step": fun}, f"`first_step` {NUMBER}<function"),
    ({"first_step": 2}, "`first_step=2` is longer than `t_span`, 1."),
    ({"jac": "3-point"} | RADAU, "`jac='3-point'` is unknown"),
    ({"jac": {}} | RADAU, f"`jac` {MATRIX}, or a function of (t, y); got {{}}"),
    ({"jac": [["a"]]} | RADAU, f"`jac` {MATRIX}, or a function of (t, y); got [['a']]"),
    ({"jac": [1.0, 2.0]} | RADAU, "have shape (2, 2), but actually has (2,)"),
    ({"jac": np.eye(3)} | BDF, "have shape (2, 2), but actually has (3, 3)"),
    ({"jac": np.eye(3)} | LSODA, "have shape (2, 2), but actually has (3, 3)"),
    ({"jac_sparsity": "band"} | RADAU, f"`jac_sparsity` {MATRIX}; got the text 'band'"),
    ({"jac_sparsity": fun} | RADAU, f"`jac_sparsity` {MATRIX}; got <function"),
    ({"jac_sparsity": [[1]]} | RADAU, "have shape (2, 2), but actually has (1, 1)"),
    ({"lband": "x"} | LSODA, f"`lband` {NUMBER}the text 'x'"),
    ({"lband": 1.5} | LSODA, "`lband` must be a whole number; got 1.5"),
    ({"uband": -1} | LSODA, "must not be negative; got (0, -1)"),
    ({"min_step": "x"} | LSODA, f"`min_step` {NUMBER}the text 'x'"),
    ({"min_step": None} | LSODA, f"`min_step` {NUMBER}None"),
    ({"mass": "unit"} | BDF, f"`mass` {MATRIX}, or a function of (t, y); got the text 'unit'"),
    ({"mass": 3.0} | BDF, "`mass` must be a matrix of 2 rows and columns"),
    ({"mass": [1.0, 2.0]} | BDF, "`mass` must be a matrix of 2 rows and columns"),
    ({"mass": np.eye(2)}, "`mass` is not for RK45"),
    ({"step": "x"} | RK4, f"`step` {NUMBER}the text 'x'"),
    ({"step": [0.1, 0.2]} | RK4, f"`step` {NUMBER}[0.1, 0.2]"),
    ({"step": -0.1} | RK4, "`step` must be positive and finite"),
    (RK4, "takes constant steps: give their size as `step`"),
    ({"at": "noon"}, "`at` must be times in rising order; got 'noon'"),
    ({"at": [2.0]}, "behind the end of the span from 0.0 to 1.0"),
    ({"at": [0.2, 0.1]}, "0.2 comes before 0.1"),
    ({"every": "day"}, "`every` must be a number; got 'day'"),
    ({"every": 0}, "`every` must be a time above zero"),
    ({"discrete": "x", "every": 0.1}, "`discrete` must be numbers; got the text 'x'"),
    ({"discrete": [1.0], "every": 0.1}, "`discrete` never changes: give `on_event`"),
    ({"breakpoints": "x"}, "`breakpoints` must be a sequence of times; got the text 'x'"),
    ({"breakpoints": ["a"]}, "`breakpoints` must be a sequence of times; got ['a']"),
    ({"breakpoints": [0.5, None]}, "`breakpoints` must be a sequence of times; got [0.5, None]"),
    ({"breakpoints": [50.0]}, "`breakpoints` have no effect: none is within `t_span`, from 0 to 1"),
    ({"breakpoints": 0.5}, "`breakpoints` must be a 1-D array of times"),
    ({"breakpoints": [[0.5]]}, "`breakpoints` must be a 1-D array of times"),
    ({"project": True}, "`project` must be a function of (t, y) that returns a state; got True"),
    ({"domain": "positive"}, "`domain` must be a function of (t, y); got 'positive'"),
    ({"nonnegative": "y"}, "`nonnegative` must be True, indices of components, or 2 bools"),
    ({"nonnegative": [7]}, "`nonnegative` must list each component once, from 0 to 1; got [7]"),
    ({"max_steps": "many"}, f"`max_steps` {NUMBER}the text 'many'"),
    ({"max_steps": True}, f"`max_steps` {NUMBER}True"),
    ({"max_steps": 0}, "`max_steps` must be at least 1; got 0"),
    ({"progress": "yes"}, f"`progress` {FLAG}the text 'yes'"),
    ({"on_interrupt": "Return"}, 'did you mean "return"?'),
    ({"on_interrupt": "stop"}, "choose from raise, return"),
    ({"callback": "print"}, "`callback` must be a function of the solver; got 'print'"),
    ({"checkpoint": 3}, "`checkpoint` must be the path of a file; got 3"),
    ({"checkpoint": True}, "`checkpoint` must be the path of a file; got True"),
    ({"sensitivity": "Y0"}, "`sensitivity='Y0'` is unknown; choose from 'y0', 'args'"),
    ({"sensitivity": 3}, "`sensitivity=3` is unknown"),
    ({"adjoint": "p"}, "`adjoint='p'` is unknown; choose from 'y0', 'args'"),
    ({"error_estimate": "x"}, f"`error_estimate` {FLAG}the text 'x'"),
    ({"compile": "inline"}, 'did you mean "inlined"?'),
    ({"compile": "Shared"}, 'did you mean "shared"?'),
    ({"compile": True}, "choose from auto, shared, inlined"),
    ({"Rtol": 1e-6}, "`Rtol`: did you mean `rtol`?"),
    ({"tol": 1e-6}, "`tol`: did you mean `rtol`?"),
    ({"maxstep": 0.1}, "`maxstep`: did you mean `max_step`?"),
    ({"dt": 0.1}, "`dt`: did you mean `step`?"),
]
STEPS = [row for row in OPTIONS if {*row[0]} <= {"rtol", "atol", "max_step", "first_step"}]
STATES = [row for row in ARGUMENTS if {*row[0]} == {"y0"}]
SPANS = [row for row in ARGUMENTS if {*row[0]} == {"t_span"}]
FUNCTIONS = [row for row in ARGUMENTS if {*row[0]} == {"fun"}]
OF_STEPPER = {"fun": fun, "t0": 0.0, "y0": [1.0, 0.0], "t_bound": 1.0}
ENSEMBLE = [
    *FUNCTIONS,
    *SPANS,
    ({"method": "rk45"}, 'did you mean "RK45"?'),
    ({"method": "auto"}, '`method="auto"` is for solve_ivp and for `solve` of a system'),
    ({"y0": np.ones((2, 2, 2))}, "`y0` must have shape (n,) or (M, n); got (2, 2, 2)"),
    ({"y0": [["a", "b"]]}, "`y0` must be numbers"),
    ({"args": ([1.0, 2.0],), "y0": np.ones((3, 2))}, "`args[0]` has 2, `y0` has 3"),
    ({"reduce": "finals"}, "`reduce='finals'` is unknown"),
    ({"simd": "yes"}, "`simd='yes'` is unknown"),
    ({"rtoll": 1e-6}, "did you mean `rtol`?"),
    ({"dense_output": True}, "an ensemble takes no `dense_output`"),
    ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"t_eval": "abc"}, "`t_eval` must be a sequence of times; got the text 'abc'"),
]
PHASES = {"up": Phase(fun, hit(terminal=True), fun)}
OF_PHASES = {"phases": PHASES, "first": "up", "t_span": (0, 1), "y0": [1.0, 0.0]}
OF_DAE = {
    "F": lambda t, y, yp: [yp[0] + y[0], yp[1]], "t_span": (0, 1), "y0": [0.0, 1.0],
    "yp0": [0.0, 0.0],
}  # fmt: skip
RECORD = Record([0.0, 1.0], [1.0, 0.5], [1.0], (Free(1.0),), noise=0.1)
OF_FIT = {"fun": fun, "records": RECORD}
OF_RECORD = {"t": [0.0, 1.0], "values": [1.0, 0.5], "y0": [1.0]}
DRIFT = {"system": fun, "y0": [1.0, 0.0], "t_end": 1.0, "invariants": {"energy": fun}, "step": 0.1}
ODE45 = {"odefun": fun, "tspan": [0.0, 1.0], "y0": [1.0, 0.0]}


def drift_like_ivp(method):
    return fastdyn.energy_drift(fun, (0, 1), [1.0, 0.0], method=method)


def ode45_with_parameters(*parameters):
    return matlab.ode45(fun, [0.0, 1.0], [1.0, 0.0], None, *parameters)


ANALYSED = [
    ({"fun": None}, "`fun` must be a function of (t, y, *args), or a system; got None"),
    ({"fun": "f"}, "`fun` must be a function of (t, y, *args), or a system; got 'f'"),
]
NO_ARGUMENTS = {"METHODS", "__version__", "analysis", "systems", "OdeResult", "OdeSolution", "Fit"}
ELSEWHERE = {"constrained", "Phase"}  # runs inside `fun`; among the slips of `solve_phases`
TABLE = {
    "solve_ivp": (fastdyn.solve_ivp, OF_IVP, [*METHOD, *ARGUMENTS, *OF_EVENTS, *OPTIONS]),
    "prepare": (fastdyn.prepare, OF_IVP, [
        *FUNCTIONS, *SPANS, *STATES, *STEPS,
        ({"method": "auto"}, '`method="auto"` is for solve_ivp'),
        ({"rtoll": 1e-6}, "did you mean `rtol`?"),
        ({"progress": True}, "a prepared solver takes no `progress`"),
    ]),
    "Stepper": (fastdyn.Stepper, OF_STEPPER, [
        *FUNCTIONS, *STATES, *STEPS,
        ({"t0": "0"}, "`t_span` must be start and end; got ('0', 1.0)"),
        ({"method": "verlet"}, 'did you mean "VelocityVerlet"?'),
        ({"vectorized": 0.1}, "in the fifth place"),
    ]),
    "solve_ensemble": (fastdyn.solve_ensemble, OF_IVP, ENSEMBLE),
    "solve_phases": (fastdyn.solve_phases, OF_PHASES, [
        *SPANS, *STATES, *STEPS,
        ({"phases": [PHASES["up"]]}, "`phases` must be a dict of names and Phases; got [Phase("),
        ({"phases": {"up": fun}}, "phase 'up' must be a Phase; got <function"),
        ({"phases": {"up": Phase("f", hit(terminal=True), fun)}}, "`fun of phase 'up'` must be"),
        ({"phases": {"up": Phase(fun, hit(), fun)}}, "the event of phase 'up' must be terminal"),
        ({"first": "down"}, "there is no phase 'down'; there are 'up'"),
        ({"max_phases": "many"}, f"`max_phases` {NUMBER}the text 'many'"),
        ({"max_phases": 0}, "`max_phases` must be at least 1; got 0"),
    ]),
    "solve_dae": (fastdyn.solve_dae, OF_DAE, [
        *SPANS,
        ({"F": None}, "`F` must be a function of (t, y, yp); got None"),
        ({"y0": "1"}, "`y0` must be numbers"),
        ({"y0": [1.0]}, "`yp0` must have one number for each of `y0`: it has 2, and `y0` 1"),
        ({"yp0": [[0.0, 0.0]]}, "`yp0` must be 1-dimensional"),
        ({"method": "Euler"}, "`method='Euler'` is unknown"),
        ({"given": "z"}, "`given"),
        ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ]),
    "energy_drift": (fastdyn.energy_drift, DRIFT, [
        ({"system": None}, "`system` must be a function of (t, y); got None"),
        ({"method": "gauss16"}, 'did you mean "Gauss16"?'),
        ({"method": "auto"}, '`method="auto"` is for solve_ivp'),
        ({"step": "x"}, f"`step` {NUMBER}the text 'x'"),
        ({"t_end": "x"}, f"`t_end` {NUMBER}the text 'x'"),
        ({"samples": "x"}, f"`samples` {NUMBER}the text 'x'"),
        ({"n_steps": 10}, "give one of `n_steps`, `t_end` and `periods`"),
        ({"invariants": None}, "there are no `invariants` to follow"),
        ({"invariants": fun}, "`invariants` must be a dict of names and functions"),
    ]),
    "energy_drift as solve_ivp": (drift_like_ivp, {}, [
        ({"method": "RK45"}, "The state of a function is `y0=`, the end `t_end=`"),
    ]),
    "ode45": (matlab.ode45, ODE45, [
        ({"odefun": "f"}, "`odefun` must be a function of (t, y); got 'f'"),
        ({"tspan": 10}, "`tspan` must be two or more finite times; got 10"),
        ({"tspan": "x"}, "`tspan` must be a sequence of times; got the text 'x'"),
        ({"y0": "x"}, "`y0` must be numbers"),
        ({"options": {"RelTlo": 1e-3}}, "did you mean RelTol?"),
        ({"options": {"RelTol": "x"}}, "RelTol"),
        ({"option": {}}, "did you mean `options`?"),
    ]),
    "at": (fastdyn.at, {}, [
        ({"times": 3}, "`at` must be"), ({"times": [0.2, 0.1]}, "0.2 comes before 0.1"),
        ({"times": ["a"]}, "`at` must be times"), ({"times": [np.nan]}, "must be finite"),
    ]),
    "every": (fastdyn.every, {"period": 0.1}, [
        ({"period": "x"}, "`every` must be a number"), ({"period": -1}, "a time above zero"),
        ({"start": "x"}, "`start` must be a number"), ({"period": [0.1]}, "must be a number"),
    ]),
    "fit": (fastdyn.fit, OF_FIT, [
        ({"records": 3}, "Record"), ({"records": []}, "ecord"), ({"max_nfev": "x"}, "`max_nfev`"),
        ({"level": 95}, "`level` must be between 0 and 1"), ({"level": "x"}, "`level` must be"),
        ({"fun": None}, "`fun` must be a function of (t, y, *args); got None"),
        ({"method": "rk45"}, 'did you mean "RK45"?'),
        ({"rtol": "x"}, f"`rtol` {NUMBERS}the text 'x'"), ({"starts": "x"}, "`starts`"),
    ]),
    "Record": (Record, OF_RECORD, [
        ({"t": "x"}, "`t`"), ({"values": "x"}, "`values`"), ({"values": [1.0]}, "values"),
        ({"y0": "x"}, "`y0`"), ({"noise": "x"}, "`noise='x'` is unknown"),
    ]),
    "Free": (Free, {"start": 1.0}, [
        ({"start": "x"}, "`start`"), ({"high": "x"}, "`high`"),
        ({"low": 2.0}, "is outside of its bounds 2.0"),
    ]),
    **{name: (getattr(analysis, name), {"fun": fun} | given, [*ANALYSED, *rows])
       for name, given, rows in (
        ("linearise", {"y": [1.0, 0.0]}, [
            ({"y": "x"}, "`y` must be numbers; got the text 'x'"),
            ({"y": [[1.0]]}, "It has shape (1, 1)"), ({"y": None}, "`y` is missing: only a system"),
            ({"rtol": 1e-6}, "The call is linearise(fun, y, args, t)."),
        ]),
        ("periodic_orbit", {"y0": [1.0, 0.0]}, [
            ({"y0": "x"}, "`y0` must be numbers"), ({"y0": None}, "`y0` is missing"),
        ]),
        ("lyapunov", {"y0": [1.0, 0.0]}, [
            ({"y0": "x"}, "`y0` must be numbers"), ({"y0": [[1.0]]}, "It has shape (1, 1)"),
        ]),
        ("poincare", {"y0": [1.0, 0.0]}, [
            ({}, "Give a `section`, a function that is zero on it, or a `period`."),
        ]),
        ("equilibria", {"box": [(-1, 1)]}, [
            ({"box": "x"}, "`box` must have a pair (low, high) for each component; got 'x'"),
            ({"boxes": [(-1, 1)]}, "did you mean `box`?"),
        ]),
        ("phase_portrait", {"box": [(-1, 1)] * 2}, [
            ({"box": (-1, 1)}, "`box` must have a pair (low, high) for each of the 2 components"),
        ]),
        ("basin", {"box": [(-1, 1)] * 2}, [
            ({"box": None}, "`box` must have a pair (low, high) for each of the 2 components"),
        ]),
    )},
}  # fmt: skip


def said_to(call, given):
    """The message of the exception with its notes, or the warnings if the call went through."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            call(**given)
        except Reached:
            return "\n".join(str(one.message) for one in heard)
        except (TypeError, ValueError, OverflowError) as error:
            return "\n".join([str(error), *getattr(error, "__notes__", ())])
    return "nothing"


ROWS = [
    pytest.param(call, base | given, words, id=f"{name} {' '.join(given)} {i}")
    for name, (call, base, rows) in TABLE.items()
    for i, (given, words) in enumerate(rows)
]


@pytest.mark.parametrize(("call", "given", "words"), ROWS)
def test_a_slip_is_answered(call, given, words):
    assert words in said_to(call, given)


def test_parameters_behind_the_options_of_ode45():
    for parameters in ((1.0,), (1.0, 2.0)):
        with pytest.raises(TypeError) as found:
            ode45_with_parameters(*parameters)
        assert "Parameters go in by a closure: lambda t, y: odefun" in found.value.__notes__[0]


def test_each_public_function_is_in_the_table():
    public = {
        name
        for name in {*fastdyn.__all__} - NO_ARGUMENTS - ELSEWHERE
        if not (isinstance(one := getattr(fastdyn, name), type) and issubclass(one, Exception))
    }
    assert public <= TABLE.keys() and "solve_ivp" in public
