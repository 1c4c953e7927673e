"""LLVM instructions on vectors and on numbers alike, written without Numba.

LLVM, because Numba has no vectors, and no `contract` for one operation.
"""

from llvmlite import ir

FUSE = ("contract",)
REAL = ir.DoubleType()
BIT = ir.IntType(1)
INDEX = ir.IntType(32)


def splat(builder, value, width):
    """A vector with `value` in each lane."""
    kind = ir.VectorType(value.type, width)
    if isinstance(value, ir.Constant):
        return ir.Constant(kind, [value.constant] * width)
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), value, INDEX(0))
    zeros = ir.Constant(ir.VectorType(INDEX, width), None)
    return builder.shuffle_vector(one, ir.Constant(kind, ir.Undefined), zeros)


def constant(kind, a):
    """The number `a` as a component of LLVM type `kind`."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [float(a)] * kind.count)
    return ir.Constant(kind, float(a))


def declared(module, form, name):
    """The function `name` of a module, declared if the module lacks it."""
    return module.globals.get(name) or ir.Function(module, form, name)


def intrinsic_of(builder, name, kind, n):
    """The LLVM intrinsic `name` of n vectors, or of n numbers."""
    width = f"v{kind.count}" if isinstance(kind, ir.VectorType) else ""
    form = ir.FunctionType(kind, [kind] * n)
    return declared(builder.module, form, f"llvm.{name}.{width}f64")


def fuse(builder, a, b, c):
    """a b + c, numbers or vectors, rounded once where the processor has an instruction for that.

    `fmuladd`, because with `contract` the optimiser fuses, or not, by what stands around the
    operation: kernels on tuples and on rows would differ.
    """
    return builder.call(intrinsic_of(builder, "fmuladd", a.type, 3), [a, b, c])


def pack(builder, values):
    """An LLVM structure of the values."""
    whole = ir.Constant(ir.LiteralStructType([v.type for v in values]), ir.Undefined)
    for i, value in enumerate(values):
        whole = builder.insert_value(whole, value, i)
    return whole
