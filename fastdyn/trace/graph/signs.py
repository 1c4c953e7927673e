"""The sign of a number in other spellings: x / |x|, arctan2(x, 0), the sign of a zero."""

import math
from functools import reduce

from .expressions import live

GUARD = 1e-9  # of an absolute value in a quotient; beyond, |x| / x rests in a zone of this width
NOTHING = 1e-100  # a number that is added to |x| against 0 / 0, far below any size in a model
FACTORS = 16  # of a product that are looked at: a square of a square ... has any number


def signed(graph, outputs):
    """The outputs with each spelling of the sign of x as a choice by x < 0, as of np.sign.

    A spelling is a product with x and |x| on the two sides of its fraction bars, such as
    ``mu * x / abs(x)`` or ``x * (1 / abs(x))``, and ``arctan2(x, 0)`` or ``arctan2(0, x)``.  The
    absolute value is ``abs(x)``, ``sqrt(x * x)``, or a choice between x and -x, perhaps with a
    number up to NOTHING added.  Two zeros of different signs count as one.
    """
    while graph.batches is None:  # once more for each sign within a sign, or beside it in a product
        nodes = live(outputs)
        of_abs = absolute_values(nodes)
        inner = {x.key for x in of_abs.values()}
        found = {node.key: _replacement(graph, node, of_abs, inner) for node in nodes}
        replaced = {key: node for key, node in found.items() if node is not None}
        if not replaced:
            break
        outputs = forced(graph, outputs, {}, replaced)
    return outputs


def with_signs(graph, outputs):
    """The outputs of `signed` without guards of the quotients.

    A choice by whether |x| is above a number up to GUARD, which keeps the quotient from 0 / 0,
    becomes one by whether x is not 0.
    """
    found = signed(graph, outputs)
    if found is outputs:
        return outputs
    nodes = live(outputs)
    of_abs = absolute_values(nodes)
    replaced = {}
    for node in nodes:
        if node.op in ("lt", "le") and _is_guard(node):
            less, more = node.args
            x = of_abs.get(less.key, of_abs.get(more.key))
            if x is not None:
                still = graph.compare(x, graph.const(0.0), "eq")
                replaced[node.key] = still if less.key in of_abs else graph.negation(still)
    return forced(graph, found, {}, replaced)


def forced(graph, nodes, truths, replaced=None):
    """The nodes with some conditions given: `truths` by key, or other nodes in `replaced`."""
    new = {key: graph.true if truth else graph.false for key, truth in truths.items()}
    new.update(replaced or {})
    for node in live(nodes):
        if node.key in new:
            continue
        args = [new[a.key] for a in node.args]
        same = all(one is other for one, other in zip(args, node.args, strict=True))
        new[node.key] = node if same else graph.call(node.op, *args, data=node.data)
    return [new[node.key] for node in nodes]


def absolute_values(nodes):
    """The x of each node that is |x|, by the key of the node."""
    found = {}
    for node in nodes:
        x = _inside(node)
        if x is None and node.op == "add":
            x = next((found[a.key] for a in node.args if a.key in found), None)
            x = x if any(_is_const(a, 0.0, NOTHING) for a in node.args) else None
        if x is not None:
            found[node.key] = x
    return found


def _inside(node):
    """The x of abs(x), of sqrt(x * x) and of a choice between x and -x; None for other nodes."""
    if node.op == "abs":
        return node.args[0]
    if node.op == "sqrt":
        inner = node.args[0]
        return inner.args[0] if inner.op == "mul" and inner.args[0] is inner.args[1] else None
    if node.op != "select" or node.args[0].op not in ("lt", "le"):
        return None
    (less, more), *sides = node.args[0].args, *node.args[1:]
    for x, turned in (sides, sides[::-1]):
        if turned.op == "neg" and turned.args[0] is x:
            below = less is x and (more is turned or _is_const(more, 0.0, 0.0))
            above = more is x and (less is turned or _is_const(less, 0.0, 0.0))
            if (below and sides[0] is turned) or (above and sides[0] is x):
                return x
    return None


def _is_const(node, least, most):
    return node.op == "const" and least <= node.data <= most


def _is_zero(node):
    """Whether a node is the constant 0.0, without a sign."""
    return _is_const(node, 0.0, 0.0) and math.copysign(1.0, node.data) > 0.0


def _is_guard(node):
    """Whether a comparison is one with a number up to GUARD."""
    return sum(_is_const(a, 0.0, GUARD) for a in node.args) == 1


def _sign(graph, x):
    zero = graph.const(0.0)
    behind = graph.select(graph.compare(zero, x, "lt"), graph.const(1.0), zero)
    return graph.select(graph.compare(x, zero, "lt"), graph.const(-1.0), behind)


def _replacement(graph, node, of_abs, inner):
    """The node that has the sign of a number in place of its spelling; None for other nodes."""
    if node.op in ("mul", "div"):
        return _without_quotient(graph, node, of_abs, inner) if of_abs else None
    if node.op == "atan2":
        y, x = node.args
        if _is_zero(x):
            return graph.mul(graph.const(0.5 * math.pi), _sign(graph, y))
        if _is_zero(y):
            below = graph.compare(x, graph.const(0.0), "lt")
            return graph.select(below, graph.const(math.pi), graph.const(0.0))
    if node.op == "and" and {a.op for a in node.args} == {"eq", "lt"}:
        equal, less = sorted(node.args, key=lambda a: a.op)
        inverse, zero = less.args  # 1 / a < 0, where a == 0
        if inverse.op == "div" and _is_zero(zero) and inverse.args[1] in equal.args:
            return graph.false
    return None


def _without_quotient(graph, node, of_abs, inner):
    """A product with the sign of x in place of x / |x| or |x| / x; None if there is none."""
    above, below = _factors(graph, node, inner)
    for over, under in ((above, below), (below, above)):
        for size in over:
            x = of_abs.get(size.key)
            if x is not None and x in under:
                over.remove(size)
                under.remove(x)
                top = reduce(graph.mul, [_sign(graph, x), *above])
                return graph.div(top, reduce(graph.mul, below)) if below else top
    return None


def _factors(graph, node, inner):
    """The factors of a product, above and below its fraction bars.

    The numbers of which there are absolute values, those with keys in `inner`, are not parted.
    """
    sides: tuple = [], []
    todo = [(node, 0)]
    while todo:
        each, side = todo.pop()
        parted = each.key not in inner and len(sides[0]) + len(sides[1]) + len(todo) < FACTORS
        if parted and each.op in ("mul", "div"):
            todo.append((each.args[1], side if each.op == "mul" else 1 - side))
            todo.append((each.args[0], side))
        elif parted and each.op == "neg":
            todo.append((each.args[0], side))
            sides[0].append(graph.const(-1.0))
        else:
            sides[side].append(each)
    return sides
