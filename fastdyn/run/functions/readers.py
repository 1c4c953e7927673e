"""Readers of the values of one solve by a ReadyRun: its state, and what its functions use."""

import struct

import numpy as np

from fastdyn.compile.bind import rebind
from fastdyn.compile.callables import EMPTY, codes
from fastdyn.compile.traced.known import known_trace, left_of
from fastdyn.compile.traced.make import made

NUMBERS, FLOAT, ARRAY = {float, int, np.float64}, np.dtype(float), np.ndarray


def reader_of(problem, bound, fun, args):
    """``read(fun, args, block)`` of a Bound, whose result is None if the values need other code."""
    if bound.callback is not None:
        return reader_in_python(bound, fun, args)
    p, mode, n, varying = problem, bound.mode, bound.n, ()
    if mode.constant:
        return lambda fun, args, block: ()
    if mode.sensitivities:  # the trace is that of the equations without sensitivities
        mode, n, varying = p.fun.mode, p.fun.n, p.fun.positions()
    elif not made(bound.function):  # Numba's code
        return lambda fun, args, block: rebind(bound, fun, args) or None
    known = known_trace(fun, args, mode, n, varying, bound.function.in_batches)
    if known is None:
        return lambda fun, args, block: None
    return known[0].read


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


def is_left(problem, bounds, functions, args):
    """Whether one of the functions was left to Python, where its compiled code is bound."""
    pairs = zip(bounds, functions, strict=True)
    found = [(f, b.mode) for b, f in pairs if b.callback is None]
    if problem.mode.sensitivities:
        found.append((functions[0], problem.fun.mode))
    return any(left_of(f, args, mode)[0] for f, mode in found)


def state_writer(room, n, sizes):
    """``take(y0)``, which writes n numbers to `room`; False if the state needs the long way."""
    shape, pack, state = (n,), struct.Struct(f"{n}d").pack_into, room[:n]
    words = memoryview(room).cast("B")  # gives its address in a third of an array's time
    least, most = sizes or (0.0, 0.0)

    def take(y0):
        kind = y0.__class__
        try:
            if kind is list or kind is tuple:
                for number in y0:  # twice as fast as a set of types
                    if number.__class__ is not float and number.__class__ not in NUMBERS:
                        return False
                pack(words, 0, *y0)
            elif kind is ARRAY and y0.dtype.kind in "if" and y0.shape == shape:
                state[...] = y0
            else:
                return False
        except (struct.error, ValueError):  # a number beyond all floats; numbers not aligned
            return False
        return not most or least <= max(map(abs, state)) <= most

    return take
