"""Turns calls of a library on symbols into islands of the graph."""

from typing import Any

import numpy as np

from ..graph.refusal import LATEST, OutOfTime, Refusal
from ..graph.user_lines import line_of_call
from ..symbols.arrays import Array
from ..symbols.layout import arrays_in
from ..symbols.real import Symbol, symbol
from ..symbols.symbolic import BATCHES, Batched, Lazy, graph_of, refuse
from .forms import Given, Result
from .island import Island

MAX_NUMBERS = 20_000  # limit of an island's inputs, and of its results
MAX_ISLANDS = 64


def apart(function, args, kwargs, name=None, what=None) -> Any:
    """``function(*args, **kwargs)`` as an island.

    Parameters
    ----------
    function : callable
        A library function without side effects, whose value depends on its arguments only.
    args : tuple
    kwargs : dict
        The arguments, some of which hold symbols.
    name : str, optional
        The name of the function in messages.
    what : tuple, optional
        Objects that identify the function; by default (function,).

    Returns
    -------
    object
        The result of the function, with symbols in place of numbers.
    """
    name = name or getattr(function, "__name__", type(function).__name__)
    g = graph_of(args, list(kwargs.values()))
    if g is None or g.start is None:
        refuse(f"it calls {name}")
    if any(kwargs.get(each) is not None for each in ("out", "output")):
        refuse(f"{name} with an array for its result")
    if any(v is not False for k, v in kwargs.items() if k.startswith("overwrite")):
        refuse(f"{name} that overwrites what it is given")
    given = Given(args, kwargs)
    if g.in_handler():
        refuse(f"{name} where what it raises is caught")
    if given.size > MAX_NUMBERS:
        refuse(f"{name} of {given.size} numbers", final=True)
    island, result = _island(g, function, given, name, what or (function,))
    (slot,) = g.reads.parameters(g.reads.step(g.reads.root(0), "island", island), island.address)
    g.islands[slot] = island
    data = slot, island.n_in, island.n_out
    found = BATCHES["island"](g.batches, given.numbers, data) if g.batches else _entries(
        g, given, data
    )  # fmt: skip
    g.raises_if(g.negation(g.compare(found[-1].node, g.const(0.0), "eq")), lambda: None)
    made = result.of(found)
    if result.is_view:
        _forbid_stores([args, kwargs, made], name)
    return made


def _forbid_stores(value, name):
    """Refuse stores in arrays that share memory where the arrays of symbols do not."""
    for array in arrays_in(value):
        if isinstance(array, Batched):
            array.forbid_stores()  # pyright: ignore
        elif array.dtype == object and not isinstance(array, Lazy):
            refuse(f"a view that {name} gives")


def _nodes(g, given):
    """The nodes of an island's inputs."""
    parts = [p if isinstance(p, list) else [p] for p in given.numbers]
    return [symbol(g, v).node for part in parts for v in part]


def _entries(g, given, data):
    whole = g.make("island", _nodes(g, given), data)
    found = np.empty(data[2] + 1, dtype=object)
    found[:] = [Symbol(g, g.make("entry", (whole,), i)) for i in range(data[2] + 1)]
    return found.view(Array)


def _island(g, function, given, name, what):
    """The Island of a call, and the form of the result; all paths share both."""
    key = "island", *map(id, what), given.key
    known = g.kept.get(key)
    if known is None:
        if len(g.islands) >= MAX_ISLANDS:
            refuse("it calls a library in too many ways", final=True)
        first, is_view = _first(g, function, given, name)
        result = Result(first, is_view)
        if result.size > MAX_NUMBERS:
            refuse(f"{name} gives {result.size} numbers", final=True)
        known = g.kept[key] = Island(function, given, result, name, line_of_call()), result
    return known


def _first(g, function, given, name):
    """Call the library with the inputs at the start, or else with random inputs in [0.5, 1.5).

    Returns the result, and whether the result shares memory with an input.
    """
    rng = np.random.default_rng(0)
    error: Any = None
    for numbers in (_at_the_start(g, given), rng.uniform(0.5, 1.5, given.size)):
        if numbers is None:
            continue
        args, named = given.of(numbers)
        try:
            with np.errstate(all="ignore"):
                result = function(*args, **named)
        except Exception as raised:
            error = error or raised
            continue
        of_args = list(arrays_in([args, named]))
        pairs = ((array, each) for array in arrays_in(result) for each in of_args)
        return result, any(np.may_share_memory(*pair) for pair in pairs)
    return refuse(f"{name} raises {type(error).__name__} at the start", final=True)


def _at_the_start(g, given):
    """The values of an island's inputs at the start; None in a trace in batches."""
    if g.batches:
        return None
    known = g.kept.setdefault("values at the start", {})
    nodes, (t, y) = _nodes(g, given), g.start
    todo = list(nodes)
    while todo:
        node = todo[-1]
        wanted = [a for a in node.args if a.key not in known]
        if node.key in known or not wanted:
            todo.pop()
            if node.key not in known:
                known[node.key] = _value(g, node, known, t, y)
        else:
            todo += wanted
    return np.array([known[node.key] for node in nodes], float)


def _value(g, node, known, t, y):
    if node.op in ("t", "y"):
        return t if node.op == "t" else y[node.data % len(y)]
    if node.op in ("par", "const"):
        return node.data if node.op == "const" else g.values[node.data]
    with np.errstate(all="ignore"):
        return g.compute(node, [known[a.key] for a in node.args])


def or_apart(function, written_out):
    """Try `written_out`, a formula for a library function; if it refuses, call the library."""

    def call(*args, **kwargs):
        g, before = graph_of(args, list(kwargs.values())), LATEST.refusal
        raising = g and g.raising
        try:
            return written_out(*args, **kwargs)
        except OutOfTime:
            raise
        except (Refusal, TypeError, AttributeError):  # C code raises TypeError on symbols
            if g is None or g.start is None:
                raise
        LATEST.refusal, g.raising = before, raising
        return apart(function, args, kwargs)

    return call
