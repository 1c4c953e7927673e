"""Jumps of a function along a solution, where a condition on the state changes."""

import numpy as np

from ...operations import OPERATIONS
from ...operations.value import by_rule
from .evaluate import evaluate
from .expressions import live

HALVINGS = 60  # more than the 53 bits of a time
AT_THE_END = 1e-9  # fraction of a step
TOLERANCE = 1e-6  # smallest jump that counts, relative to the largest output


def decisions(graph, outputs, slots):
    """The nodes that change discontinuously with the state, or with the parameters in `slots`."""
    found, depends = [], set()
    for node in live(outputs):
        own = node.op == "y" or (node.op == "par" and node.data in slots)
        if not own and not any(a.key in depends for a in node.args):
            continue
        depends.add(node.key)
        decision = OPERATIONS[node.op].decision
        if decision and (node.op != "select" or node.args[0].key in depends):
            found.append(by_rule(graph, decision, node, *node.args))
    return list({node.key: node for node in found}.values())


def first_jump(graph, outputs, nodes, times, solution, values):
    """The first time at which a decision changes and the outputs jump; None if there is none.

    Parameters
    ----------
    nodes : list of Node
        The result of `decisions`.
    times : ndarray, shape (k,)
        Ends of steps.  A decision changes at most once in a step.
    solution : callable
        ``solution(times)`` has shape (n, k).
    values : sequence of float
        The parameters, by slot.
    """

    def at(t, wanted, watch=()):
        return evaluate(graph, wanted, t, solution(t), values, watch)

    sides = at(times, [], nodes)[1]
    for i in np.flatnonzero((sides[:, 1:] != sides[:, :-1]).any(axis=0)):
        for row in np.flatnonzero(sides[:, i] != sides[:, i + 1]):
            ends = times[i], times[i + 1]
            for _ in range(HALVINGS):
                middle = (ends[0] + ends[1]) / 2
                same = at(np.array([middle]), [], [nodes[row]])[1][0, 0] == sides[row, i]
                ends = (middle, ends[1]) if same else (ends[0], middle)
            if abs(times[-1] - ends[0]) <= AT_THE_END * abs(times[i + 1] - times[i]):
                continue  # an event ended the solution here
            before, after = at(np.array(ends), outputs)[0].T
            if np.abs(after - before).max() > TOLERANCE * np.abs([before, after]).max():
                return float(ends[1])
    return None
