"""Rules for the differentials of a graph's operations.

A rule ``(graph, node, wanted)`` returns a list of pairs (factor, operand).  The differential of the
node is the sum of each factor times the differential of the operand.  ``wanted(operand)`` tells
whether the operand depends on an input.
"""

import math

import numpy as np

from .expressions import Graph


def _mul(g: Graph, node, wanted):
    a, b = node.args
    if a is b:
        return [(g.mul(g.const(2.0), a), a)]
    for root, other in ((a, b), (b, a)):
        rest = _without(g, other, root) if root.op == "sqrt" else None
        if rest is not None:  # at u = 0, u sqrt(u) has a derivative, sqrt(u) none
            u = root.args[0]
            if other is u:
                return [(g.mul(g.const(1.5), root), u)]
            return [(root, other), (g.mul(g.const(0.5), rest), u)]
    return [(b, a), (a, b)]


def _without(g, product, root):
    """The quotient product / root, if the square of `root` is a factor of `product`; else None."""
    if product is root.args[0]:
        return root
    if product.op == "mul":
        for one, other in (product.args, product.args[::-1]):
            rest = _without(g, one, root)
            if rest is not None:
                return g.mul(rest, other)
    return None


def _div(g, node, wanted):
    a, b = node.args
    inverse = g.div(g.const(1.0), b)
    factors = [(inverse, a)]
    if wanted(b):
        factors.append((g.neg(g.mul(node, inverse)), b))
    return factors


def _abs(g, node, wanted):
    (a,) = node.args
    below = g.compare(a, g.const(0.0), "lt")
    return [(g.select(below, g.const(-1.0), g.const(1.0)), a)]


def _pow(g, node, wanted):
    a, e = node.args
    factors = []
    if wanted(a):
        if e.op == "const":
            less = g.power(a, e.data - 1.0)
        else:
            less = g.make("call", (a, g.sub(e, g.const(1.0))), "pow")
        factors.append((g.mul(e, less), a))
    if wanted(e):
        zero = g.const(0.0)
        by_exponent = g.mul(node, g.make("call", (a,), "log"))
        factors.append((g.select(g.compare(node, zero, "eq"), zero, by_exponent), e))
    return factors


def _atan2(g, node, wanted):
    y, x = node.args
    inverse = g.div(g.const(1.0), g.add(g.mul(y, y), g.mul(x, x)))
    return [(g.mul(x, inverse), y), (g.neg(g.mul(y, inverse)), x)]


def _fmod(g, node, wanted):
    a, b = node.args
    factors = [(g.const(1.0), a)]
    if wanted(b):
        whole = g.make("round", (g.div(g.sub(a, node), b),), "rint")
        factors.append((g.neg(whole), b))
    return factors


def _piece(g, knots, x):
    """The index of the piece that contains x."""
    i = g.sub(g.make("search", (x,), (knots, "right")), g.const(1.0))
    i = g.select(g.compare(i, g.const(0.0), "lt"), g.const(0.0), i)
    last = g.const(len(g.tables[knots]) - 2)
    return g.select(g.compare(i, last, "lt"), i, last)


def _piecewise(g, node, wanted):
    knots, *coefficients = node.data
    m, (x,) = len(coefficients) - 1, node.args
    if m == 0:
        return []
    i = _piece(g, knots, x)
    at = g.sub(x, g.make("table", (i,), knots))
    slope = None
    for k, name in zip(range(m, 0, -1), coefficients[:-1], strict=True):
        c = g.mul(g.const(float(k)), g.make("table", (i,), name))
        slope = c if slope is None else g.add(g.mul(slope, at), c)
    return [(slope, x)]


def _slope(g, node):
    """The slope of the piece that contains x."""
    knots, heights = node.data
    i = _piece(g, knots, *node.args)
    after = g.add(i, g.const(1.0))

    def rise(table):
        return g.sub(*[g.make("table", (at,), table) for at in (after, i)])

    return g.div(rise(heights), rise(knots))


def inside_tables(g, node, slots):
    """Yield (slot, derivative) for each parameter of `slots` in the tables of a node."""
    if node.op == "table":
        for slot, unit in _units(g, node.data, slots):
            yield slot, g.make("table", node.args, unit)
    elif node.op == "interpolate":
        knots, heights = node.data
        for slot, unit in _units(g, heights, slots):
            yield slot, g.make("interpolate", node.args, (knots, unit))
        for slot, unit in _units(g, knots, slots):
            share = g.make("interpolate", node.args, (knots, unit))
            yield slot, g.neg(g.mul(_slope(g, node), share))


def _units(g, name, slots):
    """For each parameter in a table, yield (slot, name of a table with 1 there, 0 elsewhere)."""
    table = g.tables[name]
    if isinstance(table, range):
        for slot in slots:
            if slot in table:
                yield slot, g.table(np.arange(len(table)) == table.index(slot))


# -- functions of one number: a lambda makes the derivative from (graph, argument, value)


def _of_one(derivative):
    return lambda g, node, wanted: [(derivative(g, node.args[0], node), node.args[0])]


def _call(g, name, a):
    return g.make("call", (a,), name)


def _over(g, number, a):
    return g.div(g.const(number), a)


def _one_plus_square(g, a):
    return g.add(g.const(1.0), g.mul(a, a))


def _one_minus_square(g, a):
    """(1 - a) (1 + a), which keeps its accuracy where a is near 1."""
    return g.mul(g.sub(g.const(1.0), a), g.add(g.const(1.0), a))


def _minus_one_over_root(g, a, sign):
    return _over(g, sign, g.power(_one_minus_square(g, a), 0.5))


def _gauss(g, a, sign):
    bell = _call(g, "exp", g.neg(g.mul(a, a)))
    return g.mul(g.const(sign * 2 / math.sqrt(math.pi)), bell)


LOCAL = {
    "mul": _mul, "div": _div, "abs": _abs, "pow": _pow, "atan2": _atan2, "fmod": _fmod,
    "piecewise": _piecewise,
    "table": lambda g, node, wanted: [],
    "interpolate": lambda g, node, wanted: [(_slope(g, node), node.args[0])],
    "sqrt": _of_one(lambda g, a, f: _over(g, 0.5, f)),
    "cbrt": _of_one(lambda g, a, f: _over(g, 1 / 3, g.mul(f, f))),
    "sin": _of_one(lambda g, a, f: _call(g, "cos", a)),
    "cos": _of_one(lambda g, a, f: g.neg(_call(g, "sin", a))),
    "tan": _of_one(lambda g, a, f: _one_plus_square(g, f)),
    "asin": _of_one(lambda g, a, f: _minus_one_over_root(g, a, 1.0)),
    "acos": _of_one(lambda g, a, f: _minus_one_over_root(g, a, -1.0)),
    "atan": _of_one(lambda g, a, f: _over(g, 1.0, _one_plus_square(g, a))),
    "sinh": _of_one(lambda g, a, f: _call(g, "cosh", a)),
    "cosh": _of_one(lambda g, a, f: _call(g, "sinh", a)),
    "tanh": _of_one(lambda g, a, f: _one_minus_square(g, f)),
    "asinh": _of_one(lambda g, a, f: _over(g, 1.0, g.power(_one_plus_square(g, a), 0.5))),
    "acosh": _of_one(lambda g, a, f: _over(
        g, 1.0, g.power(g.neg(_one_minus_square(g, a)), 0.5))),
    "atanh": _of_one(lambda g, a, f: _over(g, 1.0, _one_minus_square(g, a))),
    "exp": _of_one(lambda g, a, f: f),
    "exp2": _of_one(lambda g, a, f: g.mul(g.const(math.log(2.0)), f)),
    "expm1": _of_one(lambda g, a, f: _call(g, "exp", a)),
    "log": _of_one(lambda g, a, f: _over(g, 1.0, a)),
    "log2": _of_one(lambda g, a, f: _over(g, 1 / math.log(2.0), a)),
    "log10": _of_one(lambda g, a, f: _over(g, 1 / math.log(10.0), a)),
    "log1p": _of_one(lambda g, a, f: _over(g, 1.0, g.add(g.const(1.0), a))),
    "erf": _of_one(lambda g, a, f: _gauss(g, a, 1.0)),
    "erfc": _of_one(lambda g, a, f: _gauss(g, a, -1.0)),
}  # fmt: skip
