"""Derivatives of the solutions of linear equations, forward and in reverse.

From A x = b follow A dx = db - dA x, and, for a cotangent w of x, the cotangents u of b and
-u x' of A, where A' u = w.  Both use the factors of A again.
"""

from .expressions import is_zero
from .refusal import Untraceable


def slopes(g, solution, known):
    """{input: the derivatives of the n numbers of a "solution"}; ``known(node)`` is a node's."""
    a, right, x = _parts(g, solution)
    given = [node for row in (*a, right) for node in row]
    inputs = dict.fromkeys(i for node in given for i in known(node))
    found = {}
    for i in inputs:
        rest = [known(b).get(i) for b in right]
        for r, row in enumerate(a):
            pairs = [(known(e)[i], x[c]) for c, e in enumerate(row) if i in known(e)]
            change = g.sum([g.mul(d, value) for d, value in pairs])
            if pairs:
                rest[r] = g.neg(change) if rest[r] is None else g.sub(rest[r], change)
        found[i] = _solved(g, solution.args[0], rest, solution.data)
    return found


def shares(g, solution, cotangents, wanted):
    """Yield (operand, cotangent) of a "solution", whose numbers have `cotangents` {i: node}."""
    a, right, x = _parts(g, solution)
    found = [cotangents.get(i) for i in range(len(x))]
    u = _solved(g, solution.args[0], found, not solution.data)
    yield from zip(right, u, strict=True)
    for row, factor in zip(a, u, strict=True):
        for element, value in zip(row, x, strict=True):
            if wanted(element):
                yield element, g.neg(g.mul(factor, value))


def _parts(g, solution):
    """The rows of the matrix, the right-hand side and the solution, as nodes."""
    factors, *right = solution.args
    n = len(right)
    if len(factors.args) != n * n:
        raise Untraceable("the derivative of a matrix in an array is not known", final=True)
    a = [list(factors.args[i * n : i * n + n]) for i in range(n)]
    if solution.data:  # the transposed matrix
        a = [list(row) for row in zip(*a, strict=True)]
    return a, right, [g.make("entry", (solution,), i) for i in range(n)]


def _solved(g, factors, right, transposed):
    """The numbers of another solution; None stands for zero."""
    right = [g.const(0.0) if b is None else b for b in right]
    if all(map(is_zero, right)):
        return right
    solution = g.make("solution", (factors, *right), transposed)
    return [g.make("entry", (solution,), i) for i in range(len(right))]
