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
    """The constant delays, in rising order, and whether other delays vary."""

    constant: tuple
    varying: bool


def delays_of(bound, t0, y0):
    """The Delays of a Bound by its trace; None if the function has no trace."""
    function = bound.function
    if function is None or function.traced is None or function.traced.in_batches:
        return None
    times, fixed = function.derived("delays", lambda: _times(function.traced))
    graph = function.traced.trace.graph
    t = np.array([t0])
    values, _ = evaluate(graph, times, t, y0[:, None], flat(bound.given))
    constant = {float(t0 - v) for (v,), is_fixed in zip(values, fixed, strict=True) if is_fixed}
    return Delays(tuple(sorted(constant)), not all(fixed))


def _times(traced):
    """The times at which a trace reads the past, and whether each follows t at a fixed distance."""
    graph = traced.trace.graph
    nodes = [node for node in live([*traced.stored, traced.trace.raising]) if node.op == "past"]
    times = list({node.args[0].key: node.args[0] for node in nodes}.values())
    inputs = [graph.make("t"), *[graph.make("y", (), i) for i in range(traced.n)]]
    fixed = []
    for time in times:
        try:
            (found,) = partials(graph, [time], inputs)
        except Untraceable:
            found = {}
        alone = set(found) == {0} and found[0].op == "const"
        fixed.append(alone and found[0].data == 1.0)
    return times, fixed


def followed(starts, delays, t0, tf, order):
    """The times in (t0, tf) at which a derivative up to `order` jumps.

    Each of `starts` is a jump of a low derivative; a delay carries a jump on, one derivative
    higher each time.

    Raises
    ------
    ValueError
        If there are more than MOST_POINTS.
    """
    points = new = np.unique(np.asarray(starts, float))
    for _ in range(order):
        new = _merged(np.add.outer(new, np.asarray(delays, float)).ravel())
        new = new[new < tf]
        points = _merged(np.concatenate([points, new]))
        if len(points) > MOST_POINTS:
            raise ValueError(
                f"the delays {delays} carry jumps to more than {MOST_POINTS} times within the span:"
                " give `order=` a smaller number, to which jumps are followed."
            )
        if not len(new):
            break
    return points[(points > t0) & (points < tf)]


def _merged(points):
    points = np.sort(points)
    if not len(points):
        return points
    apart = np.diff(points) > MERGED * np.maximum(np.abs(points[1:]), np.abs(points[:-1]))
    return points[np.r_[True, apart]]
