"""Compiles the product of a row vector k and the Jacobians of the equations: k df/dy, k df/dp.

The product is called like the function, ``vjp(t, [y, k], 2 n, block, out)``, with the block of the
function.  It adds n numbers, k df/dy, and m numbers, k df/dp, to `out`: the second part is the
gradient, which the steps of a backward sweep sum.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.trace.graph.expressions import MAX_NODES
from fastdyn.trace.graph.jumps import decisions
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.graph.reverse import pullback

from ..callables import Uncompilable
from ..functions import with_code
from ..mode import DERIVATIVE, VJP
from ..traced.known import why
from ..traced.make import LONG, traced_function
from .sensitivities import DECISIONS, slots_of

NOT_TRACED = "it cannot be traced"
TOO_LONG = (
    f"it cannot be traced number by number, in at most {MAX_NODES} operations, as derivatives of "
    "long arrays must be"
)


class Product(NamedTuple):
    """The vjp of a function with the values of one solve.

    `bound` is a Bound of the vjp, `n` and `m` are the numbers of its results; `positions` are those
    of the differentiated arguments.
    """

    bound: Any
    n: int
    m: int
    positions: tuple


def bind_vjp(fun, args, near, positions):
    """The Product of ``fun(t, y, *args)`` by y, and by the arguments at `positions`, from 1.

    The Product keeps copies of all outside values: no later change of an array changes it.

    Raises
    ------
    Uncompilable
        If `fun` has no trace, or a derivative is missing.
    """
    n, varying = len(near.y0), tuple(sorted(positions))
    found = traced_function(fun, args, DERIVATIVE, n, near, varying)
    if found is None:
        raise Uncompilable(
            why(fun, args, DERIVATIVE, n, varying) or (NOT_TRACED if n < LONG else TOO_LONG)
        )
    base, values, at = found
    groups = tuple([at[j - 1] for j in positions])
    try:
        function = base.derived((VJP, groups), lambda: _vjp(base, groups, n))
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    m = function.traced.n_stored - n
    bound = frozen(function, None, values, VJP, 2 * n, at)
    return Product(bound, n, m, tuple(positions))


def frozen(function, python, values, mode, n, at=()):
    """A Bound with copies of its (type, value) pairs."""
    copies = [(kind, np.array(v) if isinstance(v, np.ndarray) else v) for kind, v in values]
    return with_code(function, python, [None, ()], copies, mode, n, at)


def _vjp(base, groups, n):
    traced, g = base.traced, base.traced.trace.graph
    slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, n)]
    cotangents = [g.make("y", (), n + i) for i in range(n)]
    inputs = [g.make("y", (), i) for i in range(n)]
    inputs += [g.make("par", (), slot) for slot in slots]
    outputs = pullback(g, traced.stored, cotangents, inputs)
    function = traced.with_outputs(outputs, VJP, 2 * n, g.false).compiled()
    own = traced.trace._replace(outputs=traced.stored)
    function.notes[DECISIONS] = own, decisions(own.graph, own.outputs, set(slots))
    return function
