"""What a problem is, and its right-hand side compiled as rivals take it."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit


class Problem(NamedTuple):
    """A right-hand side with its data.

    Attributes
    ----------
    name : str
    fun : callable
        ``fun(t, y, *args)`` in plain Python, which Numba compiles.
    t_span : tuple
    y0 : list or ndarray
    args : tuple
    code : str
        Name of the C++ function in reference.cpp, empty if there is none.
    terms : callable, optional
        The equations over a namespace, for formulas.
    into : callable, optional
        ``into(t, y, d)``, the right-hand side in loops, written into d; there are no `args`.
    arrays : callable, optional
        The equations over a namespace of whole arrays, where `terms` would be too many.
    """

    name: str
    fun: Any
    t_span: tuple
    y0: Any
    args: tuple
    code: str = ""
    terms: Callable | None = None
    into: Callable | None = None
    arrays: Callable | None = None


def small(terms, t_end, y0, args, name="", code=""):
    """A problem of few components, from t = 0."""
    word = terms.__name__
    return Problem(name or word, terms(math), (0.0, t_end), y0, args, code or word, terms)


def in_place(problem):
    """``into(t, y, d)`` compiled, the parameters constants of the code."""
    if problem.into is not None:
        return njit(problem.into)
    inner, n, args = njit(problem.fun), len(problem.y0), problem.args

    @njit
    def into(t, y, d):
        rates = inner(t, y, *args)
        for i in range(n):
            d[i] = rates[i]

    return into


def compiled(problem):
    """``fun(t, y)`` compiled, as a user of SciPy writes it: it gives an array."""
    into = in_place(problem)

    @njit
    def fun(t, y):
        d = np.empty_like(y)
        into(t, y, d)
        return d

    return fun


def large(name, into, t_end, y0, code, **others):
    """A problem of many components, written in loops."""

    def fun(t, y):
        d = np.empty_like(y)
        into(t, y, d)
        return d

    return Problem(name, fun, (0.0, t_end), y0, (), code, into=into, **others)
