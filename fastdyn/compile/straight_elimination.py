"""Routines with LAPACK's interface for small matrices of one structure, in straight-line code."""

import functools
import math

from llvmlite import ir

from fastdyn import code_store
from fastdyn.kernels.algebra import straight_line
from fastdyn.kernels.algebra.elimination_structure import structure
from fastdyn.kernels.algebra.straight_line import Pairs, Reals
from fastdyn.kernels.vector.instructions import INDEX, REAL, constant

INFO = ir.IntType(32)
FULL = 8  # components, up to which a structure need not be known
MOST_PRODUCTS = 200  # of a factorisation


class _Column:
    """Numbers in the memory, which the arithmetic takes one by one."""

    def __init__(self, numbers, pointer):
        self._numbers, self._pointer = numbers, pointer

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
        """Exchange number i with that at an index, which is an LLVM value."""
        builder, n = self._numbers.builder, self._numbers.parts
        there = [builder.add(builder.mul(at, INDEX(n)), INDEX(k)) for k in range(n)]
        there = [builder.gep(self._pointer, [place]) for place in there]
        for a, b in zip(self._places(i), there, strict=True):
            before, other = builder.load(a), builder.load(b)
            builder.store(other, a)
            builder.store(before, b)


class _Matrix:
    """Elements by columns, and pivots."""

    def __init__(self, numbers, found, pointer, pivots):
        self.structure, self._n, self._builder = found, len(found.below), numbers.builder
        self._elements = _Column(numbers, pointer)
        self._pivots = _Column(Reals(numbers.builder), pivots)

    def _at(self, place):
        if isinstance(place, tuple):
            return self._elements, place[1] * self._n + place[0]
        return self._pivots, place

    def __getitem__(self, place):
        """The element (i, j), or the pivot of column k."""
        column, at = self._at(place)
        return column[at]

    def __setitem__(self, place, value):
        column, at = self._at(place)
        column[at] = value

    def exchange_rows(self, k, pivot, rows, columns):
        row = self._builder.fptosi(pivot, INDEX)
        for j in columns:
            at = self._builder.add(row, INDEX(j * self._n))
            self._elements.exchange(j * self._n + k, at)


def _factorise(numbers, found, arguments):
    """?getrf, whose info is not 0 if the matrix is singular.

    The last pivot, of which there is no need, says whether there are others.
    """
    _, _, matrix, _, pivots, info = arguments
    builder, n = numbers.builder, len(found.below)
    a = _Matrix(numbers, found, matrix, pivots)
    a[n - 1] = builder.uitofp(straight_line.factorise(numbers, a), REAL)
    infinite = constant(REAL, math.inf)
    finite = [builder.fcmp_ordered("<", numbers.size(a[k, k]), infinite) for k in range(n)]
    singular = builder.not_(functools.reduce(builder.and_, finite))
    builder.store(builder.zext(singular, INFO), builder.bitcast(info, INFO.as_pointer()))


def _solve(numbers, found, arguments):
    """?getrs of one right-hand side."""
    _, _, _, matrix, _, pivots, side, _, _ = arguments
    builder, n, side = numbers.builder, len(found.below), _Column(numbers, side)
    a = _Matrix(numbers, found, matrix, pivots)
    exchanged = builder.fcmp_ordered("!=", a[n - 1], constant(REAL, 0.0))

    def exchange(k, _):
        side.exchange(k, builder.fptosi(a[k], INDEX))

    with builder.if_else(exchanged) as (then, otherwise):
        with then:
            straight_line.forward(numbers, a, side, exchange)
            straight_line.backward(numbers, a, side)
        with otherwise:
            values = [side[i] for i in range(n)]
            straight_line.forward(numbers, a, values)
            straight_line.backward(numbers, a, values)
            for i, value in enumerate(values):
                side[i] = value


ROUTINES = {"getrf": (_factorise, 6), "getrs": (_solve, 9)}


@functools.lru_cache(256)
def straight_routines(n, places, complex_too):
    """The addresses of dgetrf, dgetrs, zgetrf and zgetrs for matrices of n rows, and a zero.

    Parameters
    ----------
    n : int
    places : tuple of (int, int), optional
        The row and the column of the elements that are not zero everywhere; those of the diagonal
        may be missing.  None: any may differ from zero.
    complex_too : bool
        Whether there will be complex matrices; the addresses are 0 otherwise.

    Returns
    -------
    list of int or None
        None where so long a text is not worth its time.
    """
    if places is None:
        if n > FULL:
            return None
        places = [(i, j) for i in range(n) for j in range(n)]
    found = structure(places, n)
    if found.n_products > MOST_PRODUCTS:
        return None
    return [*_routines(found, Reals), *(_routines(found, Pairs) if complex_too else [0, 0]), 0]


def _routines(found, arithmetic):
    key = f"{arithmetic.__name__} {len(found.below)} {sorted(found.places)}"
    return [
        code_store.assembled(
            f"{name} {key}", functools.partial(_text, arithmetic, found, *routine), scheduled=True
        ).address
        for name, routine in ROUTINES.items()
    ]


def _text(arithmetic, found, write, n_arguments, symbol):
    """LLVM's text of a module with a routine."""
    module = ir.Module()
    form = ir.FunctionType(ir.VoidType(), [REAL.as_pointer()] * n_arguments)
    function = ir.Function(module, form, symbol)
    builder = ir.IRBuilder(function.append_basic_block())
    write(arithmetic(builder), found, function.args)
    builder.ret_void()
    return str(module)
