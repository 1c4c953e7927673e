"""Drift and diffusion as functions that return n numbers each, and the kind of their noise."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import DERIVATIVE, EVENT
from fastdyn.compile.python_callback import called_with, evaluate, value_of
from fastdyn.problem.events import event_list
from fastdyn.problem.validate import function
from fastdyn.words.kinds import are_real, shown

MOST_SOURCES = 2**20  # the word of a source has 20 bits, see `kernels/noise/brownian.py`


class Equations(NamedTuple):
    """Functions of (t, y, *args), checked at the start.

    Parameters
    ----------
    drift : callable
    columns : list of callable
        One function for noise that acts component by component (`diagonal`), else one for each
        source of noise, whose n numbers are a column of the diffusion matrix.
    diagonal : bool
    n, n_sources : int
    constant : bool
        Whether the diffusion was given as numbers.
    """

    drift: Any
    columns: list
    diagonal: bool
    n: int
    n_sources: int
    constant: bool


class ConstantColumn:
    """A diffusion, or a column of it, that was given as numbers."""

    def __init__(self, numbers):
        self.numbers = numbers

    def __call__(self, t, y, *args):
        return self.numbers


def column_of(diffusion, j):
    """Column j of a function that returns a matrix."""

    def column(t, y, *args):
        return np.array(diffusion(t, y, *args))[:, j]

    return functools.update_wrapper(column, diffusion)


def flat_of(diffusion):
    """The numbers of a function that returns a number, or a matrix of one column."""

    def numbers(t, y, *args):
        return np.array(diffusion(t, y, *args)).reshape(len(y))

    return functools.update_wrapper(numbers, diffusion)


def equations(drift, diffusion, t0, y0, args, one_source):
    """The Equations; functions are called once, at the start.

    Raises
    ------
    TypeError, ValueError
        If the values do not have the shape of the state, or of a matrix of its length.
    """
    n = len(y0)
    evaluate(called_with(drift, args), DERIVATIVE, t0, y0.copy())
    constant = not callable(diffusion)
    value = diffusion if constant else value_of(diffusion, args, "diffusion", t0, y0.copy())
    if isinstance(value, bool) or not are_real(value):
        raise TypeError(f"`diffusion` must give real numbers; got {shown(value)}.")
    value = np.asarray(value, dtype=float)
    if not np.isfinite(value).all():
        raise ValueError(f"`diffusion` is not finite at the start: {value}.")
    if value.ndim == 0 and n > 1 and not constant:
        raise ValueError(
            f"`diffusion` returned one number for a state of {n}: return {n} numbers, one for each "
            f"component, or a matrix of {n} rows, with a column for each source of noise."
        )
    if (
        value.ndim > 2
        or (value.ndim == 2 and len(value) != n)
        or (value.ndim == 1 and len(value) != n)
    ):
        raise ValueError(
            f"`diffusion` gives shape {value.shape} for a state of {n}: it must be ({n},), one "
            f"number for each component, or ({n}, m), a column for each of m sources of noise."
        )
    if value.ndim == 2 and not 0 < value.shape[1] < MOST_SOURCES:
        raise ValueError(f"`diffusion` has {value.shape[1]} columns; at least one, below 2**20.")
    if one_source and value.ndim == 2 and value.shape[1] > 1:
        raise ValueError(
            f'`noise="scalar"` is one source of noise; `diffusion` has {value.shape[1]} columns.'
        )
    if constant:
        value = np.broadcast_to(value, (n,)) if value.ndim == 0 else value
        whole = value.T if value.ndim == 2 else [value]
        columns: list = [ConstantColumn(np.array(numbers)) for numbers in whole]
    elif value.ndim == 2 and value.shape[1] > 1:
        columns = [column_of(diffusion, j) for j in range(value.shape[1])]
    else:
        columns = [diffusion if value.ndim == 1 else flat_of(diffusion)]
    diagonal = value.ndim < 2 and not (one_source and n > 1)
    if n == 1 and len(columns) == 1:
        diagonal = True
    return Equations(drift, columns, diagonal, n, n if diagonal else len(columns), constant)


def passages_of(events):
    """The argument `events` as a list of `problem.events.Event`.

    Raises
    ------
    TypeError, ValueError
        For what is no function, and for rules that a first passage does not have.
    """
    listed = list(events) if isinstance(events, list | tuple) else [events] * (events is not None)
    for each in listed:
        function(each, "events")
    found = event_list(listed)
    for event in found:
        others = {"terminal": event.limit} if event.limit > 1 else {}
        others |= event.beyond("limit", "direction")
        if others:
            asked = " and ".join([f"`{name}={value:g}`" for name, value in others.items()])
            raise ValueError(
                f"the event `{event.name}` asks for {asked}: a first passage has `direction`, and "
                "`terminal` True or False."
            )
    return found


def check_events(asked, start):
    """Call each event once, to find mistakes."""
    for event in asked.events:
        evaluate(called_with(event.function, asked.args), EVENT, asked.grid.t0, start.copy())
