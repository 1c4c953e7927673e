"""A trace as functions that Numba inlines into kernels: on numbers, and on vectors."""

import functools
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit.options import INTERNAL, njit
from fastdyn.kernels.vector.instructions import FUSE
from fastdyn.trace.emit.numbers import INDEX, REAL, WORD, Emitter
from fastdyn.trace.graph.refusal import refused_as

from ..callables import Uncompilable
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
def vector_text(traced, symbol, n, width, exact, kinds=None, skip=0):
    """See `Traced.vector_text`."""
    if traced.trace.error:
        raise Uncompilable(f"it can raise ({traced.trace.error}), which vectors cannot")
    g = traced.trace.graph
    vector = ir.VectorType(REAL, width)
    # where the function would raise, the value is NaN
    nodes = [g.select(traced.trace.raising, g.const(np.nan), node) for node in traced.stored]
    whole = vector if traced.mode.one_number else ir.ArrayType(vector, len(nodes))
    given = [vector, ir.ArrayType(vector, n), WORD.as_pointer()]
    module = ir.Module()
    function = ir.Function(module, ir.FunctionType(whole, given), symbol)
    function.attributes.add("alwaysinline")
    builder = ir.IRBuilder(function.append_basic_block())
    t, y, words = function.args
    if skip:
        words = builder.gep(words, [INDEX(skip)])
    source = VectorSource(builder, traced, t, y, words, kinds or traced.kinds)
    in_vectors = None if exact else functools.partial(by_formula, builder)
    emitter = Emitter(builder, g, vector, source, in_vectors, () if exact else FUSE)
    values = emitter.nodes(nodes)
    if traced.mode.one_number:
        builder.ret(values[0])
    else:
        result: Any = ir.Constant(whole, ir.Undefined)
        for i, value in enumerate(values):
            result = builder.insert_value(result, value, i)
        builder.ret(result)
    return str(module)
