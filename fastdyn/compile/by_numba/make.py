"""The compiled form of a function that cannot be traced: from memory, from disk, or from Numba.

The arguments of the function are parameters of the compiled form.  All other values that the
function uses are constants of the code, and the key of the code names their content: if the content
changes, the function is compiled again.
"""

import functools
import types as python

from numba import types
from numba.core.registry import cpu_target

from fastdyn import code_store
from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit_options import OWNING_INLINED

from .. import budget, memory
from ..callables.compiled import Function
from ..callables.diagnostics import Uncompilable, explain
from ..callables.parts import T, Y, codes_of
from ..fingerprint import calls_itself, contains_opaque, frozen_function
from ..function_convention import form
from ..parameters import Constant, is_function, n_words, parameter_type
from .arguments import arguments
from .pointer_form import pointer_form
from .rewrite.pipeline import called_function, dispatcher

# An index out of bounds is an exception, as in Python.
CHECKED = {"boundscheck": True, **OWNING_INLINED}
MOST_TRIES, FAILURE = 8, 4  # most compilations of a code object; a failure counts as FAILURE
CHANGES = "what it uses from outside changes from solve to solve: pass the values as `args`"
SIZE = 10  # size of a function in `memory`, with the data that Numba keeps

_functions = memory.Table()  # (the Function, or why there is none; the code to keep alive)
_tries = memory.Table()  # (number of compilations of a code object, reason to compile no more)


def compiled_function(parts, mode, probe=None):
    """Compile a function for the types of its arguments and the values that it uses.

    Parameters
    ----------
    parts : callables.parts.Parts
    mode : mode.Mode
        A mode whose `by_numba` is true.
    probe : callable, optional
        Called before Numba compiles the function, to find mistakes of the user in Python.

    Returns
    -------
    Function
    list of (type, value)
        The parameters, in order.

    Raises
    ------
    Uncompilable
        If the function must run in Python.
    """
    try:
        layout = tuple([_place(value) for value in parts.positional])
    except Exception as error:
        raise Uncompilable(explain(error)) from error
    code, content = parts.function.__code__, _content(parts)
    key = id(code), mode, layout, content, tuple(parts.options.items())
    found = _functions.get(key)
    if found is None:
        try:
            made, size = _limited(parts, mode, layout, content, probe), SIZE
        except Uncompilable as reason:
            made, size = str(reason), 1
        found = _functions.put(key, (made, code), size)
    if isinstance(found[0], str):
        raise Uncompilable(found[0])
    given = zip(layout, parts.positional, strict=True)
    return found[0], [pair for pair in given if not isinstance(pair[0], str)]


def _place(value):
    """The type of a positional argument; "t" and "y" for the solver's time and state."""
    return "t" if value is T else "y" if value is Y else parameter_type(value)


def _content(parts):
    """A token of a function, and of the content of each value that the function uses."""
    return frozen_function(parts.function, owner=parts.owner)


def _limited(parts, mode, layout, content, probe):
    """The Function; Uncompilable if its code was compiled too often."""
    given = [v.__code__ for v in parts.positional if isinstance(v, python.FunctionType)]
    place = *codes_of(parts.function), *given, mode
    tries, reason = _tries.get(place) or (0, "")
    if tries >= MOST_TRIES:
        raise Uncompilable(reason)
    if probe is not None:
        probe()
    try:
        function = _made(parts, mode, layout, content)
    except Uncompilable as reason:
        _tries.put(place, (tries + FAILURE, str(reason)))
        raise
    _tries.put(place, (tries + 1, CHANGES))
    return function


def _made(parts, mode, layout, content):
    """The Function, from disk or from Numba."""
    if calls_itself(content) or calls_itself(layout):
        raise Uncompilable("it calls itself, and compiled code would not stop at any depth")
    of_process = contains_opaque((layout, content))  # no other process can identify the values
    key = None if of_process else repr((mode, layout, content, parts.options))
    build = functools.cache(functools.partial(_pointer_form, parts, mode, layout, content))
    code = key and code_store.stored(key)
    if not code:
        budget.not_here()
        try:
            code = code_store.compiled(key, lambda: (build(), types.none(*FORM)))
        except Exception as error:
            raise Uncompilable(explain(error)) from error
    size = sum([n_words(kind) for kind in layout if not isinstance(kind, str)])
    return Function(key, code.address, size, build, code, mode)


def _pointer_form(parts, mode, layout, content):
    """The dispatcher of ``function(t, y, n, block, out)``."""
    _check_convention()
    ready = [
        Constant(kind.token, called_function(kind.value))
        if isinstance(kind, Constant) and is_function(kind.value)
        else kind
        for kind in layout
    ]
    inner = dispatcher(parts.function, parts.owner, {**parts.options, **CHECKED}, filled=True)
    made = pointer_form(inner, arguments(ready), mode)
    if _content(parts) != content:  # another thread has changed a value
        raise Uncompilable("what it uses from outside changed while it was compiled")
    return made


@functools.cache
def _check_convention():
    """Refuse a version of Numba that calls functions in another way than kept kernels do."""
    convention = cpu_target.target_context.call_conv  # pyright: ignore[reportAttributeAccessIssue]
    numbas = _kinds(convention.get_function_type(types.none, FORM))
    if numbas != _kinds(form()):
        raise Uncompilable(f"this version of Numba calls functions by {numbas}, which is new")


def _kinds(form):
    """The types of the result and the arguments; all pointers count as one type."""
    return ["ptr" if t.is_pointer else str(t) for t in (form.return_type, *form.args)]
