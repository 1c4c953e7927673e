"""Kernels on vectors with functions of the user inside, found by their keys.  Needs no Numba."""

import functools
import itertools

from fastdyn import code_store
from fastdyn.compile import memory
from fastdyn.compile.sentences import Uncompilable, explain

MAX_VECTORS = 24  # more components leave the registers
_kernels = memory.Table()


def check_length(n):
    """Raise Uncompilable if a state of n components is too long for vectors."""
    if n > MAX_VECTORS:
        raise Uncompilable(f"{n} components are more than {MAX_VECTORS}")


def texts_of(symbols, forms):
    """The texts of VectorForms by symbol, and the words of the block behind which each one's begin.

    No kernel depends on the number of these words, which the texts contain.
    """
    begins = [0, *itertools.accumulate([form.n_words for form in forms])]
    pairs = zip(symbols, forms, begins[:-1], strict=True)
    return {name: functools.partial(form.text, skip=begin) for name, form, begin in pairs}, begins


def linked(key, place, texts, build, *modules):
    """The code of a kernel with functions inside: from memory, from disk, or linked by LLVM.

    Parameters
    ----------
    key, place : str
        What the code depends on, with the functions and without.
    texts : dict
        The functions, by their symbols, as `code_store.linked` takes them.
    build : callable
        Returns the kernel that waits for the functions, and its signature.
    modules : str
        The modules that make the kernel, see `code_store.key.sources.MadeBy`.

    Raises
    ------
    Uncompilable
        With the reason.
    """
    found = _kernels.get(key)
    if found is None:
        made_by = code_store.FUNCTIONS.around(*modules)
        try:
            found = code_store.stored(key, made_by)
            if found is None:
                of_kernel = code_store.KERNELS.around(*modules)
                kernel = code_store.without_function(place, build, of_kernel)
                found = code_store.linked(key, kernel, texts, lambda: None, made_by)
        except Exception as error:
            raise Uncompilable(explain(error)) from error
        _kernels.put(key, found)
    return found
