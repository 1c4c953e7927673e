"""The functions of a reduced system, as text: its motion, its projection, its residual.

Each is a function of (t, x, p): x is the reduced state, p the parameters of the graph, and behind
them, the bound of `pivots`.
"""

from .write import Text

NEWTON = 3  # iterations of equations that are not linear: errors of 1e-3 fall below rounding


def motion(reduced):
    """``motion(t, x, p)``: the derivative of the reduced state."""
    text, highest = _with_highest(reduced)
    place = {each: i for i, each in enumerate(reduced.states)}
    return text.function("motion", [
        f"x[{place[j, order + 1]}]" if (j, order + 1) in place else highest[j]
        for j, order in reduced.states
    ])  # fmt: skip


def components(reduced):
    """``components(t, x, p)``: all components of y."""
    given, place = reduced.given, {each: i for i, each in enumerate(reduced.states)}
    wanted = [given.place(k) for k in range(given.n)]
    wanted = [(given.columns.index(column), order) for column, order in wanted]
    text, highest = _text(reduced), []
    if any(each not in place for each in wanted):
        text, highest = _with_highest(reduced)
    return text.function("components", [
        f"x[{place[each]}]" if each in place else highest[each[0]] for each in wanted
    ])  # fmt: skip


def projection(reduced, depths):
    """``projection(t, x, p)``: the reduced state with what follows from the states mended."""
    text, d, c = _text(reduced), reduced.offsets.components, reduced.offsets.equations
    names = {place: f"x[{i}]" for i, place in enumerate(reduced.states)}
    for i, depth in enumerate(depths):
        m = len(depths) - i
        linear = all(c[row] > m for row in depth.rows)
        for _ in range(1 if linear else NEWTON):
            residuals = text.values([reduced.orders[row][c[row] - m] for row in depth.rows])
            matrix = _matrix(reduced, text, depth.rows, depth.follow)
            for j, change in zip(depth.follow, text.solved(matrix, residuals), strict=True):
                where = j, int(d[j]) - m
                names[where] = text.named(f"{names[where]} - {change}")
                text.let({reduced.node(*where).key: names[where]})
    return text.function("projection", [names[place] for place in reduced.states])


def pivots(reduced, depths):
    """``pivots(t, x, p)``: 1 / (1 + `choice.growth`) less the last of p; None without a choice."""
    text, squares = _text(reduced), []
    for depth in depths:
        matrix = _matrix(reduced, text, depth.rows, depth.follow)
        others = _matrix(reduced, text, depth.rows, depth.free)
        for right in zip(*others, strict=True):
            if any(entry != "0.0" for entry in right):
                squares += [f"{name} * {name}" for name in text.solved(matrix, right)]
    if not squares:
        return None
    total = "0.0"
    for square in squares:
        total = text.named(f"{total} + {square}")
    share = text.named(f"1.0 / (1.0 + {total})")  # smooth where the growth is infinite
    return text.function("pivots", f"{share} - p[{len(reduced.given.values)}]")


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
    values, n = text.values(nodes), len(columns)
    return [values[i * n : (i + 1) * n] for i in range(len(rows))]


def _with_highest(reduced):
    """(Text, the names of the highest orders by position)."""
    text, every = _text(reduced), range(len(reduced.orders))
    rest = [text.named(f"-{value}") for value in text.values(reduced.rest)]
    return text, text.solved(_matrix(reduced, text, every, every), rest)
