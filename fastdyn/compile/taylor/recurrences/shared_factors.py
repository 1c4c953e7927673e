"""Moves a factor that all products with a power share into the recurrence of the power."""

from .operations import Power, Quotient, Sum


def share_factors(steps, uses, graph):
    """Move the factor f into a power or reciprocal b if every use of b is a product f a b.

    In the recurrence of b, f enters only the coefficient of order 0; in the products, f would
    multiply every order.
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
