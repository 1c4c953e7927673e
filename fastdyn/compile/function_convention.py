"""The calling convention of the user's compiled functions: ``function(t, y, n, block, out)``.

Numba's machine code returns a status, and has two more arguments before t: the addresses of a
result and of an exception.  This file writes the convention for C and for LLVM; for Numba, `FORM`
in `kernels/calls/user_function.py` has the types.  The words of a block are defined in
`kernels/calls/block.py`.  Kernels have another convention: `kernels/calls/calling_convention.py`.
"""

import ctypes
import functools
import math

from fastdyn.kernels.calls.block import FAULT, RAISED_WORD, TIME

POINTER = ctypes.c_void_p
NUMBER = ctypes.c_double
WHOLE = ctypes.c_ssize_t
SIGNATURE = ctypes.CFUNCTYPE(
    ctypes.c_int, POINTER, POINTER, NUMBER, POINTER, WHOLE, POINTER, POINTER
)
WORDS = ctypes.POINTER(ctypes.c_int64)


@functools.lru_cache(64)
def code_at(address):
    """The machine code at an address as a function of SIGNATURE, for calls from Python."""
    return SIGNATURE(address)


def call(function, t, y, block, out, left=None):
    """Call a function of SIGNATURE; return whether the function raised, and clear RAISED_WORD.

    `left` is the address of a word where Numba's code stores the exception.
    """
    block[RAISED_WORD] = 0
    function(left, left, t, y.ctypes.data, len(y), block.ctypes.data, out.ctypes.data)
    raised = block[RAISED_WORD]
    block[RAISED_WORD] = 0
    return bool(raised)


def mark(block):
    """Set RAISED_WORD of the block at an address, after a Python function has raised."""
    ctypes.cast(block, WORDS)[RAISED_WORD] = 1


def form():
    """The LLVM type of a compiled function."""
    from llvmlite import ir

    pointer = ir.IntType(8).as_pointer()
    real = ir.DoubleType()
    word = ir.IntType(64)
    numbers = real.as_pointer()
    words = word.as_pointer()
    return ir.FunctionType(ir.IntType(32), [pointer, pointer, real, numbers, word, words, numbers])


def define(module, symbol, body):
    """Define a function in an LLVM module; ``body(builder, t, y, n, block, out)`` emits code."""
    from llvmlite import ir

    kind = form()
    function = ir.Function(module, kind, symbol)
    builder = ir.IRBuilder(function.append_basic_block())
    body(builder, *function.args[2:])
    builder.ret(kind.return_type(0))


def note_fault(builder, t, y, block, out, n, n_results):
    """Emit code for an exception: store time and state of the first exception, and NaN in `out`.

    `n` and `n_results` are LLVM values, the lengths of y and out.
    """
    from fastdyn.trace.emit.memory import Memory
    from fastdyn.trace.emit.numbers import INDEX, REAL, WORD

    memory = Memory(builder)
    raised = builder.gep(block, [INDEX(RAISED_WORD)])
    with builder.if_then(builder.icmp_signed("==", builder.load(raised), WORD(0))):
        builder.store(WORD(1), raised)
        at = builder.gep(block, [INDEX(TIME)])
        builder.store(t, builder.bitcast(at, REAL.as_pointer()))
        fault = builder.load(builder.gep(block, [INDEX(FAULT)]))
        kept = builder.bitcast(builder.gep(block, [fault]), REAL.as_pointer())
        with builder.if_then(builder.icmp_signed(">", n, WORD(0))), memory.each(n, 1) as i:
            builder.store(builder.load(builder.gep(y, [i])), builder.gep(kept, [i]))
    some = builder.icmp_signed(">", n_results, WORD(0))
    with builder.if_then(some), memory.each(n_results, 1) as i:
        builder.store(REAL(math.nan), builder.gep(out, [i]))
