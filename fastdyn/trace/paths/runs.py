"""The runs of a function on symbols, one for each path, merged into one graph.

During a run, conditions take their truth from a script.  Each new decision adds a script with the
opposite truth, until every path has been run.  The paths form a tree of decisions; `select` nodes
merge the tree.
"""

from typing import Any, NamedTuple

import numpy as np

from ..batches.state import LongArrays
from ..graph.refusal import LATEST, Abandoned, Refusal, Untraceable, refused_as
from ..outside.surroundings import Outside
from ..reads.reads import Reads
from ..symbols.masks import Masked
from ..symbols.real import Symbol
from ..symbols.symbolic import NOW
from .decisions import Paths
from .states import Numbers

MAX_PATHS = 256  # of eight branches that do not depend on each other
STATE = "the state that it is given"
IN_PLACE = {STATE, "an array"}  # objects that machine code can write to


class Leaf(NamedTuple):
    """The end of a path; `results` is None if the path raised or is left to Python."""

    taken: list
    results: list | None
    raising: Any


class Trace(NamedTuple):
    """The graph of a function.

    `outputs` are nodes, or node numbers of batches.  `raising` is the condition under which the
    function raises or is left to Python.  `failing` is this condition without the conditions of
    `Paths.stays_below`.  `error` is the message of an exception that a path raised, or empty.
    """

    graph: Paths
    outputs: list
    raising: Any
    reads: Reads
    n_paths: int
    error: str
    failing: Any = None


@refused_as(Refusal.untraceable)
def trace(
    fun, args, n, shape, varying=(), lifted="all", zeros=0, complex_state=False, batches=False,
    start=None,
):  # fmt: skip
    """Trace ``fun(t, y, *args)``.

    Parameters
    ----------
    fun : callable
    args : tuple
    n : int
        Number of components of y.
    shape : tuple or None
        Shape of the result; None for a number.
    varying : collection of int
        Indices (from 1) of the `args` that vary between trajectories; no decision depends on them.
    lifted : {"all", "floats", "none"}
        The numbers from outside that become parameters of the code.
    zeros : int
        Number of constant zeros appended to the n components.
    complex_state : bool
        Whether components are complex.  Entries 2 i and 2 i + 1 of the state are then the real and
        the imaginary part of component i.  Results alternate in this way, unless `shape` is None.
    batches : bool
        Whether long arrays are traced in batches.  The outputs are then node numbers of
        `graph.batches`, unless `shape` is None.
    start : tuple, optional
        The (time, state) of the first call, in real numbers.

    Raises
    ------
    Untraceable
    """
    g = Paths()
    g.start = start
    if not batches and n * (1 + complex_state) >= g.most:  # refuse before any node is made
        raise Untraceable("its state is too long", final=True, said=False)
    g.reads = Reads(g, (fun, *args), varying)
    states: Any = (
        LongArrays(g, n, complex_state) if batches else Numbers(g, n, zeros, complex_state)
    )
    try:
        leaves, errors = _leaves(
            g, lambda script: _run(g, script, Outside(g, g.reads, lifted), fun, args, states, shape)
        )
    finally:
        # Arrays of symbols refer to the graph.  Python's collector does not look into such arrays:
        # a graph that refers to them would never leave memory.
        g.kept.clear()
    counts = [len(leaf.results) for leaf in leaves if leaf.results is not None]
    if not counts:
        raise Untraceable(errors[0])
    outputs, raising = _merged(states, leaves, 0, counts[0])
    whole = g.both(raising, g.sizes, "or")
    return Trace(g, outputs, whole, g.reads, len(leaves), errors[0] if errors else "", raising)


def _leaves(g, run):
    """The ends of all paths, by ``run(script)``, and the messages of exceptions."""
    todo: list[tuple] = [()]
    leaves, errors = [], []
    while todo:
        script = todo.pop()
        results, error = run(script)
        errors += error
        leaves.append(Leaf(list(g.taken), results, g.raising))
        if len(leaves) + len(todo) > MAX_PATHS:
            raise Untraceable("it decides in too many ways", final=True)
        for i in range(len(script), len(g.taken)):
            todo.append((*(value for _, value in g.taken[:i]), False))
    return leaves, errors


def _run(g, script, outside, fun, args, states, shape):
    """Run one path; return the results or None, and a list with the message of an exception."""
    g.until = _run.__code__
    NOW.table = g.batches
    g.begin(script)
    LATEST.refusal = None
    results, errors, written = None, [], []
    try:
        copy, given = _surroundings(outside, fun, args)
        y = states.start()
        if shape is not None and len(shape) > 1:
            y = y.reshape(shape)
        with np.errstate(all="ignore"):
            result = copy(Symbol(g, g.make("t")), y, *given)
        if g.texts:
            raise Refusal("a value that depends on t or y is needed as text")
        if g.conditions and g.reads.truths:
            raise Refusal("it asks whether something `is True` or `is False`")
        if isinstance(result, Masked):
            raise Refusal("it returns a selection by a mask")
        results = states.results(result, shape)
        if states.written(y):
            written.append(STATE)
    except Refusal as reason:
        if not outside.writes() or reason.flags["effect"]:
            raise reason.untraceable() from None
        LATEST.refusal = None  # the user is told of the write, not of the refusal
    except RecursionError:
        raise Untraceable("it calls itself too deep", final=True, said=False) from None
    except Abandoned:
        pass
    except Exception as raised:
        errors.append(f"{type(raised).__name__}: {raised}")
    finally:
        NOW.table = None
    if g.abandoned:
        results = None
        errors.append(g.abandoned)
    written += outside.writes()
    if LATEST.refusal:
        raise LATEST.refusal.untraceable()
    if written:
        effect = not IN_PLACE.issuperset(written)
        raise Untraceable(f"it changes {written[0]}", final=True, effect=effect, writes=not effect)
    if len(g.taken) < len(script):
        raise Untraceable("it does not decide the same at the same point")
    return results, errors


def _surroundings(outside, fun, args):
    reads = outside.reads
    given = [outside.wrap(a, reads.root(i)) for i, a in enumerate(args, 1)]
    copy = outside.wrap(fun, reads.root(0))
    if copy is fun or not callable(copy):
        raise Refusal("it is no function written in Python")
    return copy, given


def _merged(states, leaves, depth, n):
    """The results of a tree of paths, and the condition under which the function raises."""
    g = states.g
    if len(leaves) == 1 and len(leaves[0].taken) == depth:
        _, results, raising = leaves[0]
        return (states.lost(n), g.true) if results is None else (results, raising)
    node = leaves[0].taken[depth][0]
    sides = [[leaf for leaf in leaves if leaf.taken[depth][1] is side] for side in (True, False)]
    (yes, bad), (no, worse) = (_merged(states, side, depth + 1, n) for side in sides)
    outputs = states.chosen(node, yes, no)
    raising = g.both(g.both(node, bad), g.both(g.negation(node), worse), "or")
    return outputs, bad if bad is worse else raising
