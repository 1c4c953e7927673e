"""Powers under Python's rules: the conditions under which a power raises or is complex."""

import numpy as np

from ...operations.domains import overflows
from ...operations.value import by_rule
from ..graph.domains import too_large_a_power, zero_to_a_negative_power


def note_power(base, o, result, kind):
    """Add the conditions under which a power raises, or is left to Python."""
    whole = kind == 0  # Python's integers
    g, value, zero = base.g, o.node.value, base.g.const(0.0)
    negative = g.compare(base.node, zero, "lt")
    if not whole and (o.node.varies or value != np.rint(value)):
        if o.node.varies:
            whole = g.compare(g.call("floor", o.node), o.node, "eq")
            negative = g.both(negative, g.negation(whole))
        g.leaves_to_python_if(negative)  # Python gives a complex number
    if not whole and (o.node.varies or value < 0):
        at_zero = g.compare(base.node, zero, "eq")
        if o.node.varies:
            at_zero = g.both(at_zero, g.compare(o.node, zero, "lt"))
        g.raises_if(at_zero, zero_to_a_negative_power)
    if whole:
        g.keep_exact(result)
    elif result.op in ("pow", "sqrt", "mul", "div"):
        g.raises_if(by_rule(g, overflows, result, base.node, o.node), too_large_a_power)
