"""Functions with a short pulse, of which nobody was told yet."""

import itertools
import types

LINES = itertools.count(7000)


def pulse(t, start=5.0, width=0.2):
    return 1.0 if start < t < start + width else 0.0


def fresh(fun, name="pulsed"):
    """A copy of a function of which nobody was told yet: on a line of its own."""
    code = fun.__code__.replace(co_firstlineno=next(LINES))
    return types.FunctionType(code, fun.__globals__, name, None, fun.__closure__)
