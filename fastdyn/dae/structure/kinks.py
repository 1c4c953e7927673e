"""Kinks and jumps of constraints: where an equation that constrains the states is not smooth."""

import numpy as np

from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.jumps import first_jump

from .trajectory import orders

LEAST = 1e-3  # in the unit of a constraint: jumps below a millionth of this are rounding


def decisions(reduced):
    """The nodes that change discontinuously and on which constraints of the states depend."""
    found = {}
    for node in live(_constraints(reduced)):
        decides = node.args[0] if node.op == "select" else node if node.op == "round" else None
        if decides is not None:
            found[decides.key] = decides
    return list(found.values())


def jump_of(reduced, nodes, found):
    """The first time of a result at which a constraint jumps, or None."""
    graph, values = reduced.given.graph, reduced.given.values
    outputs = [*_constraints(reduced), graph.const(LEAST)]
    outputs += [reduced.node(*place) for place in reduced.states]  # by which a jump is measured
    return first_jump(
        graph, outputs, nodes, found.t, lambda t: orders(reduced, np.asarray(found.sol(t))), values
    )


def _constraints(reduced):
    """The equations and derivatives that hold for the reduced state: all but the last ones."""
    return [node for each in reduced.orders for node in each[:-1]]
