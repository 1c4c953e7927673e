"""Derivatives of the times of events: g(t, y(t, p), p) = 0 differentiated along the solution."""

import numpy as np

from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat

from ..mode import EVENT
from ..traced.make import traced_function
from .sensitivities import slots_of


def time_derivatives(event, args, near, directions, occurrences):
    """The derivatives of an event's times, shape (m, k); None if g cannot be differentiated.

    They are -(dg/dy S + dg/dp) / (dg/dt + dg/dy f), which is inf or nan where g touches zero.

    Parameters
    ----------
    event : callable
    args : tuple
    near : traced.make.Near
        The region of the state, without sensitivities.
    directions : tuple of int
        As in `problem.sensitivities.Variational`.
    occurrences : tuple of ndarray
        Times (k,), states (n, k), their rates f (n, k), S before the event (n, m, k).
    """
    t, y, rate, s = occurrences
    positions = tuple(sorted({j for j in directions if j}))
    found = traced_function(event, args, EVENT, len(near.y0), near, positions)
    if found is None:
        return None
    function, values, at = found
    groups = tuple([at[j - 1] if j else None for j in directions])
    try:
        inputs, nodes = function.derived(
            ("gradient", groups), lambda: _gradient(function.traced, groups, len(near.y0))
        )
    except Untraceable:
        return None
    graph, numbers = function.traced.trace.graph, flat([value for _, value in values])
    by_input = dict(zip(inputs, evaluate(graph, nodes, t, y, numbers)[0], strict=True))
    crossing, moved = by_input.pop("t", 0.0), np.zeros(s.shape[1:])
    for (kind, i), gradient in by_input.items():
        if kind == "y":
            crossing = crossing + gradient * rate[i]
            moved += gradient * s[i]
        else:
            moved[i] += gradient
    with np.errstate(all="ignore"):
        return -moved / crossing


def _gradient(traced, groups, n):
    """The inputs on which an event depends, and the nodes of its derivatives by these inputs.

    The inputs are "t", ("y", component) and ("parameter", direction).
    """
    graph = traced.trace.graph
    inputs = {"t": graph.make("t"), **{("y", i): graph.make("y", (), i) for i in range(n)}}
    slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, n)]
    for j, slot in enumerate(slots):
        if slot is not None:
            inputs["parameter", j] = graph.make("par", (), slot)
    (row,) = partials(graph, traced.stored, list(inputs.values()))
    names = list(inputs)
    return [names[i] for i in row], list(row.values())
