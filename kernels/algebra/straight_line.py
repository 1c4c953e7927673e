"""Elimination in straight-line code for LLVM: factors P A = L U, and solutions.

`elimination_structure.py` finds, before code is made, the elements that may be nonzero.  Pivots and
the order of operations are those of `factorise.py` and `factorise_complex.py`.  If no rows need to
be exchanged, the code jumps over the exchange.

The elements are an object `a` with the elements ``a[i, j]``, the pivot ``a[k]`` of column k,
`structure`, and ``exchange_rows(k, pivot, rows, columns)``.  This method exchanges, in the given
columns, row k with the row among `rows` that the pivot names.  `Reals` or `Pairs` has the
arithmetic of the elements.

LLVM, because the operations differ with the places of the elements, and Numba unrolls no loop over
a list that is known before.
"""

import functools

from llvmlite.ir import IntType

from ..vector.instructions import BIT, REAL, constant, intrinsic_of


class Reals:
    """Numbers, or vectors with a number in each lane; `flags` are LLVM's for sums and products."""

    parts = 1  # doubles in a number

    def __init__(self, builder, kind=REAL, flags=()):
        self.builder = builder
        self.kind = kind
        self.flags = flags

    def size(self, x):
        return self.builder.call(intrinsic_of(self.builder, "fabs", self.kind, 1), [x])

    def product(self, a, b):
        return self.builder.fmul(a, b)

    def less_product(self, a, b, c):
        """a - b c."""
        product = self.builder.fmul(b, c, flags=self.flags)
        return self.builder.fsub(a, product, flags=self.flags)

    def reciprocal(self, x):
        return self.builder.fdiv(constant(self.kind, 1.0), x)

    def select(self, mask, a, b):
        return self.builder.select(mask, a, b)

    def any(self, mask):
        """Whether a mask is true in any lane."""
        if mask.type == BIT:
            return mask
        bits = self.builder.bitcast(mask, IntType(mask.type.count))
        return self.builder.icmp_unsigned("!=", bits, bits.type(0))


class Pairs(Reals):
    """Complex numbers, of real and imaginary parts."""

    parts = 2

    def size(self, x):
        re, im = (super(Pairs, self).size(part) for part in x)
        return self.builder.fadd(re, im)

    def product(self, a, b):
        u, v = a
        x, y = b
        builder = self.builder
        re = builder.fsub(builder.fmul(u, x), builder.fmul(v, y))
        return re, builder.fadd(builder.fmul(u, y), builder.fmul(v, x))

    def less_product(self, a, b, c):
        re, im = self.product(c, b)
        return self.builder.fsub(a[0], re), self.builder.fsub(a[1], im)

    def reciprocal(self, x):
        """1 / (re + i im) without squares that overflow."""
        builder = self.builder
        one = constant(self.kind, 1.0)
        sizes = [super(Pairs, self).size(part) for part in x]
        steep = builder.fcmp_unordered("<", *sizes)
        larger, smaller = self.select(steep, x[::-1], x)
        ratio = builder.fdiv(smaller, larger)
        size = builder.fadd(larger, builder.fmul(smaller, ratio))
        near = builder.fdiv(one, size)
        far = builder.fdiv(ratio, size)
        re, im = self.select(steep, (far, near), (near, far))
        return re, builder.fneg(im)

    def select(self, mask, a, b):
        return tuple(self.builder.select(mask, x, y) for x, y in zip(a, b, strict=True))


def _exchange(numbers, a, k, below, right):
    """Exchange row k with the row of the pivot; return whether any lane exchanges rows."""
    builder = numbers.builder
    sizes = {i: numbers.size(a[i, k]) for i in (k, *below)}
    larger = [builder.fcmp_ordered(">", sizes[i], sizes[k]) for i in below]
    here = numbers.any(functools.reduce(builder.or_, larger))
    a[k] = constant(numbers.kind, k)
    with builder.if_then(here):
        largest = sizes[k]
        pivot = constant(numbers.kind, k)
        for i in below:
            more = builder.fcmp_ordered(">", sizes[i], largest)
            largest = builder.select(more, sizes[i], largest)
            pivot = builder.select(more, constant(numbers.kind, i), pivot)
        a[k] = pivot
        a.exchange_rows(k, pivot, below, (k, *right))
    return here


def eliminate(numbers, a, k, below, right):
    """Step k of `factorise`."""
    exchanged = _exchange(numbers, a, k, below, right) if below else BIT(0)
    a[k, k] = scale = numbers.reciprocal(a[k, k])
    row = {j: a[k, j] for j in right}
    for i in below:
        a[i, k] = factor = numbers.product(a[i, k], scale)
        for j, value in row.items():
            a[i, j] = numbers.less_product(a[i, j], factor, value)
    return exchanged


def factorise(numbers, a):
    """Replace a matrix by L and U, with the reciprocals of the diagonal of U.

    Returns whether any lane has exchanged rows.
    """
    exchanged = BIT(0)
    for k, (below, right) in enumerate(zip(a.structure.below, a.structure.right, strict=True)):
        exchanged = numbers.builder.or_(exchanged, eliminate(numbers, a, k, below, right))
    return exchanged


def forward(numbers, a, b, exchange=None):
    """Replace b by x, with L x = P b.

    ``exchange(k, rows)`` repeats on b the exchange of row k with one of `rows`.
    """
    for k, below in enumerate(a.structure.below):
        if exchange and below:
            exchange(k, below)
        x = b[k]
        for i in below:
            b[i] = numbers.less_product(b[i], a[i, k], x)


def backward(numbers, a, b):
    """Replace the list b by x, with U x = b."""
    for k in reversed(range(len(a.structure.below))):
        x = b[k]
        for j in reversed(a.structure.right[k]):
            x = numbers.less_product(x, a[k, j], b[j])
        b[k] = numbers.product(x, a[k, k])
