"""The common part of straight-line routines: access to matrices in memory, and LLVM's text."""

import functools
import math

from llvmlite import ir

from fastdyn import code_store
from fastdyn.kernels.algebra.straight_line import Pairs, Reals
from fastdyn.kernels.vector.instructions import BIT, INDEX, REAL, constant


class Column:
    """An array of real or complex numbers in memory; indexing emits a load or a store."""

    def __init__(self, numbers, pointer):
        self._numbers = numbers
        self._pointer = pointer

    def _places(self, i):
        n = self._numbers.parts
        return [self._numbers.builder.gep(self._pointer, [INDEX(n * i + k)]) for k in range(n)]

    def __getitem__(self, i):
        parts = [self._numbers.builder.load(place) for place in self._places(i)]
        return parts[0] if len(parts) == 1 else tuple(parts)

    def __setitem__(self, i, value):
        parts = value if isinstance(value, tuple) else [value]
        for part, place in zip(parts, self._places(i), strict=True):
            self._numbers.builder.store(part, place)

    def exchange(self, i, at):
        """Emit the exchange of number i and the number at index `at`, an LLVM value."""
        builder = self._numbers.builder
        n = self._numbers.parts
        there = [builder.add(builder.mul(at, INDEX(n)), INDEX(k)) for k in range(n)]
        there = [builder.gep(self._pointer, [place]) for place in there]
        for a, b in zip(self._places(i), there, strict=True):
            before = builder.load(a)
            other = builder.load(b)
            builder.store(other, a)
            builder.store(before, b)


class Matrix:
    """A matrix in memory by columns, whose starts are `ld` numbers apart, and its pivots."""

    def __init__(self, numbers, found, ld, pointer, pivots):
        self.structure = found
        self._ld = ld
        self._builder = numbers.builder
        self._elements = Column(numbers, pointer)
        self._pivots = Column(Reals(numbers.builder), pivots)

    def _at(self, place):
        if isinstance(place, tuple):
            return self._elements, place[1] * self._ld + place[0]
        return self._pivots, place

    def __getitem__(self, place):
        """The element of a place (i, j), or the pivot of column `place`."""
        column, at = self._at(place)
        return column[at]

    def __setitem__(self, place, value):
        column, at = self._at(place)
        column[at] = value

    def exchange_rows(self, k, pivot, rows, columns):
        row = self._builder.fptosi(pivot, INDEX)
        for j in columns:
            at = self._builder.add(row, INDEX(j * self._ld))
            self._elements.exchange(j * self._ld + k, at)

    def exchange_in(self, b):
        """``exchange(k, rows)``, which exchanges number k of b with the number at pivot k."""
        return lambda k, rows: b.exchange(k, self._builder.fptosi(self[k], INDEX))


class Notes:
    """Two flags on the stack: rows were exchanged; a reciprocal on the diagonal is not finite."""

    def __init__(self, numbers):
        self._numbers = numbers
        self._exchanged, self._singular = (numbers.builder.alloca(BIT) for _ in range(2))
        for flag in (self._exchanged, self._singular):
            numbers.builder.store(BIT(0), flag)

    def take(self, exchanged, reciprocals):
        builder = self._numbers.builder
        for flag, found in [
            (self._exchanged, exchanged),
            *[(self._singular, self._is_infinite(x)) for x in reciprocals],
        ]:
            builder.store(builder.or_(builder.load(flag), found), flag)

    def _is_infinite(self, x):
        size = self._numbers.size(x)
        return self._numbers.builder.fcmp_unordered(">=", size, constant(REAL, math.inf))

    def put(self, a, k, info):
        """Store the flag of exchanges as pivot k, which is unused, and the other flag at `info`."""
        builder = self._numbers.builder
        a[k] = builder.uitofp(builder.load(self._exchanged), REAL)
        info = builder.bitcast(info, INDEX.as_pointer())
        builder.store(builder.zext(builder.load(self._singular), INDEX), info)


def has_exchanges(numbers, a, k):
    """Whether rows were exchanged: the flag that `Notes.put` stored as pivot k."""
    return numbers.builder.fcmp_ordered("!=", a[k], constant(REAL, 0.0))


class Routines(list):
    """The addresses of routines; the list keeps the machine code in memory."""

    codes: tuple = ()


def routines(write, given, complex_too, scheduled):
    """The Routines for real matrices, then for complex matrices, then the word 0.

    Parameters
    ----------
    write : dict of str to (function, int)
        By the name of a routine, ``function(numbers, *given, arguments)``, which emits the routine,
        and the number of arguments of the routine.
    given : tuple
        The facts on which the code depends, such as the structure of a matrix.
    complex_too : bool
        Whether complex matrices need routines; otherwise the words of these routines are 0.
    scheduled : bool
        Whether instructions are in their final order: see `code_store.assembled`.
    """
    found = []
    for arithmetic in (Reals, Pairs)[: 1 + complex_too]:
        for name, routine in write.items():
            key = f"{arithmetic.__name__} {name} {given}"
            text = functools.partial(_text, arithmetic, given, *routine)
            found.append(code_store.assembled(key, text, scheduled))
    words = Routines([*[code.address for code in found], *[0] * (5 - len(found))])
    words.codes = tuple(found)
    return words


def _text(arithmetic, given, write, n_arguments, symbol):
    """LLVM's text of a module with one routine."""
    module = ir.Module()
    form = ir.FunctionType(ir.VoidType(), [REAL.as_pointer()] * n_arguments)
    function = ir.Function(module, form, symbol)
    builder = ir.IRBuilder(function.append_basic_block())
    write(arithmetic(builder), *given, function.args)
    builder.ret_void()
    return str(module)
