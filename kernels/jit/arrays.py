"""Arrays over borrowed memory, in LLVM: the fields of their records, without a copy on the stack.

LLVM, because Numba's own `make_array` stores an array's record on the stack to read one field; nine
in ten instructions of a kernel were of that kind before LLVM optimised them.
"""

from llvmlite import ir
from numba import types


def field_of(context, builder, ty, array, name, *axis):
    """A field of an array: `data`, or an item of `shape` or `strides`."""
    at = context.data_model_manager[ty].get_field_position(name)
    return builder.extract_value(array, [at, *axis])


def shape_of(context, builder, ty, array):
    return [field_of(context, builder, ty, array, "shape", axis) for axis in range(ty.ndim)]


def borrowed(context, builder, ty, data, shape, strides=None):
    """A C-contiguous array over memory that belongs to the caller."""
    model = context.data_model_manager[ty]
    size = None
    item = context.get_abi_sizeof(context.get_data_type(ty.dtype))
    if strides is None:
        strides = [context.get_constant(types.intp, item)]
        for length in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], length))
    for length in shape:
        size = length if size is None else builder.mul(size, length)
    array = ir.Constant(model.get_value_type(), None)  # no owner, and no Python object
    item = context.get_constant(types.intp, item)
    for name, value in (("nitems", size), ("itemsize", item), ("data", data)):
        array = builder.insert_value(array, value, model.get_field_position(name))
    for name, values in (("shape", shape), ("strides", strides)):
        for axis, value in enumerate(values):
            array = builder.insert_value(array, value, [model.get_field_position(name), axis])
    return array
