"""The user's function on vectors: eight trajectories at once, from the same text."""

# Numba's decorators and types say less than they are.
# pyright: reportCallIssue=false, reportArgumentType=false

import functools
from typing import NamedTuple

import llvmlite.binding as llvm
from numba import njit, types
from numba.core import errors
from numba.extending import intrinsic
from numba.np import arrayobj

from . import cache
from .adapt import INLINED, described, identity, taken_in, words_of
from .kernels import METHODS, adaptive, fixed, lanes, vector_math  # noqa: F401
from .kernels.calls import BARE, FUSED, WORDS
from .kernels.form import Form
from .kernels.vector import is_real, widen
from .parts import parts_of
from .refusal import Uncompilable, explain
from .specialise import STATES, TABLE
from .values import MOMENTS, Spread

MAX_TUPLE = 24
ADVANCE = types.int64(STATES, TABLE, TABLE, WORDS, types.int64)


@functools.cache
def width():
    """Lanes of a vector on this machine: two registers, so that one can wait for the other."""
    features = llvm.get_host_cpu_features()
    return 8 if features.get("avx") else 4


class Kernel(NamedTuple):
    """A stepping kernel on vectors; `n_words` is the length of its block behind FIRST."""

    address: int
    width: int
    n_words: int
    kinds: list
    alive: list


@intrinsic
def _words(typingctx, block):
    def codegen(context, builder, signature, args):
        return arrayobj.make_array(WORDS)(context, builder, args[0]).data

    return types.CPointer(types.int64)(block), codegen


@intrinsic
def _value(typingctx, result, y):
    """What a function returned, as a value of the state."""
    if not isinstance(result, types.BaseTuple) or not all(map(is_real, result)):
        raise errors.TypingError(f"the result on vectors is of type {result}")
    skip = len(result) - len(y)

    def codegen(context, builder, signature, args):
        parts = [
            widen(context, builder, result[i], builder.extract_value(args[0], i), y.dtype.width)
            for i in range(skip, len(result))
        ]
        return context.make_tuple(builder, y, parts)

    return y(result, y), codegen


@intrinsic(prefer_literal=True)
def _head(typingctx, y, moments):
    """The state without its moments."""
    n = len(y) // (1 + len(moments.literal_value.split()))
    own = types.UniTuple(y.dtype, n)

    def codegen(context, builder, signature, args):
        parts = [builder.extract_value(args[0], i) for i in range(n)]
        return context.make_tuple(builder, own, parts)

    return own(y, moments), codegen


@intrinsic(prefer_literal=True)
def _extended(typingctx, f, y, moments):
    """[f, rates of the moments of y]: y itself, or its squares."""

    def codegen(context, builder, signature, args):
        parts = [builder.extract_value(args[0], i) for i in range(len(f))]
        state = [builder.extract_value(args[1], i) for i in range(len(f))]
        for moment in moments.literal_value.split():
            parts += [builder.fmul(x, x) if moment == "rms" else x for x in state]
        return context.make_tuple(builder, y, parts)

    return y(f, y, moments), codegen


@intrinsic
def _padded(typingctx, q):
    """[q, 0]."""
    whole = types.UniTuple(q.dtype, 2 * len(q))

    def codegen(context, builder, signature, args):
        parts = [builder.extract_value(args[0], i) for i in range(len(q))]
        zero = context.get_constant_null(q.dtype)
        return context.make_tuple(builder, whole, [*parts, *[zero] * len(q)])

    return whole(q), codegen


def right_hand_side(function, values, mode):
    """``rhs(t, y, block, out)`` for the steps."""
    if mode in MOMENTS:

        @njit(**FUSED)
        def rhs(t, y, block, out):
            own = _head(y, mode)
            return _extended(_value(function(*values(t, own, _words(block), None)), own), y, mode)

    elif mode == "acceleration":

        @njit(**FUSED)
        def rhs(t, y, block, out):
            return _value(function(*values(t, _padded(y), _words(block), None)), y)

    else:

        @njit(**FUSED)
        def rhs(t, y, block, out):
            return _value(function(*values(t, y, _words(block), None)), y)

    return rhs


def _loop(method, rhs, form, extrema):
    """The dispatcher of a method's loop around `rhs`."""
    step = method.step
    if method.advance is adaptive.advance:
        control, exponent, last = method.arguments

        @njit(**BARE)
        def kernel(state, many, work, block, n_steps):
            return lanes.advance(
                rhs, step, control, exponent, last, form, extrema, state, many, work, block, n_steps
            )

    else:
        last, low = method.arguments

        @njit(**BARE)
        def kernel(state, many, work, block, n_steps):
            return lanes.advance_fixed(
                rhs, step, last, low, form, extrema, state, many, work, block, n_steps
            )

    return kernel


_kernels: dict = {}


def kernel(name, fun, args, varying, mode, n, extrema):
    """The stepping kernel of a method for n vectors, with `fun` inlined.

    Parameters
    ----------
    name : str
        Of the method.
    fun, args : callable, tuple
    varying : tuple of bool
        Which of `args` differ between trajectories.
    mode : str
        "derivative" or "acceleration"; see `adapt.bind`.
    n : int
        Length of the state.
    extrema : bool
        Whether it looks out for the largest and smallest values.

    Returns
    -------
    Kernel

    Raises
    ------
    Uncompilable
        With the reason in a sentence.
    """
    method = METHODS[name]
    if method.advance not in (adaptive.advance, fixed.advance):
        raise Uncompilable(f"the steps of {name} are not written for vectors")
    if n > MAX_TUPLE:
        raise Uncompilable(f"{n} components are more than {MAX_TUPLE}")
    spread = Spread(width())
    given = tuple(spread if v else a for v, a in zip(varying, args, strict=True))
    parts = parts_of(fun, given)
    layout, outside = described(parts)
    key = identity(parts, mode, layout, outside)
    key = key and f"lanes {name} {n} {width()} {extrema} {key}"
    found = _kernels.get(key)
    if found is None:

        def build():
            function, values = taken_in(parts, layout, outside, True, INLINED)
            rhs = right_hand_side(function, values, mode)
            return _loop(method, rhs, Form(n, width()), extrema or None), ADVANCE

        try:
            found = cache.compiled(key, build)
        except Exception as error:
            raise Uncompilable(explain(error)) from error
        if key is not None:
            _kernels[key] = found
    kinds = [(k, v) for k, v in zip(layout, parts.positional, strict=True) if type(k) is not str]
    kinds += outside.values()
    size = words_of([k for k, _ in kinds])
    return Kernel(found.address, width(), size, kinds, [found, parts])
