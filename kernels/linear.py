"""Small dense linear systems inside a right-hand side, and equations of motion with constraints.

Matrices are tuples of rows, so that their size is known when code is made: the elimination is
straight-line code on registers, with the larger pivot chosen by selection instead of branches,
and nothing is allocated.  The same functions work on plain Python numbers, with the same bits.
"""

import math

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import errors
from numba.extending import intrinsic, overload

from .calls import BARE

EPS = float(np.finfo(float).eps)
REAL = ir.DoubleType()
SINGULAR = "the matrix is singular"
CONTRADICTORY = (
    "the equations of motion are singular: the constraints do not determine the accelerations "
    "and reactions (are they written for the accelerations, and independent of each other?)"
)


class SingularMatrixError(ArithmeticError):
    """A system of linear equations without a unique solution, to working precision."""


def solve_linear(a, b):
    """Solve a x = b by elimination with scaled partial pivoting.

    Parameters
    ----------
    a : tuple of n tuples of n numbers
        Rows of the matrix.
    b : tuple of n numbers

    Returns
    -------
    tuple of n floats

    Raises
    ------
    SingularMatrixError
        If a pivot is below n eps of the largest entry of its row.
    """
    x, singular = _eliminate(_Numbers, [[*map(float, row), float(r)] for row, r in _rows(a, b)])
    if singular:
        raise SingularMatrixError(SINGULAR)
    return tuple(x)


def constrained(mass, a, force, b):
    """Accelerations and reactions of a system with constraints.

    Solves M q'' - A^T R = f and A q'' = b: each constraint, differentiated until it holds for the
    accelerations, has one reaction, which acts along its row of A.

    Parameters
    ----------
    mass : tuple of n numbers, or of n tuples of n numbers
        The masses, all positive; or the rows of M, which may be singular (a massless part).
    a : tuple of k tuples of n numbers
        Rows of A.
    force : tuple of n numbers
        Applied forces f.
    b : tuple of k numbers

    Returns
    -------
    tuple of n + k floats
        The accelerations q'', then the reactions R.

    Raises
    ------
    SingularMatrixError
        If they are not determined: constraints that depend on each other, or that say nothing of
        the accelerations.

    Notes
    -----
    With b the residual and no force, the first n numbers are the smallest displacement, measured
    by the masses, that removes the residual: this is how a state is projected onto constraints.
    """
    mass = [list(map(float, row)) if isinstance(row, tuple) else float(row) for row in mass]
    a = [list(map(float, row)) for row in a]
    x, singular = _constrained(_Numbers, mass, a, list(map(float, force)), list(map(float, b)))
    if singular:
        raise SingularMatrixError(CONTRADICTORY)
    return tuple(x)


def _rows(a, b):
    if any(len(row) != len(b) for row in a) or len(a) != len(b):
        raise ValueError(f"the matrix must have {len(b)} rows of {len(b)} numbers")
    return zip(a, b, strict=True)


class _Numbers:
    """Arithmetic on Python floats."""

    zero, tiny = 0.0, EPS
    add, sub, mul = float.__add__, float.__sub__, float.__mul__

    @staticmethod
    def div(x, y):
        if y != 0.0:
            return x / y
        return math.nan if x == 0.0 or x != x else math.copysign(math.inf, x) * math.copysign(1, y)

    absolute = staticmethod(abs)

    @staticmethod
    def greater(x, y):
        return x > y

    @staticmethod
    def select(condition, x, y):
        return x if condition else y

    @staticmethod
    def either(x, y):
        return x or y


class _Code:
    """The same arithmetic as instructions."""

    def __init__(self, builder):
        self._builder = builder
        self.zero, self.tiny = ir.Constant(REAL, 0.0), ir.Constant(REAL, EPS)
        self.add, self.sub, self.mul = builder.fadd, builder.fsub, builder.fmul
        self.div, self.select, self.either = builder.fdiv, builder.select, builder.or_

    def absolute(self, x):
        function = self._builder.module.declare_intrinsic("llvm.fabs", [REAL])
        return self._builder.call(function, [x])

    def greater(self, x, y):
        return self._builder.fcmp_ordered(">", x, y)


def _eliminate(do, rows):
    """Solve the n x (n + 1) system; (x, whether it is singular or not finite)."""
    n = len(rows)
    rows = [list(row) for row in rows]
    scale = [_largest(do, row[:n]) for row in rows]
    singular = None
    for k in range(n):
        for i in range(k + 1, n):  # row k becomes the better of the two
            here = do.mul(do.absolute(rows[k][k]), scale[i])
            there = do.mul(do.absolute(rows[i][k]), scale[k])
            swap = do.greater(there, here)
            pairs = [(rows[k][j], rows[i][j]) for j in range(k, n + 1)]
            rows[k][k:] = [do.select(swap, y, x) for x, y in pairs]
            rows[i][k:] = [do.select(swap, x, y) for x, y in pairs]
            upper, lower = scale[k], scale[i]
            scale[k], scale[i] = do.select(swap, lower, upper), do.select(swap, upper, lower)
        pivot, floor = do.absolute(rows[k][k]), scale[k]
        floor = do.mul(do.tiny, floor)
        total = floor
        for _ in range(n - 1):
            total = do.add(total, floor)
        sound = do.greater(pivot, total)  # false for NaN too
        bad = do.select(sound, _false(do), _true(do))
        singular = bad if singular is None else do.either(singular, bad)
        for i in range(k + 1, n):
            factor = do.div(rows[i][k], rows[k][k])
            for j in range(k + 1, n + 1):
                rows[i][j] = do.sub(rows[i][j], do.mul(factor, rows[k][j]))
    x = [do.zero] * n
    for k in reversed(range(n)):
        total = rows[k][n]
        for j in range(k + 1, n):
            total = do.sub(total, do.mul(rows[k][j], x[j]))
        x[k] = do.div(total, rows[k][k])
    return x, singular


def _largest(do, values):
    """The largest absolute value."""
    largest, *others = map(do.absolute, values)
    for x in others:
        largest = do.select(do.greater(x, largest), x, largest)
    return largest


def _false(do):
    return False if do is _Numbers else ir.Constant(ir.IntType(1), 0)


def _true(do):
    return True if do is _Numbers else ir.Constant(ir.IntType(1), 1)


def _dot(do, x, y):
    total = do.mul(x[0], y[0])
    for p, q in zip(x[1:], y[1:], strict=True):
        total = do.add(total, do.mul(p, q))
    return total


def _constrained(do, mass, a, force, b):
    n, k = len(force), len(b)
    if any(len(row) != n for row in a) or len(a) != k or len(mass) != n:
        raise ValueError(f"{n} forces and {k} right-hand sides need A with {k} rows of {n} numbers")
    if isinstance(mass[0], list):
        if any(len(row) != n for row in mass):
            raise ValueError(f"{n} forces need {n} masses, or M with {n} rows of {n} numbers")
        size = _largest(do, [x for row in mass for x in row])  # reactions are counted in it
        rows = [
            [*m, *(do.sub(do.zero, do.mul(size, a[i][j])) for i in range(k)), force[j]]
            for j, m in enumerate(mass)
        ]
        rows += [[*row, *[do.zero] * k, r] for row, r in zip(a, b, strict=True)]
        x, singular = _eliminate(do, rows)
        return [*x[:n], *(do.mul(size, r) for r in x[n:])], singular
    per_mass = [[do.div(x, m) for x, m in zip(row, mass, strict=True)] for row in a]
    rows = [
        [*(_dot(do, row, other) for other in a), do.sub(r, _dot(do, row, force))]
        for row, r in zip(per_mass, b, strict=True)
    ]
    reactions, singular = _eliminate(do, rows)
    total = list(force)
    for row, r in zip(a, reactions, strict=True):
        total = [do.add(f, do.mul(x, r)) for f, x in zip(total, row, strict=True)]
    return [*(do.div(f, m) for f, m in zip(total, mass, strict=True)), *reactions], singular


def _is_row(ty):
    return isinstance(ty, types.BaseTuple) and all(
        isinstance(t, types.Float | types.Integer | types.Boolean) for t in ty
    )


def _is_matrix(ty):
    return isinstance(ty, types.BaseTuple) and len(ty) > 0 and all(map(_is_row, ty))


def _values(context, builder, ty, value):
    """The numbers of a row, or the lists of a matrix, as doubles."""
    parts = [(t, builder.extract_value(value, i)) for i, t in enumerate(ty)]
    if _is_matrix(ty):
        return [_values(context, builder, t, v) for t, v in parts]
    return [context.cast(builder, v, t, types.float64) for t, v in parts]


def _packed(context, builder, n, x, singular):
    numbers = context.make_tuple(builder, types.UniTuple(types.float64, n), x)
    return context.make_tuple(builder, _result(n), [numbers, singular])


def _result(n):
    return types.Tuple((types.UniTuple(types.float64, n), types.boolean))


@intrinsic
def _solve(typingctx, a, b):
    n = len(b)

    def codegen(context, builder, signature, args):
        rows, right = (_values(context, builder, t, v) for t, v in zip((a, b), args, strict=True))
        rows = [[*row, r] for row, r in zip(rows, right, strict=True)]
        return _packed(context, builder, n, *_eliminate(_Code(builder), rows))

    return _result(n)(a, b), codegen


@intrinsic
def _solve_constrained(typingctx, mass, a, force, b):
    n = len(force) + len(b)
    given = (mass, a, force, b)

    def codegen(context, builder, signature, args):
        values = [_values(context, builder, t, v) for t, v in zip(given, args, strict=True)]
        return _packed(context, builder, n, *_constrained(_Code(builder), *values))

    return _result(n)(*given), codegen


@overload(solve_linear, jit_options=BARE)
def _solve_linear(a, b):
    if not (_is_matrix(a) and _is_row(b) and {len(a), *map(len, a)} == {len(b)}):
        raise errors.TypingError("solve_linear takes n tuples of n numbers, and a tuple of n")

    def solve(a, b):
        x, singular = _solve(a, b)
        if singular:
            raise SingularMatrixError(SINGULAR)
        return x

    return solve


@overload(constrained, jit_options=BARE)
def _constrained_motion(mass, a, force, b):
    shapes = _is_matrix(a) and _is_row(force) and _is_row(b) and (_is_row(mass) or _is_matrix(mass))
    n, k = (len(force), len(b)) if shapes else (0, 0)
    if not shapes or len(a) != k or len(mass) != n or {*map(len, a)} != {n}:
        raise errors.TypingError(
            "constrained takes masses (n numbers or n rows), A (k rows of n), n forces and k "
            "right-hand sides, all as tuples"
        )

    def solve(mass, a, force, b):
        x, singular = _solve_constrained(mass, a, force, b)
        if singular:
            raise SingularMatrixError(CONTRADICTORY)
        return x

    return solve
