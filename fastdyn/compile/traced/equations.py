"""Emits systems of linear equations: memory for a matrix, and calls of kernels.

The kernels are those of `kernels/algebra/padded/`, which describes the memory.
"""

from typing import Any, NamedTuple

from llvmlite import ir

from fastdyn.kernels.algebra.padded import storage
from fastdyn.kernels.algebra.padded.storage import leading, length
from fastdyn.kernels.output.arguments import PAST_PLACES
from fastdyn.kernels.vector.instructions import BIT, INDEX, REAL
from fastdyn.trace.emit.memory import Memory
from fastdyn.trace.emit.numbers import BY_KERNELS
from fastdyn.trace.graph.expressions import is_zero
from fastdyn.trace.operations import linear
from fastdyn.trace.operations.delays import PAST
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


def _room(builder, kind, count):
    """The address of memory on the stack."""
    with builder.goto_entry_block():
        room = builder.alloca(ir.ArrayType(kind, count))
    room.align = 32
    return builder.bitcast(room, kind.as_pointer())


def _zeros(builder, count):
    """The address of numbers that are zero."""
    room = _room(builder, REAL, count)
    kinds = [ir.IntType(8).as_pointer(), WORD]
    clear = builder.module.declare_intrinsic("llvm.memset", kinds)
    place = builder.bitcast(room, kinds[0])
    builder.call(clear, [place, ir.IntType(8)(0), WORD(8 * count), BIT(0)])
    return room


def _called(builder, name, words):
    """Call a kernel by words; its status."""
    function = builder.module.globals.get(name) or ir.Function(
        builder.module, ir.FunctionType(WORD, [WORD.as_pointer()]), name
    )
    given = _room(builder, WORD, len(words))
    for k, word in enumerate(words):
        builder.store(word, builder.gep(given, [INDEX(k)]))
    return builder.call(function, [given])


def _row(builder, pointer, count):
    return [builder.ptrtoint(pointer, WORD), WORD(count)]


def _factors(emitter, node, args):
    b = emitter.builder
    n, kind = node.data
    a = _zeros(b, length(n))
    pivots = _room(b, REAL, 2 * n)
    for i in range(n, leading(n)):
        b.store(REAL(1.0), b.gep(a, [INDEX(i * leading(n) + i)]))
    if len(args) == 1:
        _copy(b, emitter.source.address(node.args[0].data), a, n)
    else:
        for k, (operand, value) in enumerate(zip(node.args, args, strict=True)):
            i, j = divmod(k, n)
            if not is_zero(operand):
                b.store(value, b.gep(a, [INDEX(j * leading(n) + i)]))
    words = [*_row(b, a, length(n)), *_row(b, pivots, 2 * n)]
    status = _called(b, FACTORS, [*words, WORD(KINDS[kind])])
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
    words = [*factors.words, *_row(b, numbers, length), WORD(int(node.data))]
    _called(b, SOLUTION, words)
    return numbers


def _entry(emitter, node, args):
    b = emitter.builder
    return b.load(b.gep(args[0], [INDEX(node.data)]))


FEW_READ = 16  # a component alone costs as much as so many of a whole past state


def _past(emitter, node, args):
    """The address of the n numbers of the state at an earlier time; None where few are read."""
    if FEW_READ * emitter.reads[node.key] <= node.data[0]:
        return None
    return _read(emitter, node, args, 0, node.data[0])


def _read(emitter, node, args, first, count):
    """The address of `count` components from `first` on of a past state."""
    b = emitter.builder
    _, n_words, order = node.data
    numbers = _room(b, REAL, count)
    history = emitter.source.table(node.args[1].data)
    time = b.bitcast(args[0], WORD)
    now = b.bitcast(args[2], WORD)
    place = WORD(node.args[0].key % PAST_PLACES)
    asked = [place, time, now, WORD(order), WORD(first)]
    words = [*_row(b, history, n_words), *asked, *_row(b, numbers, count)]
    _called(b, PAST, words)
    return numbers


def _of_past(emitter, node, args):
    """A component of a past state."""
    if args[0] is not None:
        return _entry(emitter, node, args)
    (past,) = node.args
    given = [emitter.value(each) for each in past.args]
    return emitter.builder.load(_read(emitter, past, given, node.data, 1))


def calls_kernels():
    """Register the code of these operations."""
    BY_KERNELS["factors"] = _factors
    BY_KERNELS["singular"] = lambda emitter, node, args: args[0].singular
    BY_KERNELS["solution"] = _solution
    BY_KERNELS["entry"] = _entry
    BY_KERNELS["past"] = _past
    BY_KERNELS["of_past"] = _of_past
    BY_KERNELS["of_slope"] = _of_past
