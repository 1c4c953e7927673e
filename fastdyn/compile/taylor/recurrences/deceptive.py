"""Plans whose series may look right although the function changes within the step.

Far from its transition a saturated tanh is constant to rounding, and a pulse vanishes: no term of
the series tells.  Sums, products, quotients, powers, sines and cosines of low degree cannot deceive
so: their coefficients decay slowly, and a zero or pole of low degree is seen from afar.
"""

from .operations import Choice, Integral, Power, Quotient, Root, Sum

MOST = 6.0  # degree in one component, or in the time
HONEST = frozenset(("sin", "cos"))


def is_deceptive(plan):
    """True if steps of a plan must be compared with the function within the step."""
    degrees: dict = {}
    functions = [step for step in plan.steps if isinstance(step, Integral)]
    if plan.signed or any(step.name not in HONEST for step in functions):
        return True
    for step in plan.steps:
        degrees[step.node.key] = found = _degree(step, degrees)
        if any(degree > MOST for degree in found.values()):
            return True
    return False


def _degree(step, known):
    """The degrees of a step in the leaves; poles count as zeros of the same degree."""

    def of(node):
        return {node.key: 1.0} if node.op in ("t", "y") else known.get(node.key, {})

    if isinstance(step, Sum):
        parts = [of(a) for _, a in step.terms]
        return _largest(parts + [_added(of(a), of(b)) for _, a, b in step.products])
    if isinstance(step, Quotient):
        return _added({} if step.a is None else of(step.a), of(step.b))
    if isinstance(step, Power):
        return {key: abs(step.exponent) * d for key, d in of(step.a).items()}
    if isinstance(step, Root):
        return of(step.a)
    if isinstance(step, Choice):
        return _largest([of(step.a), of(step.b)])
    return of(step.arguments[0])


def _added(a, b):
    return {key: a.get(key, 0.0) + b.get(key, 0.0) for key in a | b}


def _largest(parts):
    keys = {key for part in parts for key in part}
    return {key: max(part.get(key, 0.0) for part in parts) for key in keys}
