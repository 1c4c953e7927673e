"""Repeated calls of solve_dde: the same function, method and options, other values."""

import types as python

import numpy as np

from fastdyn.compile import memory
from fastdyn.problem.options.table import value_of

FUNCTION = python.FunctionType
MOST_TIMES = 1000  # of `t_eval` in a key
LEAST = 1e-13  # of `rtol`: below, each call warns
OTHER_VALUES = {"on_event", "at", "every", "breakpoints", "sensitivity"}  # for the long way

_recent = memory.Table()  # Equations between calls, by the kind of a call


def kind_of(given):
    """The key of the call of a Given; None for a call that is not made again in a short way."""
    fun, t_span, history, method, t_eval, dense_output, events, args, delays, jumps, options = given
    if events is not None or delays is not None or jumps is not None:
        return None
    if fun.__class__ is not FUNCTION or not OTHER_VALUES.isdisjoint(options):
        return None
    if hasattr(history, "sol"):  # an earlier result
        return None
    try:
        if np.min(value_of(options, "rtol")) < LEAST:
            return None
        if history.__class__ is FUNCTION:
            form = history.__code__
        else:
            form = len(history)
        times = None
        if t_eval is not None:
            times = np.asarray(t_eval)
            if times.ndim != 1 or len(times) > MOST_TIMES:
                return None
            times = times.dtype.str, times.tobytes()
        key = (
            fun.__code__, tuple(map(float, t_span)), form, method, times, dense_output, len(args),
            *options.items(),
        )  # fmt: skip
        hash(key)
    except (TypeError, ValueError):
        return None
    return key


def solved(kind, fun, history, args):
    """The result of a call like an earlier one; None for the long way."""
    idle = None if kind is None or args.__class__ is not tuple else _recent.get(kind)
    if not idle:
        return None
    equation = idle.pop()  # so that no other thread takes it
    result = equation.again(fun, history, args)
    if result is not None:
        equation.let_go()
        idle.append(equation)
    return result


def keep(kind, equation):
    """Keep an Equation that was solved, for calls of its kind."""
    if kind is None or not equation.may_come_again:
        return
    equation.let_go()
    idle = _recent.get(kind)
    if idle is None:
        _recent.put(kind, [equation], 1 + equation.history.n // 1000)
    elif not idle:
        idle.append(equation)
