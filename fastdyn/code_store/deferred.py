"""Numba's optimising and translating of each helper, put off until the whole is sealed."""

# pyright: reportAttributeAccessIssue=false

import functools
import threading

from numba.core import callconv, codegen, cpu, dispatcher, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import lookup_environment

from fastdyn.kernels.jit_options import jit_enabled

# Globals that the process which lowered the code fills in: an environment of Python objects, an
# address, a function that was not there yet.
ENVIRONMENT = "NumbaEnv"
PROCESS_BOUND = ("_ZN08NumbaEnv", "numba.dynamic.globals", ".numba.unresolved$")


FOR_PYTHON = "_ZN7cpython"  # begins the name of a function's entry from Python
KERNELS = "fastdyn.kernels."  # begins the name of the modules of our own functions


class deferred:
    """While it holds, what this thread lowers is linked, but neither optimised nor translated.

    Functions with an entry for Python, a user's own ``@njit`` ones, are Numba's as always: they
    may be called from Python later.
    """

    _thread = None
    addressless = False  # whether Numba makes an entry for Python that nobody will call

    def __enter__(self):
        global_compiler_lock.acquire()
        self._outer, deferred._thread = deferred._thread, threading.get_ident()
        self._enabled = jit_enabled()
        self._enabled.__enter__()

    def __exit__(self, *failure):
        self._enabled.__exit__(*failure)
        deferred._thread = self._outer
        global_compiler_lock.release()


def _instead(owner, name):
    """Replace a method of Numba's where `deferred` holds: ``f(original, self, *args)``."""

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
    """One form of our own functions for all whole numbers, not another for each constant.

    LLVM sees the constants all the same.  Numba needs them where a field of a tuple is meant.
    """
    if str(called.py_func.__module__).startswith(KERNELS):
        args, kws = _any_number(args), dict(zip(kws, _any_number(kws.values()), strict=True))
    return original(called, args, kws)


def _any_number(given):
    return tuple([types.unliteral(a) if isinstance(a, types.IntegerLiteral) else a for a in given])


@_instead(codegen.CPUCodeLibrary, "_optimize_final_module")
def optimise_library(original, library):
    """Leave the optimising of each library to `sealed`, but for functions that Python may call."""
    if not _spared(library):
        original(library)


@_instead(codegen.CPUCodeLibrary, "_finalize_final_module")
def finalise_library(original, library):
    """Leave the translating of each library to `sealed`, with the same exception."""
    if not _spared(library):
        return original(library)
    library._finalize_dynamic_globals()
    library._finalized = True


@_instead(cpu.CPUContext, "get_executable")
def _executable(original, context, library, *rest):
    """An entry for Python that has no address, of a library that has none."""
    before, deferred.addressless = deferred.addressless, _spared(library)
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
    """What Numba needs the address of at once: a loop of a ufunc (`numba.vectorize`)."""
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
    """A message made at run time needs an environment; only whether it raised is ever read."""
    convention.set_static_user_exc(builder, exc, None, loc, func_name)
