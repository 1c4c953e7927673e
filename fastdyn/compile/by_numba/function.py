"""The compiled form of a function that cannot be traced: from memory, from disk, or from Numba.

Numba compiles the function as it is.  The arguments are parameters of the compiled form.  All other
values that the function uses are constants of the code, and the key of the code names their
content: if the content changes, the function is compiled again.
"""

import functools

from fastdyn import code_store

from .. import budget, memory
from ..callables import T, Uncompilable, Y, codes_of
from ..fingerprint import frozen_function, kernels_in
from ..functions import Function
from ..parameters import n_words, parameter_type
from ..sentences import explain

MOST_TRIES, FAILURE = 8, 4  # most compilations of a code object; a failure counts as FAILURE
CHANGES = "what it uses from outside changes from solve to solve: pass the values as `args`"
OF_OBJECT = (
    "Numba compiles functions, and no methods of objects: pass the object's numbers as `args`"
)
SIZE = 10  # size of a function in `memory`, with the data that Numba keeps

_functions = memory.Table()  # the Function, or why there is none
_tries = memory.Table()  # (number of compilations of a code object, reason to compile no more)


def compiled_function(parts, mode, probe=None):
    """Compile a function for the types of its arguments and the values that it uses.

    Parameters
    ----------
    parts : callables.Parts
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
    if parts.owner is not None:
        raise Uncompilable(OF_OBJECT)
    layout = tuple(
        ["t" if v is T else "y" if v is Y else parameter_type(v) for v in parts.positional]
    )
    token = frozen_function(parts.function)
    used = code_store.FUNCTIONS.around(*sorted(kernels_in((layout, token))))
    options = tuple(parts.options.items())
    key = mode, layout, token, parts.jitted, options, code_store.sources(used)
    found = _functions.get(key)
    if found is None:
        try:
            found = _functions.put(key, _limited(parts, mode, layout, key, probe), SIZE)
        except Uncompilable as reason:
            found = _functions.put(key, str(reason))
    if isinstance(found, str):
        raise Uncompilable(found)
    given = zip(layout, parts.positional, strict=True)
    return found, [pair for pair in given if not isinstance(pair[0], str)]


def _limited(parts, mode, layout, key, probe):
    """The Function; Uncompilable if its code was compiled too often."""
    functions = [v for v in parts.positional if hasattr(v, "__code__")]
    place = *[code for each in (parts.function, *functions) for code in codes_of(each)], mode
    tries, reason = _tries.get(place) or (0, "")
    if tries >= MOST_TRIES:
        raise Uncompilable(reason)
    if probe is not None:
        probe()
    try:
        function = _made(parts, mode, layout, key)
    except Uncompilable as reason:
        _tries.put(place, (tries + FAILURE, str(reason)))
        raise
    _tries.put(place, (tries + 1, CHANGES))
    return function


def _made(parts, mode, layout, key):
    """The Function, from disk or from Numba."""

    @functools.cache
    def build():
        from .pointer_form import pointer_form

        made = pointer_form(parts, mode, layout)
        if frozen_function(parts.function) != key[2]:  # another thread has changed a value
            raise Uncompilable("what it uses from outside changed while it was compiled")
        return made

    code = code_store.stored(repr(key))
    if not code:
        budget.not_here()
        from .pointer_form import signature

        try:
            code = code_store.compiled(repr(key), lambda: (build(), signature()))
        except Exception as error:
            raise Uncompilable(explain(error)) from error
    size = sum([n_words(kind) for kind in layout if not isinstance(kind, str)])
    return Function(repr(key), code.address, size, build, code, mode)
