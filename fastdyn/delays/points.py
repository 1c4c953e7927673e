"""The delays of a traced function, and the points at which a derivative of the solution jumps."""

from typing import NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat

MERGED = 16.0 * np.finfo(float).eps  # points closer than their roundings are one point
MOST_POINTS = 2**17  # followed points; k delays to order p have up to C(k + p, p)


class Delays(NamedTuple):
    """The constant delays in rising order, whether other delays vary, and the neutral ones.

    A neutral delay is a constant one at which the derivative is read; `derivatives` tells whether
    the derivative is read at any delay.
    """

    constant: tuple
    varying: bool
    neutral: tuple = ()
    derivatives: bool = False


def delays_of(bound, t0, y0):
    """The Delays of a Bound by its trace; None if the function has no trace."""
    function = bound.function
    if function is None or function.traced is None or function.traced.in_batches:
        return None
    times, fixed, orders = function.derived("delays", lambda: _times(function.traced))
    graph = function.traced.trace.graph
    t = np.array([t0])
    values, _ = evaluate(graph, times, t, y0[:, None], flat(bound.given))
    found = [
        (float(t0 - v), order)
        for (v,), is_fixed, order in zip(values, fixed, orders, strict=True) if is_fixed
    ]  # fmt: skip
    constant = {tau for tau, _ in found}
    neutral = {tau for tau, order in found if order}
    return Delays(tuple(sorted(constant)), not all(fixed), tuple(sorted(neutral)), any(orders))


def _times(traced):
    """The times at which a trace reads the past, whether each is at a fixed distance, and orders.

    The order of a time is 1 if the derivative is read, else 0.
    """
    graph = traced.trace.graph
    nodes = [node for node in live([*traced.stored, traced.trace.raising]) if node.op == "past"]
    times = list({node.args[0].key: node.args[0] for node in nodes}.values())
    orders = [max(n.data[2] for n in nodes if n.args[0] is time) for time in times]
    inputs = [graph.make("t"), *[graph.make("y", (), i) for i in range(traced.n)]]
    fixed = []
    for time in times:
        try:
            (found,) = partials(graph, [time], inputs)
        except Untraceable:
            found = {}
        alone = set(found) == {0} and found[0].op == "const"
        fixed.append(alone and found[0].data == 1.0)
    return times, fixed, orders


def followed(starts, delays, t0, tf, order, neutral=()):
    """The times in (t0, tf) at which a derivative up to `order` jumps.

    Each of `starts` is a jump of a low derivative; a delay carries a jump on, one derivative
    higher each time; a `neutral` one carries the derivative itself on, to the end of the span.

    Raises
    ------
    ValueError
        If there are more than MOST_POINTS.
    """
    new = np.unique(np.asarray(starts, float))
    points = new = _repeated(new, neutral, tf)
    for _ in range(order):
        new = _repeated(_carried(new, delays, tf), neutral, tf)
        points = _few(_merged(np.concatenate([points, new])), delays)
        if not len(new):
            break
    return points[(points > t0) & (points < tf)]


def _carried(points, delays, tf):
    """The points one delay later, before tf."""
    later = _merged(np.add.outer(points, np.asarray(delays, float)).ravel())
    return later[later < tf]


def _repeated(points, neutral, tf):
    """The points, and all that neutral delays make of them before tf."""
    new = points
    while neutral and len(new):
        known = points
        points = _few(_merged(np.concatenate([points, _carried(new, neutral, tf)])), neutral)
        at = np.searchsorted(known, points)
        near = np.minimum(at, len(known) - 1)
        new = points[(at == len(known)) | (known[near] != points)]
    return points


def _few(points, delays):
    if len(points) > MOST_POINTS:
        raise ValueError(
            f"the delays {delays} carry jumps to more than {MOST_POINTS} times within the span: "
            "end the span earlier, or give jumps that are followed by `delays=`."
        )
    return points


def _merged(points):
    points = np.sort(points)
    if not len(points):
        return points
    apart = np.diff(points) > MERGED * np.maximum(np.abs(points[1:]), np.abs(points[:-1]))
    return points[np.r_[True, apart]]
