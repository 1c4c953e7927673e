"""Switches, pulses and chattering problems under every method: right, told, or wrong."""

import itertools
import math
import types
import warnings

import numpy as np

import fastdyn

from ..problems.switches import STATES, TIMES
from ..report.table import markdown

METHODS = ("auto", "Taylor", "Tsit5", "Vern7", "Vern9", "Rodas5P", "RK23", "RK45", "DOP853",
           "Radau", "BDF", "LSODA", "ode45", "ode23")  # fmt: skip
GIVEN = {"rtol": 1e-6, "atol": 1e-9, "max_steps": 100_000}
ALLOWED = 1e-3  # error that counts as right, as a share of the size of the states
LINES = itertools.count(1000)
RIGHT, TELLS, WRONG = "right", "tells", "wrong"


def end_of(problem):
    """The end state: by hand, or by a method whose steps end at the changes, and are short."""
    p = problem
    if p.end is not None:
        return np.array(p.end)
    tight = {"rtol": 1e-10, "atol": 1e-12, "max_step": p.max_step}
    method = "Radau" if math.isinf(p.max_step) else "DOP853"
    if math.isinf(p.max_step):  # the changes are whole and half numbers near the end
        end = p.t_span[1]
        tight["breakpoints"] = np.arange(max(0.0, end - 10.0), end, 0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = fastdyn.solve_ivp(p.fun, p.t_span, p.y0, method, args=p.args, **tight)
    return run.y[:, -1]


def _fresh(fun):
    """A copy of a function that no warning named yet: on another line."""
    code = fun.__code__.replace(co_firstlineno=next(LINES))
    return types.FunctionType(code, fun.__globals__, fun.__name__, None, fun.__closure__)


def verdict(problem, method, end):
    """RIGHT; TELLS of a wrong result by a warning, or of none by a sentence; or WRONG."""
    p, fun = problem, _fresh(problem.fun)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            run = fastdyn.solve_ivp(fun, p.t_span, p.y0, method, args=p.args, **GIVEN)
        except ValueError:  # Taylor says why it does not apply
            return TELLS
    if run.status < 0:
        return TELLS
    size = max(np.abs(end).max(), np.abs(p.y0).max())
    if np.abs(run.y[:, -1] - end).max() <= ALLOWED * size:
        return RIGHT
    return TELLS if caught else WRONG


def rows(quick):
    """One row a problem and method."""
    for kind, problems in (("time", TIMES), ("state", STATES)):
        for p in problems[:2] if quick else problems:
            end = end_of(p)
            for method in METHODS[:3] if quick else METHODS:
                yield {
                    "kind": kind, "problem": p.name, "solver": method,
                    "verdict": verdict(p, method, end),
                }  # fmt: skip


def summary(found):
    """A line a problem, a column a method."""
    lines = {}
    for row in found:
        lines.setdefault(row["problem"], {})[row["solver"]] = row["verdict"]
    body = [[name, *(cells[m] for m in METHODS)] for name, cells in lines.items()]
    return "\n".join(markdown(["", *METHODS], body))
