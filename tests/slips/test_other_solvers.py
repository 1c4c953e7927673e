"""Slips in the calls of the solvers beside solve_ivp."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn import Phase, dae, drift, solve, systems
from fastdyn.ensemble import Fold
from fastdyn.planets import Planets, outer_planets
from support.slips import (
    FUNCTIONS,
    NUMBER,
    NUMBERS,
    SPANS,
    STATES,
    STEPS,
    fun,
    hit,
    of_kind,
    rows_of,
    said_to,
)  # fmt: skip

IVP = {"fun": fun, "t_span": (0, 1), "y0": [1.0, 0.0]}
OF_BVP = {"fun": fun, "bc": fun, "x": [0.0, 0.5, 1.0], "y": np.zeros((2, 3))}
OF_DDE = {"fun": lambda t, y, past: [-past(t - 1)[0]], "t_span": (0, 1), "history": [1.0]}
OF_SDE = {
    "drift": lambda t, y: -y, "diffusion": 0.1, "t_span": (0, 1), "y0": [1.0, 0.0], "step": 0.1,
}  # fmt: skip
OF_LANGEVIN = {
    "accel": lambda t, q: -q, "t_span": (0, 1), "q0": [1.0], "v0": [0.0], "friction": 1.0,
    "sigma": 0.1, "step": 0.1,
}  # fmt: skip
OF_STEPPER = {"fun": fun, "t0": 0.0, "y0": [1.0, 0.0], "t_bound": 1.0}
ENSEMBLE = [
    *FUNCTIONS,
    *SPANS,
    ({"method": "rk45"}, 'did you mean "RK45"?'),
    ({"method": "auto"}, '`method="auto"` is for solve_ivp and for `solve` of a system'),
    ({"y0": np.ones((2, 2, 2))}, "`y0` must have shape (n,) or (M, n); got (2, 2, 2)"),
    ({"y0": [["a", "b"]]}, "`y0` must be numbers"),
    ({"args": ([1.0, 2.0],), "y0": np.ones((3, 2))}, "`args[0]` has 2, `y0` has 3"),
    ({"reduce": "finals"}, "`reduce='finals'` is unknown; did you mean \"final\"?"),
    ({"reduce": "variance"}, "`reduce='variance'` is unknown; choose from max, max_time"),
    ({"reduce": 3}, "`reduce` must be a list; got 3"),
    ({"reduce": Fold("f")}, "`function of a Fold` must be a function of (value, t, y); got the te"),
    ({"reduce": Fold(fun, "x")}, f"`start of a Fold` {NUMBER}the text 'x'"),
    ({"threads": "x"}, f"`threads` {NUMBER}the text 'x'"),
    ({"threads": 1.5}, "`threads` must be a whole number; got 1.5"),
    ({"reduce": Fold(lambda t, y: 0)}, "`fold` is called as fold(value, t, y): too many pos"),
    ({"reduce": Fold(lambda v, t, y: y)}, "a Fold returned an array of shape (2,)"),
    ({"block": "x"}, f"`block` {NUMBER}the text 'x'"),
    ({"progress": "x"}, "`progress` must be True or False; got the text 'x'"),
    ({"simd": "yes"}, "`simd='yes'` is unknown"),
    ({"rtoll": 1e-6}, "did you mean `rtol`?"),
    ({"dense_output": True}, "an ensemble takes no `dense_output`"),
    ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"t_eval": "abc"}, "`t_eval` must be a sequence of times; got the text 'abc'"),
    ({"teval": [0.1]}, "an ensemble takes no `teval`; did you mean `t_eval`?"),
    ({"params": (1.0,)}, "an ensemble takes no `params`; did you mean `args`?"),
    ({"rtol": -1}, "`rtol` must not be negative"), ({"atol": -1}, "`atol` must be positive"),
    ({"rtol": np.nan}, "`rtol` must not be NaN"), ({"step": 0.1}, "RK45 chooses its steps"),
]  # fmt: skip
PHASES = {"up": Phase(fun, hit(terminal=True), fun)}
OF_PHASES = {"phases": PHASES, "first": "up", "t_span": (0, 1), "y0": [1.0, 0.0]}
OF_DAE = {
    "F": lambda t, y, yp: [yp[0] + y[0], yp[1]], "t_span": (0, 1), "y0": [0.0, 1.0],
    "yp0": [0.0, 0.0],
}  # fmt: skip
TRANSPOSED = {"y0": np.ones((2, 5)), "yp0": None}
OF_DAES = [
    *SPANS,
    ({"F": None}, "`F` must be a function of (t, y, yp); got None"),
    ({"y0": "1"}, "`y0` must be numbers"),
    ({"y0": [1.0]}, "`yp0` must have one number for each of `y0`: it has 2, and `y0` 1"),
    ({"y0": np.ones((2, 2, 2))}, "`y0` must have shape (n,) or (M, n); got (2, 2, 2)"),
    ({"y0": np.ones((0, 2)), "yp0": None}, "`y0` has no rows"),
    ({"y0": np.ones((3, 2)), "yp0": np.ones((4, 2))}, "rows of 3 trajectories, and `yp0` of 4"),
    ({"y0": [1j, 0.0]}, "`y0` is complex"),
    (TRANSPOSED, "`y0` has shape (2, 5), and F fits its columns: a row is a trajectory"),
    ({"y0": np.full((3, 2), np.nan), "yp0": None}, "All components of `y0` must be finite"),
    ({"args": ([1.0, 2.0],), "y0": np.ones((3, 2))}, "`args[0]` has 2, `y0` has 3"),
    ({"args": (np.ones((2, 2)),)}, "`args[0]` must be a number or a 1-D array of numbers"),
    ({"method": "Euler"}, "`method='Euler'` is unknown"),
    ({"given": "z"}, "`given"),
    ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ({"rtoll": 1e-3}, "`solve_dae_ensemble` has no option `rtoll`"),
    ({"on_event": fun}, "no `on_event`: a state behind a jump is computed in Python"),
    ({"sensitivity": "y0"}, "no `sensitivity`: `solve_dae`, trajectory by trajectory, has it"),
    ({"events": fastdyn.at([0.5])}, "has no schedules: `solve_dae`, trajectory by trajectory"),
    ({"store": "x"}, "an ensemble of DAEs takes no `store`"),
    ({"simd": "yes"}, "`simd='yes'` is unknown"),
    ({"simd": True}, "`simd=True`: equations F(t, y, y') = 0 have no form for vectors"),
    ({"threads": "x"}, f"`threads` {NUMBER}the text 'x'"),
    ({"reduce": "finals"}, "`reduce='finals'` is unknown; did you mean \"final\"?"),
    ({"reduce": "mean"}, "give F a further component with the equation of its integral"),
    ({"reduce": "max", "method": "DOP853"}, "is for equations of index 0 and 1"),
]
OF_SECOND = {"accel": fun, "t_span": (0, 1), "q0": [1.0], "v0": [0.0], "step": 0.1}
OF_SEPARABLE = {
    "velocity": fun, "force": fun, "t_span": (0, 1), "q0": [1.0], "p0": [0.0], "step": 0.1,
}  # fmt: skip
OF_CONSTRAINED = {"mass": (1.0,), "a": ((1.0,),), "force": (1.0,), "b": (0.0,)}
OF_PLANETS = {
    "masses": [1.0, 0.1], "q0": [[0, 0, 0], [1, 0, 0]], "v0": [[0, 0, 0], [0, 1, 0]], "G": 1.0,
}  # fmt: skip
NO_NUMBERS = "text", None, {1.0: 2.0}
OF_RUN = {"t_span": (0, 1), "step": 0.1}
OF_COMPARISON = {"system": systems.pendulum(), "methods": ["RK4"], "evaluations": 10}
DRIFT = {"system": fun, "y0": [1.0, 0.0], "t_end": 1.0, "invariants": {"energy": fun}, "step": 0.1}


def drift_like_ivp(method):
    return fastdyn.energy_drift(fun, (0, 1), [1.0, 0.0], method=method)


TABLE = {
    "prepare": (fastdyn.prepare, IVP, [
        *FUNCTIONS, *SPANS, *STATES, *STEPS,
        ({"method": "auto"}, '`method="auto"` is for solve_ivp'),
        ({"rtoll": 1e-6}, "did you mean `rtol`?"),
        ({"progress": True}, "a prepared solver takes no `progress`"),
        ({"teval": [0.1]}, "a prepared solver takes no `teval`; did you mean `t_eval`?"),
        ({"step": 0.1}, "RK45 chooses its steps"),
    ]),
    "Stepper": (fastdyn.Stepper, OF_STEPPER, [
        *FUNCTIONS, *STATES, *STEPS,
        ({"t0": "0"}, f"`t0` {NUMBER}the text '0'"),
        ({"t_bound": None}, f"`t_bound` {NUMBER}None"),
        ({"method": "verlet"}, 'did you mean "VelocityVerlet"?'),
        ({"vectorized": 0.1}, "in the fifth place"), ({"step": 0.1}, "RK45 chooses its steps"),
        ({"atols": 1e-6}, "`atols`: did you mean `atol`?"),
        ({"t_eval": [1.0]}, "no effect for a chosen solver: `t_eval`."),
    ]),
    "solve_ensemble": (fastdyn.solve_ensemble, IVP, ENSEMBLE),
    "solve_phases": (fastdyn.solve_phases, OF_PHASES, [
        *SPANS, *STATES, *STEPS,
        ({"phases": [PHASES["up"]]}, "`phases` must be a dict of names and Phases; got [Phase("),
        ({"phases": {"up": fun}}, "phase 'up' must be a Phase; got <function"),
        ({"phases": {"up": Phase("f", hit(terminal=True), fun)}}, "`fun of phase 'up'` must be"),
        ({"phases": {"up": Phase(fun, hit(), "b")}}, "`after of phase 'up'` must be a function"),
        ({"phases": {"up": Phase(fun, hit(), fun)}}, "the event of phase 'up' must be terminal"),
        ({"first": "down"}, "there is no phase 'down'; there are 'up'"),
        ({"first": "Up"}, "there is no phase 'Up'; did you mean 'up'?"),
        ({"first": ["up"]}, "there is no phase ['up']; there are 'up'"),
        ({"max_phases": "many"}, f"`max_phases` {NUMBER}the text 'many'"),
        ({"max_phases": 0}, "`max_phases` must be at least 1; got 0"),
    ]),
    "solve_bvp": (fastdyn.solve_bvp, OF_BVP, [  # SciPy's sentences
        ({"x": [0.0, 1.0, 1.0]}, "`x` must be strictly increasing."),
        ({"y": [0.0, 0.0, 0.0]}, "`y` must be 2 dimensional."),
        ({"y": np.zeros((2, 4))}, "`y` is expected to have 3 columns, but actually has 4."),
        ({"fun": "f"}, "`fun` must be a function of (x, y); got the text 'f'"),
        ({"bc": None}, "`bc` must be a function of (ya, yb); got None"),
        ({"x": "x"}, f"`x` {NUMBERS}the text 'x'"), ({"y": "x"}, "`y` must be numbers; got the t"),
        ({"tol": "x"}, f"`tol` {NUMBER}the text 'x'"), ({"p": "x"}, "`p` must be numbers"),
        ({"fun_jac": 3}, "`fun_jac` must be a function of (x, y); got 3"),
        ({"max_node": 3}, "did you mean `max_nodes`?"), ({"tolerance": 3}, "The call is solve_bvp"),
        ({"S": np.zeros((3, 3))}, "`S` is expected to have shape (2, 2), but actually has (3, 3)"),
        ({"verbose": 3}, "`verbose` must be in [0, 1, 2]."),
        ({"tol": -1}, "`tol` must not be negative"), ({"rtol": 1e-3}, "did you mean `tol`?"),
        ({"bc_tol": np.nan}, "`bc_tol` must not be negative; got nan"),
    ]),
    "solve_dae": (fastdyn.solve_dae, OF_DAE, [
        *SPANS,
        ({"F": None}, "`F` must be a function of (t, y, yp); got None"),
        ({"y0": "1"}, "`y0` must be numbers"),
        ({"y0": [1.0]}, "`yp0` must have one number for each of `y0`: it has 2, and `y0` 1"),
        ({"yp0": [[0.0, 0.0]]}, "`yp0` must be 1-dimensional"),
        ({"method": "Euler"}, "`method='Euler'` is unknown"),
        ({"given": "z"}, "`given"), ({"given": "yp", "yp0": None}, "holds all of `yp0`: give it"),
        ({"teval": [0.1]}, "did you mean `t_eval`?"),
        ({"yp": [0.0]}, "`solve_dae` has no option `yp`; did you mean `yp0`?"),
        ({"step": 0.1}, "`max_step` limits the steps"), ({"rtol": -1}, "must not be negative"),
        ({"rtol": "1e-3"}, f"`rtol` {NUMBERS}the text '1e-3'"),
    ]),
    "solve_dae_ensemble": (fastdyn.solve_dae_ensemble, OF_DAE, OF_DAES),
    "solve_dde": (fastdyn.solve_dde, OF_DDE, [
        ({"fun": None}, "`fun` must be a function of (t, y, past)"),
        ({"fun": lambda t, y: [-y[0]]}, "fun(t, y"),
        ({"fun": lambda t, y, past: [-past[0]]}, "not subscriptable"),
        ({"fun": lambda t, y, past: [-past(t + 1)[0]]}, "a delay is -1: `past` is for times befo"),
        ({"history": "x"}, "`history` must be n numbers, a function of t, or a result"),
        ({"history": [1j]}, "`history` must be real; got [1j]: let the state have real"),
        ({"history": lambda t: [np.exp(1j * t)]}, "`history` must be real; got"),
        ({"history": [np.nan]}, "`history` is not finite at the start"),
        ({"history": [[1.0], [2.0]]}, "`history` must give n numbers; got an array of shape (2"),
        ({"history": lambda t: [1.0, 2.0]}, "2"),
        ({"t_span": (1, 0)}, "`t_span` must be finite and ascend"),
        ({"method": "RK45"}, "does not solve delay equations; choose from auto, Tsit5"),
        ({"method": "tsit5"}, 'did you mean "Tsit5"?'),
        ({"sensitivity": "y0"}, "name 'history' for a constant one"),
        ({"sensitivity": "tua"}, "`sensitivity='tua'` is unknown"),
        ({"adjoint": "y0"}, "`solve_dde` takes no `adjoint`"),
        ({"lags": [1.0]}, "`solve_dde` takes no `lags`"),
        ({"rtol": -1}, "`rtol` must not be negative"),
        ({"events": 3}, "`events`"), ({"delays": "x"}, "`delays` must be a sequence of times"),
    ]),
    "solve_dde_ensemble": (fastdyn.solve_dde_ensemble, OF_DDE, [
        ({"fun": None}, "`fun` must be a function of (t, y, past)"),
        ({"method": "RK45"}, "does not solve delay equations; choose from auto, Tsit5"),
        ({"history": [[np.nan]]}, "All components of `history` must be finite"),
        ({"history": np.ones((0, 1))}, "`history` has no rows"),
        ({"history": [np.cos, np.sin, np.exp], "args": ([1.0, 2.0],)}, "`args[0]` has 2, `histor"),
        ({"sensitivity": "tau"}, "takes no `sensitivity`: `solve_dde`, trajectory by trajectory"),
        ({"dense_output": True}, "takes no `dense_output`: `t_eval` has times of output"),
        ({"reduce": "max"}, "takes no `reduce`: compute it from `y`"),
        ({"y0": [1.0]}, "takes no `y0`: `history` is the state up to the start"),
        ({"threads": 0}, "`threads` must be at least 1; got 0"), ({"threads": 1.5}, "`threads`"),
        ({"lags": [1.0]}, "`solve_dde` takes no `lags`"), ({"rtol": -1}, "must not be negative"),
    ]),
    "prepare_dde": (fastdyn.delays.prepare_dde, OF_DDE, [
        ({"fun": None}, "`fun` must be a function of (t, y, past)"),
        ({"method": "RK45"}, "does not solve delay equations; choose from auto, Tsit5"),
        ({"history": [np.nan]}, "`history` is not finite at the start"),
        ({"lags": [1.0]}, "`solve_dde` takes no `lags`"), ({"rtol": -1}, "must not be negative"),
    ]),
    "solve_sde": (fastdyn.solve_sde, OF_SDE, [
        *SPANS,
        ({"drift": None}, "`drift` must be a function of (t, y); got None"),
        ({"diffusion": "x"}, "`diffusion` must give real numbers; got the text 'x'"),
        ({"diffusion": [1.0, 2.0, 3.0]}, "`diffusion` gives shape (3,) for a state of 2"),
        ({"diffusion": lambda t, y: 1.0}, "`diffusion` returned one number for a state of 2"),
        ({"diffusion": np.nan}, "`diffusion` is not finite at the start"),
        ({"diffusion": np.ones((2, 2)), "noise": "scalar"}, "`diffusion` has 2 columns"),
        ({"y0": "x"}, "`y0` must be numbers"),
        ({"y0": [1j, 0.0]}, "`y0` must be real"), ({"y0": [np.inf, 0.0]}, "must be finite"),
        ({"y0": np.ones((3, 2)), "paths": 2}, "`y0` has 3 rows for 2 paths"),
        ({"t_span": (1, 0)}, "`t_span` must be finite and ascend"),
        ({"t_span": (0, np.inf)}, "`t_span` must be finite and ascend"),
        ({"step": -0.1}, "`step` must be a positive number; got -0.1"),
        ({"step": "x"}, f"`step` {NUMBER}the text 'x'"),
        ({"t_eval": [0.13]}, "`t_eval` must be ends of steps, 0.0 + i 0.1; 0.13 is none"),
        ({"t_eval": [0.5, 0.1]}, "`t_eval` must ascend"), ({"t_eval": [2.0]}, "within `t_span`"),
        ({"paths": 0}, "`paths` must be 1 to 2**32; got 0"),
        ({"paths": 2.5}, "`paths` must be a whole number; got 2.5"),
        ({"method": "eulermaruyama"}, 'did you mean "EulerMaruyama"?'),
        ({"method": "RK45"}, "choose from auto, EulerMaruyama"),
        ({"method": "SRA1", "diffusion": lambda t, y: y}, "noise that does not depend on the"),
        ({"method": "Milstein", "diffusion": lambda t, y: y[::-1]}, "sources do not mix"),
        ({"method": "Platen", "diffusion": lambda t, y: y, "calculus": "stratonovich"},
         "does not hold for the stratonovich integral"),
        ({"calculus": "Ito"}, "`calculus='Ito'` is unknown; choose from ito, stratonovich"),
        ({"noise": "diagonal"}, "`noise='diagonal'` is unknown; choose from auto, scalar"),
        ({"events": 3}, "`events` must be a function of (t, y)"),
        ({"threads": 0}, "`threads` must be at least 1"),
        ({"reduce": "final"}, "`reduce='final'` is unknown; choose from mean, variance"),
        ({"reduce": 3}, "`reduce` takes names and functions of (t, y); got 3"),
        ({"refine": -1}, "`refine` must be 0 to 63; got -1"),
        ({"dt": 0.1}, "solve_sde"), ({"seed": 1}, "solve_sde"),
    ]),
    "solve_langevin": (fastdyn.solve_langevin, OF_LANGEVIN, [
        ({"accel": "a"}, "`accel` must be a function of (t, q); got the text 'a'"),
        ({"v0": [1.0, 2.0]}, "`q0` and `v0` must have one shape"),
        ({"friction": -1.0}, "`friction` must not be negative; got -1.0"),
        ({"sigma": [1.0, 2.0]}, "`sigma` must be a number, or 1 numbers"),
        ({"method": "SRA1"}, "choose from auto, BAOAB, OBABO"),
    ]),
    "energy_drift": (fastdyn.energy_drift, DRIFT, [
        ({"system": None}, "`system` must be a function of (t, y); got None"),
        ({"method": "gauss16"}, 'did you mean "Gauss16"?'),
        ({"method": "auto"}, '`method="auto"` is for solve_ivp'),
        ({"step": "x"}, f"`step` {NUMBER}the text 'x'"),
        ({"t_end": "x"}, f"`t_end` {NUMBER}the text 'x'"),
        ({"steps_per_period": 0, "step": None}, "`steps_per_period` must be positive; got 0"),
        ({"rtol": "x", "method": "RK45"}, f"`rtol` {NUMBER}the text 'x'"),
        ({"samples": "x"}, f"`samples` {NUMBER}the text 'x'"),
        ({"tend": 1.0}, "`energy_drift` takes no `tend`; did you mean `t_end`?"),
        ({"energy": fun}, "`energy_drift` takes no `energy`; did you mean `invariants`?"),
        ({"method": "RK45", "rtol": -1, "step": None}, "`rtol` must not be negative"),
        ({"n_steps": 10}, "give one of `n_steps`, `t_end` and `periods`"),
        ({"invariants": None}, "there are no `invariants` to follow"),
        ({"invariants": fun}, "`invariants` must be a dict of names and functions"),
    ]),
    "energy_drift as solve_ivp": (drift_like_ivp, {}, [
        ({"method": "RK45"}, "The state of a function is `y0=`, the end `t_end=`"),
    ]),
    "solve_second_order": (solve.solve_second_order, OF_SECOND, [
        ({"accel": "a"}, "`accel` must be a function of (t, q); got the text 'a'"),
        ({"q0": "x"}, "`q0` must be numbers; got the text 'x'"),
        ({"v0": [1.0, 2.0]}, "`q0` and `v0` must be real and of one length; got shapes (1,), (2,)"),
        *of_kind(ValueError, [
            ({"q0": [[1.0]]}, "`q0` must be 1-dimensional"), ({"v0": [1j]}, "must be real"),
            ({"v0": [np.nan]}, "initial state `v0` must be finite"),
        ]),
        ({"step": "x"}, f"`step` {NUMBER}the text 'x'"),
        ({"method": "RK45"}, "`method='RK45'` does not solve q'' = a(t, q); these do: VelocityV"),
        ({"method": "verlet"}, 'did you mean "VelocityVerlet"?'),
        ({"t_span": 10}, "`t_span` must be start and end; got 10: (0, 10)?"),
        ({"stepp": 0.1}, "`stepp`: did you mean `step`?"),
    ]),
    "solve_separable": (solve.solve_separable, OF_SEPARABLE, [
        ({"velocity": "a"}, "give two functions, `velocity` and `force`; got ('a', <function"),
        ({"force": None}, "give two functions, `velocity` and `force`"),
        ({"p0": [1.0, 2.0]}, "`q0` and `p0` must be real and of one length"),
        ({"method": "radua"}, 'did you mean "Radau"?'),
    ]),
    "Planets": (Planets, OF_PLANETS, [
        *of_kind(ValueError, [
            ({"masses": [1.0]}, "two bodies or more; got 1"),
            ({"masses": [[1.0, 2.0]]}, "`masses` must be a row of numbers"),
            ({"masses": [1.0, -1.0]}, "must not be negative"),
            ({"masses": [0.0, 1.0]}, "the first must be positive"),
            ({"masses": [1.0, np.nan]}, "`masses` must be finite"),
            ({"q0": [[0, 0, 0]]}, "shape (2, 3); got shape (1, 3)"),
            ({"q0": [0, 0, 0]}, "rows of three numbers"),
            ({"q0": [[0, 0, 0], [0, 0, 0]]}, "two bodies are in one place"),
            ({"v0": [[0, 0, 0], [0, np.inf, 0]]}, "`v0` must be finite"),
            ({"G": 0.0}, "`G` must be a positive number"),
            ({"G": np.nan}, "`G` must be a positive number"),
        ]),
        *of_kind(TypeError, [
            ({name: value}, f"`{name}` must be") for name in OF_PLANETS for value in NO_NUMBERS
        ]),
    ]),
    "solve of Planets": (lambda **given: outer_planets().solve(**given), OF_RUN, [
        *of_kind(ValueError, [
            ({"step": 0.0}, "`step`"), ({"step": -0.1}, "`step`"), ({"step": np.nan}, "`step`"),
            ({"corrector": 4}, "must be 3, 5, 7, 11, 17, or 0"),
            ({"t_eval": [0.0, 2.0]}, "not within `t_span`"),
            ({"t_eval": [0.5, 0.1]}, "not properly sorted"), ({"t_span": (0, np.inf)}, "must end"),
        ]),
        *of_kind(TypeError, [
            ({"step": "0.1"}, "`step`"), ({"checkpoint": 3}, "`checkpoint`"),
            ({"corrector": "17"}, "`corrector`"), ({"progress": "yes"}, "`progress`"),
        ]),
    ]),
    "time_transformed": (solve.time_transformed, {"fun": fun, "density": fun}, [
        ({"fun": "f"}, "`fun` and `density` must be plain Python functions"),
        ({"density": 3}, "`fun` and `density` must be plain Python functions"),
    ]),
    "reduce_index": (dae.reduce_index, {"fun": lambda t, y, yp: [yp[0]], "y0": [1.0]}, [
        ({"fun": "f"}, "`fun` must be a function of (t, y, yp); got the text 'f'"),
        ({"t0": "x"}, f"`t0` {NUMBER}the text 'x'"),
        ({"yp0": [1.0, 2.0]}, "`yp0` must have one number for each of `y0`: it has 2, and `y0` 1"),
    ]),
    "compare_drift": (drift.compare_drift, OF_COMPARISON, [
        ({"methods": "RK4"}, "`methods` must be a list; got the text 'RK4'"),
        ({"methods": ["rk4"]}, 'did you mean "RK4"?'),
        ({"evaluations": "x"}, f"`evaluations` {NUMBER}the text 'x'"),
        ({"seconds": 1.0}, "give one of `evaluations`, `seconds`, `step`, `steps_per_period`"),
        ({"system": None}, "`system` must be a function of (t, y); got None"),
    ]),
    "solve_linear": (fastdyn.solve_linear, {"a": ((1.0,),), "b": (1.0,)}, [
        ({"a": "x"}, "a matrix is a tuple of rows, a row or a right-hand side a tuple of numbers"),
        ({"a": 3}, "a tuple of numbers; got 3"),
        ({"b": None}, "a tuple of numbers; got None"),
        ({"b": ("1",)}, "a tuple of numbers; got ('1',)"),
        ({"a": ((1.0, 2.0),)}, "the matrix must have 1 rows of 1 numbers"),
    ]),
    "constrained": (fastdyn.constrained, OF_CONSTRAINED, [
        ({"mass": "x"}, "a tuple of numbers; got 'x'"),
        ({"force": None}, "a tuple of numbers; got None"),
        ({"mass": 3.0}, "a tuple of numbers; got 3.0"),
        ({"b": (1.0, 2.0)}, "1 forces and 2 right-hand sides need 1 masses and A with 2 rows of 1"),
    ]),
    "at": (fastdyn.at, {}, [
        ({"times": 3}, "`at` must be a sequence of times; got 3"),
        ({"times": [0.2, 0.1]}, "0.2 comes before 0.1"),
        ({"times": ["a"]}, "`at` must be a sequence"), ({"times": [np.nan]}, "must be finite"),
    ]),
    "every": (fastdyn.every, {"period": 0.1}, [
        ({"period": "x"}, "`every` must be a number"), ({"period": -1}, "a time above zero"),
        ({"start": "x"}, "`start` must be a number"), ({"period": [0.1]}, "must be a number"),
    ]),
}  # fmt: skip


@pytest.mark.parametrize(("call", "given", "words", "kind"), rows_of(TABLE))
def test_a_slip_is_answered(call, given, words, kind):
    assert words in said_to(call, given, kind)


NAMED = [  # a call that lacks an argument, whose name is written in another way
    (lambda: fastdyn.solve_ivp(fun, tspan=(0, 1), y0=[1.0]), "`tspan`: did you mean `t_span`?"),
    (lambda: fastdyn.prepare(fun, (0, 1), Y0=[1.0]), "`Y0`: did you mean `y0`?"),
    (lambda: fastdyn.Stepper(fun, 0, [1.0], tbound=1), "The call is Stepper(fun, t0, y0, t_bound"),
    (lambda: fastdyn.solve_phases(phase=PHASES, first="up"), "`phase`: did you mean `phases`?"),
    (lambda: fastdyn.solve_dae(fun, (0, 1), y_0=[1.0]), "`y_0`: did you mean `y0`?"),
]


@pytest.mark.parametrize(("call", "words"), NAMED)
def test_a_name_of_an_argument_that_lacks_is_proposed(call, words):
    with pytest.raises(TypeError) as found:
        call()
    assert words in found.value.__notes__[0]


def test_transposed_states_of_an_ensemble():
    with pytest.raises(ValueError, match="returned 2 values for a state of 5") as found:
        fastdyn.solve_ensemble(lambda t, y: [y[1], -y[0]], (0, 1), np.ones((2, 5)))
    assert "Is it transposed? y0.T has 5 states of 2." in found.value.__notes__[-1]


STEPPER = fastdyn.Stepper(lambda t, y: -y, 0.0, [1.0], 1.0)
SET = [("y", [2.0]), ("t", 0.5), ("t_bound", 9.0), ("fun", fun), ("max_step", 0.1), ("rtol", 1e-3)]


@pytest.mark.parametrize(("name", "value"), SET)
def test_what_would_be_ignored_in_a_stepper_is_refused(name, value):
    with pytest.raises(AttributeError, match=f"`{name}`.* Stepper\\(fun, "):
        setattr(STEPPER, name, value)
    STEPPER.label = "mine"


@pytest.mark.parametrize("method", ["Gauss4", "EnergyConserving2"])
def test_a_step_that_is_far_too_long_is_named(method):
    hard = fastdyn.solve_ivp(lambda t, y: [y[1], -(y[0] ** 3)], (0, 50), [1.0, 0.0], method, step=5)
    assert "The step from t = 0, of the length 5, gives no finite state" in hard.message
    bad = fastdyn.solve_ivp(lambda t, y: [math.nan], (0, 50), [1.0], method, step=5)
    assert "gives no finite state" not in bad.message and bad.status == -1
