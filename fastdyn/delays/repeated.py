"""Repeated calls of solve_dde: the same function, method and options, other values."""

import types as python
from typing import Any

import numpy as np

from fastdyn.problem.options.table import OPTIONS, taken_by, value_of
from fastdyn.run import again
from fastdyn.solve.keys import hashable, is_known

FUNCTION = python.FunctionType
MOST_TIMES = 1000  # of `t_eval` in a key
LEAST = 1e-13  # of `rtol`: below, each call warns
IN_KEY = {name: OPTIONS[name] for name in taken_by("past again") if OPTIONS[name].in_key}


def key_of(given):
    """The key of the call of a Given; None for a call that is not made again in a short way."""
    fun, t_span, history, method, t_eval, dense_output, events, args, delays, jumps, options = given
    if events is not None or delays is not None or jumps is not None:
        return None
    if fun.__class__ is not FUNCTION or hasattr(history, "sol"):  # an earlier result
        return None
    for name, value in options.items():
        if name not in IN_KEY or not is_known(IN_KEY[name], value):
            return None
    try:
        if np.min(value_of(options, "rtol")) < LEAST:
            return None
        form = id(history.__code__) if history.__class__ is FUNCTION else (len(history),)
        times = None if t_eval is None else np.asarray(t_eval)
        if times is not None and (times.ndim != 1 or len(times) > MOST_TIMES):
            return None
        key = hashable((
            "dde", id(fun.__code__), np.asarray(t_span), form, method, times, dense_output,
            len(args), *options, *options.values(),
        ))  # fmt: skip
        hash(key)
    except (TypeError, ValueError):
        return None
    return key


def solved(key, fun, history, args):
    """The result of a call like an earlier one; None for the long way."""
    kind: Any = None if key is None or args.__class__ is not tuple else again.calls.get(key)
    equation = again.taken(kind)
    if equation is None:
        return None
    result = equation.again(fun, history, args)
    if result is not None:
        equation.let_go()
        kind.give_back(equation)
    return result


def keep(key, equation, *functions):
    """Keep an Equation of functions that was solved, for calls of its kind."""
    if key is None or not equation.may_come_again:
        return
    equation.let_go()
    codes = [each.__code__ for each in functions if each.__class__ is FUNCTION]
    again.kept(key, lambda: again.Kind(codes), equation.history.n).give_back(equation)
