"""The phases of event functions: numbers with which a function turns, though the solution does not.

A step may contain several turns of sin(50 t), or all of a narrow peak exp(-((t - 5) / s)**2): see
`kernels/output/series_roots/phases.py`, which divides such steps.  Sums and products are about as
slow as their operands, and have no phases: most event functions have none.  Neither have quotients
by numbers of the state alone, and the angle of two numbers, whose relative changes the steps of the
solution follow.  Roots and logarithms have the logarithm and the sign of their operand: at its zero
they have a cusp.
"""

import math
from typing import Any, NamedTuple

from fastdyn.kernels.output.arguments import MOST_PHASES
from fastdyn.trace.graph.expressions import MAX_EXPONENT, live
from fastdyn.trace.operations import OPERATIONS

from ..mode import ENTRIES

LOGARITHMS = ("log", "log2", "log10")
STEEP = 1.5  # of a logarithm as a phase: a number changes by a factor of 2.8 in a part


class Phases(NamedTuple):
    """The compiled function of the phases, and the number of phases of each kind."""

    function: Any
    n_periodic: int = 0
    n_transitions: int = 0
    n_divisors: int = 0

    @property
    def fields(self):
        """The fields of an EVENTS record."""
        found = self._asdict()
        function = found.pop("function")
        return found | {"phases": 0 if function is None else function.address}


NONE = Phases(None)


def phases(function):
    """The Phases of a compiled event function; none of a function that was not traced."""
    if function is None or function.traced is None or function.in_batches:
        return NONE
    return function.derived("phases", lambda: _compiled(function.traced))


def _compiled(traced):
    kinds = _found(traced.trace.graph, traced.stored)
    kinds = [list({node.key: node for node in kind}.values()) for kind in kinds]
    while sum(map(len, kinds)) > MOST_PHASES:  # sums of waves: the last terms are the fastest
        max(kinds, key=len).pop(0)
    nodes = [node for kind in kinds for node in kind]
    if not nodes:
        return NONE
    graph = traced.trace.graph
    function = traced.with_outputs(nodes, ENTRIES, traced.n, graph.false).compiled()
    return Phases(function, *map(len, kinds))


def _is_steep(node):
    """Whether an operation has a pole, or an infinite slope, where its first operand is zero."""
    if node.op == "pow":
        exponent = node.args[1]
        return exponent.op == "const" and not float(exponent.data).is_integer()
    return node.op in LOGARITHMS or OPERATIONS[node.op].root


def _found(graph, outputs):
    """The phases of outputs: operands of periodic functions, of transitions, and divisors."""
    periodic = []
    transitions = []
    divisors = []
    timed = set()
    moving = set()
    for node in live(outputs):
        operation = OPERATIONS[node.op]
        of: Any = node.args[0] if node.args else None
        if node.op == "t" or any(each.key in timed for each in node.args):
            timed.add(node.key)
        if node.op == "y" or any(each.key in moving for each in node.args):
            moving.add(node.key)
        fast = timed | moving
        if not any(each.key in fast for each in node.args):
            continue
        if _is_steep(node):
            of_zero = of.args[0] if of.op == "abs" else of
            size = graph.call("log", graph.call("abs", of_zero))
            periodic.append(graph.mul(graph.const(STEEP), size))
            periodic.append(graph.call("copysign", graph.const(math.pi), of_zero))
        if node.op == "pow":
            exponent = node.args[1]
            large = exponent.op == "const" and abs(exponent.data) > MAX_EXPONENT
            if large or exponent.key in fast:
                transitions.append(graph.mul(exponent, graph.call("log", graph.call("abs", of))))
        elif node.op == "div" or node.op in LOGARITHMS:
            if node.args[-1].key in timed:
                divisors.append(node.args[-1])
        elif node.op == "fmod":
            if node.key in moving:
                periodic.append(graph.div(*node.args))
        elif operation.whole:
            if node.key in moving:  # other jumps are switching times
                periodic.append(node)
        elif operation.width or node.op == "exp2":
            transitions.append(of)
        elif operation.elementary and not operation.monotone and node.op != "atan2":
            periodic += [each for each in node.args if each.key in fast]
    return periodic, transitions, divisors
