"""The machine code of a function, called from Python."""

from fastdyn.compile.compare import machine_value
from fastdyn.compile.functions import with_code
from fastdyn.compile.python_callback import Held


def called(function, values, mode, n):
    """``f(t, y)`` of a compiled Function; None where the code raises.

    `values` has a (type, value) for each parameter.
    """
    bound = with_code(function, None, Held(), values, mode, n)
    return lambda t, y: machine_value(bound, t, y)
