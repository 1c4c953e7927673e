"""A graph beside its function: at the start, around it, and on each side of every decision."""

from typing import Any

import numpy as np

from .clock import look
from .evaluate import evaluate
from .graph import live
from .refusal import Untraceable

COUNT, CANDIDATES, ENOUGH = 16, 256, 3
TOLERANCE = 1e-9
SPREADS = np.array([0.01, 0.1, 0.5, 1.5, 10.0, 100.0])


def points(trace, t0, tf, y0, values):
    """The start, points near and far, and each that shows a new side of a decision."""
    rng = np.random.default_rng(0)
    n, k = len(y0), CANDIDATES
    decisions = [
        node.args[0] for node in live([*trace.outputs, trace.raising]) if node.op == "select"
    ]
    if not decisions:
        k = COUNT
    t = t0 + (tf - t0) * rng.random(k)
    sizes = np.sort(np.abs(y0))
    middle = float(sizes[(n - 1) // 2] + sizes[n // 2]) / 2 if n else 1.0  # the median
    size = np.maximum(np.abs(y0), 0.1 * max(1e-3, middle))
    each = np.arange(k)
    spread = np.where(each < COUNT, SPREADS[each % 4], SPREADS[each % 6])
    y = y0[:, None] + spread * size[:, None] * rng.standard_normal((n, k))
    positive = each % 3 == 2  # the signs of the start: concentrations, radii
    y[:, positive] = np.abs(y[:, positive]) * np.where(y0 < 0, -1.0, 1.0)[:, None]
    at_rest = (each % 7 == 3) & ~positive
    rest = np.where(each % 2, 0.0, 1.0) * y0[:, None]
    y = np.where(at_rest & (rng.random((n, k)) < 0.5), rest, y)
    small = (each % 7 == 5) & ~positive
    y = np.where(small, y * 10.0 ** rng.uniform(-12, 2, k), y)
    t[0], y[:, 0] = t0, y0
    chosen = list(range(COUNT))
    if decisions:
        sides = evaluate(trace.graph, [], t, y, values, decisions)[1].astype(bool)
        seen = {(row, side) for row, side in zip(*_sides(sides[:, :COUNT]), strict=True)}
        for i in range(COUNT, k):
            new = set(zip(*_sides(sides[:, i : i + 1]), strict=True)) - seen
            if new:
                seen |= new
                chosen.append(i)
    return t[chosen], np.ascontiguousarray(y[:, chosen].T)


def _sides(table):
    rows = np.arange(len(table))
    return np.repeat(rows, table.shape[1]), table.reshape(-1)


def verify(trace, function, compiled, t0, tf, y0, values) -> None:
    """Raise Untraceable unless both give the same.

    Parameters
    ----------
    trace : paths.Trace
    function : callable
        ``function(t, y)``, what the user wrote; an array of as many numbers as outputs.
    compiled : callable
        The same of the graph; None where it says that the function raises.
    t0, tf : float
    y0 : ndarray, shape (n,)
    values : sequence of float
        Of the parameters.
    """
    compared, failed = 0, "it gives no finite number near the start"
    for t, y in zip(*points(trace, t0, tf, np.asarray(y0, float), values), strict=True):
        look()
        mine = compiled(t, y)
        try:
            with np.errstate(all="ignore"):
                real: Any = function(float(t), y.copy())
        except Exception as error:
            if mine is not None:
                raise Untraceable(
                    f"it raises {type(error).__name__} where its graph does not"
                ) from error
            failed = f"{type(error).__name__}: {error}"
            continue
        if mine is None:
            raise Untraceable("its graph raises where it does not")
        if real.shape != mine.shape:
            raise Untraceable(f"it returns {real.size} numbers, not {mine.size}")
        finite = np.isfinite(real)
        if np.any(finite & ~np.isfinite(mine)):
            raise Untraceable("its graph is not finite where it is")
        both = finite & np.isfinite(mine)
        scale = np.maximum(np.abs(real[both]), 1e-3 * np.max(np.abs(real[both]), initial=0.0))
        if np.any(np.abs(real[both] - mine[both]) > TOLERANCE * scale + 1e-300):
            raise Untraceable("its graph gives other numbers")
        compared += bool(both.any())
    if compared < ENOUGH:
        raise Untraceable(failed)
