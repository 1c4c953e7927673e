"""Conditions that no numbers fulfil, such as a negative sum of squares.

If such a condition decides whether the function raises, the condition is dropped: a step then
neither watches the sides of the condition nor calls the function.  In floating-point arithmetic,
too, such a condition never holds: a square, or a sum of squares, is at least zero, or is NaN, and
no comparison with NaN is true.
"""

from fastdyn.trace.graph.expressions import alternatives


def possible(graph, condition):
    """The condition without those terms of its disjunctions that never hold."""
    every = sorted(alternatives(condition), key=lambda one: one.key)
    left = [one for one in every if not _never_holds(one)]
    if len(left) == len(every):
        return condition
    found = graph.false
    for one in left:
        found = graph.both(found, one, "or")
    return found


def _never_holds(condition):
    """True if a conjunct of the condition is that a square is negative."""
    todo = [condition]
    while todo:
        one = todo.pop()
        if one.op == "and":
            todo += one.args
        elif one.op == "lt" and _never_positive(one.args[1]) and never_negative(one.args[0]):
            return True
    return False


def _never_positive(node):
    return node.op == "const" and node.data <= 0.0


def never_negative(node):
    """True if a node is made of squares, |x|, roots and constants >= 0 by sums and products."""
    seen = set()
    todo = [node]
    while todo:
        one = todo.pop()
        if one.key in seen:
            continue
        seen.add(one.key)
        square = one.op == "mul" and one.args[0] is one.args[1]
        if one.op in ("add", "mul") and not square:
            todo += one.args
        elif one.op == "const":
            if not one.data >= 0.0:
                return False
        elif not (square or one.op in ("abs", "sqrt")):
            return False
    return True
