"""Numba without optimisation and translation of helpers: `emit_object.sealed` does both once."""

# pyright: reportAttributeAccessIssue=false

import functools
import gc
import threading
from typing import Any

import numba  # noqa: F401  # waits for an import in another thread; a submodule's does not
from numba.core import callconv, codegen, cpu, dispatcher, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import lookup_environment

from fastdyn.kernels.jit.options import jit_enabled

from .target import ENVIRONMENT

FOR_PYTHON = "_ZN7cpython"  # start of the name of a function's entry from Python
KERNELS = "fastdyn.kernels."  # start of the names of the modules of our own functions


class deferred:
    """A context in which code of this thread is linked, but neither optimised nor translated.

    No garbage is collected meanwhile, as what a compilation makes lives until its end: collections
    took a tenth of a first solve.

    Numba treats functions with an entry for Python, the user's own ``@njit`` functions, as always:
    Python may call these functions later.
    """

    _thread = None
    _types: Any = None  # types of calls that this context has resolved
    addressless = False  # True while Numba makes an entry for Python that nobody will call

    def __enter__(self):
        global_compiler_lock.acquire()
        self._outer, deferred._thread = deferred._thread, threading.get_ident()
        if self._outer is None:
            deferred._types = {}
        self._enabled = jit_enabled()
        self._enabled.__enter__()
        self._collects = gc.isenabled()
        gc.disable()

    def __exit__(self, *failure):
        if self._collects:
            gc.enable()
        self._enabled.__exit__(*failure)
        deferred._thread = self._outer
        if self._outer is None:
            deferred._types = None
        global_compiler_lock.release()


def _instead(owner, name):
    """Replace a method of Numba's within `deferred` by ``f(original, self, *args)``."""

    def decorate(function):
        original = getattr(owner, name)

        @functools.wraps(original)
        def method(self, *args, **kwargs):
            if deferred._thread != threading.get_ident():
                return original(self, *args, **kwargs)
            return function(original, self, *args, **kwargs)

        setattr(owner, name, method)
        return original

    return decorate


def _spared(library):
    return not any(
        f.name.startswith(FOR_PYTHON) and not f.is_declaration
        for f in library._final_module.functions
    )


@_instead(dispatcher._DispatcherBase, "get_call_template")
def _call(original, called, args, kws):
    """Compile our own functions once for all integers, not once for each constant.

    LLVM still sees the constants.  Numba needs a constant where it selects a field of a tuple.
    """
    if str(called.py_func.__module__).startswith(KERNELS):
        args = _any_number(args)
        kws = dict(zip(kws, _any_number(kws.values()), strict=True))
    return original(called, args, kws)


def _any_number(given):
    return tuple([types.unliteral(a) if isinstance(a, types.IntegerLiteral) else a for a in given])


@_instead(types.BaseFunction, "get_call_type")
def _type_of_call(original, function, context, args, kws):
    """Resolve a call of Numba's functions once for equal types: Numba tries templates each time.

    The templates of ``a * b`` were tried some thousand times in a first solve, a sixth of its time.
    """
    if kws:
        return original(function, context, args, kws)
    found = deferred._types.get((function, args))
    if found is None:
        found = deferred._types[function, args] = original(function, context, args, kws)
    return found


@_instead(codegen.CPUCodeLibrary, "_optimize_final_module")
def optimise_library(original, library):
    """Leave the optimisation of a library to `sealed`, except for functions with a Python entry."""
    if not _spared(library):
        original(library)


@_instead(codegen.CPUCodeLibrary, "_finalize_final_module")
def finalise_library(original, library):
    """Leave the translation of a library to `sealed`, except for functions with a Python entry."""
    if not _spared(library):
        return original(library)
    library._finalize_dynamic_globals()
    library._finalized = True


@_instead(cpu.CPUContext, "get_executable")
def _executable(original, context, library, *rest):
    """The entry for Python without an address, for a library that is not translated."""
    before = deferred.addressless
    deferred.addressless = _spared(library)
    try:
        return original(context, library, *rest)
    finally:
        deferred.addressless = before


@_instead(codegen.JITCodeLibrary, "get_pointer_to_function")
def _pointer(original, library, name):
    if deferred.addressless:
        return 0
    library._ensure_finalized()
    if _spared(library) and not library._codegen._engine.is_symbol_defined(name):
        _translate_after_all(library)
    return original(library, name)


def _translate_after_all(library):
    """Translate code whose address Numba needs at once: the loop of a ufunc (`numba.vectorize`)."""
    optimise_library(library)
    finalise_library(library)
    for value in library._final_module.global_variables:
        environment = lookup_environment(value.name)
        if ENVIRONMENT in value.name and environment is not None:
            library._codegen.set_env(value.name, environment)


@_instead(codegen.JITCPUCodegen, "set_env")
def _environment(original, code, name, environment):
    if not deferred.addressless:
        original(code, name, environment)


@_instead(callconv.CPUCallConv, "set_dynamic_user_exc")
def _raise(original, convention, builder, exc, args, types, loc=None, func_name=None):
    """Omit messages made at run time, which need an environment and are never read."""
    convention.set_static_user_exc(builder, exc, None, loc, func_name)
