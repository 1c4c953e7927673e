"""A builtin of Python's stable interface for plain solves, in half of the time of Python's lines.

The code is one function in LLVM's text, common to all runs; `self` of a builtin is the address of
the words of its run.  The code calls documented functions of the stable ABI, whose addresses are
among the words, and reads no field of the interpreter's objects.
"""

import ctypes
import functools
from array import array
from typing import Any

from fastdyn import code_store
from fastdyn.code_store.call import address_of
from fastdyn.kernels.state.record import FINISHED

NEW_BUILTIN = ctypes.PYFUNCTYPE(
    ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.py_object
)(("PyCFunction_NewEx", ctypes.pythonapi))
NO_STATUS = -1
FASTCALL = 0x0080  # METH_FASTCALL of methodobject.h
CALLED = (
    "PyObject_Type", "PyList_Size", "PyList_GetItem", "PyFloat_AsDouble",
    "PyObject_CallFunctionObjArgs", "PyEval_SaveThread", "PyEval_RestoreThread",
    "PyLong_FromLongLong", "Py_IncRef", "Py_DecRef", "PyObject_GetItem", "PyTuple_GetItem",
    "PyDict_SetItem",
)  # fmt: skip
FIELDS = ("t", "y", "nfev", "n_accepted", "n_rejected")
OBJECTS = ("list", "float", "none", "read", "block", "kind", "empty", "copies", "more")
PLACES = ("left", "room", "kernel", "at", "told", "points", "accepted", "rejected", "extra")
NUMBERS = ("n", "end", "stages")
TEXT = """
declare ptr @PyLong_AsVoidPtr(ptr)

define ptr @SYMBOL(ptr %self, ptr %given, i64 %count) {
  %words = call ptr @PyLong_AsVoidPtr(ptr %self)
LOADS
  %type.y0 = call ptr %PyObject_Type(ptr %y0)           ; a list of n floats
  call void %Py_DecRef(ptr %type.y0)
  %is_list = icmp eq ptr %type.y0, %list
  br i1 %is_list, label %length, label %other
length:
  %size = call i64 %PyList_Size(ptr %y0)
  %has_n = icmp eq i64 %size, %n
  %solves = load i64, ptr %left                         ; until a comparison is due
  %not_due = icmp sgt i64 %solves, 1
  %begins = and i1 %has_n, %not_due
  br i1 %begins, label %numbers, label %other
numbers:
  %i = phi i64 [0, %length], [%next, %number]
  %is_done = icmp eq i64 %i, %n
  br i1 %is_done, label %values, label %look
look:
  %item = call ptr %PyList_GetItem(ptr %y0, i64 %i)     ; borrowed; no other code runs meanwhile
  %type = call ptr %PyObject_Type(ptr %item)
  call void %Py_DecRef(ptr %type)
  %is_float = icmp eq ptr %type, %float
  br i1 %is_float, label %number, label %other
number:
  %value = call double %PyFloat_AsDouble(ptr %item)
  %place = getelementptr double, ptr %room, i64 %i
  store double %value, ptr %place
  %next = add i64 %i, 1
  br label %numbers

values:                                                 ; null: an exception; None: other code
  %is_many = icmp eq ptr %block, %none
  %third = select i1 %is_many, ptr %events, ptr %block
  %held = call ptr (ptr, ...) %PyObject_CallFunctionObjArgs(
      ptr %read, ptr %fun, ptr %args, ptr %third, ptr null)
  %raises = icmp eq ptr %held, null
  %is_none = icmp eq ptr %held, %none
  %ends = or i1 %raises, %is_none
  br i1 %ends, label %return, label %solve
return:
  ret ptr %held
solve:                                                  ; other threads run meanwhile
  %thread = call ptr %PyEval_SaveThread()
  %status = call i64 %kernel(ptr %at)
  call void %PyEval_RestoreThread(ptr %thread)
  call void %Py_DecRef(ptr %held)
  %k = load i64, ptr %points
  %is_end = icmp eq i64 %status, %end
  %has_points = icmp sgt i64 %k, 0
  %has_end = and i1 %is_end, %has_points
  %to_tell = load i64, ptr %told
  %is_silent = icmp eq i64 %to_tell, 0
  %is_plain = and i1 %has_end, %is_silent
  br i1 %is_plain, label %copy, label %code
code:
  %found = call ptr %PyLong_FromLongLong(i64 %status)
  ret ptr %found

copy:                                                   ; the arrays, by `outcome.Copies`
  %solves.less = sub i64 %solves, 1
  store i64 %solves.less, ptr %left
  %key = call ptr %PyLong_FromLongLong(i64 %k)
  %pair = call ptr %PyObject_GetItem(ptr %copies, ptr %key)
  call void %Py_DecRef(ptr %key)
  %fails = icmp eq ptr %pair, null
  br i1 %fails, label %failed, label %make
failed:
  ret ptr null
make:
  %copy.t = call ptr %PyTuple_GetItem(ptr %pair, i64 0)
  %copy.y = call ptr %PyTuple_GetItem(ptr %pair, i64 1)
  %t = call ptr (ptr, ...) %PyObject_CallFunctionObjArgs(ptr %copy.t, ptr null)
  %y = call ptr (ptr, ...) %PyObject_CallFunctionObjArgs(ptr %copy.y, ptr null)
  %made = call ptr (ptr, ...) %PyObject_CallFunctionObjArgs(ptr %kind, ptr %empty, ptr null)
  %is.accepted = load i64, ptr %accepted
  %is.rejected = load i64, ptr %rejected
  %is.extra = load i64, ptr %extra
  %tried = add i64 %is.accepted, %is.rejected
  %in_steps = mul i64 %tried, %stages
  %is.nfev = add i64 %in_steps, %is.extra
  %nfev = call ptr %PyLong_FromLongLong(i64 %is.nfev)
  %n_accepted = call ptr %PyLong_FromLongLong(i64 %is.accepted)
  %n_rejected = call ptr %PyLong_FromLongLong(i64 %is.rejected)
  %lacks.0 = icmp eq ptr %made, null
CHECKS
  br i1 %lacks, label %release, label %fill
fill:                                                   ; of places that are there: nothing fails
SETS
RELEASES
  %is_whole = icmp eq ptr %more, %none
  br i1 %is_whole, label %whole, label %fields
fields:                                                 ; the other fields
  %filled = call ptr (ptr, ...) %PyObject_CallFunctionObjArgs(
      ptr %more, ptr %made, ptr %pair, ptr null)
  call void %Py_DecRef(ptr %filled)
  %is_filled = icmp ne ptr %filled, null
  br i1 %is_filled, label %whole, label %half
whole:
  call void %Py_DecRef(ptr %pair)
  ret ptr %made
half:
  call void %Py_DecRef(ptr %pair)
  call void %Py_DecRef(ptr %made)
  ret ptr null
release:                                                ; the memory is full; `Py_DecRef` takes null
  call void %Py_DecRef(ptr %pair)
  call void %Py_DecRef(ptr %made)
RELEASES
  ret ptr null

other:
  call void %Py_IncRef(ptr %none)
  ret ptr %none
}
"""


class _Definition(ctypes.Structure):
    """PyMethodDef, which the interpreter reads as long as a builtin lives."""

    _fields_ = tuple(zip(
        ("name", "function", "flags", "doc"),
        (ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p),
        strict=True,
    ))  # fmt: skip


def _text(symbol):
    """The LLVM text of the function."""
    loads, checks, sets, releases = [], [], [], []
    for i, name in enumerate((*CALLED, *OBJECTS, *[f"of.{f}" for f in FIELDS], *PLACES, *NUMBERS)):
        loads.append(f"%{name}.word = getelementptr i64, ptr %words, i64 {i}")
        loads.append(f"%{name} = load {'i64' if name in NUMBERS else 'ptr'}, ptr %{name}.word")
    for i, name in enumerate(("fun", "y0", "args", "events")):
        loads.append(f"%{name}.at = getelementptr ptr, ptr %given, i64 {i}")
        loads.append(f"%{name} = load ptr, ptr %{name}.at")
    for i, field in enumerate(FIELDS, 1):
        checks.append(f"%is_null.{i} = icmp eq ptr %{field}, null")
        checks.append(f"%lacks.{i} = or i1 %is_null.{i}, %lacks.{i - 1}")
        sets.append(f"call i32 %PyDict_SetItem(ptr %made, ptr %of.{field}, ptr %{field})")
        releases.append(f"call void %Py_DecRef(ptr %{field})")
    text = TEXT.replace("SYMBOL", symbol).replace("%lacks,", f"%lacks.{len(FIELDS)},")
    parts = {"LOADS": loads, "CHECKS": checks, "SETS": sets, "RELEASES": releases}
    for word, lines in parts.items():
        text = text.replace(word, "\n".join(f"  {line}" for line in lines))
    return text


def _address(function) -> Any:
    """The address of a function of ctypes."""
    return ctypes.cast(function, ctypes.c_void_p).value


@functools.cache
def _shared():
    """The code, its definition, and the addresses of CALLED."""
    code = code_store.assembled(_text("SYMBOL"), _text)
    called = [_address(getattr(ctypes.pythonapi, name)) for name in CALLED]
    return code, _Definition(b"solve", code.address, FASTCALL, None), called


def builtin(kernel, at, read, block, left, state, told, plain) -> Any:
    """``solve(fun, y0, args, events)``: the result of a plain solve, or the status of its kernel.

    None if `y0` is no list of n floats, if a comparison is due, or if `read` returns None; then no
    kernel has run.  An exception of `read` passes through.

    Parameters
    ----------
    kernel : code_store.call.KERNEL
    at : ctypes.c_void_p
        The address of the words of the kernel.
    read : callable
        ``read(fun, args, block)``, whose result lives until the kernel ends; or
        ``read(fun, args, events)``, if `block` is None.
    block : ndarray or None
    left : array of int
        The first number is that of the solves until the next comparison.
    state : ndarray, shape (n,)
        The kernel's initial state.
    told : int or None
        The address of a count; a solve with another count than 0 returns its status.
    plain : outcome.Plain or None
        The parts of plain results; without these, each solve returns a status.
    """
    code, definition, called = _shared()
    end = NO_STATUS if plain is None else FINISHED
    nothing = array("q", [0])
    none = None, None, None, None, [nothing.buffer_info()[0]] * 4, 0
    kind, empty, copies, more, counts, stages = plain or none
    objects = list, float, None, read, block, kind, empty, copies, more, *FIELDS
    told = told or nothing.buffer_info()[0]
    places = left.buffer_info()[0], address_of(state), _address(kernel), at.value, told, *counts
    words = array("q", [*called, *map(id, objects), *places, len(state), end, stages])
    held = code, definition, words, objects, left, state, nothing  # by the builtin, in its `module`
    return NEW_BUILTIN(ctypes.addressof(definition), words.buffer_info()[0], held)
