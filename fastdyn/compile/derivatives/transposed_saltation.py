"""Compiles the passage of derivatives back over an event: the transposed saltation matrix.

The derivatives k by the state behind an event, and c by the event's time, become

    k dR/dy + s dg/dy,   s = -(k (dR/dy f + dR/dt - f+) + c) / (dg/dt + dg/dy f),

by the state before it, and so for the parameters: see `sensitivities.py` for R, g, f, f+.  An event
that does not act has R(t, y) = y, and k by its own state, at its moving time: without f+.  The time
of a schedule is fixed: s = 0.
"""

import numpy as np

from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.graph.reverse import pullback

from ..callables import Uncompilable
from ..mode import DERIVATIVE, VJP
from ..traced.known import Attempt
from ..traced.make import Near, traced_function
from .crossings import crossing_number
from .sensitivities import slots_of
from .vjp import NOT_TRACED, Product, frozen


def bind_transposed(saltation, args, near, positions):
    """The vjp.Product of an event, called ``(t, [y, ..., k, c])``: see `places`.

    Parameters
    ----------
    saltation : problem.sensitivities.Saltation
    args : tuple
    near : traced.make.Near
        The region of the state.
    positions : tuple of int
        Those of the differentiated arguments, from 1.

    Raises
    ------
    Uncompilable
        If a function has no trace, or a derivative is missing.
    """
    n, size = saltation.n, saltation.n_together()
    longer = Near(near.t0, near.tf, np.r_[near.y0, np.zeros(size - n)])
    attempt = Attempt(saltation.together(), args, DERIVATIVE, size, sorted(positions))
    found = traced_function(attempt, longer)
    if found is None:
        raise Uncompilable(attempt.why() or NOT_TRACED)
    base, values, at = found
    groups = tuple([at[j - 1] for j in positions])
    kind = saltation.event is None, saltation.jump is None
    try:
        function = base.derived(
            (VJP, "event", groups, kind), lambda: _transposed(base, groups, n, *kind)
        )
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    m = function.traced.n_stored - n
    return Product(frozen(function, None, values, VJP, size + n + 1, at), n, m, positions)


def _transposed(base, groups, n, scheduled, passive):
    traced = base.traced
    g = base.traced.trace.graph
    size = traced.n_stored
    stored = traced.stored
    slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, size)]
    k = [g.make("y", (), size + i) for i in range(n)]
    inputs = [g.make("y", (), i) for i in range(n)] + [g.make("par", (), slot) for slot in slots]
    time = g.make("t")
    if passive:
        rate = stored[:n]
        behind = []
        by = [*k, *[g.const(0.0)] * len(slots)]
        by_time = g.const(0.0)
    else:
        rate = stored[n : 2 * n]
        behind = stored[2 * n : 3 * n]
        *by, by_time = pullback(g, stored[:n], k, [*inputs, time])
    if not scheduled:
        crossed = [crossing_number(g, stored[-1], rate)]
        *slope, drift = pullback(g, crossed, [g.const(1.0)], [*inputs, time])
        total = [by_time, g.make("y", (), size + n), *_products(g, by, rate)]
        total += [g.neg(each) for each in _products(g, k, behind)]
        crossing = g.sum([drift, *_products(g, slope, rate)])
        later = g.neg(g.div(g.sum(total), crossing))
        by = [g.add(own, g.mul(later, each)) for own, each in zip(by, slope, strict=True)]
    return traced.with_outputs(by, VJP, size + n + 1, g.false).compiled()


def _products(graph, row, rate):
    """The terms of the product of a row, which may be longer, and a column."""
    return [graph.mul(*each) for each in zip(row, rate, strict=False)]
