"""The equations differentiated by time, on the graph, as often as the offsets say."""

from typing import NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import along, jacobian
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.graph.substitute import substituted

from .equations import Equations
from .signature import Offsets


class Differentiated(NamedTuple):
    """Equations and their derivatives, up to those that are linear in the highest orders.

    With equation i differentiated c_i times and component j of order d_j, the matrix is that of
    the derivatives of equation i by derivative d_j - c_i of component j.

    Attributes
    ----------
    given : Equations
    offsets : Offsets
    orders : list of list of Node
        ``orders[i][k]`` is derivative k of equation i; the last is of order c_i.
    matrix : dict
        The nodes of the matrix by (i, j), in positions, not in numbers of components.
    rest : list of Node
        The last derivatives with zeros for the highest orders.
    states : list of (int, int)
        (position j, order l < d_j), the components of the reduced state.
    extra : int
        1 if all equations were differentiated once more, to be linear or to have a state, else 0.
    """

    given: Equations
    offsets: Offsets
    orders: list
    matrix: dict
    rest: list
    states: list
    extra: int

    def node(self, j, order):
        return self.given.node(self.given.columns[j], order)

    def name(self, j, order):
        """The component that derivative `order` at position j is, or None."""
        return self.given.name(self.given.columns[j], order)

    def residual(self, i, m):
        """The node of equation i, differentiated c_i - m times."""
        return self.orders[i][int(self.offsets.equations[i]) - m]

    def levels(self):
        """The number of orders in the graph."""
        return 2 + int(self.offsets.components.max(initial=0))

    def with_values(self, values):
        """The equations with other parameters, of shape (n_slots,), or (n_slots, k) at k points."""
        return self._replace(given=self.given._replace(values=values))

    def numbers(self, nodes, t, z):
        """The values of nodes, (n_nodes, k), at k points.

        t has shape (k,); z of shape (m, k) has the derivatives of y, order by order.
        """
        return evaluate(self.given.graph, nodes, t, z, self.given.values)[0]

    def matrices(self, t, z):
        """The matrix at k points, shape (k, size, size)."""
        found = np.zeros((len(t), len(self.orders), len(self.orders)))
        if self.matrix:
            rows, columns = np.array(list(self.matrix)).T
            found[:, rows, columns] = self.numbers(list(self.matrix.values()), t, z).T
        return found


def differentiated(given, offsets):
    """The Differentiated equations.

    Raises
    ------
    ValueError
        If an operation of the function has no derivative.
    """
    try:
        extra = not _linear(given, offsets) or not offsets.components.any()
        if extra:
            offsets = Offsets(offsets.equations + 1, offsets.components + 1)
        return _differentiated(given, offsets, int(extra))
    except Untraceable as reason:
        raise ValueError(f"the equations cannot be differentiated: {reason}") from None


def _differentiated(given, offsets, extra):
    graph = given.graph
    c, d = offsets
    orders = [[output] for output in given.outputs]
    for i, found in enumerate(orders):
        for _ in range(c[i]):
            found.append(*along(graph, found[-1:], _motion(given, d)))
    slopes = _slopes(given, d)
    matrix = {}
    for j, column in enumerate(given.columns):
        for i in np.flatnonzero(c <= d[j]):
            entry = slopes.get((int(i), int(d[j] - c[i]) * given.n + column))
            if entry is not None:
                matrix[int(i), j] = entry
    highest = {
        given.node(column, int(d[j])).key: graph.const(0.0)
        for j, column in enumerate(given.columns)
    }
    rest = substituted(graph, [found[-1] for found in orders], highest)
    states = [(j, order) for j in range(len(d)) for order in range(int(d[j]))]
    return Differentiated(given, offsets, orders, matrix, rest, states, extra)


def _motion(given, d):
    """Each input of the graph that moves in time, and its rate."""
    graph = given.graph
    found = [(graph.make("t"), graph.const(1.0))]
    for column, highest in zip(given.columns, d, strict=True):
        for order in range(int(highest)):
            found.append((given.node(column, order), given.node(column, order + 1)))
    return found


def _slopes(given, d):
    """The derivatives of the equations by the nodes of each order, where they are not zero."""
    found = jacobian(given.graph, given.outputs, int(d.max(initial=0) + 1) * given.n)
    return {(int(i), int(place)): node for i, place, node in zip(*found, strict=True)}


def _linear(given, offsets):
    """Whether the equations that are not differentiated are linear in the highest orders."""
    c, d = offsets
    places = {int(d[j]) * given.n + column for j, column in enumerate(given.columns)}
    highest = {given.graph.make("y", (), place).key for place in places}
    return not any(
        c[i] == 0 and place in places and highest & {node.key for node in live([slope])}
        for (i, place), slope in _slopes(given, d).items()
    )
