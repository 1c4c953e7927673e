"""Values of a graph under Python's operators, with which the rules of records are written."""

from functools import partial
from typing import Any


class Value:
    """A value `of` a graph g, for example a node.

    The graph has ``call(operation, *values, data=None)``, ``const(number)`` and `tables`.
    """

    __slots__ = ("g", "of")
    __hash__: Any = None
    __eq__: Any = lambda a, b: call("eq", a, b)
    __ne__: Any = lambda a, b: ~call("eq", a, b)
    __abs__, __neg__, __invert__ = (lambda a, op=op: call(op, a) for op in ("abs", "neg", "not"))

    def __init__(self, g, of):
        self.g = g
        self.of = of

    def read(self, operation, data):
        """Read a table at this value."""
        return Value(self.g, self.g.call(operation, self.of, data=data))


def call(operation, *values) -> Any:
    """An operation on values and numbers, one of them at least a value."""
    g = next(v.g for v in values if isinstance(v, Value))
    return Value(g, g.call(operation, *[_of(g, v) for v in values]))


def by_rule(g, rule, *values):
    """The result of a rule, or of a number in its place, for values of a graph."""
    return _of(g, rule(*[Value(g, v) for v in values]) if callable(rule) else rule)


def _of(g, value):
    return value.of if isinstance(value, Value) else g.const(value)


for _name, _operation, _reflected in (
    ("add", "add", "radd"), ("sub", "sub", "rsub"), ("mul", "mul", "rmul"),
    ("truediv", "div", "rtruediv"), ("lt", "lt", "gt"), ("le", "le", "ge"), ("and", "and", "rand"),
    ("or", "or", "ror"),
):  # fmt: skip
    setattr(Value, f"__{_name}__", lambda a, b, op=_operation: call(op, a, b))
    setattr(Value, f"__{_reflected}__", lambda a, b, op=_operation: call(op, b, a))
exp, log, log1p, sin, cos, sinh, cosh, sqrt, floor, rint, fmod, power, select = (
    partial(call, name)
    for name in "exp log log1p sin cos sinh cosh sqrt floor rint fmod pow select".split()
)
