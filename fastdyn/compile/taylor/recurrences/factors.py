"""Factors of nodes: a multiple of a node needs no recurrence of its own.

`Scaled` splits a node into a factor and a core.  `share_factors` moves a factor that all products
with a power share into the recurrence of the power.
"""

from .operations import Power, Quotient, Sum


class Scaled:
    """Splits rewritten nodes into a factor and a core."""

    def __init__(self, rewrite):
        self.rewrite, self.one, self._known = rewrite, rewrite.graph.const(1.0), {}

    def __call__(self, node):
        """(f, core) with node = f core; the core of an invariant is None."""
        known = self._known.get(node.key)
        if known is None:
            known = self._known[node.key] = self._scaled(node)
        return known

    def _scaled(self, node):
        g = self.rewrite.graph
        factor = self.one
        while not self.rewrite.is_invariant(node):
            if node.op == "neg":
                factor = g.neg(factor)
                node = node.args[0]
                continue
            if node.op == "mul":
                a, b = node.args
                if self.rewrite.is_invariant(b):
                    a, b = b, a
                if self.rewrite.is_invariant(a):
                    factor = g.mul(factor, a)
                    node = b
                    continue
                f, a = self(a)
                h, b = self(b)
                product = g.mul(a, b)
                if product is not node:
                    factor = g.mul(factor, g.mul(f, h))
                    node = product
                    continue
            if node.op == "div" and self.rewrite.is_invariant(node.args[1]):
                factor = g.div(factor, node.args[1])
                node = node.args[0]
                continue
            return factor, node
        return g.mul(factor, node), None


def share_factors(steps, uses, graph):
    """Move the factor f into a power or reciprocal b if every use of b is a product f a b.

    In the recurrence of b, f multiplies only the coefficient of order 0.  In the products, f would
    multiply the coefficients of all orders.
    """
    sums = [step for step in steps if isinstance(step, Sum)]
    places: dict = {}
    for step in sums:
        for j, (_, a, b) in enumerate(step.products):
            for one in {a.key, b.key}:
                places.setdefault(one, []).append((step.products, j))
    given = set()
    for i, step in enumerate(steps):
        inverse = isinstance(step, Power) or (isinstance(step, Quotient) and step.a is None)
        found = places.get(step.node.key, [])
        factors = {products[j][0] for products, j in found}
        names = {(id(products), j) for products, j in found}
        if not inverse or len(factors) != 1 or names & given:
            continue
        (factor,) = factors
        if len(found) == uses[step.node.key] and factor is not graph.const(1.0):
            given |= names
            steps[i] = step._replace(factor=graph.mul(step.factor, factor))
            for products, j in found:
                products[j] = (graph.const(1.0), *products[j][1:])
