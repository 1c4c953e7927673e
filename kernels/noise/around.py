"""The loop over paths around given functions: on vectors, or on rows by the functions' addresses.

`plan` has the facts of a problem, see `fastdyn/noise/plan.py`.
"""

from typing import Any, NamedTuple

from ..algebra.elimination_in_lanes import make_product
from ..calls.user_function import call_function
from ..jit.options import INLINED, njit
from ..random.normal import everywhere
from ..state.elementwise import apply
from ..state.layout import Form
from ..state.rows import scratch, vector_at
from . import diffusions, loop, passages, steps

one_number = scratch(1)


class Functions(NamedTuple):
    """The functions that a step calls, see `steps.py`."""

    drift: Any
    diffusion: Any
    spread: Any
    along: Any
    one_source: bool
    ito: bool


def _around(plan, drift, columns, along, events, forms, width):
    """The loop of a plan around functions ``f(t, y, block, out)`` and events."""
    method = plan.method
    spread = None  # of Langevin's equation, whose noise is part of the step
    if not method.langevin:
        spread = diffusions.diagonal(columns[0]) if plan.diagonal else diffusions.columns(columns)
    diffusion = columns[0] if columns else None
    functions = Functions(drift, diffusion, spread, along, not plan.diagonal, plan.ito)
    start = loop.first_acceleration(drift) if method.langevin else loop.no_acceleration
    watched = [(event, spread, i, forms[2]) for i, event in enumerate(events)]
    in_order = spread is not None and plan.n_sources == 1 and len(events) > 1
    look = passages.in_turn([passages.passage(*each, in_order) for each in watched])
    settle = passages.settled(plan.terminal, in_order) if watched else None
    ends = [each for each, ends in zip(watched, plan.terminal, strict=True) if ends]
    leave = passages.ends_in_turn([passages.end(*each, forms[0] is None) for each in ends])
    step = getattr(steps, method.step)(functions)
    return loop.kernel(step, start, forms, width, method.areas, look, settle, leave)


def in_lanes(plan, functions, slope, width):
    """The loop on vectors.

    Parameters
    ----------
    plan : Plan
    functions : list of callable
        ``f(t, y, block)`` of vectors: drift, columns of the diffusion, events.
    slope : None or (callable, list, list)
        The elements of the Jacobian of the diffusion, of the same form, their rows and columns.
    width : int
    """
    lanes = Form(1, width)
    n_others = len(functions) - len(plan.terminal)
    drift, *columns = [_at_one_time(f, lanes) for f in functions[:n_others]]
    events = [_number_at_one_time(f, lanes) for f in functions[n_others:]]
    along = None
    if slope is not None:
        elements, rows, places = slope
        along = _along(_at_one_time(elements, lanes), make_product(rows, places))
    forms = Form(plan.n, width), Form(plan.n_sources, width), lanes
    return _around(plan, drift, columns, along, events, forms, width)


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
    columns = [_of_block(1 + j) for j in range(n_columns)]
    events = [_number_of_block(1 + n_columns + j, lanes) for j in range(len(plan.terminal))]
    return _around(plan, _of_block(0), columns, None, events, (None, None, lanes), 1)


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
