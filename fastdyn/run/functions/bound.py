"""Binds the functions of a problem: the equations, and the functions called between steps."""

from typing import Any

import numpy as np

from fastdyn.compile import budget
from fastdyn.compile.bind import bind, bind_matrix
from fastdyn.compile.derivatives.sensitivities import bind_saltation
from fastdyn.compile.derivatives.sparse_jacobian import (
    bind_sparse_function,
    bind_sparse_matrix,
    is_sparse,
    pattern_of,
)
from fastdyn.compile.python_callback import evaluate, value_of
from fastdyn.compile.sentences import GaveUp, WritesToState
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FAULT, RAISED_WORD, TIME
from fastdyn.problem.events import between_steps
from fastdyn.problem.lsoda import NAME as LSODA
from fastdyn.problem.second_order_and_pairs import bind_equations

from .followed import with_room

# Limits of a solve that each event waits for its code, when the equations have used the first one:
# its values alone do not show each turn of a fast event.  Its code takes 0.03 s as a rule.
PATIENCE = 3.0


def leave_writers_to_scipy(problem, bound, others):
    """Raise WritesToState if a function in Python writes to the state at the start.

    Later writes of such functions raise WritesToState, too.
    """
    p = problem
    n = len(problem.y0)
    functions = [(bound, p.fun), *zip(others, [f for f, _ in between_steps(p)], strict=True)]
    for each, fun in functions:
        if not (each.mode.acts_on_state or each.mode.one_number):
            continue
        if each.callback is not None:
            if Attempt(fun, p.args, each.mode, n).facts().of_state:
                raise WritesToState
            each.callback.writes = False


def bind_functions(problem):
    """Bind the equations of a problem, and the functions that are called between steps."""
    p = problem
    others = between_steps(p)
    bound = bind_equations(p)
    near = Near(p.t0, p.tf, p.y0, not p.method.series)
    bounds = [_bind(p, fun, mode, near) for fun, mode in others]
    if p.callback is None and all(b.function is not None for b in (bound, *bounds)):
        return bound, bounds
    return with_room(bound), [with_room(b) for b in bounds]


def _bind(problem, fun, mode, near):
    """Bind a function that is called between steps, or a Jacobian."""
    p = problem
    n = len(problem.y0)
    if mode.saltation:
        return bind_saltation(fun, p.args, near)
    if not callable(fun):
        return bind_sparse_matrix(fun) if is_sparse(fun) else bind_matrix(fun)
    bound = bind(fun, p.args, mode, n, near)
    if mode.one_number and getattr(bound.callback, "account", None):
        with budget.limited(PATIENCE * budget.SECONDS / budget.SHARE):
            bound = bind(fun, p.args, mode, n, near)
    if mode.matrix and bound.function is None:
        found = value_of(fun, p.args, mode.argument, p.t0, p.y0.copy())
        if is_sparse(found):
            return bind_sparse_function(fun, p.args, n, p.sparsity or pattern_of(found, n))
    return bound


def type_of_time(problem) -> Any:
    """A function from a time to the number that SciPy's solver passes as this time.

    LSODA passes Python's floats, whose division by 0 and overflow raise.  So do Radau and BDF at
    the end of the span, which they take as it was given.
    """
    name = problem.method.name
    end = problem.tf
    if name in ("Radau", "BDF"):
        return lambda t: float(t) if t == end else np.float64(t)
    return float if name == LSODA else np.float64


def raise_kept(bounds, problem):
    """Raise the exception of a user's function: the kept exception, or that of a new call.

    The new call passes the time in the type of SciPy's solver.  Raises GaveUp if the function
    raises nothing.
    """
    for bound in bounds:
        if bound.block[RAISED_WORD]:
            if bound.callback is not None and bound.callback.exception is not None:
                raise bound.callback.exception
            t = float(bound.block[TIME : TIME + 1].view(float)[0])
            y = bound.block[bound.block[FAULT] :].view(float)
            first = t == problem.t0 and not bound.mode.acts_at_events
            time = float if first else type_of_time(problem)
            evaluate(bound.python, bound.mode, time(t), y.copy())
            raise GaveUp(bound, t)
