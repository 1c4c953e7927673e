"""The lines of a function in LLVM's text: names, places, loops, tables."""

import contextlib
import itertools
import struct

import numpy as np

from fastdyn.kernels.calls.block import FAILED

# LLVM schedules a block of instructions in a time that grows with the square of its length: a
# network of 10 oscillators takes 1.1 s in blocks of SHORT lines, 4.6 s in one block of 10 000.  A
# kernel with a block above LONG lines is cut.  Cuts cost the seven bodies of the Pleiades, whose
# longest block has 3400 lines, a tenth of their speed.
LONG = 4000
SHORT = 500


def hexadecimal(value):
    """A constant in hexadecimal, exact to the last bit."""
    return "0x" + struct.pack(">d", value).hex().upper()


class Lines:
    """The lines of one function."""

    def __init__(self):
        self.lines = []
        self.slots = []
        self.declarations = {}
        self._numbers = itertools.count(1)

    def put(self, line):
        self.lines.append(f"  {line}")

    def new(self, expression):
        """Assign an expression to a new name; return the name."""
        name = f"%v{next(self._numbers)}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def label(self, name):
        self.lines.append(f"{name}:")

    def slot(self, kind, count=1):
        """Reserve memory on the stack; return its name."""
        name = f"%s{len(self.slots)}"
        self.slots.append(f"  {name} = alloca {kind}, i64 {count}, align 64")
        return name

    def at(self, pointer, index):
        """The address of number `index` after a pointer."""
        return self.new(f"getelementptr double, ptr {pointer}, i64 {index}")

    def read_words(self, words):
        """Name the words of a kernel; `words` has {name: (index, type)}."""
        for name, (at, kind) in words.items():
            self.put(f"%at_{name} = getelementptr i64, ptr %words, i64 {at}")
            self.put(f"%{name} = load {kind}, ptr %at_{name}")

    def clear(self, pointer, count):
        """Store `count` zeros."""
        name = "llvm.memset.p0.i64"
        self.declarations[name] = f"declare void @{name}(ptr, i8, i64, i1)"
        self.put(f"call void @{name}(ptr {pointer}, i8 0, i64 {8 * count}, i1 false)")

    def index(self, table, i):
        """Entry i of a table of `indices`."""
        at = self.new(f"getelementptr i32, ptr {table}, i64 {i}")
        return self.new(f"sext i32 {self.new(f'load i32, ptr {at}')} to i64")

    @contextlib.contextmanager
    def each(self, end, first=0, step=1, always=True):
        """A context whose lines become a loop over first, first + step, ... below `end`.

        `always` tells that first < end is known.
        """
        name = f"each{next(self._numbers)}"
        place = self.slot("i64")
        self.put(f"store i64 {first}, ptr {place}")
        if always:
            self.put(f"br label %{name}")
        else:
            some = self.new(f"icmp slt i64 {first}, {end}")
            self.put(f"br i1 {some}, label %{name}, label %{name}done")
        self.label(name)
        i = self.new(f"load i64, ptr {place}")
        yield i
        following = self.new(f"add i64 {i}, {step}")
        self.put(f"store i64 {following}, ptr {place}")
        more = self.new(f"icmp slt i64 {following}, {end}")
        self.put(f"br i1 {more}, label %{name}, label %{name}done")
        self.label(f"{name}done")

    def indices(self, name, table):
        """Define a constant array of 32-bit integers; return its name."""
        return self._constants(name, "i32", np.ravel(table).tolist())

    def words(self, name, table):
        """Define a constant array of words; return its name."""
        return self._constants(name, "i64", table)

    def table(self, name, values):
        """Define a constant array of doubles; return its name."""
        return self._constants(name, "double", [hexadecimal(v) for v in values])

    def _constants(self, name, kind, numbers):
        if name not in self.declarations:
            items = ", ".join([f"{kind} {x}" for x in numbers])
            self.declarations[name] = (
                f"@{name} = private unnamed_addr constant [{len(numbers)} x {kind}] [{items}]"
            )
        return f"@{name}"

    def listing(self, declared, *functions):
        """LLVM's text of functions, without the declarations in `declared`."""
        heads = [line for name, line in self.declarations.items() if name not in declared]
        return "\n".join([*heads, *functions])

    def function(self, head, given):
        """The text of the function, which returns a word; a LONG block is cut.

        `given` is an address that LLVM does not know, and that is not null.
        """
        lines = list(self._cut(given)) if max(self._lengths()) > LONG else self.lines
        return "\n".join([f"define {head} {{", "entry:", *self.slots, *lines, "}"])

    def _lengths(self):
        """The number of each line within its block."""
        length = 0
        for line in self.lines:
            length = 0 if line.endswith(":") else length + 1
            yield length

    def _cut(self, given):
        """The lines in blocks of SHORT lines, separated by branches that are always taken.

        LLVM does not know that the branches are always taken.
        """
        yield f"  %given = icmp ne ptr {given}, null"
        for i, (line, length) in enumerate(zip(self.lines, self._lengths(), strict=True)):
            if length and length % SHORT == 0 and line.startswith("  %v"):
                yield f"  br i1 %given, label %part{i}, label %nothing"
                yield f"part{i}:"
            yield line
        yield "nothing:"
        yield f"  ret i64 {FAILED}"
