"""Event functions that jump over zero: the condition that changes there has the derivatives.

The time of an event is a zero of g, and has the derivatives of this zero.  Where g jumps over zero,
a condition changes, a comparison or a rounding, at a zero or a whole value of a number, which takes
the place of g: the time of the event is the time of the change.
"""

from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.substitute import substituted
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.operations.value import by_rule

COMPARISONS = ("lt", "le", "eq")
# Distances of the two sides of an event from its time, and from its state: an event is located to 4
# roundings of its time, a switching time to 16, and the state at the event to some roundings.
FAR = 2.0**-46
NEAREST = 2.0**-60  # of events at t = 0


def crossing_number(graph, event, rates):
    """The number whose zero an event is: the node of its function, or one that takes its place.

    `rates` are the nodes of the state's derivative before the event.
    """
    found = list(_conditions(graph, event))
    if not found:
        return event
    changing = [each for each, _ in found]
    t = graph.make("t")
    off = graph.add(_share(graph, t), graph.const(NEAREST))
    zero = graph.const(0.0)
    before = {t.key: graph.sub(t, off)}
    behind = {t.key: graph.add(t, off)}
    for y in [node for node in live(changing) if node.op == "y"]:
        rate = rates[y.data]
        far = graph.add(graph.call("abs", graph.mul(off, rate)), _share(graph, y))
        far = graph.select(graph.compare(rate, zero, "lt"), graph.neg(far), far)
        before[y.key] = graph.sub(y, far)
        behind[y.key] = graph.add(y, far)
    sides = [substituted(graph, changing, side) for side in (before, behind)]
    for (node, number), a, b in reversed(list(zip(found, *sides, strict=True))):
        event = graph.select(_differ(graph, node, a, b), number, event)
    return event


def _share(graph, node):
    return graph.mul(graph.const(FAR), graph.call("abs", node))


def _conditions(graph, event):
    """The nodes that may jump in an event function, inner ones first, and their numbers."""
    for node in live([event]):
        decision = OPERATIONS[node.op].decision
        if node.op in COMPARISONS:
            yield node, graph.sub(*node.args)
        elif decision and node.op != "select":
            own = graph.div(*node.args) if node.op == "fmod" else node.args[0]
            yield by_rule(graph, decision, node, *node.args), own


def _differ(graph, node, a, b):
    """Whether two values of a node differ."""
    if not OPERATIONS[node.op].truth:
        return graph.negation(graph.compare(a, b, "eq"))
    one = graph.both(a, graph.negation(b))
    return graph.both(one, graph.both(b, graph.negation(a)), "or")
