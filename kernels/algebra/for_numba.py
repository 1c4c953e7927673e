"""Linear systems and constrained motion in functions that Numba compiles.

LLVM, because the code of the solution comes from `straight_line.py`.
"""

from numba import types
from numba.core import errors
from numba.extending import intrinsic, overload

from ..jit.options import OWNING
from ..vector.emit import Lanes
from .constrained import CONTRADICTORY, constrained, constraints_solved
from .linear import SINGULAR, SingularMatrixError, linear_solved, solve_linear

REAL = (types.Float, types.Integer, types.Boolean)


def is_row(ty):
    return isinstance(ty, types.BaseTuple) and all(isinstance(t, REAL) for t in ty)


def is_matrix(ty):
    return isinstance(ty, types.BaseTuple) and len(ty) > 0 and all(map(is_row, ty))


def lists_of(context, builder, ty, value):
    """Nested tuples as nested lists of Lanes."""
    if isinstance(ty, types.BaseTuple):
        parts = [(t, builder.extract_value(value, i)) for i, t in enumerate(ty)]
        return [lists_of(context, builder, *part) for part in parts]
    return Lanes(builder, context.cast(builder, value, ty, types.float64))


def in_code(formula, size):
    """A function that returns the pair of `formula`; x has ``size(*tuples)`` numbers.

    The function takes a tuple of rows and matrices.
    """

    @intrinsic
    def solve(typingctx, given):
        row = types.UniTuple(types.float64, size(*given))
        result = types.Tuple((row, types.boolean))

        def codegen(context, builder, signature, args):
            x, regular = formula(*lists_of(context, builder, given, args[0]))
            x = context.make_tuple(builder, row, [v.value for v in x])
            return context.make_tuple(builder, result, [x, regular.value])

        return result(given), codegen

    return solve


_solve = in_code(linear_solved, lambda a, b: len(b))


@overload(solve_linear, jit_options=OWNING)
def _solve_linear(a, b):
    if not (is_matrix(a) and is_row(b) and {len(a), *map(len, a)} == {len(b)}):
        raise errors.TypingError("solve_linear takes n tuples of n numbers, and a tuple of n")

    def solve(a, b):
        x, regular = _solve((a, b))
        if not regular:
            raise SingularMatrixError(SINGULAR)
        return x

    return solve


_motion = in_code(constraints_solved, lambda mass, a, force, b: len(force) + len(b))


@overload(constrained, jit_options=OWNING)
def _constrained_motion(mass, a, force, b):
    shapes = is_matrix(a) and is_row(force) and is_row(b) and (is_row(mass) or is_matrix(mass))
    n, k = (len(force), len(b)) if shapes else (0, 0)
    if not shapes or len(a) != k or len(mass) != n or {*map(len, a)} != {n}:
        raise errors.TypingError(
            "constrained takes masses (n numbers or n rows), A (k rows of n), n forces and k "
            "right-hand sides, all as tuples"
        )

    def solve(mass, a, force, b):
        x, regular = _motion((mass, a, force, b))
        if not regular:
            raise SingularMatrixError(CONTRADICTORY)
        return x

    return solve
