"""Compares machine code with the function that it was made from.

Before a solve, `compare_around` compares code and function at the start, around the start, and on
each side of the decisions that points around the start reach.  Then `compare_along` compares code
and function at states of the solution.
"""

import ctypes
import timeit
from typing import Any

import numpy as np

from fastdyn.kernels.calls.block import RAISED_WORD, SIDES, TIME
from fastdyn.trace.graph.clock import look
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live

from .function_convention import call, code_at
from .python_callback import evaluate as in_python
from .sentences import GaveUp

TOLERANCE = 1e-9
CANCELLED = 1e-12
CLOSE = 1e-6  # largest error by cancellation around the start, relative to the largest number
COUNT = 16
CANDIDATES = 256
ENOUGH = 3
FEWEST, MOST_NUMBERS = 4, 2**19  # fewest points; most numbers, points times length
PERIOD = 65_537  # a prime, after which the random numbers of a long state repeat
EPS = np.finfo(float).eps
ROUNDINGS = 1e3  # largest difference, over the function's change by roundings of t, y
SPREADS = np.array([0.01, 0.1, 0.5, 1.5, 10.0, 100.0])


def points_around(near, n, trace=None):
    """The start, points near and far, and a point for each new side of a trace's decisions.

    Returns times, shape (k,), and states, shape (k, n).
    """
    t0 = near.t0
    tf = near.tf
    y0 = np.resize(np.asarray(near.y0, float), n)
    rng = np.random.default_rng(0)
    k = CANDIDATES
    decisions = []
    graph: Any = None
    if trace is not None and trace.graph.batches is None:
        graph = trace.graph
        decisions = [
            node.args[0] for node in live([*trace.outputs, trace.raising]) if node.op == "select"
        ]
    count = int(min(COUNT, max(FEWEST, MOST_NUMBERS // max(n, 1))))
    if not decisions:
        k = count
    t = t0 + (tf - t0) * rng.random(k)
    sizes = np.sort(np.abs(y0))
    middle = float(sizes[(n - 1) // 2] + sizes[n // 2]) / 2 if n else 1.0  # the median
    size = np.maximum(np.abs(y0), 0.1 * max(1e-3, middle))
    each = np.arange(k)
    spread = np.where(each < COUNT, SPREADS[each % 4], SPREADS[each % 6])
    noise = rng.standard_normal((k, min(n, PERIOD)))
    y = np.tile(noise, (1, 1 + n // PERIOD))[:, :n] if n > PERIOD else noise
    y *= size
    y *= spread[:, None]
    y += y0
    positive = each % 3 == 2  # every third point keeps the signs of the start, as radii do
    y[positive] = np.abs(y[positive]) * np.where(y0 < 0, -1.0, 1.0)
    for i in np.flatnonzero((each % 7 == 3) & ~positive):  # some components unchanged, or 0
        y[i] = np.where(rng.random(n) < 0.5, (1 - i % 2) * y0, y[i])
    for i in np.flatnonzero((each % 7 == 5) & ~positive):
        y[i] *= 10.0 ** rng.uniform(-12, 2)
    t[0] = t0
    y[0] = y0
    chosen = list(range(count))
    if decisions:
        sides = evaluate(graph, [], t, y.T, graph.values, decisions)[1].astype(bool)
        seen = {(row, side) for row, side in zip(*_sides(sides[:, :count]), strict=True)}
        for i in range(count, k):
            new = set(zip(*_sides(sides[:, i : i + 1]), strict=True)) - seen
            if new:
                seen |= new
                chosen.append(i)
    return t[chosen], y[chosen]


def _sides(table):
    rows = np.arange(len(table))
    return np.repeat(rows, table.shape[1]), table.reshape(-1)


class Different(GaveUp):
    """Raised if machine code and its function give different values.

    `wrong` is False if only the type of t makes the difference.
    """

    wrong = True
    sentence = "its compiled form gives {}, and Python {}"

    def __init__(self, bound, t, y, expected, of_code):
        super().__init__(bound, t)
        of_code = "an exception" if of_code is None else of_code
        values = self.sentence.format(short(of_code), short(expected))
        self.args = (f"at t = {t:.10g}, y = {short(y)} {values}",)


def compare_around(bound, near, trace=None):
    """Compare a Bound's machine code with its function around the start.

    The code of a trace must agree at ENOUGH points, and raise where the function raises.  Numba's
    code may raise where the function does not: a solve notices such an exception later.

    Parameters
    ----------
    bound : Bound
    near : traced.make.Near
    trace : trace.paths.Trace, optional
        The trace of the function, with the parameter values in its graph.

    Returns
    -------
    None, Different or str
        None if code and function agree, Different if the code is wrong.  A sentence tells why the
        code cannot be used although it is not wrong: it gives up, or the function gives no numbers,
        or another value at each call.
    """
    compared = 0
    failed = "it gives no finite number near the start"
    time: Any = float  # SciPy's first call passes a float
    for t, y in zip(*points_around(near, bound.n, trace), strict=True):
        look()
        t = time(t)
        time = np.float64
        real = python_value(bound, t, y)
        mine = machine_value(bound, t, y)
        if mine is None and _is_value(real):
            if trace is None:
                continue
            return "its compiled form raises where it does not"
        if not agree(bound, real, mine, t, y, of_solution=False):
            again = python_value(bound, t, y)
            if _is_value(again) and not np.array_equal(again, real, equal_nan=True):
                return "it gives another value at each call"
            return Different(bound, t, y, real, mine)
        if _is_value(real):
            compared += bool(np.isfinite(real).any())
        else:
            failed = f"{type(real).__name__}: {real}"
    return None if compared >= ENOUGH or trace is None else failed


def compare_along(bound, times, states, time: Any = np.float64):
    """Raise Different if a Bound's machine code and its function differ at states of a solution.

    `time` makes a number of the type that SciPy's solver passes to functions.
    """
    found = []
    for t, y in zip(times, states, strict=True):
        t = time(t)
        y = y[: bound.n]
        found.append((t, y, python_value(bound, t, y), machine_value(bound, t, y)))
    pairs = [(real, mine) for *_, real, mine in found if _is_value(real) and mine is not None]
    if not found or (len(pairs) == len(found) and all_close(*zip(*pairs, strict=True))):
        return
    sizes = [np.abs(real[np.isfinite(real)]) for *_, real, _ in found if _is_value(real)]
    largest = max((float(size.max()) for size in sizes if size.size), default=0.0)
    for t, y, real, mine in found:
        if not agree(bound, real, mine, t, y, largest):
            error = Different(bound, t, y, real, mine)
            t = np.float64(t)  # the type of t in a trace, whose division by zero gives inf
            error.wrong = not agree(bound, python_value(bound, t, y), mine, t, y, largest)
            raise error


def _is_value(found):
    return not isinstance(found, Exception)


def python_value(bound, t, y) -> Any:
    """The function's value in Python, or the exception that it raises."""
    try:
        with np.errstate(all="ignore"):
            found = in_python(bound.python, bound.mode, t, y.copy())
            return np.array(found)  # a copy: the array may be a buffer of the function
    except Exception as error:
        return error


def machine_value(bound, t, y):
    """The value of a function's machine code; None if the code raises."""
    out, failed, _ = called(bound, bound.function, bound.mode.n_results(len(y)), t, y)
    return None if failed else out


def sides_at(bound, t, y):
    """The word of the sides that a function's decisions take at a state; 0 if the code raises."""
    _, failed, sides = called(bound, bound.function, bound.mode.n_results(len(y)), t, y)
    return 0 if failed else sides


def called(bound, function, size, t, y):
    """Call a Function with the block of a Bound; leave the block's marks of exceptions unchanged.

    Returns the `size` results, whether the code raised, and the word of the sides that its
    decisions took.
    """
    block = bound.block
    out = np.empty(size)
    kept = block[RAISED_WORD : TIME + 1].copy()
    block[SIDES] = 0
    left = ctypes.c_int64()
    failed = call(code_at(function.address), t, y.copy(), block, out, ctypes.addressof(left))
    sides = int(block[SIDES])
    block[RAISED_WORD : TIME + 1] = kept
    return out, failed, sides


def seconds_of(bound, t, y):
    """The time of an evaluation, in seconds: an upper bound, because Python makes the call.

    The time of machine code holds for all values, because no loop of a trace depends on values.
    """
    y = np.resize(np.asarray(y, float), bound.n)
    block = bound.block
    out = np.empty(bound.mode.n_results(len(y)))
    left = ctypes.c_int64()
    kept = block[RAISED_WORD : TIME + 1].copy()
    code, place = code_at(bound.function.address), ctypes.addressof(left)
    words = place, place, t, y.ctypes.data, len(y), block.ctypes.data, out.ctypes.data
    found = min(timeit.repeat(lambda: code(*words), number=1, repeat=3))
    block[RAISED_WORD : TIME + 1] = kept
    return found


def agree(bound, real, mine, t, y, largest=0.0, of_solution=True):
    """Whether two results agree, up to roundings that large cancelling terms amplify.

    `largest` and `of_solution` are as in `differ`.
    """
    if not _is_value(real) or mine is None:
        return not _is_value(real) and mine is None
    if real.shape != mine.shape:
        return False
    if not differ(real, mine, largest, of_solution):
        return True
    return (of_solution or are_close(real, mine)) and _by_rounding(bound, real, mine, t, y)


def _by_rounding(bound, real, mine, t, y):
    """Whether roundings of t and y change the Python function as much as the results differ."""
    spread = np.zeros(real.shape)
    signs = np.random.default_rng(0).choice((-1.0, 1.0), (3, len(y)))
    for sign in signs:
        moved = python_value(bound, type(t)(t * (1.0 + sign[0] * EPS)), y * (1.0 + sign * EPS))
        if not _is_value(moved) or moved.shape != real.shape:
            return True
        spread = np.maximum(spread, np.abs(moved - real))
    return not np.any(np.abs(real - mine) > ROUNDINGS * spread)


def all_close(real, mine):
    """Whether all results are finite and differ by rounding at most: a fast, sufficient check."""
    if len({value.shape for value in (*real, *mine)}) > 1:
        return False
    real = np.array(real)
    with np.errstate(all="ignore"):
        return bool((np.abs(np.array(mine) - real) <= TOLERANCE * np.abs(real)).all())


def are_close(real, mine):
    """Whether arrays are close, relative to the largest number, and finite at the same places."""
    finite = np.isfinite(real)
    far = np.abs(real - mine)[finite] > CLOSE * np.max(np.abs(real[finite]), initial=0.0)
    return np.array_equal(finite, np.isfinite(mine)) and not far.any()


def differ(real, mine, largest=0.0, of_solution=True):
    """Whether two results differ by more than rounding.

    `largest` is the largest size of a result along the solution; a difference of the size of the
    rounding errors of `largest` is allowed.  Away from a solution (`of_solution` False), any two
    non-finite numbers agree.
    """
    if np.array_equal(real, mine, equal_nan=True):
        return False
    finite = np.isfinite(real) & np.isfinite(mine)
    if of_solution:
        odd = ~finite & (real != mine) & ~(np.isnan(real) & np.isnan(mine))
    else:
        odd = np.isfinite(real) != np.isfinite(mine)
    if odd.any():
        return True
    real = real[finite]
    mine = mine[finite]
    scale = np.maximum(np.abs(real), 1e-3 * np.max(np.abs(real), initial=0.0))
    allowed = np.maximum(TOLERANCE * scale, CANCELLED * largest) + 1e-300
    return bool(np.any(np.abs(real - mine) > allowed))


def short(value):
    """A value, or an exception, as text for a sentence."""
    if isinstance(value, Exception | str):
        return value if isinstance(value, str) else f"{type(value).__name__}: {value}"
    return np.array2string(np.asarray(value), precision=12, threshold=8, edgeitems=3)
