"""Stepping kernels on vectors, a trajectory in each lane, from the source of the scalar step."""

# Numba's type annotations are incomplete.
# pyright: reportCallIssue=false, reportArgumentType=false

import functools
from typing import NamedTuple

from fastdyn.code_store.target import width
from fastdyn.compile.derivatives.vector_form import vector_form
from fastdyn.compile.mode import EVENT
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.taylor.recurrences.rewrite import NotSmooth
from fastdyn.kernels.algebra.elimination_structure import MOST_PRODUCTS, structure
from fastdyn.kernels.ensemble import events_and_folds
from fastdyn.kernels.jit.options import INLINED, njit
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.method import Derivatives
from fastdyn.kernels.state.lane_fields import N_FIELDS
from fastdyn.kernels.state.layout import Form

from .in_lanes import check_length, linked, texts_of
from .scalar import FUNCTION, module_of
from .signatures import ADVANCE_VECTORS
from .vector_rhs import named, number, right_hand_side

JACOBIAN = "fastdyn_jacobian"  # symbol of the Jacobian's code
PHASES = "fastdyn_phases"  # of the phases of an event, with the event's number


class Kernel(NamedTuple):
    """A stepping kernel on vectors; `n_words` is the length of its block behind FIRST.

    `parameters` has a list of (type, value) for each function.  If `watches`, the kernel detects
    events; if `accumulates`, the kernel updates the folds.
    """

    address: int
    width: int
    n_words: int
    parameters: list
    keepalive: list
    watches: bool
    accumulates: bool


@njit(**INLINED)
def _accumulate(*given):
    """`events_and_folds.accumulate`; the result False means no event, as of `crossed`."""
    events_and_folds.accumulate(*given)
    return False


def _in_turn(each, functions, row, n_rows=1):
    """The function that `lanes.adaptive` calls after a step; None without functions.

    The function calls those of `each` for each of `functions`, with the rows from `row` on,
    `n_rows` for each, and returns the "or" of the results.
    """
    together = None
    for i, (one, function) in enumerate(zip(each, functions, strict=True)):
        together = _with_another(together, one, function, row + n_rows * i)
    return together


def _watched(functions, inside, fast):
    """The function that tells in which lanes an event may have occurred; None without functions.

    `inside` has, for each function, whether its crossings within a step count; `fast` the function
    of its phases, and their kinds, or None.
    """
    crossed = events_and_folds.crossed, events_and_folds.crossed_inside
    each = [crossed[one] for one in inside]
    each = [one if of is None else events_and_folds.or_fast(one, *of)
            for one, of in zip(each, fast, strict=True)]  # fmt: skip
    return _in_turn(each, functions, N_FIELDS, 2)


def _with_another(before, one, function, row):
    @njit(**INLINED)
    def last(form, t, y, lanes_in, block, many):
        return one(function, row, form, t, y, lanes_in, block, many)

    if before is None:
        return last

    @njit(**INLINED)
    def together(form, t, y, lanes_in, block, many):
        others = before(form, t, y, lanes_in, block, many)
        return others | last(form, t, y, lanes_in, block, many)

    return together


def _fast(i, kinds):
    """The phases of event i, as `_watched` takes them."""
    n_periodic, n_transitions, _ = kinds
    n_phases = sum(kinds)
    function = number(named(f"{PHASES}{i}", n_phases))
    return function, n_periodic + n_transitions, n_periodic, n_phases


def _check_elimination(jacobian, n, mass):
    rows, columns = mass or ((), ())
    places = zip([*jacobian.rows, *rows], [*jacobian.columns, *columns], strict=True)
    if structure(places, n).n_products > MOST_PRODUCTS:
        raise Uncompilable(
            f"the elimination for {n} equations has more than {MOST_PRODUCTS} products"
        )


def _derivatives(jacobian, mass):
    function = right_hand_side(named(JACOBIAN, jacobian.size))
    return Derivatives(function, jacobian.rows, jacobian.columns, not jacobian.autonomous, mass)


def kernel(name, fun, args, varying, mode, n, near, extrema, between=((), ()), mass=None):
    """The stepping kernel of a method for n vectors, with `fun` inlined.

    Parameters
    ----------
    name : str
        The name of the method.
    fun, args : callable, tuple
    varying : tuple of bool
        True for each of `args` that differs between trajectories.
    mode : compile.mode.Mode
    n : int
        Length of the state.
    near : traced.make.Near
        The start, the end and a state of the solves.
    extrema : bool
        Whether the kernel also finds the extrema of the state.
    between : pair of sequences
        Events and folds.  An event is a function of (t, y), and whether its crossings within a step
        count; a fold is a function of (t, [value, y]).  The functions return one number.
    mass : pair of lists of int, optional
        The rows and the columns of the elements of a mass matrix.

    Returns
    -------
    Kernel

    Raises
    ------
    Uncompilable
        If a function has no form on vectors; the exception states the reason.
    """
    method = METHODS[name].code
    if method.lane_kernel is None:
        raise Uncompilable(f"the steps of {name} are not written for vectors")
    check_length(n)
    events, folds = between
    inside = [each for _, each in events]
    if any(inside) and mass is not None:
        raise Uncompilable("slopes of equations with a mass matrix are not those of the state")
    functions = [(fun, mode, n // 2 if mode.second_order else n)]
    functions += [(event, EVENT, n) for event, _ in events]
    functions += [(fold, EVENT, n + 1) for fold in folds]
    forms = [
        vector_form(function, args, varying, how, length, near, width())
        for function, how, length in functions
    ]
    if any(form.raises for form in forms[1 + len(events) :]):
        raise Uncompilable("a fold can raise an exception, which vectors do not notice")
    derived = None
    if METHODS[name].n_matrices:
        derived = forms[0].jacobian(METHODS[name].by_time)
        _check_elimination(derived[0], n, mass)
    found = [form.phases() for form in forms[1 : 1 + len(events)]]
    kinds = [each[1:] if one and of else None
             for one, (each, of) in zip(inside, found, strict=True)]  # fmt: skip
    keys = [form.key for form in forms]
    key = f"lanes {name} {n} {width()} {extrema} {inside} {mass} {keys}"
    symbols = [f"{FUNCTION}{i}" for i in range(len(forms))]
    texts, begins = texts_of(symbols, forms)
    for i, (_, text) in enumerate(found):
        if kinds[i]:
            texts[f"{PHASES}{i}"] = functools.partial(text, skip=begins[i + 1])
    shapes = [form.n_results for form in forms]
    structure = None
    if derived is not None:
        jacobian, texts[JACOBIAN] = derived
        structure = (
            *(list(map(int, places)) for places in (jacobian.rows, jacobian.columns)),
            jacobian.autonomous,
            mass,
        )

    def build():
        user, *others = [named(*each) for each in zip(symbols, shapes, strict=True)]
        numbers = [number(function) for function in others]
        fast = [of and _fast(i, of) for i, of in enumerate(kinds)]
        watched = _watched(numbers[: len(events)], inside, fast)
        summed = numbers[len(events) :]
        accumulated = _in_turn([_accumulate] * len(summed), summed, N_FIELDS + 2 * len(events))
        given = [extrema or None, watched, accumulated]
        if derived is not None:
            given.append(_derivatives(derived[0], mass))
        kernel = method.lane_kernel(right_hand_side(user), Form(n, width()), *given)
        return kernel, ADVANCE_VECTORS

    place = f"waits {name} {n} {width()} {extrema} {inside} {kinds} {shapes} {structure}"
    compiled = linked(key, place, texts, build, module_of(METHODS[name]), "specialise.vector")
    keepalive, parameters = [compiled, forms], [form.parameters for form in forms]
    watches, accumulates = bool(events), bool(folds)
    return Kernel(
        compiled.address, width(), begins[-1], parameters, keepalive, watches, accumulates
    )


def series_kernel(order, fun, args, varying, mode, n, near, extrema, between=((), ())):
    """The kernel of the Taylor method of an order, without extrema, events and folds in lanes."""
    if extrema or any(between):
        raise Uncompilable("Taylor takes extrema, events and folds one trajectory at a time")
    check_length(n)
    form = vector_form(fun, args, varying, mode, n, near, width())
    try:
        code = form.series(order)
    except NotSmooth as reason:
        raise Uncompilable(str(reason)) from None
    return Kernel(
        code.address, width(), form.n_words, [form.parameters], [code, form], False, False
    )
