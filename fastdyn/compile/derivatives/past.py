"""The equations of sensitivities of a delay equation, which read the past of the sensitivities.

The dense output of the solve has y and S, so that S of the past is read as y of the past is.  Along
direction j, the component i of the state at the time s moves by S_ij(s) + y_i'(s) ds, where ds is
the derivative of s: by a delay tau in s = t - tau, -y_i'(t - tau).
"""

from fastdyn.trace.graph.derivatives import along_directions
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.substitute import substituted


def outputs_of_past(graph, traced, columns, n):
    """The nodes of f, and of its derivatives by the directions, row by row.

    Each of `columns` is the slot of a parameter, or None for a component of the initial state.
    """
    g = graph
    m = len(columns)
    size = n * (1 + m)
    stored = traced.stored[:n]

    def longer(past):
        """A past state with its sensitivities."""
        _, n_words, order = past.data
        return g.make("past", past.args, (size, n_words, order))

    def of_past(node):
        first = n + node.data * m
        whole = longer(node.args[0])
        return {j: g.make("of_past", (whole,), first + j) for j in range(m)}

    inputs = [g.make("y", (), i) for i in range(n)]
    known = {
        y.key: {j: g.make("y", (), n + i * m + j) for j in range(m)} for i, y in enumerate(inputs)
    }
    for slot in dict.fromkeys(slot for slot in columns if slot is not None):
        parameter = g.make("par", (), slot)
        inputs.append(parameter)
        known[parameter.key] = {j: g.const(1.0) for j, each in enumerate(columns) if each == slot}
    found = along_directions(g, stored, known, inputs, of_past)
    zero = g.const(0.0)
    outputs = [*stored, *(row.get(j, zero) for row in found for j in range(m))]
    pasts = [node for node in live(stored) if node.op == "past"]  # read once, with S
    return substituted(g, outputs, {node.key: longer(node) for node in pasts})
