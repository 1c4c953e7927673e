"""Nodes as multiples of other nodes: a multiple needs no recurrence of its own."""


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
        g, factor = self.rewrite.graph, self.one
        while not self.rewrite.is_invariant(node):
            if node.op == "neg":
                factor, node = g.neg(factor), node.args[0]
                continue
            if node.op == "mul":
                a, b = node.args
                if self.rewrite.is_invariant(b):
                    a, b = b, a
                if self.rewrite.is_invariant(a):
                    factor, node = g.mul(factor, a), b
                    continue
                (f, a), (h, b) = self(a), self(b)
                product = g.mul(a, b)
                if product is not node:
                    factor, node = g.mul(factor, g.mul(f, h)), product
                    continue
            if node.op == "div" and self.rewrite.is_invariant(node.args[1]):
                factor, node = g.div(factor, node.args[1]), node.args[0]
                continue
            return factor, node
        return g.mul(factor, node), None
