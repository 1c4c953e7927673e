"""Jumps of a function along a solution, where a condition on the state changes."""

import numpy as np

from ..operations import OPERATIONS
from ..operations.value import by_rule
from .evaluate import evaluate
from .expressions import live
from .signs import signed

HALVINGS = 60  # more than the 53 bits of a time
AT_THE_END = 1e-9  # fraction of a step
TOLERANCE = 1e-6  # smallest jump that counts, relative to the largest output along the solution


def decisions(graph, outputs, slots, in_time=False):
    """The nodes that change discontinuously with the state, or with the parameters in `slots`.

    States of the past count as the state; `in_time` lets the time count, too.
    """
    found = []
    depends = set()
    for node in live(signed(graph, outputs)):
        own = node.op in ("y", "of_past", "of_slope") or (node.op == "par" and node.data in slots)
        own = own or (in_time and node.op == "t")
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
    steps, rows = np.nonzero((sides[:, 1:] != sides[:, :-1]).T)  # in the order of time
    if not len(steps):
        return None
    low = times[steps]
    high = times[steps + 1]
    own = sides[rows, steps]
    for _ in range(HALVINGS):  # of all changes at once
        middle = (low + high) / 2
        same = at(middle, [], nodes)[1][rows, np.arange(len(rows))] == own
        low = np.where(same, middle, low)
        high = np.where(same, high, middle)
    both = np.array([at(low, outputs)[0], at(high, outputs)[0]])
    with np.errstate(invalid="ignore"):
        rise = np.fmax.reduce(np.abs(both[1] - both[0]))  # a slope at the jump may be NaN
        along = np.abs(np.concatenate([*both, at(times, outputs)[0]], axis=1))
    jumps = rise > TOLERANCE * along[np.isfinite(along)].max(initial=0.0)
    # An event may have ended the solution at a change.
    jumps &= np.abs(times[-1] - low) > AT_THE_END * np.abs(times[steps + 1] - times[steps])
    return float(high[jumps.argmax()]) if jumps.any() else None
