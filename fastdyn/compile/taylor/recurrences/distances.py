"""Comparisons of roots as comparisons of the numbers under the roots.

The series of a distance sqrt(x^2 + y^2) ends at the nearest zero of the radicand, also at a complex
time, and steps that watch whether the distance exceeds R end there, too.  The radicand exceeds R^2
at the same times, and its series is as long as those of x and y.
"""

from .impossible_conditions import never_negative

TURNED = {"lt": "gt", "le": "ge", "eq": "eq", "gt": "lt", "ge": "le"}


def without_root(rewrite, op, a, b):
    """The comparison "lt", "le" or "eq" of rewritten nodes without a root; None for others."""
    for side, other, sign in ((a, b, op), (b, a, TURNED[op])):
        found = _isolated(rewrite, side, other, sign)
        if found is not None:
            return _of_radicands(rewrite, *found)
    return None


def _is_root(rewrite, node):
    _, exponent = rewrite.power_of(node)
    return exponent > 0.0 and exponent != int(exponent)


def _isolated(rewrite, node, rest, sign):
    """(root, rest, sign) such that ``root sign rest`` is ``node sign rest``; None without one."""
    g = rewrite.graph
    while not _is_root(rewrite, node):
        known = [rewrite.is_invariant(a) for a in node.args]
        if node.op == "neg":
            node = node.args[0]
            rest = g.neg(rest)
            sign = TURNED[sign]
        elif node.op in ("add", "sub") and sum(known) == 1:
            at = known.index(False)
            fixed, node, op = node.args[1 - at], node.args[at], node.op
            if op == "sub" and at == 1:
                rest = g.sub(fixed, rest)
                sign = TURNED[sign]
            else:
                rest = g.sub(rest, fixed) if op == "add" else g.add(rest, fixed)
        elif node.op in ("mul", "div") and sum(known) == 1 and not (node.op == "div" and known[0]):
            factor = node.args[known.index(True)]
            if factor.op != "const" or factor.data == 0.0:
                return None
            rest = g.div(rest, factor) if node.op == "mul" else g.mul(rest, factor)
            node = node.args[known.index(False)]
            sign = sign if factor.data > 0 else TURNED[sign]
        elif node.op == "sub" and rest.op == "const" and rest.data == 0.0:
            node, rest = node.args
        else:
            return None
    return node, rest, sign


def _of_radicands(rewrite, root, rest, sign):
    g = rewrite.graph
    base, exponent = rewrite.power_of(root)
    zero = g.const(0.0)
    other = rewrite.power_of(rest)
    real = _never_below(g, base)
    if other[1] == exponent and not rewrite.is_invariant(rest):
        return g.both(g.both(real, _never_below(g, other[0])), g.compare(base, other[0], sign))
    if exponent == 0.5:
        bound = g.mul(rest, rest)
    elif rewrite.is_invariant(rest):
        bound = g.call("pow", rest, g.const(1.0 / exponent))
    else:
        return None
    found = g.compare(base, bound, sign)
    if sign in ("gt", "ge"):
        found = g.both(g.compare(rest, zero, "lt"), found, "or")
    else:
        found = g.both(g.compare(zero, rest, "lt" if sign == "lt" else "le"), found)
    return g.both(real, found)


def _never_below(g, base):
    """The condition that a radicand is not negative."""
    return g.true if never_negative(base) else g.compare(base, g.const(0.0), "ge")
