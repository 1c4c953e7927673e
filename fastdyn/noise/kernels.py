"""The loop over paths for given functions: with their code inside, or by their addresses.

This file imports Numba.  A solve imports this file only if a kernel is not on disk yet.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.algebra.elimination_in_lanes import make_product
from fastdyn.kernels.calls.user_function import call_function
from fastdyn.kernels.jit.options import INLINED, njit
from fastdyn.kernels.noise import arguments, diffusions, loop, passages, steps
from fastdyn.kernels.random.normal import everywhere
from fastdyn.kernels.state.elementwise import apply
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.state.rows import scratch, vector_at
from fastdyn.specialise.signatures import ROW, TABLE, WORDS, kernel_of
from fastdyn.specialise.vector_rhs import named, number

one_number = scratch(1)
RUNS = np.empty(0, arguments.RUN)
ADVANCE = kernel_of(
    RUNS, WORDS, TABLE, TABLE, TABLE, arguments.Places(ROW, TABLE, TABLE, ROW, TABLE)
)


class Functions(NamedTuple):
    """The functions that a step calls, see `fastdyn.kernels.noise.steps`."""

    drift: Any
    diffusion: Any
    spread: Any
    along: Any
    one_source: bool
    ito: bool


def build(plan, functions, events, forms, width):
    """The dispatcher and the signature of the loop of a Plan."""
    method = plan.method
    start = loop.first_acceleration(functions.drift) if method.langevin else loop.no_acceleration
    looks = [
        passages.passage(event, functions.spread, i, forms[2], terminal)
        for i, (event, terminal) in enumerate(zip(events, plan.terminal, strict=True))
    ]
    step = getattr(steps, method.step)(functions)
    look = passages.in_turn(looks)
    stops = any(plan.terminal)
    return loop.kernel(step, start, forms, width, method.areas, look, stops), ADVANCE


def _spread(plan, columns):
    """G(t, y) w of the columns; None for Langevin's equation, whose noise is part of the step."""
    if plan.method.langevin:
        return None
    return diffusions.diagonal(columns[0]) if plan.diagonal else diffusions.columns(columns)


def in_lanes(plan, symbols, sizes, slope, width):
    """The loop on vectors, in which LLVM links the functions of `symbols`.

    `symbols` are drift, columns and events; `sizes` has the words of the parameters of each.
    `slope` is None, or (symbol, number of entries, rows, columns) of the Jacobian of the diffusion.
    """
    n = plan.n_drift
    lanes = Form(1, width)
    vectors = []
    for i, symbol in enumerate(symbols):
        is_event = i >= len(symbols) - len(plan.terminal)
        vectors.append(number(named(symbol, None if is_event else n), sum(sizes[:i])))
    n_events = len(plan.terminal)
    last = len(vectors) - n_events
    drift, *columns = [_at_one_time(f, lanes) for f in vectors[:last]]
    events = [_number_at_one_time(f, lanes) for f in vectors[last:]]
    along = None
    if slope is not None:
        symbol, size, rows, places = slope
        of_block = number(named(symbol, size), sizes[0])
        along = _along(_at_one_time(of_block, lanes), make_product(rows, places))
    functions = Functions(
        drift, columns[0] if columns else None, _spread(plan, columns), along,
        not plan.diagonal, plan.ito,
    )  # fmt: skip
    forms = Form(plan.n, width), Form(plan.n_sources, width), lanes
    return build(plan, functions, events, forms, width)


def _at_one_time(function, lanes):
    @njit(**INLINED)
    def rhs(t, y, block, out):
        return function(everywhere(lanes, t), y, block)

    return rhs


def _number_at_one_time(function, lanes):
    @njit(**INLINED)
    def number(t, y, block):
        return function(everywhere(lanes, t), y, block)

    return number


@njit(**INLINED)
def _zero(g):
    return (0.0 * g,)


def _along(entries, multiply):
    """g dg/dy, the derivative of the diffusion along itself."""

    @njit(**INLINED)
    def along(t, y, g, block):
        zero = apply(_zero, (None,), (), (g,))[0]
        return multiply(entries(t, y, block, None), g, zero)

    return along


def by_address(plan):
    """The loop on rows, for one path at a time, of functions that the block names."""
    lanes = Form(1, 1)
    n_columns = plan.n_columns
    drift = _of_block(0)
    columns = [_of_block(1 + j) for j in range(n_columns)]
    events = [_number_of_block(1 + n_columns + j, lanes) for j in range(len(plan.terminal))]
    functions = Functions(
        drift, columns[0] if columns else None, _spread(plan, columns), None, not plan.diagonal,
        plan.ito,
    )  # fmt: skip
    return build(plan, functions, events, (None, None, lanes), 1)


def _of_block(i):
    @njit(**INLINED)
    def function(t, y, block, out):
        call_function(block[i], t, y, out)
        return out

    return function


def _number_of_block(i, lanes):
    @njit(**INLINED)
    def number(t, y, block):
        out = one_number()
        call_function(block[i], t, y, out)
        return vector_at(lanes, out, 0)

    return number
