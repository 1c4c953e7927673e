"""LAPACK's factors and solutions, by the addresses of its routines; see `factorise.py`.

`ge` routines take full matrices, `gb` routines take band matrices: E. Anderson and others, "LAPACK
Users' Guide", third edition (1999).

LLVM, because Numba passes no addresses of copies to a routine at an address.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.options import INTERNAL, njit
from ..state.elementwise import data_of

INT = ir.IntType(32)
NOT_TRANSPOSED = ord("N")


@intrinsic
def call_routine(typingctx, routine, arguments):
    """Call the routine at an address; return the last argument of the routine, `info`.

    A number is passed as the address of a copy, a row as the address of its data.
    """

    def codegen(context, builder, signature, args):
        pointers = []
        for i, ty in enumerate(arguments):
            value = builder.extract_value(args[1], i)
            if isinstance(ty, types.Array):
                pointers.append(builder.bitcast(data_of(context, builder, ty, value), VOID))
            else:
                place = cgutils.alloca_once(builder, INT)
                builder.store(builder.trunc(value, INT), place)
                pointers.append(builder.bitcast(place, VOID))
        info = cgutils.alloca_once_value(builder, ir.Constant(INT, 0))
        pointers.append(builder.bitcast(info, VOID))
        kind = ir.FunctionType(ir.VoidType(), [VOID] * len(pointers))
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), pointers)
        return builder.sext(builder.load(info), ir.IntType(64))

    return types.int64(routine, arguments), codegen


VOID = ir.IntType(8).as_pointer()


@njit(**INTERNAL)
def factorise_full(routine, a, n, pivots):
    """Factorise a full matrix by ?getrf; return whether the matrix is regular."""
    return call_routine(routine, (n, n, a, n, pivots)) == 0


@njit(**INTERNAL)
def solve_full(routine, a, n, pivots, b):
    """Solve with the factors of a full matrix, by ?getrs."""
    call_routine(routine, (NOT_TRANSPOSED, n, 1, a, n, pivots, b, n))


@njit(**INTERNAL)
def factorise_band(routine, a, n, lower, upper, pivots):
    """Factorise a band matrix with ld = 2 lower + upper by ?gbtrf; return whether it is regular."""
    return call_routine(routine, (n, n, lower, upper, a, 2 * lower + upper + 1, pivots)) == 0


@njit(**INTERNAL)
def solve_band(routine, a, n, lower, upper, pivots, b):
    """Solve with the factors of a band matrix, by ?gbtrs."""
    ld = 2 * lower + upper + 1
    call_routine(routine, (NOT_TRANSPOSED, n, lower, upper, 1, a, ld, pivots, b, n))
