"""The flow of equations over a span, with its exact derivatives.

The equations are solved over s from 0 to 1, dy/ds = length f(start + length s, y), with the span as
arguments `start` and `length`.  One compiled function then serves all spans, and the derivative
with respect to the length is a sensitivity.
"""

import inspect
from typing import Any, NamedTuple

import numpy as np

from fastdyn.problem.options.names import refuse_unknown
from fastdyn.problem.options.table import OPTIONS, defaults_of
from fastdyn.solve.ivp import solve_ivp

from .equations import NotConvergedError, SystemEquations

METHOD = "DOP853"


class OverUnit:
    """``fun`` over s from 0 to 1, with the arguments `start` and `length` before its own.

    `start` is an array of one number, which compiled code reads in place, so that the caller may
    change the number between solves.
    """

    def __init__(self, fun):
        self.fun = fun
        self.__name__ = getattr(fun, "__name__", "fun")

    def __call__(self, s, y, start, length, *args):
        rates = self.fun(start[0] + length * s, y, *args)
        return [length * rate for rate in rates]


class Passage(NamedTuple):
    """The end of a flow, and its derivatives.

    `by_start` has shape (n, n); `by_length` and `by_parameter` have shape (n,).  `by_parameter` is
    None without a parameter.
    """

    y: np.ndarray
    by_start: np.ndarray
    by_length: np.ndarray
    by_parameter: Any


class Flow(NamedTuple):
    """The flow of equations; `options` are options of `solve_ivp`."""

    equations: SystemEquations
    options: dict

    def passage(self, y0, start, length, j=None):
        """The Passage from a state; `j` is the position of the parameter to differentiate by.

        Raises
        ------
        NotConvergedError
            If the solve fails on the way.
        """
        e = self.equations
        wanted = ["y0", "length"] + ([] if j is None else [f"args[{j + 2}]"])
        result = solve_ivp(
            OverUnit(e.fun), (0.0, 1.0), y0, t_eval=[1.0],
            args=(np.array([start], float), float(length), *e.args),
            sensitivity=wanted, **self.options,
        )  # fmt: skip
        if not result.success:
            raise NotConvergedError(
                f"The solve from t = {start:g} over {length:g} failed (times are shares of this "
                f"span): {result.message}"
            )
        by = {name: found[..., -1] for name, found in result.sensitivity.items()}
        return Passage(
            result.y[:, -1], by["y0"], by["length"], None if j is None else by[wanted[2]]
        )

    def curve(self, y0, start, length, n_points):
        """(times, states of shape (n, n_points)) along the flow."""
        times = np.linspace(start, start + length, n_points)
        e = self.equations
        result = solve_ivp(
            e.fun, (times[0], times[-1]), y0, args=e.args, t_eval=times, **self.options
        )
        if not result.success:
            raise NotConvergedError(result.message)
        return times, result.y


def options_of(analysis, method, given, more=()):
    """The options of the solves of an analysis, a public function; `more` are no `solve_ivp`'s."""
    for name in ("sensitivity", "t_eval", "dense_output", "events", "args"):
        if name in given:
            raise TypeError(f"`{name}` is no option here: the analysis sets it.")
    own = inspect.signature(analysis).parameters
    refuse_unknown(f"`{analysis.__name__}`", given, {*OPTIONS, *more}, own)
    return {"method": method, **defaults_of(analysis.__name__), **given}
