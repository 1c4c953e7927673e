"""Decisions that earlier ones on a path imply: of ranges, of a schedule, of a table."""

from typing import Any, NamedTuple

FREE = 4  # decisions of a path, beyond which the order of parameters is taken for part of the code


class Bound(NamedTuple):
    """``x < limit`` (`upper`) or ``limit < x``; or equal, where it is not `strict`."""

    upper: bool
    strict: bool
    limit: Any  # a node that does not vary

    def opposite(self):
        """What holds of an x that is a number, where this does not."""
        return Bound(not self.upper, not self.strict, self.limit)


def bound_of(node):
    """What a comparison says, and of which node; None of another condition."""
    if node.op not in ("lt", "le"):
        return None
    a, b = node.args
    if a.varies == b.varies:
        return None
    strict = node.op == "lt"
    return (a, Bound(True, strict, b)) if a.varies else (b, Bound(False, strict, a))


class Implied:
    """What the decisions of a path say of each node that was compared."""

    def __init__(self, graph):
        self.graph = graph
        self._known: dict = {}  # (bound, truth) of each node
        self._numbers: set = set()  # nodes that are not NaN

    def note(self, node, value):
        """A decision that was taken."""
        found = bound_of(node)
        if found is not None:
            x, bound = found
            self._known.setdefault(x.key, []).append((bound, value))
            if value:
                self._numbers.add(x.key)

    def truth(self, node, many):
        """What follows for a condition; None if nothing does.

        Where parameters are compared, their order becomes part of the code, if decisions are
        `many`.
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
    """Whether a bound holds, as another was found to hold, or not to; None if nothing follows."""
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
    """Whether all that lies within a bound lies within another of the same direction."""
    a, b = (one.limit.value, other.limit.value)
    a, b = (a, b) if one.upper else (-a, -b)
    return a < b or (a == b and (one.strict or not other.strict))


def _apart(one, other):
    """Whether nothing lies within two bounds of opposite directions."""
    upper, lower = (one, other) if one.upper else (other, one)
    a, b = upper.limit.value, lower.limit.value
    return a < b or (a == b and (upper.strict or lower.strict))
