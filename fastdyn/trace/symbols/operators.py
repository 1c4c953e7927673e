"""The operators of symbols, and their rounding to whole numbers."""

import operator

import numpy as np

from .arithmetic import call, stored, to_decimals, to_whole, where
from .symbol import HANDLERS, Symbol


def _is_other(value):
    """Whether an operand is for its own class to handle."""
    return not (
        isinstance(value, int | float | complex | np.generic | np.ndarray | list | tuple)
        or type(value) is Symbol
        or type(value).__name__ == "Fraction"
    )


def _operators():
    def two(name, back):
        def method(self, other):
            if _is_other(other):
                return NotImplemented
            if self.py and isinstance(other, list | tuple):
                if name == "multiply":
                    return operator.index(self) * other
                return NotImplemented
            if isinstance(other, np.ndarray) and type(other) is not Symbol and back:
                return getattr(np, name)(other, self)
            both = (other, self) if back else (self, other)
            return HANDLERS["matmul"](*both) if name == "matmul" else call(name, *both)

        return method

    def in_place(name):
        def method(self, other):
            found = HANDLERS["matmul"](self, other) if name == "matmul" else call(name, self, other)
            return stored(found, self) if self.many else found

        return method

    names = {
        "add": "add", "sub": "subtract", "mul": "multiply", "truediv": "divide", "pow": "power",
        "mod": "remainder", "floordiv": "floor_divide", "divmod": "divmod", "and": "bitwise_and",
        "or": "bitwise_or", "xor": "bitwise_xor", "matmul": "matmul",
        "lshift": "left_shift", "rshift": "right_shift",
    }  # fmt: skip
    for short, name in names.items():
        setattr(Symbol, f"__{short}__", two(name, False))
        setattr(Symbol, f"__r{short}__", two(name, True))
        if name != "divmod":
            setattr(Symbol, f"__i{short}__", in_place(name))
    for short, name in (("lt", "less"), ("le", "less_equal"), ("gt", "greater"),
                        ("ge", "greater_equal"), ("eq", "equal"), ("ne", "not_equal")):  # fmt: skip
        setattr(Symbol, f"__{short}__", two(name, False))
    for short, name in (("neg", "negative"), ("pos", "positive"), ("abs", "absolute"),
                        ("invert", "invert")):  # fmt: skip
        setattr(Symbol, f"__{short}__", lambda self, name=name: call(name, self))


def _rounding(how):
    return lambda self: to_whole(self.single(), how)


def _round(self, digits=None):
    s = self.single()
    if digits is None:
        return to_whole(s, "rint")
    return s if s.kind in "bi" else to_decimals(s, digits)


_operators()
METHODS = {
    **{f"__{how}__": _rounding(how) for how in ("floor", "ceil", "trunc")},
    "__round__": _round,
    "choose": where,  # of the elimination in `kernels.algebra`
    **dict.fromkeys(("conjugate", "conj"), lambda self: call("conjugate", self)),
}
for _name, _method in METHODS.items():
    setattr(Symbol, _name, _method)
