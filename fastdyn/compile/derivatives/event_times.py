"""Derivatives of the times of events: g(t, y(t, p), p) = 0 differentiated along the solution.

And derivatives of functions in numbers.
"""

import numpy as np

from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat

from ..mode import EVENT
from ..traced.known import Attempt
from ..traced.make import traced_function
from .crossings import crossing_number
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
    found = slopes(event, args, EVENT, near, directions, t, y, rate)
    if found is None:
        return None
    (by_input,) = found
    crossing = by_input.pop("t", 0.0)
    moved = np.zeros(s.shape[1:])
    for (kind, i), gradient in by_input.items():
        if kind == "y":
            crossing = crossing + gradient * rate[i]
            moved += gradient * s[i]
        else:
            moved[i] += gradient
    with np.errstate(all="ignore"):
        return -moved / crossing


def slopes(fun, args, mode, near, directions, t, y, rate=None):
    """The derivatives of each result at k times and states (n, k), as a dict by the inputs.

    The inputs are "t", ("y", component) and ("parameter", direction); the values have shape (k,),
    and zeros are left out.  None if the function cannot be traced or differentiated.  With
    the `rate` of the state, those of an event function are those of its `crossing_number`.
    """
    attempt = Attempt(fun, args, mode, len(near.y0), sorted({j for j in directions if j}))
    found = traced_function(attempt, near)
    if found is None:
        return None
    function, values, at = found
    groups = tuple([at[j - 1] if j else None for j in directions])
    try:
        rows = function.derived(
            ("gradient", groups, rate is None),
            lambda: _gradient(function.traced, groups, len(near.y0), rate is not None),
        )
    except Untraceable:
        return None
    graph = function.traced.trace.graph
    numbers = flat([value for _, value in values])
    nodes = [node for row in rows for node in row.values()]
    y = y if rate is None else np.concatenate([y, rate])
    each = iter(evaluate(graph, nodes, t, y, numbers)[0])
    return [{name: next(each) for name in row} for row in rows]


def _gradient(traced, groups, n, crosses):
    """The nodes of the derivatives of each result of a function, by the inputs of `slopes`.

    Of an event that `crosses`, behind the state stands its rate.
    """
    graph = traced.trace.graph
    results = traced.stored
    if crosses:
        rates = [graph.make("y", (), n + i) for i in range(n)]
        results = [crossing_number(graph, results[0], rates)]
    inputs = {"t": graph.make("t"), **{("y", i): graph.make("y", (), i) for i in range(n)}}
    slots = [slot for group in groups for slot in slots_of(traced.trace.reads, group, n)]
    for j, slot in enumerate(slots):
        if slot is not None:
            inputs["parameter", j] = graph.make("par", (), slot)
    names = list(inputs)
    found = partials(graph, results, list(inputs.values()))
    return [{names[i]: node for i, node in row.items()} for row in found]
