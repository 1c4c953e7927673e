"""LLVM's text, written directly: numbers, vectors, loops.

A value is a name or a constant.  None stands for zero: operations on None emit no instruction.
"""

import copy
import struct

from fastdyn.trace.operations import OPERATIONS

from .lines import Lines, hexadecimal

INDEX = "i64"


def number(constant):
    """The value of a constant."""
    return struct.unpack(">d", bytes.fromhex(constant[2:]))[0]


ZERO, ONE, MINUS, INFINITE = map(hexadecimal, (0.0, 1.0, -1.0, float("inf")))
OF_VECTORS = "fastdyn_vector_"  # prefix of the names of functions of vectors


class Text(Lines):
    """The lines of one function, whose numbers are doubles, or vectors of doubles.

    Parameters
    ----------
    fused : str
        LLVM's name of a b + c: "fma", or "fmuladd" for a processor without the instruction.
    lanes : int
        Lanes of a vector; 1 for doubles.  A constant stands for a vector of equal lanes.
    """

    def __init__(self, fused="fma", lanes=1):
        super().__init__()
        self.fused = fused
        self._take(lanes)

    def _take(self, lanes):
        self.lanes = lanes
        self.kind, self.truth, self.whole = (self.many(each) for each in ("double", "i1", "i64"))
        self._suffix = "f64" if lanes == 1 else f"v{lanes}f64"

    def of(self, lanes):
        """A Text for vectors of `lanes` lanes that writes into the same function."""
        other = copy.copy(self)
        other._take(lanes)
        return other

    def call(self, name, kind, *args):
        """Call a function whose arguments have the type of its result."""
        self.declarations[name] = f"declare {kind} @{name}({', '.join([kind] * len(args))})"
        return self.new(f"call {kind} @{name}({', '.join(f'{kind} {a}' for a in args)})")

    # -- numbers

    def many(self, kind):
        """The type of a vector with a `kind` in each lane."""
        return kind if self.lanes == 1 else f"<{self.lanes} x {kind}>"

    def operand(self, x):
        """A value or constant in LLVM's notation."""
        return self.splat(x, self.lanes) if self.lanes > 1 and x.startswith("0x") else x

    def add(self, a, b):
        if a is None or b is None:
            return b if a is None else a
        return self._two("fadd", a, b)

    def neg(self, a):
        if a is None or a.startswith("0x"):
            return a and hexadecimal(-number(a))
        return self.new(f"fneg {self.kind} {a}")

    def sub(self, a, b):
        if a is None or b is None:
            return self.neg(b) if a is None else a
        return self._two("fsub", a, b)

    def mul(self, a, b):
        if a is None or b is None:
            return None
        for one, other in ((a, b), (b, a)):
            if one in (ONE, MINUS):
                return other if one == ONE else self.neg(other)
        if a.startswith("0x") and b.startswith("0x"):
            return hexadecimal(number(a) * number(b))
        return self._two("fmul", a, b)

    def div(self, a, b):
        return None if a is None else self._two("fdiv", a, b)

    def fma(self, a, b, c):
        """a b + c"""
        if a is None or b is None or c is None:
            return c if a is None or b is None else self.mul(a, b)
        for one, other in ((a, b), (b, a)):
            if one in (ONE, MINUS):
                return self.add(other, c) if one == ONE else self.sub(c, other)
        return self.intrinsic(self.fused, a, b, c)

    def intrinsic(self, name, *args):
        """Call LLVM's intrinsic `name`."""
        return self.call(f"llvm.{name}.{self._suffix}", self.kind, *map(self.operand, args))

    def elementary(self, name, *args):
        """Call an elementary function of LLVM or C; for vectors, a function of the module."""
        if self.lanes > 1:
            return self.call(f"{OF_VECTORS}{name}", self.kind, *map(self.operand, args))
        llvm = OPERATIONS[name].llvm
        return self.call(f"{llvm}.f64" if llvm else name, self.kind, *args)

    def compare(self, sign, a, b):
        """The truth value of a comparison."""
        return self.new(f"fcmp {sign} {self.kind} {self.operand(a)}, {self.operand(b)}")

    def select(self, truth, a, b):
        """a if the truth value holds, else b."""
        either = ", ".join(f"{self.kind} {self.operand(x)}" for x in (a, b))
        return self.new(f"select {self.truth} {truth}, {either}")

    def truths(self, word, a, b):
        """Combine two truth values by "and", "or" or "xor"."""
        return self.new(f"{word} {self.truth} {a}, {b}")

    def _two(self, word, a, b):
        return self.new(f"{word} {self.kind} {self.operand(a)}, {self.operand(b)}")

    # -- vectors

    def constant(self, numbers):
        """A vector of constants."""
        return f"<{', '.join([f'double {hexadecimal(x)}' for x in numbers])}>"

    def splat(self, x, width):
        kind = f"<{width} x double>"
        if x.startswith("0x"):
            return self.constant([number(x)] * width)
        one = self.new(f"insertelement {kind} poison, double {x}, i64 0")
        zeros = f"<{width} x i32> zeroinitializer"
        return self.new(f"shufflevector {kind} {one}, {kind} poison, {zeros}")

    # -- memory

    def load(self, pointer, kind=None):
        kind = kind or self.kind
        align = ", align 8" if kind[0] == "<" else ""
        return self.new(f"load {kind}, ptr {pointer}{align}")

    def store(self, value, pointer, kind=None):
        kind = kind or self.kind
        if value is None:
            value = ZERO if kind == "double" else "zeroinitializer"
        elif kind == self.kind:
            value = self.operand(value)
        align = ", align 8" if kind[0] == "<" else ""
        self.put(f"store {kind} {value}, ptr {pointer}{align}")
