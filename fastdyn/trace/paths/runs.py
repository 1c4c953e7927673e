"""The runs of a function on symbols, one for each path, merged into one graph.

During a run, conditions take their truth from a script.  Each new decision adds a script with the
opposite truth, until every path has been run.  The paths form a tree of decisions; `select` nodes
merge the tree.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..functions import stand_ins  # noqa: F401  # registers NumPy's functions
from ..graph.refusal import LATEST, Abandoned, Refusal, Untraceable, refused_as
from ..graph.rows import FEW, ID, PAIR
from ..outside.surroundings import Outside
from ..reads.reads import Reads
from ..symbols.arithmetic import cast
from ..symbols.lift import symbol
from ..symbols.masks import Masked
from ..symbols.symbol import AN_ARRAY, NOW, STATE, Symbol
from .tracing import Tracing

MAX_PATHS = 256  # of eight branches that do not depend on each other


class Leaf(NamedTuple):
    """The end of a path; `results` is None if the path raised or is left to Python."""

    taken: list
    results: list | None
    raising: Any


class Trace(NamedTuple):
    """The graph of a function.

    `outputs` are nodes, or the ids of long arrays.  `raising` is the condition under which the
    function raises or is left to Python.  `failing` is this condition without the conditions of
    `Tracing.stays_below`.  `error` is the message of an exception that a path raised, or empty.
    """

    graph: Tracing
    outputs: list
    raising: Any
    reads: Reads
    n_paths: int
    error: str
    failing: Any = None


@refused_as(Refusal.untraceable)
def trace(
    fun, args, n, shape, varying=(), lifted="all", zeros=0, complex_state=False, batches=False,
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
    lifted : {"all", "none"}
        The numbers from outside that become parameters of the code.
    zeros : int
        Number of constant zeros appended to the n components.
    complex_state : bool
        Whether components are complex.  Entries 2 i and 2 i + 1 of the state are then the real and
        the imaginary part of component i.  Results alternate in this way, unless `shape` is None.
    batches : bool
        Whether operations on long arrays are rows.  The outputs are then ids, not nodes.

    Raises
    ------
    Untraceable
    """
    size = n * (1 + complex_state)
    g = Tracing(size, FEW if batches else math.inf)
    if not batches and size >= g.most:  # refuse before any node is made
        raise Untraceable("its state is too long", final=True, said=False)
    g.reads = Reads(g, (fun, *args), varying)
    states = States(g, zeros, complex_state)
    leaves, errors = _leaves(
        g,
        lambda script: _run(g, script, Outside(g, g.reads, lifted), fun, args, states, shape),
    )
    counts = [len(leaf.results) for leaf in leaves if leaf.results is not None]
    if not counts:
        raise Untraceable(errors[0])
    outputs: Any
    outputs, raising = _merged(states, leaves, 0, counts[0])
    whole = g.both(raising, g.sizes, "or")
    if batches:
        g.batches = g
    else:
        outputs = [g.node(i) for i in outputs.tolist()]
    return Trace(g, outputs, whole, g.reads, len(leaves), errors[0] if errors else "", raising)


def _leaves(g, run):
    """The ends of all paths, by ``run(script)``, and the messages of exceptions."""
    todo: list[tuple] = [()]
    leaves = []
    errors = []
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
    g.outside = outside
    NOW.g = g
    g.begin(script)
    LATEST.refusal = None
    results = None
    errors = []
    try:
        copy, given = _surroundings(outside, fun, args)
        y = states.start()
        if shape is not None and len(shape) > 1:
            y = y.reshape(shape)
        time = Symbol(g, g.make("t").key)
        with np.errstate(all="ignore"):
            result = copy(time, y, *given)
        if g.texts:
            raise Refusal("a value that depends on t or y is needed as text")
        if g.conditions and g.reads.truths:
            raise Refusal("it asks whether something `is True` or `is False`")
        if type(result) is Masked:
            raise Refusal("it returns a selection by a mask")
        results = states.results(result, shape)
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
        NOW.g = g.outside = None  # a graph lives as long as its code
    if g.abandoned:
        results = None
        errors.append(g.abandoned)
    written = outside.writes()
    if LATEST.refusal:
        raise LATEST.refusal.untraceable()
    if written:
        effect = not {STATE, AN_ARRAY}.issuperset(written)  # machine code can write to these
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


class States:
    """The state that a traced function gets, and its results, as ids.

    A complex state and its results alternate real and imaginary parts.
    """

    def __init__(self, g, zeros, complex_state):
        self.g = g
        self.complex_state = complex_state
        g.given = np.append(g.ids(g.state), np.full(zeros, g.const(0.0).key, ID))
        g.given.flags.writeable = False

    def start(self):
        ids = self.g.given
        return Symbol(self.g, ids.view(PAIR), "c") if self.complex_state else Symbol(self.g, ids)

    def results(self, result, shape):
        """The ids of a result."""
        g = self.g
        size = 1 if shape is None else int(np.prod(shape))
        s = symbol(g, result)
        if not s.many and size > 1 and not isinstance(result, list | tuple | np.ndarray):
            s = Symbol(g, np.full(size, s.ids, ID), s.kind) if s.kind != "c" else s
        flat = np.asarray(s.ids).reshape(-1) if s.many else s.ids
        count = flat.size if s.many else 1
        if count != size:
            raise Refusal(f"it returns {count} numbers, not {size}")
        complex_results = self.complex_state and shape is not None
        if s.kind == "c" and not complex_results:
            raise Refusal("it returns complex numbers")
        ids = cast(g, s, "c" if complex_results else "f", "unsafe")
        if not isinstance(ids, np.ndarray):
            return np.array(ids, ID).reshape(-1)
        return np.ascontiguousarray(ids).reshape(-1).view(ID)

    def chosen(self, node, yes, no):
        """Select the results `yes` or `no` by a condition."""
        return self.g.map("select", node.key, yes, no) if (yes != no).any() else yes

    def lost(self, n):
        """The results of a path that raises or is left to Python: n times NaN."""
        return np.full(n, self.g.const(math.nan).key, ID)


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
