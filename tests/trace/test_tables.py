"""Tables: one thing with an address, whatever their length, and never stale."""

import bisect
import gc
import warnings
import weakref

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import make as by_tracing
from fastdyn.compile.traced.known import Attempt
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths import runs

# RK45 jumps over entries of long tables: what it tells of is no matter here
pytestmark = pytest.mark.filterwarnings("ignore::fastdyn.SwitchingWarning")
START = np.array([0.5, 0.1])
N = 400


def numbers(n=N):
    return np.sin(0.37 * np.arange(n)) + 0.01 * np.arange(n) % 1.0


def agrees(fun, args=None):
    """By trace, and the same; jumps do not change equal steps."""
    steps: dict = {"first_step": 1 / 64, "max_step": 1 / 64, "atol": 1e3, "args": args}
    with warnings.catch_warnings():
        warnings.simplefilter("error", fastdyn.CompileWarning)
        mine = fastdyn.solve_ivp(fun, (0.0, 1.0), START, **steps)
    theirs = reference(fun, (0.0, 1.0), START, **steps)
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-7)
    assert Attempt(fun, args or (), DERIVATIVE, 2).known() is not None


TAB, WIDE = numbers(), numbers(3 * N).reshape(N, 3)
HEIGHTS, KNOTS = numbers(), np.linspace(-0.1, 1.2, N)
WHOLE, TRUE = (100 * numbers()).astype(int), numbers() > 0.4
LIST, TUPLE, INTS = TAB.tolist(), tuple(TAB.tolist()), WHOLE.tolist()
MIXED = [int(v) if i % 3 else v for i, v in enumerate(10 * TAB)]
SWITCHES, ROWS = TRUE.tolist(), WIDE.tolist()
TUPLES = [tuple(row) for row in ROWS]
ONE, FEW = [1.0], np.array([0.0, 1.0, 3.0])
ORDER = np.arange(N)[::-1].copy()


def k(t, y):
    return int(300 * t) % 300


USES = {
    "entry": lambda t, y: TAB[k(t, y)] - y,
    "from the end": lambda t, y: TAB[-1 - k(t, y)] - y,
    "of a slice": lambda t, y: TAB[10:350][k(t, y)] - y,
    "every third": lambda t, y: TAB[1::3][k(t, y) // 3] - y,
    "backwards": lambda t, y: TAB[::-1][k(t, y)] - y,
    "two columns": lambda t, y: WIDE[k(t, y), :2] - y,
    "a column": lambda t, y: WIDE[:, 1][k(t, y)] - y,
    "a row": lambda t, y: WIDE[k(t, y)][1:] - y,
    "both": lambda t, y: WIDE[k(t, y), int(3 * abs(y[0])) % 3] - y,
    "transposed": lambda t, y: WIDE.T[1, k(t, y)] - y,
    "reshaped": lambda t, y: WIDE.reshape(-1)[k(t, y)] - y,
    "of another": lambda t, y: TAB[ORDER[k(t, y)]] - y,
    "several": lambda t, y: TAB[(299 * np.abs(np.sin(y))).astype(int)] - y,
    "whole numbers": lambda t, y: 0.01 * WHOLE[k(t, y)] - y,
    "truth": lambda t, y: -y if TRUE[k(t, y)] else -2 * y,
    "truths": lambda t, y: np.where(TRUE[k(t, y)], -y, -2 * y),
    "list": lambda t, y: LIST[k(t, y)] - y,
    "tuple": lambda t, y: TUPLE[k(t, y)] - y,
    "of whole numbers": lambda t, y: TAB[INTS[k(t, y)] % 7] - y,
    "mixed": lambda t, y: MIXED[k(t, y)] * 0.1 - y,
    "of truths": lambda t, y: -y if SWITCHES[k(t, y)] else y,
    "of rows": lambda t, y: np.array(ROWS[k(t, y)][:2]) - y,
    "of tuples": lambda t, y: np.array(TUPLES[k(t, y)][1:]) - y,
    "row": lambda t, y: np.array(ROWS[3][:2]) * np.array(TUPLES[4][1:]) - y,
    "ends": lambda t, y: TAB[0] * TAB[-1] * LIST[1] * len(LIST) - TUPLE[-2] * y * len(TAB),
    "shape": lambda t, y: -y * WIDE.shape[1] * TAB.size / WIDE.ndim,
    "sum": lambda t, y: TAB.sum() + np.sum(WIDE, axis=0)[:2] + sum(LIST) - y,
    "extremes": lambda t, y: TAB.max() - min(LIST) * y + max(TUPLE) + np.argmax(TAB),
    "iteration": lambda t, y: sum(a * b for a, b in zip(TAB, LIST, strict=True)) - y,
    "elements": lambda t, y: (TAB * y[0] + WIDE[:, 1])[:2] - y,
    "product": lambda t, y: WIDE.T @ TAB * 1e-2 @ np.ones(3) - y,
    "slices": lambda t, y: np.array(LIST[3:5]) + TAB[4:6] + np.array(TUPLE[7:9]) - y,
    "added": lambda t, y: np.array((LIST + ONE)[-2:]) - y * (ONE + LIST)[1],
    "copied": lambda t, y: np.array(LIST)[k(t, y)] - np.asarray(TUPLE)[k(t, y)] * y,
    "written": lambda t, y: _written(TAB.copy(), t, y),
    "interp": lambda t, y: np.interp(t + 0.01 * y, KNOTS, HEIGHTS) - y,
    "a known place": lambda t, y: np.interp(0.5, KNOTS, HEIGHTS) - TAB[np.searchsorted(FEW, 2)] * y,
    "interp of lists": lambda t, y: np.interp(t, KNOTS, LIST, -1.0, y[0]) - y,
    "interp of columns": lambda t, y: np.interp(t, KNOTS, WIDE[:, 2]) - y,
    "interp of rows": lambda t, y: np.interp(t, KNOTS, WIDE.T[1]) - y,
    "search": lambda t, y: TAB[np.searchsorted(KNOTS, t)] - y,
    "nearest": lambda t, y: TAB[np.argmin(np.abs(KNOTS - t))] - y,
    "nearest to the state": lambda t, y: TAB[abs(y[0] - KNOTS).argmin()] - y,
    "bins": lambda t, y: TAB[np.digitize(y[0], KNOTS) % 50] - y,
    "falling bins": lambda t, y: 0.01 * np.digitize(y[0], KNOTS[::-1]) - y,
    "clipped": lambda t, y: TAB[min(max(int(500 * t) - 50, 0), len(TAB) - 1)] - y,
    "np.clip": lambda t, y: TAB[int(np.clip(500 * t - 50, 0, N - 1))] - y,
}


def _written(copy, t, y):
    copy[3] = y[0]
    return copy[2:4] + copy[7] - y


@pytest.mark.few(19)
@pytest.mark.parametrize("name", USES)
def test_as_python_has_it(name):
    agrees(USES[name])


CHANGES = {
    "entry": (TAB, slice(None)), "two columns": (WIDE, slice(None)), "sum": (WIDE, 0),
    "whole numbers": (WHOLE, slice(None)), "list": (LIST, 3), "of tuples": (TUPLES, 2),
    "of rows": (ROWS, 3), "mixed": (MIXED, 30), "interp": (HEIGHTS, 100), "search": (KNOTS, 120),
    "nearest": (KNOTS, 120),
    "a known place": (HEIGHTS, slice(None)), "truth": (TRUE, slice(0, 50)),
    "iteration": (LIST, 8), "elements": (WIDE, 0),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_never_stale(name):
    table, key = CHANGES[name]
    agrees(USES[name])
    before = table[key].copy() if isinstance(table, np.ndarray) else table[key]
    if name in ("search", "nearest"):
        table[key] += 0.001
    elif isinstance(table, np.ndarray):
        table[key] = ~before if table.dtype == bool else before * 2
    elif isinstance(before, list):
        before[0] += 5
    else:
        table[key] = tuple(2 * v for v in before) if isinstance(before, tuple) else before + 7
    try:
        agrees(USES[name])
    finally:
        if isinstance(before, list):
            before[0] -= 5
        else:
            table[key] = before


def test_a_changed_entry_needs_no_new_trace(monkeypatch):
    agrees(USES["entry"])
    monkeypatch.setattr(by_tracing, "trace", None)
    TAB[7] += 1
    agrees(USES["entry"])
    TAB[7] -= 1


def test_an_index_outside():
    def fun(t, y):
        return TAB[int(1000 * t)] - y

    with pytest.raises(IndexError):
        fastdyn.solve_ivp(fun, (0.0, 1.0), START)

    def caught(t, y):
        try:
            return LIST[int(500 * t)] - y
        except IndexError:
            return -y

    agrees(caught)


@pytest.mark.hunt
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_knots_that_fall_later():
    knots = np.linspace(0.0, 1.0, 50)

    def fun(t, y):
        return knots.searchsorted(t) * 0.01 - y + np.interp(t, knots, HEIGHTS[:50])

    agrees(fun)
    knots[10] = 0.9
    mine, theirs = (f(fun, (0.0, 1.0), START) for f in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_table_that_is_written_to_is_no_table():
    kept = np.zeros(50)

    def fun(t, y):
        kept[int(49 * t)] = y[0]
        kept[3] = t
        return -y * (1 + kept[3])

    mine, theirs = (f(fun, (0.0, 1.0), START) for f in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9)
    assert kept.any()


LONG = 1_000_000


@pytest.mark.few(3)
@pytest.mark.parametrize("kind", ["float", "int", "bool", "wide", "interp"])
def test_a_million_entries(kind):
    """A table of any length costs what a short one costs, but for a look at it.

    The 81 paths of the function share the ids of the table.
    """
    long, short = (by_index(kind, n) for n in (LONG, 400))
    agrees(long)
    graphs = [runs.trace(fun, (), 2, (2,)).graph for fun in (long, short)]
    assert len(graphs[0].rows) == len(graphs[1].rows) <= 4
    assert len(graphs[0].nodes) == len(graphs[1].nodes)


def by_index(kind, n):
    """A function that looks entries of a table of n numbers up."""
    table = numbers(n)
    table = {"int": 9 * table, "bool": table > 0.3, "wide": table.reshape(-1, 10)}.get(kind, table)
    table = table.astype(int) if kind == "int" else table
    knots = np.linspace(0.0, 1.0, n)

    def entry(t):
        if kind == "interp":
            return np.interp(t, knots, table)
        i = round(10 * t)
        if i < 0:
            return table[0]
        return table[-1] if i >= len(table) else table[i]

    def fun(t, y):
        one = entry(t) * 1.0 + entry(t + 0.1) - entry(t + 0.2) * 0.5 + entry(t + 0.3)
        return (one[:2] if kind == "wide" else one) - y

    return fun


def test_a_list_of_thousands_of_numbers_is_to_be_an_array():
    table = numbers(5000).tolist()

    def fun(t, y):
        return [table[3] == 0.5, -y[1]]

    with pytest.raises(Untraceable, match="a list of 5000 items: make it an array"):
        runs.trace(fun, (), 2, (2,))


def test_a_graph_leaves_memory_with_its_tables(monkeypatch):
    """Arrays of symbols, into which Python's collector does not look, refer to the graph."""
    table, graphs = numbers(1000), []

    class Noted(runs.Tracing):
        def __init__(self, *given):
            super().__init__(*given)
            graphs.append(weakref.ref(self))

    monkeypatch.setattr(runs, "Tracing", Noted)
    runs.trace(lambda t, y: table[int(300 * t) % 300] - y, (), 2, (2,))
    gc.collect()
    gc.collect()  # of what the first has freed
    assert [graph() for graph in graphs] == [None]


def test_bisect():
    agrees(lambda t, y: TAB[bisect.bisect(LIST_OF_KNOTS, t)] - y)
    agrees(lambda t, y: TAB[bisect.bisect_left(KNOTS, y[0])] - y)


LIST_OF_KNOTS = KNOTS.tolist()
