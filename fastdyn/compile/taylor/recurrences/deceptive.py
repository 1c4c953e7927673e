"""Plans whose series may look right although the function changes within the step.

Far from its transition, a saturated tanh is constant to rounding, and a pulse vanishes: no term of
the series shows the transition.  A step must not carry the argument of such a function to the
transition: the argument may change by half of its value, or by the width of the transition.  Sums,
products, quotients, powers, sines and cosines of low degree cannot deceive: the terms of their
series decay slowly, and a zero or pole of low degree affects the series at a distance.  For all
other functions, the slopes of function and series are compared at a point inside the step.
"""

from typing import Any, NamedTuple

from fastdyn.trace.operations import OPERATIONS

from .operations import Choice, Integral, Power, Quotient, Root, Sum

MOST = 6.0  # highest degree, in one component or in the time, that cannot deceive
STEEP = 1.5  # a power with an exponent below -STEEP may be a pulse


class Hold(NamedTuple):
    """A node u that a step must not move farther than the larger of `width` and `share` |u|."""

    node: Any
    width: float
    share: float


def root(step):
    """The `Hold` of a root or power that must not touch zero: see `Plan.rooted`; or None.

    For a root, the node is the root itself, which changes more slowly than its argument.  For a
    pole, the node is the argument.
    """
    if isinstance(step, Root):
        return Hold(step.node, 0.0, 1.0)
    if isinstance(step, Power) and step.exponent % 1.0 and step.exponent > -1.0:
        return Hold(step.node if step.exponent > 0.0 else step.a, 0.0, 1.0)
    return None


def transition(step):
    """The `Hold` of the argument of a function with a transition, or of a steep pole; or None."""
    if isinstance(step, Power) and step.exponent < -STEEP:
        return Hold(step.a, 0.0, min(1.0, -2.0 * STEEP / step.exponent))
    if isinstance(step, Integral) and OPERATIONS[step.name].width and step.parts:
        return Hold(step.parts[0][1], OPERATIONS[step.name].width, 0.5)
    return None


def held(step):
    """The `Hold` of a step, or None."""
    return root(step) or transition(step)


def is_deceptive(plan):
    """True if steps of a plan must be compared with the function within the step."""
    degrees: dict = {}
    for step in plan.steps:
        unknown = isinstance(step, Integral) and OPERATIONS[step.name].width is None
        if unknown or isinstance(step, Choice):
            return True
        degrees[step.node.key] = found = _degree(step, degrees)
        if any(degree > MOST for degree in found.values()):
            return True
    return False


def _degree(step, known):
    """The degree of a step in each component and in the time; a pole counts as a zero."""

    def of(node):
        return {node.key: 1.0} if node.op in ("t", "y") else known.get(node.key, {})

    if isinstance(step, Sum):
        parts = [of(a) for _, a in step.terms]
        return _largest(parts + [_added(of(a), of(b)) for _, a, b in step.products])
    if isinstance(step, Quotient):
        return _added({} if step.a is None else of(step.a), of(step.b))
    if isinstance(step, Power):
        exponent = 1.0 if transition(step) else abs(step.exponent)
        return {key: exponent * degree for key, degree in of(step.a).items()}
    return of(step.a if isinstance(step, Root) else step.parts[0][1])


def _added(a, b):
    return {key: a.get(key, 0.0) + b.get(key, 0.0) for key in a | b}


def _largest(parts):
    keys = {key for part in parts for key in part}
    return {key: max(part.get(key, 0.0) for part in parts) for key in keys}
