"""Routines with LAPACK's interface for narrow band matrices.

A routine is a loop over the columns, with straight-line code for one column.  The last columns
have fewer elements to the right of the diagonal, and are treated as a small matrix.
"""

import contextlib
import functools

from llvmlite import ir

from fastdyn.kernels.algebra import straight_line
from fastdyn.kernels.algebra.elimination_structure import Structure
from fastdyn.kernels.vector.instructions import INDEX, REAL

from .straight_routines import Column, Matrix, Notes, has_exchanges, routines

WORD = ir.IntType(64)
MOST_PRODUCTS = 40  # most products for a column


class _Band:
    """A band in LAPACK's storage; `lower` and `upper` count diagonals beside the main diagonal."""

    def __init__(self, numbers, lower, upper, n, matrix, pivots):
        self.numbers = numbers
        self.lower = lower
        self.ld = 2 * lower + upper
        self.width = lower + upper  # diagonals above the main diagonal, in the factor U
        self._matrix = matrix
        self._pivots = pivots
        builder = numbers.builder
        n = builder.load(builder.bitcast(n, INDEX.as_pointer()))
        self.last = builder.sub(builder.sext(n, WORD), WORD(self.width))
        self.below, self.right = range(1, lower + 1), range(1, self.width + 1)

    def _moved(self, pointer, k, step):
        builder = self.numbers.builder
        return builder.gep(pointer, [builder.mul(k, WORD(step))])

    def at(self, k, structure=None):
        """The matrix that begins with element (k, k)."""
        parts = self.numbers.parts
        first = self.numbers.builder.gep(self._matrix, [WORD(self.width * parts)])
        matrix = self._moved(first, k, parts * (self.ld + 1))
        return Matrix(self.numbers, structure, self.ld, matrix, self._moved(self._pivots, k, 1))

    def end(self):
        """The last columns, a small square matrix."""
        n = self.width
        below = tuple(range(k + 1, min(n, k + 1 + self.lower)) for k in range(n))
        return self.at(self.last, Structure(below, tuple(range(k + 1, n) for k in range(n)), {}))

    def numbers_at(self, side, k):
        """The numbers of a right-hand side from index k on."""
        return Column(self.numbers, self._moved(side, k, self.numbers.parts))


@contextlib.contextmanager
def _columns(builder, end, backward=False):
    """A context whose code is the body of a loop over the columns before `end`."""
    head, body, behind = (builder.function.append_basic_block() for _ in range(3))
    before = builder.block
    builder.branch(head)
    builder.position_at_end(head)
    count = builder.phi(WORD)
    count.add_incoming(WORD(0), before)
    builder.cbranch(builder.icmp_signed("<", count, end), body, behind)
    builder.position_at_end(body)
    yield builder.sub(builder.sub(end, WORD(1)), count) if backward else count
    count.add_incoming(builder.add(count, WORD(1)), builder.block)
    builder.branch(head)
    builder.position_at_end(behind)


def _window(numbers, count):
    """A buffer for numbers that one column passes to the next; LLVM keeps them in registers."""
    return Column(numbers, numbers.builder.alloca(REAL, INDEX(count * numbers.parts)))


def _factorise(numbers, lower, upper, arguments):
    """Emit ?gbtrf; `info` is not 0 if the matrix is singular.  Fill-in must be 0 before."""
    _, n, _, _, matrix, _, pivots, info = arguments
    notes = Notes(numbers)
    band = _Band(numbers, lower, upper, n, matrix, pivots)
    with _columns(numbers.builder, band.last) as k:
        a = band.at(k)
        exchanged = straight_line.eliminate(numbers, a, 0, band.below, band.right)
        notes.take(exchanged, [a[0, 0]])
    a = band.end()
    exchanged = straight_line.factorise(numbers, a)
    notes.take(exchanged, [a[k, k] for k in range(band.width)])
    notes.put(a, band.width - 1, info)


def _solve(numbers, lower, upper, arguments):
    """Emit ?gbtrs for one right-hand side."""
    _, n, _, _, _, matrix, _, pivots, side, _, _ = arguments
    builder = numbers.builder
    band = _Band(numbers, lower, upper, n, matrix, pivots)
    with builder.if_else(has_exchanges(numbers, band.end(), band.width - 1)) as (then, otherwise):
        with then:
            _forward_with_exchanges(band, side)
        with otherwise:
            _forward(band, side)
    _backward(band, side)


def _forward_with_exchanges(band, side):
    numbers = band.numbers
    with _columns(numbers.builder, band.last) as k:
        a = band.at(k)
        b = band.numbers_at(side, k)
        a.exchange_in(b)(0, band.below)
        x = b[0]
        for i in band.below:
            b[i] = numbers.less_product(b[i], a[i, 0], x)
    a = band.end()
    b = band.numbers_at(side, band.last)
    straight_line.forward(numbers, a, b, a.exchange_in(b))


def _forward(band, side):
    numbers = band.numbers
    lower = band.lower
    window = _window(numbers, lower)
    b = Column(numbers, side)
    for i in range(lower):
        window[i] = b[i]
    with _columns(numbers.builder, band.last) as k:
        a = band.at(k)
        b = band.numbers_at(side, k)
        b[0] = x = window[0]
        for i in band.below:
            before = window[i] if i < lower else b[i]
            window[i - 1] = numbers.less_product(before, a[i, 0], x)
    b = band.numbers_at(side, band.last)
    values = [window[i] if i < lower else b[i] for i in range(band.width)]
    straight_line.forward(numbers, band.end(), values)
    for i, value in enumerate(values):
        b[i] = value


def _backward(band, side):
    numbers = band.numbers
    b = band.numbers_at(side, band.last)
    values = [b[i] for i in range(band.width)]
    window = _window(numbers, band.width)
    straight_line.backward(numbers, band.end(), values)
    for i, value in enumerate(values):
        b[i] = window[i] = value
    with _columns(numbers.builder, band.last, backward=True) as k:
        a = band.at(k)
        b = band.numbers_at(side, k)
        x = b[0]
        for j in reversed(band.right):
            x = numbers.less_product(x, a[0, j], window[j - 1])
        x = numbers.product(x, a[0, 0])
        for j in reversed(range(1, band.width)):
            window[j] = window[j - 1]
        b[0] = window[0] = x


ROUTINES = {"gbtrf": (_factorise, 8), "gbtrs": (_solve, 11)}


def are_short(lower, upper):
    """True if the code for a column of a band is short enough to pay."""
    return 0 < lower * (1 + lower + upper) <= MOST_PRODUCTS


@functools.lru_cache(64)
def band_routines(lower, upper, complex_too):
    """The addresses of routines for bands: dgbtrf, dgbtrs, zgbtrf, zgbtrs.

    A matrix must have at least as many columns as diagonals beside the main diagonal.
    """
    return routines(ROUTINES, (lower, upper), complex_too, scheduled=False)
