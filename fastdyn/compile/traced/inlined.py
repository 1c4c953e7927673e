"""A trace as functions that Numba inlines into kernels: on numbers, and on vectors."""

import functools
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit_options import INLINED, INTERNAL, njit
from fastdyn.kernels.vector.instructions import FUSE
from fastdyn.trace.emit.numbers import Emitter
from fastdyn.trace.graph.refusal import refused_as
from fastdyn.trace.islands.island import calls_libraries

from ..callables.diagnostics import Uncompilable
from .inputs import VectorSource
from .pointer_form import body, by_formula


def dispatcher(traced):
    """The pointer form as a Numba dispatcher that kernels inline."""

    def into_kernels(typingctx, t, y, n, block, out):
        def codegen(context, builder, signature, args):
            body(traced, builder, *args)
            return context.get_dummy_value()

        return types.none(*FORM), codegen

    emitted: Any = intrinsic(into_kernels)

    @njit(**INTERNAL)
    def function(t, y, n, block, out):
        emitted(t, y, n, block, out)

    return function


@refused_as(Uncompilable)
def build_vector(traced, kinds=None):
    """See `Traced.build_vector`."""
    if calls_libraries(traced.trace.graph):
        raise Uncompilable("it calls a library, which vectors cannot")
    if traced.trace.error:
        raise Uncompilable(f"it can raise ({traced.trace.error}), which vectors cannot")
    g, kinds = traced.trace.graph, kinds or traced.kinds
    # where the function would raise, the value is NaN
    nodes = [g.select(traced.trace.raising, g.const(np.nan), node) for node in traced.stored]

    def of_vectors(typingctx, t, y, block):
        whole = t if traced.mode.one_number else types.UniTuple(t, len(nodes))

        def codegen(context, builder, signature, args):
            t_value, y_value, words = args
            source = VectorSource(builder, traced, t_value, y_value, words, kinds)
            in_vectors = None if t.exact else functools.partial(by_formula, builder)
            flags = () if t.exact else FUSE
            emitter = Emitter(builder, g, args[0].type, source, in_vectors, flags)
            values = emitter.nodes(nodes)
            if traced.mode.one_number:
                return values[0]
            return context.make_tuple(builder, whole, values)

        return whole(t, y, block), codegen

    results: Any = intrinsic(of_vectors)

    @njit(**INLINED)
    def function(t, y, block):
        return results(t, y, block)

    return function
