"""The layout of Python's objects for C: the places of their fields, and functions that read them.

Each process checks the layout once; without the expected layout, the process has no entry.
"""

import ctypes
import functools
import sysconfig
import types
from typing import Any

import numpy as np

from fastdyn.compile.callables import numpy_errors
from fastdyn.compile.traced import met
from fastdyn.run.outcome import PARTS, SUCCESS
from fastdyn.run.result import OdeResult

HEAD = object.__basicsize__  # bytes before the fields of an object
TYPE = HEAD - 8  # the last word of the head, with and without the interpreter lock
DATA, NDIM, SHAPE, DESCR, FLAGS = HEAD, HEAD + 8, HEAD + 16, HEAD + 40, HEAD + 48  # of an array
TUPLE = tuple.__basicsize__  # the first item of a tuple
ATTRIBUTES = types.FunctionType.__dictoffset__
PLAIN = 0x101  # flags of an array that is C-contiguous and aligned
NEW = 93  # PyArray_New among NumPy's C functions
LAYOUT = HEAD, TUPLE, ATTRIBUTES

FUNCTIONS = (  # of Python's stable C interface, except PyFunction_Get* and PyCell_Get
    "PyTuple_GetItem", "PyTuple_Size", "PyList_GetItem", "PyList_Size", "PyList_SetSlice",
    "PyList_Append", "PyDict_GetItem", "PyDict_Next", "PyDict_Size", "PyDict_SetItem",
    "PyDict_Update", "PyFloat_AsDouble", "PyLong_FromLongLong", "PyLong_AsLongLongAndOverflow",
    "PyFunction_GetCode", "PyFunction_GetGlobals", "PyFunction_GetClosure",
    "PyFunction_GetDefaults", "PyFunction_GetKwDefaults", "PyCell_Get", "PyContextVar_Get",
    "PyObject_CallNoArgs", "PyObject_Vectorcall", "PyEval_SaveThread", "PyEval_RestoreThread",
    "Py_IncRef", "Py_DecRef",
)  # fmt: skip
COUNTS = "nfev", "njev", "nlu", "n_accepted", "n_rejected"  # fields with a number of each solve
TEMPLATE = dict.fromkeys(PARTS) | {"status": 0, "message": SUCCESS, "success": True}
OBJECTS: dict[str, Any] = {
    "result": OdeResult, "template": TEMPLATE, "args": "args", "none": None, "tuple": tuple,
    "list": list, "dict": dict, "float": float, "float of numpy": np.float64, "int": int,
    "function": types.FunctionType, "ndarray": np.ndarray,
    "float64": np.dtype(float), "errors": numpy_errors.state,
    "usual errors": numpy_errors.USUAL, **{name: name for name in ("t", "y", *COUNTS)},
}  # fmt: skip
NAMES = (*FUNCTIONS, "PyArray_New", "left", *OBJECTS)
PLACE = {name: 8 * i for i, name in enumerate(NAMES)}  # in the table


class Unknown(Exception):
    """Raised if objects have another layout in this interpreter, or functions other names."""


@functools.cache
def table():
    """The addresses of functions and objects, by `PLACE`; raises Unknown."""
    if numpy_errors.state is None:
        raise Unknown("NumPy keeps the handling of errors elsewhere")
    _check_heads()
    _check_arrays()
    try:
        functions = [getattr(ctypes.pythonapi, name) for name in FUNCTIONS]
    except AttributeError as error:
        raise Unknown(str(error)) from None
    found = [ctypes.cast(function, ctypes.c_void_p).value for function in functions]
    words = [*found, _array_new(), met.N_LEFT.buffer_info()[0], *map(id, OBJECTS.values())]
    return np.array(words, np.int64)


def _word(address):
    return ctypes.c_int64.from_address(address).value


def _number(address):
    return ctypes.c_int32.from_address(address).value


def _check_heads():
    """Raise Unknown if tuples or functions have another layout, or Python has no global lock."""

    def probe():
        pass

    things = probe, object()
    vars(probe)["attribute"] = things
    if ATTRIBUTES <= 0 or _word(id(probe) + ATTRIBUTES) != id(vars(probe)):
        raise Unknown("functions")
    if _word(id(things) + TUPLE) != id(probe) or _word(id(things) + TUPLE + 8) != id(things[1]):
        raise Unknown("tuples")
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        raise Unknown("threads without the interpreter lock")


def _check_arrays():
    """Raise Unknown if arrays have another layout, or PyArray_New is at another place."""
    for a in (
        np.zeros(3), np.zeros((2, 5)), np.zeros(9)[::2], np.zeros((3, 2)).T, np.zeros(2, "f4"),
        np.zeros(()), np.frombuffer(bytearray(33), np.int8)[1:].view(float),
    ):  # fmt: skip
        at, shape = id(a), _word(id(a) + SHAPE)
        found = (
            _word(at + TYPE), _word(at + DATA), _number(at + NDIM),
            tuple(_word(shape + 8 * i) for i in range(a.ndim)), _word(at + DESCR),
            _number(at + FLAGS) & PLAIN == PLAIN,
        )  # fmt: skip
        plain = a.flags.c_contiguous and a.flags.aligned
        if found != (id(np.ndarray), a.ctypes.data, a.ndim, a.shape, id(a.dtype), plain):
            raise Unknown("arrays")
    a = _as_python(_array_new())(
        id(np.ndarray), 2, (ctypes.c_int64 * 2)(4, 3), 12, None, None, 0, 2, None
    )
    if type(a) is not np.ndarray or a.shape != (4, 3) or a.dtype != float or a.flags.c_contiguous:
        raise Unknown("PyArray_New")


def _as_python(address):
    word, small = ctypes.c_void_p, ctypes.c_int
    return ctypes.PYFUNCTYPE(
        ctypes.py_object, word, small, word, small, word, word, small, small, word
    )(address)


def _array_new():
    """The address of PyArray_New, from NumPy's table of C functions."""
    from numpy._core import _multiarray_umath  # pyright: ignore

    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    return _word(pointer(_multiarray_umath._ARRAY_API, None) + 8 * NEW)
