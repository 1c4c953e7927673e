"""How a kernel stores values of vectors: known to the compiler, without memory of its own."""

from numba import types
from numba.core.imputils import lower_constant
from numba.extending import models, register_model, typeof_impl

from ..vector.number import Vector


class Form:
    """How values are stored: tuples of n vectors, known to the compiler."""

    def __init__(self, n, width, exact=False):
        self.value = types.UniTuple(Vector(width, exact), n)


class FormType(types.Type):
    """The type of one Form; `value` is that of the values."""

    def __init__(self, value):
        self.value = value
        super().__init__(name=f"Form({value})")


register_model(FormType)(models.OpaqueModel)


@typeof_impl.register(Form)
def _typeof_form(value, context):
    return FormType(value.value)


@lower_constant(FormType)
def _constant_form(context, builder, ty, value):
    return context.get_dummy_value()
