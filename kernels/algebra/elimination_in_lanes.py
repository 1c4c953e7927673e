"""Small linear systems with a matrix in each lane of a vector: factors P A = L U, and solutions.

Pivots are those of `factorise.py`, each lane has its own: rows are exchanged by selection, and
where no lane exchanges any, that is jumped over.  Which elements may differ from zero is known when
code is made, so that it is straight-line code for these alone, written for LLVM.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit_options import INLINED, INTERNAL, njit
from ..state.elementwise import data_of, load
from ..vector.instructions import FUSE, constant, intrinsic_of
from .elimination_structure import structure


class _Elements:
    """The stored elements of a matrix, and behind them the pivot of each column."""

    def __init__(self, context, builder, form, array, found):
        self.builder, self.found = builder, found
        self.kind = context.get_value_type(form)
        self._data = data_of(context, builder, array[0], array[1])

    def _pointer(self, at):
        place = cgutils.gep(self.builder, self._data, at * self.kind.count)
        return self.builder.bitcast(place, self.kind.as_pointer())

    def _at(self, place):
        known = self.found.places
        return known[place] if isinstance(place, tuple) else len(known) + place

    def __getitem__(self, place):
        """The element (i, j), or the pivot of column k."""
        return load(self.builder, self._pointer(self._at(place)))

    def __setitem__(self, place, value):
        self.builder.store(value, self._pointer(self._at(place))).align = 8


def _less_product(builder, a, b, c):
    """a - b c."""
    return builder.fsub(a, builder.fmul(b, c, flags=FUSE), flags=FUSE)


def _any(builder, mask):
    bits = builder.bitcast(mask, ir.IntType(mask.type.count))
    return builder.icmp_unsigned("!=", bits, bits.type(0))


def _pivot(builder, a, k, below):
    """Note the row with the largest element of column k; whether any lane has to exchange."""
    size = intrinsic_of(builder, "fabs", a.kind, 1)
    largest, pivot = builder.call(size, [a[k, k]]), constant(a.kind, k)
    for i in below:
        other = builder.call(size, [a[i, k]])
        larger = builder.fcmp_ordered(">", other, largest)
        largest = builder.select(larger, other, largest)
        pivot = builder.select(larger, constant(a.kind, i), pivot)
    a[k] = pivot
    return _any(builder, builder.fcmp_ordered("!=", pivot, constant(a.kind, k)))


def _exchanged(builder, pivot, upper, lower):
    """`upper` after its exchange with that of `lower`, {row: value}, which the pivot names."""
    new = upper
    for i, value in lower.items():
        chosen = builder.fcmp_ordered("==", pivot, constant(pivot.type, i))
        new = builder.select(chosen, value, new)
        lower[i] = builder.select(chosen, upper, value)
    return new


def _fill(builder, a, entries, diagonal):
    """The matrix with `diagonal` on its diagonal, less the entries, {(row, column): value}."""
    zero = constant(a.kind, 0.0)
    for i, j in a.found.places:
        value = diagonal if i == j else zero
        if (i, j) in entries:
            value = builder.fsub(value, entries[i, j])
        a[i, j] = value


def _factorise(builder, a):
    """Put L and U, with the reciprocals of its diagonal, in the place of a matrix."""
    exchanged = ir.Constant(ir.IntType(1), 0)
    one = constant(a.kind, 1.0)
    for k, (below, right) in enumerate(zip(a.found.below, a.found.right, strict=True)):
        if below:
            here = _pivot(builder, a, k, below)
            with builder.if_then(here):
                for j in (k, *right):
                    column = {i: a[i, j] for i in below}
                    a[k, j] = _exchanged(builder, a[k], a[k, j], column)
                    for i, value in column.items():
                        a[i, j] = value
            exchanged = builder.or_(exchanged, here)
        a[k, k] = builder.fdiv(one, a[k, k])
        for i in below:
            a[i, k] = builder.fmul(a[i, k], a[k, k])
            for j in right:
                a[i, j] = _less_product(builder, a[i, j], a[i, k], a[k, j])
    return exchanged


def _forward(builder, a, b, exchanging):
    """L x = P b, in the place of b."""
    for k, below in enumerate(a.found.below):
        if exchanging and below:
            rows = {i: b[i] for i in below}
            b[k] = _exchanged(builder, a[k], b[k], rows)
            for i, value in rows.items():
                b[i] = value
        for i in below:
            b[i] = _less_product(builder, b[i], a[i, k], b[k])


def _backward(builder, a, b):
    """U x = b, in the place of b."""
    for k in reversed(range(len(b))):
        for j in a.found.right[k]:
            b[k] = _less_product(builder, b[k], a[k, j], b[j])
        b[k] = builder.fmul(b[k], a[k, k])


def make_elimination(rows, columns, form):
    """The functions for matrices ``diagonal * identity - J``, J with entries in these places.

    Returns
    -------
    room : int
        Rows of vectors that factors take.
    factorise : function
        ``factorise(factors, entries, diagonal)`` fills the array; whether any lane has exchanged
        rows.  The matrix of a singular system has a zero on the diagonal of U: solutions are
        infinite or NaN.
    solve : function
        ``solve(factors, exchanged, b)`` gives x, with A x = b.
    """
    places = [*zip(map(int, rows), map(int, columns), strict=True)]
    n, found = len(form.value), structure(places, len(form.value))
    return len(found.places) + n, _make_factorise(found, places), _make_solve(found)


def make_product(rows, columns):
    """``multiply(entries, x, total)`` gives J x + total, of a J with entries in these places."""

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


def _make_factorise(found, places):
    @intrinsic
    def factorise(typingctx, factors, entries, diagonal):
        def codegen(context, builder, signature, args):
            array, given, scale = args
            a = _Elements(context, builder, diagonal, (factors, array), found)
            values = [builder.extract_value(given, i) for i in range(len(places))]
            _fill(builder, a, dict(zip(places, values, strict=True)), scale)
            return _factorise(builder, a)

        return types.boolean(factors, entries, diagonal), codegen

    @njit(**INLINED)
    def called(factors, entries, diagonal):
        return factorise(factors, entries, diagonal)

    return called


def _make_solve(found):
    def half(work):
        @intrinsic
        def solved(typingctx, factors, b):
            def codegen(context, builder, signature, args):
                a = _Elements(context, builder, b.dtype, (factors, args[0]), found)
                values = [builder.extract_value(args[1], i) for i in range(len(b))]
                work(builder, a, values)
                return context.make_tuple(builder, b, values)

            return b(factors, b), codegen

        return solved

    plain = half(lambda builder, a, b: _forward(builder, a, b, False))
    exchanging = half(lambda builder, a, b: _forward(builder, a, b, True))
    backward = half(_backward)

    @njit(**INTERNAL)
    def solve(factors, exchanged, b):
        z = exchanging(factors, b) if exchanged else plain(factors, b)
        return backward(factors, z)

    return solve
