"""Comparisons that earlier decisions on a path imply: t < 1 implies t < 2."""

from typing import Any, NamedTuple

FREE = 4  # from so many decisions on, a path may assume the current order of two parameters


class Bound(NamedTuple):
    """``x < limit`` if `upper`, else ``limit < x``; <= instead of < if not `strict`."""

    upper: bool
    strict: bool
    limit: Any  # a node that does not vary

    def opposite(self):
        """The negation of this bound, for an x that is not NaN."""
        return Bound(not self.upper, not self.strict, self.limit)


def bound_of(node):
    """(compared node, Bound) of a comparison with a limit that does not vary; else None."""
    if node.op not in ("lt", "le"):
        return None
    a, b = node.args
    if a.varies == b.varies:
        return None
    strict = node.op == "lt"
    return (a, Bound(True, strict, b)) if a.varies else (b, Bound(False, strict, a))


class Implied:
    """The bounds that the decisions of a path set for each compared node."""

    def __init__(self, graph):
        self.graph = graph
        self._known: dict = {}  # (bound, truth) of each node
        self._numbers: set = set()  # nodes that are not NaN

    def note(self, node, value):
        """Record the decision that the condition `node` has the truth `value`."""
        found = bound_of(node)
        if found is not None:
            x, bound = found
            self._known.setdefault(x.key, []).append((bound, value))
            if value:
                self._numbers.add(x.key)

    def is_number(self, node):
        """Store that a node is not NaN."""
        self._numbers.add(node.key)

    def truth(self, node, many):
        """The truth of a condition if earlier decisions imply it, else None.

        Limits that depend on parameters are compared only with `many`.  The code is then valid only
        for the current order of these limits.
        """
        found = bound_of(node)
        if found is None:
            return None
        x, bound = found
        is_number = x.op == "t" or x.key in self._numbers
        for known, held in self._known.get(x.key, ()):
            constant = known.limit.op == bound.limit.op == "const"
            if not (constant or many):
                continue
            value = _follows(bound, known, held, is_number)
            if value is not None:
                if not constant:
                    self._assume_order(known.limit, bound.limit)
                return value
        return None

    def _assume_order(self, a, b):
        g = self.graph
        if a.value > b.value:
            a, b = b, a
        g.assume(g.compare(a, b, "lt" if a.value < b.value else "eq"))


def _follows(bound, known, held, is_number):
    """The truth of `bound`, if the truth `held` of the bound `known` implies it; else None."""
    if not held:
        if known.upper is bound.upper and _within(bound, known):
            return False
        if not is_number:
            return None
        known = known.opposite()
    if known.upper is bound.upper:
        return True if _within(known, bound) else None
    return False if _apart(known, bound) else None


def _within(one, other):
    """Whether the bound `one` implies `other`, a bound of the same direction."""
    a, b = (one.limit.value, other.limit.value)
    a, b = (a, b) if one.upper else (-a, -b)
    return a < b or (a == b and (one.strict or not other.strict))


def _apart(one, other):
    """Whether no x satisfies both of two bounds of opposite directions."""
    upper, lower = (one, other) if one.upper else (other, one)
    a, b = upper.limit.value, lower.limit.value
    return a < b or (a == b and (upper.strict or lower.strict))
