"""Emits systems of linear equations: memory for a matrix, and calls of kernels.

The kernels are those of `kernels/algebra/padded/`, which describes the memory.
"""

from typing import Any, NamedTuple

from llvmlite import ir

from fastdyn.kernels.algebra.padded import storage
from fastdyn.kernels.algebra.padded.storage import leading, length
from fastdyn.kernels.vector.instructions import BIT, INDEX, REAL
from fastdyn.trace.emit.memory import Memory
from fastdyn.trace.emit.numbers import BY_KERNELS
from fastdyn.trace.graph.expressions import is_zero
from fastdyn.trace.operations import linear
from fastdyn.trace.operations.linear import FACTORS, SOLUTION

WORD = ir.IntType(64)
KINDS = {
    linear.GENERAL: storage.GENERAL,
    linear.SYMMETRIC: storage.SYMMETRIC,
    linear.SCALED: storage.SCALED,
}


class Factors(NamedTuple):
    """The words of a matrix and its pivots, and whether the matrix is singular."""

    words: list
    singular: Any


def room(builder, kind, count):
    """The address of memory on the stack."""
    with builder.goto_entry_block():
        numbers = builder.alloca(ir.ArrayType(kind, count))
    numbers.align = 32
    return builder.bitcast(numbers, kind.as_pointer())


def _zeros(builder, count):
    """The address of numbers that are zero."""
    numbers = room(builder, REAL, count)
    kinds = [ir.IntType(8).as_pointer(), WORD]
    clear = builder.module.declare_intrinsic("llvm.memset", kinds)
    place = builder.bitcast(numbers, kinds[0])
    builder.call(clear, [place, ir.IntType(8)(0), WORD(8 * count), BIT(0)])
    return numbers


def called(builder, name, words):
    """Call a kernel by words; its status."""
    function = builder.module.globals.get(name) or ir.Function(
        builder.module, ir.FunctionType(WORD, [WORD.as_pointer()]), name
    )
    given = room(builder, WORD, len(words))
    for k, word in enumerate(words):
        builder.store(word, builder.gep(given, [INDEX(k)]))
    return builder.call(function, [given])


def row_words(builder, pointer, count):
    """The words of an array of numbers."""
    return [builder.ptrtoint(pointer, WORD), WORD(count)]


def _factors(emitter, node, args):
    b = emitter.builder
    n, kind = node.data
    a = _zeros(b, length(n))
    pivots = room(b, REAL, 2 * n)
    for i in range(n, leading(n)):
        b.store(REAL(1.0), b.gep(a, [INDEX(i * leading(n) + i)]))
    if len(args) == 1:
        _copy(b, emitter.source.address(node.args[0].data), a, n)
    else:
        for k, (operand, value) in enumerate(zip(node.args, args, strict=True)):
            i, j = divmod(k, n)
            if not is_zero(operand):
                b.store(value, b.gep(a, [INDEX(j * leading(n) + i)]))
    words = [*row_words(b, a, length(n)), *row_words(b, pivots, 2 * n)]
    status = called(b, FACTORS, [*words, WORD(KINDS[kind])])
    return Factors(words, b.icmp_signed("!=", status, WORD(0)))


def _copy(builder, elements, a, n):
    """Copy a matrix that lies in memory by rows."""
    memory = Memory(builder)
    with memory.each(WORD(n), 1) as i:
        first = builder.mul(i, WORD(n))
        with memory.each(WORD(n), 1) as j:
            value = builder.load(builder.gep(elements, [builder.add(first, j)]))
            column = builder.mul(j, WORD(leading(n)))
            builder.store(value, builder.gep(a, [builder.add(i, column)]))


def _solution(emitter, node, args):
    b = emitter.builder
    factors, *right = args
    length = leading(len(right))
    numbers = _zeros(b, length)
    for k, value in enumerate(right):
        b.store(value, b.gep(numbers, [INDEX(k)]))
    words = [*factors.words, *row_words(b, numbers, length), WORD(int(node.data))]
    called(b, SOLUTION, words)
    return numbers


def entry(emitter, node, args):
    """One of the numbers at an address."""
    b = emitter.builder
    return b.load(b.gep(args[0], [INDEX(node.data)]))


def calls_kernels():
    """Register the code of these operations."""
    BY_KERNELS["factors"] = _factors
    BY_KERNELS["singular"] = lambda emitter, node, args: args[0].singular
    BY_KERNELS["solution"] = _solution
    BY_KERNELS["entry"] = entry
