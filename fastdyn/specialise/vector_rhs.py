"""A traced function on vectors, in the forms that steps and events call.

LLVM, because Numba calls no function of vectors by a symbol.
"""

# Numba's type annotations are incomplete.
# pyright: reportCallIssue=false, reportArgumentType=false

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from fastdyn.kernels.calls.user_function import address_of, words_at
from fastdyn.kernels.jit.options import INLINED, njit


def named(symbol, n_results):
    """A function on vectors, linked later by its symbol; `n_results` None: a single vector."""

    @intrinsic
    def call(typingctx, t, y, block):
        whole = t if n_results is None else types.UniTuple(t, n_results)

        def codegen(context, builder, signature, args):
            kind = ir.FunctionType(context.get_value_type(whole), [a.type for a in args])
            function = cgutils.get_or_insert_function(builder.module, kind, symbol)
            return builder.call(function, args)

        return whole(t, y, block), codegen

    @njit(**INLINED)
    def function(t, y, block):
        return call(t, y, block)

    return function


def right_hand_side(function):
    """``rhs(t, y, block, out)`` for the steps."""

    @njit(**INLINED)
    def rhs(t, y, block, out):
        return function(t, y, words_at(address_of(block)))

    return rhs


def number(function):
    """``number(t, y, block)`` of a function on vectors."""

    @njit(**INLINED)
    def value(t, y, block):
        return function(t, y, words_at(address_of(block)))

    return value
