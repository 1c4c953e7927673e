"""Readers of the values of one solve by a ReadyRun: its state, and what its functions use."""

from typing import Any

import numpy as np

from fastdyn.compile.bind import rebind
from fastdyn.compile.callables import EMPTY, codes
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import made
from fastdyn.problem.second_order_and_pairs import form_reader

NUMBERS, FLOAT, ARRAY = {float, int, np.float64}, np.dtype(float), np.ndarray
COMPLEX_NUMBERS = {complex, np.complex128}


def reader_of(run, bound, fun, args):
    """``read(fun, args, block)`` of a Bound, whose result is None if the values do not suit.

    Raises
    ------
    Uncompilable
        The equations have to be looked at in each solve, or no trace of them is known.
    """
    read = _reader(run.problem, bound, fun, args)
    if bound.mode.second_order:
        read = _of_the_form(read, fun, args, 2 * bound.n)
    suits = run.suits
    if suits is None or bound is not run.bounds[0]:
        return read

    def suited(fun, args, block):
        values = read(fun, args, block)
        return values if values is not None and suits(values) else None

    return suited


def _reader(problem, bound, fun, args):
    if bound.callback is not None:
        return reader_in_python(bound, fun, args)
    p, mode, n, varying = problem, bound.mode, bound.n, ()
    if mode.sensitivities:  # the trace is that of the equations without sensitivities
        mode, n, varying = p.fun.mode, p.fun.n, p.fun.positions()
    elif not made(bound.function):  # Numba's code
        return lambda fun, args, block: rebind(bound, fun, args) or None
    known = Attempt(fun, args, mode, n, varying).known(bound.function.in_batches)
    if known is None:
        raise Uncompilable("its trace is no longer known")
    return known[0].read


def _of_the_form(read, fun, args, n):
    """The reader of equations that need the form q'' = a(t, q), whichever values they have."""
    has_form = form_reader(fun, args, n)
    if has_form is None:
        raise Uncompilable("its form is looked at in each solve")

    def read_both(fun, args, block):
        return None if has_form(fun, args) is None else read(fun, args, block)

    return read_both


def reader_in_python(bound, fun, args):
    """``read(fun, args, block)`` of a Bound that runs in Python, for functions of one kind.

    Another function of the same code, or arguments of other types, may have compiled code.
    """
    held, kind = bound.held, kind_of(fun, args)

    def read(fun, args, block):
        if kind_of(fun, args) != kind:
            return None
        held.take(fun, args)
        return ()

    return read


def kind_of(fun, args):
    """What decides, but for values, whether a function can be compiled."""
    cells = getattr(fun, "__closure__", None) or ()
    inner = [type(cell.cell_contents) for cell in cells if cell != EMPTY]
    return codes(fun, args), [type(fun), *inner, *map(type, args)]


def together(readers, switch=None) -> Any:
    """``read(fun, args, block)`` and the block; ``read(fun, args, events)`` and None for many.

    `readers` are those of all functions, each with its block.  ``switch(held)`` follows the
    reading: `held` are the values of all functions, which live until the kernel ends.
    """
    (first, own), *others = readers
    if switch is None and not others:
        return first, own

    def read_both(fun, args, events):
        held = first(fun, args, own)
        found = None if held is None else second(events[0], args, other)
        return None if found is None else (held, found)

    def read_all(fun, args, events):
        held = []
        for function, (read, block) in zip((fun, *events), readers, strict=True):
            found = read(function, args, block)
            if found is None:
                return None
            held.append(found)
        if switch is not None:
            switch(held)
        return held

    if switch is not None or len(others) > 1:
        return read_all, None
    ((second, other),) = others
    return read_both, None


def is_left(problem, bounds, functions, args):
    """Whether one of the functions was left to Python, where its compiled code is bound."""
    pairs = zip(bounds, functions, strict=True)
    found = [Attempt(f, args, b.mode, b.n) for b, f in pairs if b.callback is None]
    if problem.mode.sensitivities:
        found.append(Attempt(functions[0], args, problem.fun.mode, problem.fun.n))
    return any(attempt.left.reason for attempt in found)


def taken_from(y0, state, in_pairs=False):
    """Write an array of numbers to a state; False if it needs the long way.

    A state of complex numbers `in_pairs` takes a list, too.
    """
    if in_pairs:
        return _pairs_taken_from(y0, state)
    if y0.__class__ is not ARRAY or y0.dtype.kind not in "if" or y0.shape != state.shape:
        return False
    try:
        state[...] = y0
    except ValueError:  # numbers that are not aligned
        return False
    return True


def has_complex(y0):
    """Whether a state, a list or an array, has complex numbers."""
    if y0.__class__ is ARRAY:
        return y0.dtype.kind == "c"
    known = y0.__class__ is list or y0.__class__ is tuple
    return known and not COMPLEX_NUMBERS.isdisjoint(map(type, y0))


def _pairs_taken_from(y0, state):
    kind = y0.__class__
    if kind is ARRAY:
        if y0.dtype != complex or y0.ndim != 1:
            return False
    elif kind is not list and kind is not tuple:
        return False
    elif not has_complex(y0) or not {*map(type, y0)} <= COMPLEX_NUMBERS | NUMBERS:
        return False
    if 2 * len(y0) != len(state):
        return False
    try:
        state.view(complex)[...] = y0
    except (OverflowError, ValueError):  # beyond all floats, or not aligned
        return False
    return True
