"""Small linear systems with one matrix in each lane of a vector.

Each lane has its own pivots: rows are exchanged by selection, not by branches.

LLVM, because its code comes from `straight_line.py`.
"""

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.options import INLINED, INTERNAL, njit
from ..state.elementwise import data_of, load
from ..vector.instructions import FUSE, constant
from . import straight_line
from .elimination_structure import structure
from .straight_line import Reals


class _Elements:
    """The stored elements of a matrix, and behind them the pivot of each column."""

    def __init__(self, context, builder, form, array, found):
        self.builder = builder
        self.structure = found
        self.kind = context.get_value_type(form)
        self._data = data_of(context, builder, array[0], array[1])

    def _pointer(self, at):
        place = cgutils.gep(self.builder, self._data, at * self.kind.count)
        return self.builder.bitcast(place, self.kind.as_pointer())

    def _at(self, place):
        known = self.structure.places
        return known[place] if isinstance(place, tuple) else len(known) + place

    def __getitem__(self, place):
        """The element (i, j), or the pivot of column k."""
        return load(self.builder, self._pointer(self._at(place)))

    def __setitem__(self, place, value):
        self.builder.store(value, self._pointer(self._at(place))).align = 8

    def exchange_rows(self, k, pivot, rows, columns):
        for j in columns:
            column = {i: self[i, j] for i in (k, *rows)}
            _exchange(self.builder, pivot, column, k, rows)
            for i, value in column.items():
                self[i, j] = value


def _exchange(builder, pivot, column, k, rows):
    """Exchange value k of a column with the value in the row that the pivot of each lane names."""
    before = column[k]
    new = column[k]
    for i in rows:
        chosen = builder.fcmp_ordered("==", pivot, constant(pivot.type, i))
        new = builder.select(chosen, column[i], new)
        column[i] = builder.select(chosen, before, column[i])
    column[k] = new


def _fill(builder, a, entries, factor, mass):
    """Store ``factor M - J`` in `a`, with the entries of J and of M; None stands for M = I.

    Entries are {(row, column): value}.
    """
    zero = constant(a.kind, 0.0)
    for i, j in a.structure.places:
        if mass is None:
            value = factor if i == j else zero
        else:
            value = builder.fmul(factor, mass[i, j]) if (i, j) in mass else zero
        if (i, j) in entries:
            value = builder.fsub(value, entries[i, j])
        a[i, j] = value


def make_elimination(rows, columns, form, mass=None):
    """The functions for matrices ``factor M - J``, where J has entries at (rows, columns).

    `mass` has the rows and the columns of the numbers of M; None stands for M = I.

    Returns
    -------
    room : int
        Rows of vectors that factors take.
    factorise : function
        ``factorise(factors, entries, factor, mass)`` fills the array `factors` and returns whether
        any lane has exchanged rows.  `mass` has the numbers of M, or is None.  For a singular
        matrix, U has a zero on its diagonal, and solutions are infinite or NaN.
    solve : function
        ``solve(factors, exchanged, b)`` gives x, with A x = b.
    """
    places = [*zip(map(int, rows), map(int, columns), strict=True)]
    of_mass = None if mass is None else [*zip(*(map(int, each) for each in mass), strict=True)]
    n = len(form.value)
    found = structure([*places, *(of_mass or ())], len(form.value))
    return len(found.places) + n, _make_factorise(found, places, of_mass), _make_solve(found)


def make_product(rows, columns):
    """``multiply(entries, x, total)`` gives J x + total; J has entries at (rows, columns)."""

    @intrinsic
    def product(typingctx, entries, x, total):
        def codegen(context, builder, signature, args):
            given, factors, sums = (
                [builder.extract_value(value, i) for i in range(len(kind))]
                for kind, value in zip(signature.args, args, strict=True)
            )
            for e, i, j in zip(given, rows, columns, strict=True):
                sums[i] = builder.fadd(sums[i], builder.fmul(e, factors[j], flags=FUSE), flags=FUSE)
            return context.make_tuple(builder, total, sums)

        return total(entries, x, total), codegen

    @njit(**INLINED)
    def multiply(entries, x, total):
        return product(entries, x, total)

    return multiply


def _make_factorise(found, places, of_mass):
    @intrinsic
    def factorise(typingctx, factors, entries, factor, mass):
        def codegen(context, builder, signature, args):
            a = _Elements(context, builder, factor, (factors, args[0]), found)

            def values(where, given):
                return {place: builder.extract_value(given, i) for i, place in enumerate(where)}

            numbers = None if of_mass is None else values(of_mass, args[3])
            _fill(builder, a, values(places, args[1]), args[2], numbers)
            return straight_line.factorise(Reals(builder, a.kind, FUSE), a)

        return types.boolean(factors, entries, factor, mass), codegen

    @njit(**INLINED)
    def called(factors, entries, factor, mass):
        return factorise(factors, entries, factor, mass)

    return called


def _make_solve(found):
    def half(work):
        @intrinsic
        def solved(typingctx, factors, b):
            def codegen(context, builder, signature, args):
                a = _Elements(context, builder, b.dtype, (factors, args[0]), found)
                values = [builder.extract_value(args[1], i) for i in range(len(b))]
                work(Reals(builder, a.kind, FUSE), a, values)
                return context.make_tuple(builder, b, values)

            return b(factors, b), codegen

        return solved

    def with_exchanges(numbers, a, b):
        def exchange(k, rows):
            _exchange(numbers.builder, a[k], b, k, rows)

        straight_line.forward(numbers, a, b, exchange)

    plain, exchanging = half(straight_line.forward), half(with_exchanges)
    backward = half(straight_line.backward)

    @njit(**INTERNAL)
    def solve(factors, exchanged, b):
        z = exchanging(factors, b) if exchanged else plain(factors, b)
        return backward(factors, z)

    return solve
