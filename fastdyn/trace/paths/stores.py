"""Traces functions that write places in outside objects before they read these places."""

from ..graph.expressions import live
from ..graph.refusal import Untraceable
from ..outside.writes_before_reads import Stores
from .runs import trace


def trace_with_stores(*given, where):
    """Trace a function that writes to places outside before it reads them.

    The arguments are those of `trace`.  The machine code does not write to the places.  After a
    solve, the caller must therefore call the user's function at the end point.

    Raises
    ------
    Untraceable
    """
    stores = Stores()
    first = trace(*given, where=where._replace(stores=stores))
    if not stores.places:
        raise Untraceable("it writes to nothing", said=False)
    second = trace(*given, where=where._replace(stores=Stores(stores.places)))
    if _text(first) != _text(second):
        raise Untraceable("it uses what a call before has left", final=True, effect=True)
    return second


def _text(found):
    """The nodes of a trace as a list without parameter slots, for comparison with another trace."""
    reads, nodes = found.reads, live([*found.outputs, found.raising])
    names = {node.key: i for i, node in enumerate(nodes)}
    lines = []
    for node in nodes:
        data = node.data
        if node.op == "par":
            group = reads.groups[reads.group(data)]
            data = _way(reads, group.row), data - group.first
        lines.append((node.op, [names[a.key] for a in node.args], repr(data)))
    return lines, [names[node.key] for node in (*found.outputs, found.raising)]


def _way(reads, row):
    """The steps from the root to a row."""
    parent, step, key, *_ = reads.rows[row]
    return (step, repr(key)) if parent < 0 else (*_way(reads, parent), step, repr(key))
