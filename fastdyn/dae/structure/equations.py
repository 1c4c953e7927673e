"""The graph of F(t, y, y'), and the names of its variables.

In the graph, node ("y", l n + j) is the derivative of order l of component j.  An equation
y_j' = y_k defines y_k: the component k is then the derivative of component j, and the equation is
left out, so that the equations that remain are of higher order and fewer.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.derivatives.sensitivities import slots_of
from fastdyn.compile.mode import RESIDUAL
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.trace.graph.derivatives import jacobian
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.substitute import substituted
from fastdyn.trace.reads.reads import flat

from ..functions import of_vector


class Equations(NamedTuple):
    """Equations of a graph.

    Attributes
    ----------
    graph : Graph
    n : int
        Number of components of y.
    rows : list of int
        The equations, as the function numbers them.
    outputs : list of Node
        The residuals of these equations.
    columns : list of int
        The components that these equations determine.
    values : ndarray
        The parameters, by slot.
    alias : dict
        For each other component (component j, order l): the component is derivative l of y_j.
    varied : tuple of int
        The slots of the arguments among the directions of `sensitivity`, in the order of these;
        then those of the others that vary, in the order of the arguments.
    """

    graph: Any
    n: int
    rows: list
    outputs: list
    columns: list
    values: np.ndarray
    alias: dict
    varied: tuple = ()

    def node(self, j, order=0):
        """The node of a derivative of component j."""
        return self.graph.make("y", (), order * self.n + j)

    def name(self, j, order=0):
        """The index of the component that is derivative `order` of y_j; None if there is none."""
        if order == 0:
            return j
        return next((k for k, place in self.alias.items() if place == (j, order)), None)

    def place(self, k):
        """(component j, order l) of component k."""
        return self.alias.get(k, (k, 0))


def equations(given, varying=()):
    """(The Equations of a problem.DaeArguments, one for each residual; the key of their graph).

    `varying` has the positions of arguments, from 1, that differ between trajectories.

    The trace is that of the residual that BDF solves: one trace serves both, and is remembered.
    Two functions with one key have equal graphs.

    Raises
    ------
    ValueError
        If the function cannot be traced.
    """
    n = given.n
    both = np.concatenate([given.y0, given.yp0])
    residual = of_vector(given.F, n)
    near = Near(given.t0, given.tf, off_the_solution(both))
    positions = [d.position for d in given.directions or () if d.position]
    positions += sorted({*varying} - {*positions})
    attempt = Attempt(residual, given.args, RESIDUAL, 2 * n, sorted(positions))
    found = traced_function(attempt, near)
    if found is None:
        reason = attempt.facts().refusal
        attempt.forget_refusals()
        raise ValueError(
            "index reduction needs a function that can be traced, and this one cannot"
            f"{': ' * bool(reason)}{reason or ''}. Equations of index 1 need no reduction."
        )
    function, parameters, at = found
    values = flat([value for _, value in parameters])
    trace = function.traced.trace
    rows = list(range(n))
    varied = tuple(slot for j in positions for slot in slots_of(trace.reads, at[j - 1], n))
    whole = Equations(trace.graph, n, rows, trace.outputs[:n], rows, values, {}, varied)
    return whole, function.key


def without_aliases(given, barred=()):
    """The Equations with each equation y_j' = y_k used to replace y_k, if k is not `barred`."""
    alias: dict = {}
    kept = []
    for row, output in zip(given.rows, given.outputs, strict=True):
        pair = _derivative_of(given, output)
        if pair is None or pair[1] in {*alias, *barred} or _root(alias, pair[0])[0] == pair[1]:
            kept.append((row, output))
        else:
            alias[pair[1]] = pair[0]  # component: the component of which it is the derivative
    if not alias:
        return given
    place = {k: _root(alias, k) for k in alias}
    inputs = {}
    for k, (j, order) in place.items():
        for level in (0, 1):
            inputs[given.node(k, level).key] = given.node(j, order + level)
    outputs = substituted(given.graph, [output for _, output in kept], inputs)
    columns = [j for j in given.columns if j not in alias]
    return given._replace(
        rows=[row for row, _ in kept], outputs=outputs, columns=columns, alias=place
    )


def _root(alias, k):
    """(component j that is no alias, order l) of component k."""
    order = 0
    while k in alias:
        k = alias[k]
        order = order + 1
    return k, order


def _derivative_of(given, output):
    """(j, k) if the output is a multiple of y_j' - y_k, else None."""
    nodes = live([output])
    if any(node.op not in ("y", "add", "sub", "neg", "const", "mul", "div") for node in nodes):
        return None
    inputs = sorted(node.data for node in nodes if node.op == "y")
    if len(inputs) != 2 or inputs[0] >= given.n or inputs[1] < given.n:
        return None
    _, _, slopes = jacobian(given.graph, [output], 2 * given.n)
    if len(slopes) != 2 or any(slope.op != "const" for slope in slopes):
        return None
    at_rest = evaluate(given.graph, [output], np.zeros(1), np.zeros((2 * given.n, 1)), ())[0]
    k = inputs[0]
    j = inputs[1] - given.n
    return (j, k) if j != k and slopes[0].data == -slopes[1].data and at_rest == 0 else None
