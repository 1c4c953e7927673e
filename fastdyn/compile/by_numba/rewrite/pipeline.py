"""Numba's pipeline with two passes of fastdyn, and the functions that go through the passes.

Before types are inferred, values from outside become constants, functions from outside become
compiled functions, and variables that may be unassigned are checked.  After types are inferred,
arithmetic whose result would differ in Python is checked or refused.
"""

import inspect
import types as python
from typing import Any

from numba.core.compiler import Compiler as NumbaCompiler
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.ir_utils import build_definitions
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NopythonTypeInference
from numba.core.untyped_passes import InlineClosureLikes

from fastdyn.kernels.jit_options import OWNING, njit

from ... import memory
from ...callables.captured import draws_random, references, resolve, stored_outside
from ...callables.diagnostics import Uncompilable
from ...fingerprint import contains_opaque, frozen_function, of_library
from .arithmetic import Arithmetic
from .outside_values import join_tuples, replace_outside
from .unassigned_variables import check_assigned

SOURCE = "__fastdyn_source__"  # attribute of a clone: the user's function, and its `self`

_called = memory.Table()  # compiled forms of functions that a user's function calls, by content


@register_pass(mutates_CFG=False, analysis_only=False)
class Rewrite(FunctionPass):
    """The pass before types are inferred; only the clones of `dispatcher` are changed."""

    _name = "fastdyn_rewrite"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        source = getattr(state.func_id.func, SOURCE, None)
        if source is None:
            return False
        blocks = state.func_ir.blocks
        check_assigned(blocks)
        replace_outside(blocks, *source, called_function)
        join_tuples(blocks)
        state.func_ir._definitions = build_definitions(blocks)
        return True


class Compiler(CompilerBase):
    """Numba's pipeline with the passes Rewrite and Arithmetic."""

    def define_pipelines(self):
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(Rewrite, InlineClosureLikes)
        manager.add_pass_after(Arithmetic, NopythonTypeInference)
        manager.finalize()
        return [manager]


def dispatcher(function, owner, options, filled=False):
    """A dispatcher of a user's function that goes through the passes.

    Parameters
    ----------
    function : function
    owner : object
        The `self` of a method, or None.
    options : dict
        Options of Numba.
    filled : bool
        True if callers give all arguments, so that defaults are not used.

    Raises
    ------
    Uncompilable
        For a function with an effect that compiled code would lose.
    """
    if name := stored_outside(function.__code__):
        raise Uncompilable(f"it assigns to `{name}`, a variable outside itself")
    for reference in references(function, owner is not None):
        if draws_random(resolve(reference, function, owner)[0]):
            raise Uncompilable("it draws random numbers, which follow NumPy's seed in Python only")
    code, defaults = _all_positional(function, filled)
    clone = type(function)(
        code, function.__globals__, function.__name__, defaults, function.__closure__
    )
    clone.__qualname__, clone.__module__ = function.__qualname__, function.__module__
    setattr(clone, SOURCE, (function, owner))
    return njit(pipeline_class=Compiler, **{**OWNING, **options})(clone)


def _all_positional(function, filled):
    """The code of a function in which keyword-only parameters are positional, and the defaults.

    Keyword-only parameters come last, because Numba supports defaults, but no keyword-only
    parameters.
    """
    code, given = function.__code__, function.__kwdefaults__ or {}
    last = code.co_argcount + code.co_kwonlyargcount
    named = code.co_varnames[code.co_argcount : last]
    defaults = () if filled else function.__defaults__ or ()
    needed = named if defaults else named[len(named) - len(given) :]  # required names come first
    if named and (
        code.co_flags & inspect.CO_VARARGS or (not filled and not given.keys() >= {*needed})
    ):
        raise Uncompilable("it takes keyword-only arguments")
    if named:
        code = code.replace(co_argcount=last, co_kwonlyargcount=0)
        defaults = () if filled else (*defaults, *[given[name] for name in needed])
    return code, tuple([called_function(value) or value for value in defaults])


def called_function(value: Any):
    """The compiled form of a function that a user's function calls; None if it is no function.

    A jitted function is compiled again: its machine code may contain old values of its globals, or
    come from Numba's cache, where the names of functions are not unique.
    """
    owner, options, signatures = None, {"boundscheck": True}, ()
    if type(value) is CPUDispatcher and value._compiler.pipeline_class is NumbaCompiler:  # pyright: ignore
        if of_library(value.py_func):
            return value
        options = {"error_model": "python", **value.targetoptions}
        options.pop("nopython", None)
        if not value._can_compile:  # pyright: ignore
            signatures = value.nopython_signatures
        value = value.py_func
    elif isinstance(value, Dispatcher):
        return value
    if isinstance(value, python.MethodType) and not isinstance(value.__self__, type):
        value, owner = value.__func__, value.__self__
    if not isinstance(value, python.FunctionType) or of_library(value):
        return None
    content = frozen_function(value, owner=owner), repr(sorted(options.items())), signatures
    if found := _called.get(content):
        return found
    compiled = dispatcher(value, owner, options)
    for signature in signatures:
        compiled.compile(signature)
        compiled.disable_compile()
    if owner is not None:
        inner = compiled
        compiled = njit(**OWNING)(lambda *given: inner(None, *given))
    if not contains_opaque(content):
        _called.put(content, compiled)
    return compiled
