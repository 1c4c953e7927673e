"""The options `domain` and `nonnegative`, checked, and the functions that keep a solve inside.

Outside of the domain the equations are nan, which every adaptive method answers with a shorter
step; `fun` is not called there.  With `nonnegative`, the equations are continued below zero:
`fun` gets 0 for a negative component, and the derivative of a component that is not positive is at
least 0.  `kernels/output/borders.py` checks the end of each step.
"""

from typing import Any

import numpy as np

from fastdyn.compile.mode import COLUMN, DERIVATIVE
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.output.arguments import CHECKS, CLIPS, WITHIN
from fastdyn.problem.events import apart, called_between, with_functions
from fastdyn.problem.lsoda import NAME as LSODA

from .functions import (
    clipped,
    inside_of,
    inside_only,
    jacobian_inside,
    jacobian_of_kept,
    kept,
    of_clipped,
    of_states,
)  # fmt: skip

MOST_CUT = 100.0  # the sum of corrections, in units of `atol`, that a solve makes without a word
NAMES = frozenset(("domain", "nonnegative"))
SHORT = 32
NUMBERS = (bool, int, float, np.bool_, np.number)  # that `domain` may return


def asked(options):
    """Whether an option of this file is given."""
    return not NAMES.isdisjoint(options) and any(_is_given(options.get(name)) for name in NAMES)


def _is_given(value):
    return value is not None and value is not False


def keeps(problem):
    """The flags CLIPS, CHECKS and WITHIN of the checks of each step by the kernels."""
    p = problem
    checked = p.inside is not None and p.method.n_matrices > 0  # others have a stage at the end
    # LSODA would crawl: it begins anew with many short steps each time that a step is taken back.
    looks = p.inside is not None and p.method.name != LSODA
    return CLIPS * (p.nonnegative is not None) + CHECKS * checked + WITHIN * looks


def kept_inside(problem, options):
    """A Problem whose equations end, or rest, at the border of their domain.

    Parameters
    ----------
    problem : validate.Problem
        The problem without the options of this file.
    options : dict

    Returns
    -------
    validate.Problem

    Raises
    ------
    ValueError, TypeError
    """
    p = problem
    n = len(problem.y0)
    domain = options.get("domain")
    listed = listed_components(options.get("nonnegative"), n)
    for name, given in (("domain", domain), ("nonnegative", listed)):
        if given is not None:
            _check(p, name)
    if domain is not None and not callable(domain):
        raise TypeError(f"`domain` must be a function of (t, y); got {domain!r}.")
    if listed is not None:
        _check_nonnegative(p, listed)
    bare = p._replace(domain=domain, inside=domain, nonnegative=listed)
    fun, others = forms(bare, p.fun, called_between(bare), p.t0, p.y0)
    clips = listed is not None
    formed = bare._replace(
        project=clips or p.project, jac=True if clips and p.jac is not None else p.jac
    )
    return with_functions(formed, others)._replace(fun=fun, mode=DERIVATIVE, bare=bare)


def forms(bare, fun, others, t0, y0):
    """The forms of functions that keep a solve from (t0, y0) inside: the equations, the others.

    Parameters
    ----------
    bare : validate.Problem
        The Problem of the functions without forms, whose `inside` is the domain.
    fun : callable
    others : sequence of callable
        In the order of `called_between`, as are their forms.
    """
    listed = bare.nonnegative
    rest, by_field = apart(bare, others)
    domain = by_field.get("inside")
    jac: Any = by_field.get("jac", bare.jac)
    last: list[Any] = [by_field["project"]] if "project" in by_field else []
    if bare.mode is COLUMN:
        fun = of_states(fun)
    if domain is not None:
        rest.append(inside_of(domain))
        fun = inside_only(fun, domain, len(bare.y0))
        jac = jacobian_inside(jac, domain, t0, y0) if callable(jac) else jac
    if listed is not None:
        jac = None if jac is None else jacobian_of_kept(jac, fun, listed)
        fun = kept(fun, listed)
        rest = [of_clipped(each, listed) for each in rest]
        last = [clipped(listed)]
    if callable(jac):
        last.append(jac)
    return fun, rest + last


def check_start(problem):
    """Raise ValueError if a solve does not begin inside."""
    p = problem
    _check_start(p.domain, p.nonnegative, p.t0, p.y0, p.args)


def start_inside(bare, others, t0, y0, args):
    """The start of a solve, a float and an array; None where it is not inside, or is no start.

    Nothing is known about `t0`, `y0` and `args`, those of a call; `bare` and `others` are as of
    `forms`.
    """
    try:
        if y0.__class__ is np.ndarray and y0.dtype.kind not in "if":
            return None
        t0 = float(t0)
        y0 = np.array(y0, float)
        _check_start(apart(bare, others)[1].get("inside"), bare.nonnegative, t0, y0, args)
    except Exception:  # whoever checks the arguments raises the same
        return None
    return t0, y0


def _check_start(domain, listed, t0, y0, args):
    lowest = 0.0
    if listed is not None:  # the minimum of a short list takes a fifth of an array's
        lowest = min(y0.tolist()) if y0.size < SHORT else y0.min()
    if lowest < 0.0 and (listed & (y0 < 0.0)).any():
        (bad,) = np.nonzero(listed & (y0 < 0.0))
        raise ValueError(
            f"`nonnegative` lists component {bad[0]}, which `y0` begins at {y0[bad[0]]:g}."
        )
    if domain is None:
        return
    found = domain(t0, y0.copy(), *args)
    if not isinstance(found, NUMBERS):
        raise TypeError(
            "`domain` must return True or False, or a number that is positive inside; it returned "
            f"{found!r}."
        )
    # NumPy compares a bool with a number in 2 us.
    if not (bool(found) if found.__class__ is np.bool_ else found > 0):
        raise ValueError(
            f"`y0` lies outside of `domain`, which returned {found} at t = {t0:.10g}: the "
            "solution has to begin inside."
        )


def warn_of_cut(cut):
    """Warn if `cut`, the sum of the corrections to 0 in units of `atol`, is large."""
    if cut > MOST_CUT:
        warn(
            f"`nonnegative` has returned components to 0 so often that {cut:.3g} times their "
            "`atol` was added to them: give a smaller `atol`, or a method for stiff problems."
        )


def listed_components(given, n):
    """The components of `nonnegative`, n bools; None if there are none."""
    if not _is_given(given):
        return None
    if given is True:
        return np.full(n, True)
    array = np.asarray(given)
    if array.dtype == bool and array.shape == (n,):
        return array.copy() if array.any() else None
    if array.size == 0:
        return None
    if array.dtype.kind not in "iu" or array.ndim > 1:
        raise TypeError(
            f"`nonnegative` must be True, indices of components, or {n} bools; got {given!r}."
        )
    array = np.atleast_1d(array)
    if array.min() < 0 or array.max() >= n or len(np.unique(array)) < len(array):
        raise ValueError(
            f"`nonnegative` must list each component once, from 0 to {n - 1}; got {given!r}."
        )
    listed = np.full(n, False)
    listed[array] = True
    return listed


def _check(problem, name):
    """Raise ValueError if the method or the form of the equations cannot take an option."""
    p = problem
    if p.method.series or not p.method.error_order:
        said = (
            "a series does not end at a border" if p.method.series
            else "its steps are constant, and cannot be shortened at a border"
        )  # fmt: skip
        others = ", ".join(m.name for m in METHODS.values() if m.error_order and not m.series)
        raise ValueError(f"{p.method.name} does not take `{name}`, since {said}; {others} do.")
    if p.mode not in (DERIVATIVE, COLUMN):
        raise ValueError(f"`{name}` is for equations y' = fun(t, y) of real numbers.")


def _check_nonnegative(problem, listed):
    p = problem
    if p.project is not None:
        raise ValueError(
            "`nonnegative` and `project` do not go together: let `project` return a state without "
            "negative components, too."
        )
    if p.mass is not None:
        raise ValueError(
            "`nonnegative` and `mass` do not go together: `fun` is not the derivative then; "
            "`domain` may be given."
        )
    if (np.broadcast_to(p.atol, listed.shape)[listed] <= 0.0).any():
        raise ValueError(
            "`nonnegative` needs a positive `atol` for its components: a relative tolerance alone "
            "lets no step arrive at 0."
        )
