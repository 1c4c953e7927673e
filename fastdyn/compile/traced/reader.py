"""Reads the outside values of a traced function again, by Python source written for its trace.

The result is that of `Reads.follow`, in a fifth of the time: one line of source reads one value,
and one line writes all parameters into a block.  Reads on which nothing depends are left out.
"""

import builtins
import struct

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import FIRST
from fastdyn.trace.graph.expressions import LARGEST_WHOLE
from fastdyn.trace.reads import checks, steps
from fastdyn.trace.reads.checks import MISSING
from fastdyn.trace.reads.reads import ERRORS, NO_ATTRIBUTES
from fastdyn.trace.written import function_of

from ..parameters import CODES


def reader(traced, zeros):
    """``read(fun, args, block=None)`` of a trace.

    The function returns the values of the parameters, and writes them into a block, if given; then
    the returned values must live as long as the block.  The result is None, and the block is
    unchanged, if the trace does not hold for `fun` and `args`, or if one of the slots `zeros` is
    not 0.
    """
    return _Writer(traced, zeros).function()


class _Writer:
    """The lines of a reader, and the objects that the lines name."""

    def __init__(self, traced, zeros):
        self.reads, self.kinds, self.zeros = traced.trace.reads, traced.kinds, zeros
        self.lines: list[str] = []
        self.scope = {"address_of": address_of, "contiguous": np.ascontiguousarray}

    def function(self):
        reads = self.reads
        if reads.identities:
            self._follow_all()
        else:
            for i in _needed(reads):
                self._read(i)
            for a, b in sorted(reads.aliases):
                self._demand(f"{self._value(a)} is {self._value(b)}")
            for group in reads.groups:
                if group.whole:
                    value = self._value(group.row)
                    self._demand(f"{-LARGEST_WHOLE} <= {value} <= {LARGEST_WHOLE}")
        values = [self._value(group.row) for group in reads.groups]
        given = "".join([f"{value}, " for value in values])
        if (reads.fixed or reads.assumed) and not reads.identities:
            self._demand(f"{self._named(reads.holds)}(({given}))")
        self._demand_zeros(values)
        self._pack(values)
        arguments = "".join([f"a{i}, " for i in range(1, len(reads.roots))])
        first = f"{arguments}= args" if arguments else "if args: return None"
        lines = "\n        ".join([first, *self.lines, f"return ({given})"])
        errors = self._named(ERRORS)
        text = (
            f"def read(a0, args, block=None):\n    try:\n        {lines}\n"
            f"    except {errors}:\n        return None\n"
        )
        return function_of(text, "read", "reads of a trace", self.scope)

    def _named(self, thing):
        """The name of an object in the source."""
        name = f"k{len(self.scope)}"
        self.scope[name] = thing
        return name

    def _value(self, i):
        """The name of the object of row i; a root is an argument of the reader."""
        row = self.reads.rows[i]
        return f"a{row.key}" if row.parent < 0 else f"v{i}"

    def _demand(self, condition):
        self.lines.append(f"if not ({condition}): return None")

    def _follow_all(self):
        """Call `Reads.follow`, which compares the identities of all objects."""
        roots = ", ".join([f"a{i}" for i in range(len(self.reads.roots))])
        self.lines += [f"given = {self._named(self.reads.follow)}({roots})",
                       "if given is None: return None"]  # fmt: skip
        for i, group in enumerate(self.reads.groups):
            self.lines.append(f"{self._value(group.row)} = given[{i}]")

    def _read(self, i):
        row, value = self.reads.rows[i], self._value(i)
        if row.parent >= 0:
            self.lines.append(f"{value} = {self._step(row)}")
        if row.check is not None:
            self._demand(self._condition(value, row))

    def _step(self, row):
        key, parent, above = row.key, self._value(row.parent), self.reads.rows[row.parent]
        if row[1:] == NO_ATTRIBUTES:
            return f"{parent}.__dict__"
        if above.check == "code" and row.step in ("global", "builtin"):  # the scope is checked
            scope = self._named(above.expected[1] if row.step == "global" else vars(builtins))
            absent = row.check == "absent"
            return (
                f"{scope}.get({key!r}, {self._named(MISSING)})" if absent else f"{scope}[{key!r}]"
            )
        if row.step == "cell" and row.check != "absent":  # a cell without content raises
            return f"{parent}.__closure__[{key}].cell_contents"
        key = repr(key) if type(key) in (int, str) else self._named(key)
        if row.step in steps.WRITTEN:
            return steps.WRITTEN[row.step].format(parent=parent, key=key)
        return f"{self._named(steps.STEPS[row.step])}({parent}, {key})"

    def _condition(self, value, row):
        kind, expected = row.check, row.expected
        if row[1:] == NO_ATTRIBUTES:
            return f"not {value}"
        if kind == "absent":
            return f"{value} is {self._named(MISSING)}"
        if kind in checks.WRITTEN:
            return checks.WRITTEN[kind].format(value=value, expected=self._named(expected))
        if kind == "length":
            return f"type({value}) is {self._named(expected[0])} and len({value}) == {expected[1]}"
        if kind == "code" and expected[2:] == (0, 0):
            code, scope = map(self._named, expected[:2])
            return (
                f"{value}.__code__ is {code} and {value}.__globals__ is {scope} and "
                f"not {value}.__defaults__ and not {value}.__kwdefaults__"
            )
        return f"{self._named(checks.CHECKS[kind])}({value}, {self._named(expected)})"

    def _demand_zeros(self, values):
        """Demand that the slots `zeros` are 0: their formulas were never compared."""
        end = 0
        for group, value in zip(self.reads.groups, values, strict=True):
            begin, end = end, end + (1 if group.shape is None else int(np.prod(group.shape)))
            here = self.zeros[(self.zeros >= begin) & (self.zeros < end)] - begin
            if len(here):
                place = f"contiguous({value}).reshape(-1)[{self._named(here)}].any()"
                self._demand(f"{value} == 0" if group.shape is None else f"not {place}")

    def _pack(self, values):
        """Write the values into the block, if there is a block; arrays are passed in place."""
        form, words, lines = "=", [], []
        for group, kind, value in zip(self.reads.groups, self.kinds, values, strict=True):
            if kind in CODES:
                form += CODES[kind]
                words.append(value)
            else:
                form += "q" * (1 + len(group.shape))
                lines.append(f"if not {value}.flags.c_contiguous: {value} = contiguous({value})")
                words += [f"address_of({value})", *map(str, group.shape)]
        if words:
            pack = self._named(struct.Struct(form).pack_into)
            lines.append(f"{pack}(block, {8 * FIRST}, {', '.join(words)})")
            self.lines += ["if block is not None:", *["    " + line for line in lines]]


def _needed(reads):
    """The rows with a check, the rows of parameters, and the rows that lead to them."""
    needed = set()
    todo = [i for i, row in enumerate(reads.rows) if row.check is not None]
    todo += [group.row for group in reads.groups]
    todo += [row for pair in reads.aliases for row in pair]
    while todo:
        row = todo.pop()
        if row >= 0 and row not in needed:
            needed.add(row)
            todo.append(reads.rows[row].parent)
    return sorted(needed)
