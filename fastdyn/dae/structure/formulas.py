"""The functions of a reduced system, as text: its motion, its projection, its residual.

Each is a function of (t, x, p): x is the reduced state, p the parameters of the graph.
"""

from typing import NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import entries, partials

from .eliminate import solved
from .write import Text

NEWTON = 3  # iterations of equations that are not linear: errors of 1e-3 fall below rounding


def motion(reduced, pivots=()):
    """``motion(t, x, p)``: the derivative of the reduced state; `pivots` as in `eliminate`."""
    text, highest = _with_highest(reduced, pivots)
    place = {each: i for i, each in enumerate(reduced.states)}
    return text.function("motion", [
        f"x[{place[j, order + 1]}]" if (j, order + 1) in place else highest[j]
        for j, order in reduced.states
    ])  # fmt: skip


def components(reduced, pivots=(), used=None):
    """``components(t, x, p)``: the components of y; nan for those that are not `used`."""
    given = reduced.given
    place = {each: i for i, each in enumerate(reduced.states)}
    wanted: list = [given.place(k) for k in range(given.n)]
    wanted = [(given.columns.index(column), order) for column, order in wanted]
    used = range(given.n) if used is None else used
    text = _text(reduced)
    highest = []
    if any(wanted[k] not in place for k in used):
        text, highest = _with_highest(reduced, pivots)
    names = ["float('nan')"] * given.n
    for k in used:
        names[k] = f"x[{place[wanted[k]]}]" if wanted[k] in place else highest[wanted[k][0]]
    return text.function("components", names)


def projection(reduced):
    """``projection(t, x, p)``: the nearest reduced state that satisfies the constraints.

    Depth by depth (see `constraints`), each for one order of the components: x - A' (A A')^-1 r
    with the residuals r and the part A of the matrix.
    """
    text = _text(reduced)
    d = reduced.offsets.components
    names = {place: f"x[{i}]" for i, place in enumerate(reduced.states)}
    for m, rows, columns, linear in constraints(reduced):
        for _ in range(1 if linear else NEWTON):
            residuals = text.values([reduced.residual(row, m) for row in rows])
            matrix = _matrix(reduced, text, rows, columns)
            square = [[_product(text, a, b) for b in matrix] for a in matrix]
            factors = text.solved(square, residuals)
            for j, column in zip(columns, zip(*matrix, strict=True), strict=True):
                change = _product(text, column, factors)
                if change != "0.0":
                    where = j, int(d[j]) - m
                    names[where] = text.named(f"{names[where]} - {change}")
                    text.let({reduced.node(*where).key: names[where]})
    return text.function("projection", [names[place] for place in reduced.states])


def elements(reduced):
    """``elements(t, x, p)``: the elements of the matrix, in the order of ``reduced.matrix``."""
    text = _text(reduced)
    return text.function("elements", text.values(list(reduced.matrix.values())))


def constraints(reduced):
    """Yield (depth m, rows, columns, whether they are linear), the deepest first.

    At depth m, the equations with c_i >= m, differentiated c_i - m times, hold for the components
    in the order d_j - m.
    """
    c, d = reduced.offsets
    for m in range(int(c.max(initial=0)), 0, -1):
        rows = [int(i) for i in (c >= m).nonzero()[0]]
        columns = [int(j) for j in (d >= m).nonzero()[0]]
        yield m, rows, columns, all(c[i] > m for i in rows)


class Slopes(NamedTuple):
    """The derivatives of some equations: `nodes` in the places `rows`, `columns` of a matrix.

    The columns are all orders of all components, and then the parameters that are varied.
    """

    rows: np.ndarray
    columns: np.ndarray
    nodes: list
    shape: tuple

    def at(self, reduced, t, z):
        """The matrices at k points, shape (k, *shape)."""
        found = np.zeros((len(t), *self.shape))
        if self.nodes:
            found[:, self.rows, self.columns] = reduced.numbers(self.nodes, t, z).T
        return found


def slopes(reduced, varied):
    """The Slopes of the equations of each depth of `constraints`, and then of the last orders."""
    graph = reduced.given.graph
    size = (reduced.levels() + 1) * reduced.given.n
    inputs = [graph.make("y", (), i) for i in range(size)]
    inputs += [graph.make("par", (), slot) for slot in varied]
    together = [[reduced.residual(row, m) for row in rows] for m, rows, *_ in constraints(reduced)]
    together.append([found[-1] for found in reduced.orders])
    all_slopes = []
    for outputs in together:
        found = entries(partials(graph, outputs, inputs))
        all_slopes.append(Slopes(*found, (len(outputs), len(inputs))))
    return all_slopes


def _product(text, a, b):
    """The name of the sum of products of two lists of names."""
    terms = [f"{x} * {y}" for x, y in zip(a, b, strict=True) if "0.0" not in (x, y)]
    if not terms:
        return "0.0"
    return text.named(" + ".join(terms))


def residual(reduced, chosen):
    """``residual(t, x, p)`` of index 1, and the names of its unknowns.

    The unknowns Y are all orders of the components, as (position, order); x has Y, and then Y'.
    The residual has all differentiated equations, and y' = z for each state y of `chosen`.
    """
    d = reduced.offsets.components
    unknowns = [(j, order) for j in range(len(d)) for order in range(int(d[j]) + 1)]
    place = {each: i for i, each in enumerate(unknowns)}
    text = Text(
        reduced.given.graph, {reduced.node(*each).key: f"x[{i}]" for each, i in place.items()}
    )
    results = text.values([node for found in reduced.orders for node in found])
    for j, order in chosen:
        rate = f"x[{len(unknowns) + place[j, order]}]"
        results.append(text.named(f"{rate} - x[{place[j, order + 1]}]"))
    return text.function("residual", results), unknowns


def _text(reduced):
    inputs = {reduced.node(*place).key: f"x[{i}]" for i, place in enumerate(reduced.states)}
    return Text(reduced.given.graph, inputs)


def _matrix(reduced, text, rows, columns):
    zero = reduced.given.graph.const(0.0)
    nodes = [reduced.matrix.get((i, j), zero) for i in rows for j in columns]
    values = text.values(nodes)
    n = len(columns)
    return [values[i * n : (i + 1) * n] for i in range(len(rows))]


def _with_highest(reduced, pivots):
    """(Text, the names of the highest orders by position)."""
    text = _text(reduced)
    every = range(len(reduced.orders))
    rest = [text.named(f"-{value}") for value in text.values(reduced.rest)]
    return text, solved(text, _matrix(reduced, text, every, every), rest, pivots)
