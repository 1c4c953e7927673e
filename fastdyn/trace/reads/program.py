"""Reads the outside values of a traced function again, by Python source written for its trace.

One line of source reads one value or makes one check, and one line writes all parameters into a
block.  Reads on which nothing depends are left out.
"""

import builtins
import math
import struct
from typing import Any

import numpy as np

from ..graph.expressions import LARGEST_WHOLE, live
from ..written import function_of
from .reads import flat

MISSING = object()
MOST_KEPT = 2**12  # numbers of an array whose bytes are kept: to compare them takes 1 us
# Exceptions of a step or a check that cannot be done: the trace does not hold.
ERRORS = (AttributeError, KeyError, IndexError, TypeError, ValueError)
STEPS = {  # from a parent to a part of the parent
    "item": "{parent}[{key}]",
    "attribute": "{parent}.{name}",
    "cell": "{parent}.__closure__[{key}].cell_contents",
    "member": "getattr({parent}, {key}, MISSING)",
    "as base": "as_base({parent})",
    "numbers": "numbers({parent}, {key})",
    "real numbers": "real_numbers({parent})",
    "real parts": "contiguous({parent}.real).reshape(-1)",
    "entries": "ravel({parent})[slice(*{key})]",
    "itself": "{parent}",
    "remembered": "remembered({parent}, *{key})",
}
ABSENT = {  # steps to what may be missing
    "item": "{parent}.get({key}, MISSING)",
    "attribute": "getattr({parent}, {key}, MISSING)",
    "cell": "content({parent}.__closure__[{key}])",
}
CHECKS = {
    "same": "{value} is {expected}",
    "part": "{value} is {expected}",
    "absent": "{value} is MISSING",
    "nothing": "not {value}",
    "number": "type({value}) is {expected}",
    "type": "type({value}) is {expected}",
    "equal": "{value} is {expected} or equal({value}, {expected})",
    "size": "len({value}) == {expected}",
    "length": "type({value}) is {0} and len({value}) == {1}",
    "keys": "type({value}) is {0} and equal(list({value}), {1})",
    "class": "{value} is {0} and {value}.__mro__ is {1}",
    "instance": "type({value}) is {0} and {0}.__mro__ is {1}",
    "code": "{value}.__code__ is {0} and {value}.__globals__ is {1}",
    "array": "type({value}) is ndarray and {value}.dtype == {0} and {value}.shape == {1} "
    "and ({2} is None or {value}.strides == {2})",
    "real values": "not {value}.imag.any()",
    "content": "equal_arrays({value}, {0}, {1})",
    "bytes": "type({value}) is ndarray and {value}.dtype == {0} and {value}.shape == {1} and "
    "({2} is None or {value}.flags.c_contiguous == {2}) and {value}.tobytes() == {3}",
    "ascending": "({value}[1:] >= {value}[:-1]).all()",
}
FORMULAS = {
    "add": "{} + {}", "sub": "{} - {}", "mul": "{} * {}", "neg": "-{}", "abs": "abs({})",
    "lt": "{} < {}", "le": "{} <= {}", "eq": "{} == {}", "not": "not {}",
    "and": "{} and {}", "or": "{} or {}",
}  # fmt: skip


def reader(reads, zeros=(), address_of=None, first=0):
    """``read(fun, args, block=None)`` of a trace.

    The function returns the values of the parameters, and writes them into a block, if given, from
    byte `first` on; then the returned values must live as long as the block.  The result is None,
    and the block is unchanged, if the trace does not hold for `fun` and `args`, or if one of the
    slots `zeros` is not 0.
    """
    return _Writer(reads).function(np.asarray(zeros, int), address_of, first)


class _Writer:
    """The lines of a reader, and the objects that the lines name."""

    def __init__(self, reads):
        self.reads = reads
        self.lines: list[str] = []
        self.of_contents: dict[int, list[str]] = {}  # by the row of an array
        self.scope: dict = dict(NAMES)
        self.values = [self._value(group.row) for group in reads.groups]
        self.given = "".join([f"{value}, " for value in self.values])

    def function(self, zeros, address_of, first):
        for i in self._needed():
            self._read(i)
        self._compare_objects()
        self._compare_numbers(zeros)
        self._compare_contents()
        if address_of is not None:
            self.scope["address_of"] = address_of
            self._pack(first)
        arguments = "".join([f"a{i}, " for i in range(1, len(self.reads.roots))])
        self.lines.insert(0, f"{arguments}= args" if arguments else "if args: return None")
        self.lines.insert(0, "pass" if self.reads.lasting else "return None")
        body = "\n        ".join(self.lines)
        text = (
            f"def read(a0, args, block=None):\n    try:\n        {body}\n"
            f"        return ({self.given})\n"
            f"    except {self._named(ERRORS)}:\n        return None\n"
        )
        return function_of(text, "read", "reads of a trace", self.scope)

    def _needed(self):
        """The rows with a check, the rows of parameters, and the rows that lead to them."""
        reads = self.reads
        needed = set()
        todo = [i for i, row in enumerate(reads.rows) if row.check is not None]
        todo += [group.row for group in reads.groups]
        todo += [row for pair in reads.aliases for row in pair] + list(reads.pattern)
        while todo:
            row = todo.pop()
            if row >= 0 and row not in needed:
                needed.add(row)
                todo.append(reads.rows[row].parent)
        return [i for i in range(len(reads.rows)) if i in needed]  # the user may change `sorted`

    def _named(self, thing):
        """The name of an object in the source."""
        if thing is None or type(thing) is bool:
            return repr(thing)
        name = f"k{len(self.scope)}"
        self.scope[name] = thing
        return name

    def _value(self, i):
        """The name of the object of row i; a root is an argument of the reader."""
        row = self.reads.rows[i]
        if row.step == "known":
            self.scope[f"o{i}"] = row.key
            return f"o{i}"
        return f"a{row.key}" if row.step == "root" else f"v{i}"

    def _demand(self, condition, lines=None):
        lines = self.lines if lines is None else lines
        lines.append(f"if not ({condition}): return None")

    def _read(self, i):
        row = self.reads.rows[i]
        value = self._value(i)
        if row.step == "known":
            return
        lines = self.lines
        if row.check == "ascending":
            lines = self.of_contents.setdefault(row.parent, [])
        if row.parent >= 0:
            step = ABSENT.get(row.step) if row.check == "absent" else None
            step = step or STEPS[row.step]
            if "{name}" in step and not row.key.isidentifier():
                step = STEPS["member"]
            key = repr(row.key) if type(row.key) in (int, str) else self._named(row.key)
            text = step.format(parent=self._value(row.parent), key=key, name=row.key)
            lines.append(f"{value} = {text}")
        if row.check is not None:
            check = row.check
            given = row.expected
            if check == "content" and given[0].size <= MOST_KEPT and given[0].dtype.kind in "biufc":
                check = "bytes"
                given = _as_bytes(*given)
            text = CHECKS[check]
            parts = [*map(self._named, given)] if "{0}" in text else ()
            expected = "" if parts else self._named(given)
            self._demand(text.format(*parts, value=value, expected=expected), lines)

    def _compare_objects(self):
        pattern = self.reads.pattern
        for a, b in sorted(self.reads.aliases | set(pattern.items())):
            if a != b:
                self._demand(f"{self._value(a)} is {self._value(b)}")
        firsts = [f"id({self._value(a)})" for a, b in pattern.items() if a == b]
        if firsts:
            self._demand(f"len({{{', '.join(firsts)}}}) == {len(firsts)}")

    def _compare_numbers(self, zeros):
        """Compare the numbers that are constants of the code, and those that must be 0."""
        reads = self.reads
        for slot in sorted(reads.fixed):
            group, value = self._slot(slot)
            self._demand(f"same({value}, {self._named(reads.graph.values[slot])})")
        for group, value in zip(reads.groups, self.values, strict=True):
            if group.whole and group.first not in reads.fixed:
                self._demand(f"{-LARGEST_WHOLE} <= {value} <= {LARGEST_WHOLE}")
        for group, value in zip(reads.groups, self.values, strict=True):
            here = zeros[(zeros >= group.first) & (zeros < group.first + group.size)] - group.first
            if len(here):
                own = self.of_contents.setdefault(group.row, [])
                self._demand(f"not ravel({value})[{self._named(here)}].any()", own)
        for node in live(reads.assumed.values()):
            parts = [f"n{part.key}" for part in node.args]
            if node.op == "const":
                text = self._named(node.data)
            elif node.op == "par":
                text = self._slot(node.data)[1]
            elif node.op in FORMULAS:
                text = FORMULAS[node.op].format(*parts)
            else:
                compute = self._named(reads.graph.compute)
                known = self._named(node)
                text = f"computed({compute}, {known}, [{', '.join(parts)}], ({self.given}))"
            self.lines.append(f"n{node.key} = {text}")
            if node.key in reads.assumed:
                self._demand(f"same(n{node.key}, {self._named(node.value)})")

    def _compare_contents(self):
        """Make the demands on all numbers of arrays; not again on those that have met them."""
        for i, lines in self.of_contents.items():
            value = self._value(i)
            group = next(group for group in self.reads.groups if group.row == i)
            if group.shape is None or group.size > MOST_KEPT:
                self.lines += lines
                continue
            seen = self._named([b""])
            self.lines += [
                f"b{i} = {value}.tobytes()", f"if b{i} != {seen}[0]:",
                *["    " + line for line in lines], f"    {seen}[0] = b{i}",
            ]  # fmt: skip

    def _slot(self, slot):
        i = self.reads.group(slot)
        group = self.reads.groups[i]
        value = self.values[i]
        number = value if group.shape is None else f"ravel({value})[{slot - group.first}]"
        return group, f"float({number})"

    def _pack(self, first):
        """Write the values into the block, if there is a block; arrays are passed in place."""
        form = "="
        words = []
        lines = []
        for group, value in zip(self.reads.groups, self.values, strict=True):
            if group.shape is None:
                form += "d"
                words.append(value)
            else:
                form += "q" * (1 + len(group.shape))
                if self.reads.rows[group.row].step != "known":  # which is contiguous
                    lines.append(
                        f"if not {value}.flags.c_contiguous: {value} = contiguous({value})"
                    )
                words += [f"address_of({value})", *map(str, group.shape)]
        if words:
            pack = self._named(struct.Struct(form).pack_into)
            lines.append(f"{pack}(block, {first}, {', '.join(words)})")
            self.lines += ["if block is not None:", *["    " + line for line in lines]]


# -- what the lines call


def _content(cell):
    try:
        return cell.cell_contents
    except ValueError:  # the variable is not assigned yet
        return MISSING


def as_base(value):
    """The content of a list, tuple or dict of a user's class, as the base of the class reads it."""
    if isinstance(value, dict):
        return dict.copy(value)
    base: Any = list if isinstance(value, list) else tuple
    return base.__getitem__(value, slice(None))


def numbers(value, kind):
    """The numbers of a list of floats of one kind, as an array; ValueError if it has others."""
    if {*map(type, value)} != {kind}:
        raise ValueError("other items")
    return np.fromiter(value, float, len(value))


def real_numbers(value):
    """Alternating real and imaginary parts of complex numbers; a view of the array if possible."""
    return np.ascontiguousarray(value, dtype=complex).reshape(-1).view(float)


def _remembered(cached, args, named):
    """The value that a function of ``functools.lru_cache`` holds; KeyError if there is none."""
    before = cached.cache_info()
    if not before.currsize:  # a call would be the first to fill the cache
        raise KeyError(args)
    try:
        found = cached(*args, **dict(named))
    except Exception as error:
        raise KeyError(args) from error
    if cached.cache_info().misses != before.misses:
        raise KeyError(args)
    return found


def _computed(compute, node, args, given):
    with np.errstate(all="ignore"):
        return float(compute(node, [np.asarray(a)[()] for a in args], flat(given)))


def same(a, b):
    """Whether two numbers are equal, also in the sign of zero, or both nan."""
    return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (a != a and b != b)


def equal(value, expected):
    """Whether two constants are equal, also in types of their parts and in signs of zeros.

    == does not compare these: 1 == 1.0 == True, and 0.0 == -0.0.  The text of a constant does.
    """
    if value is expected or type(value) is not type(expected):
        return value is expected
    if isinstance(value, list | tuple):
        return len(value) == len(expected) and all(map(equal, value, expected))
    if isinstance(value, set | frozenset):
        return {*map(repr, value)} == {*map(repr, expected)} and value == expected
    return value.__class__.__module__ in OF_LIBRARIES and repr(value) == repr(expected)


def _as_bytes(expected, contiguous):
    """The value that the check "bytes" expects; "bytes" takes a fifth of the time of "content"."""
    order = contiguous if expected.ndim > 1 else None
    return expected.dtype, expected.shape, order, expected.tobytes()


def _equal_arrays(value, expected, contiguous):
    def bits(array):
        return array.reshape(-1).view("u8" if array.dtype.itemsize % 8 == 0 else "u1")

    return (
        type(value) is np.ndarray
        and (value.dtype, value.shape) == (expected.dtype, expected.shape)
        and (value.ndim < 2 or value.flags.c_contiguous == contiguous)
        and np.array_equal(bits(value), bits(expected))
    )


# Constants of these modules are immutable; equal ones have equal texts.
OF_LIBRARIES = {"builtins", "numpy", "numpy.dtypes", "operator", "fractions"}
NAMES: dict[str, Any] = {
    "MISSING": MISSING, "content": _content, "numbers": numbers, "as_base": as_base,
    "real_numbers": real_numbers, "contiguous": np.ascontiguousarray, "ravel": np.ravel,
    "remembered": _remembered, "computed": _computed, "equal": equal, "same": same,
    "equal_arrays": _equal_arrays, "ndarray": np.ndarray, "__builtins__": dict(vars(builtins)),
}  # fmt: skip
