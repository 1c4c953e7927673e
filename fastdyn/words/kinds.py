"""Kinds of values: functions of a name and a value, which raise a sentence for another kind.

A kind says what can be said before the state is known: numbers and no text, a function, a flag.
Lengths and ranges are checked with what they depend on.
"""

import numbers as abstract
import os

import numpy as np

LONGEST = 60  # characters of a value in a sentence


def shown(value):
    """A value in a sentence: short, and a text as one."""
    if isinstance(value, str):
        return f"the text {value!r}"
    if isinstance(value, np.ndarray) and value.ndim:
        return f"an array of shape {value.shape} and dtype {value.dtype}"
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def noted(error, note):
    """An exception of SciPy's, with a note that says what its message leaves open."""
    error.add_note(note)
    return error


def refuse(name, what, value):
    """Raise the TypeError of a value of another kind."""
    raise TypeError(f"`{name}` must be {what}; got {shown(value)}.")


def number(name, value):
    """One real number."""
    if value.__class__ is float or value.__class__ is int:
        return
    if (
        isinstance(value, bool | np.bool_ | list | tuple)
        or not are_real(value)
        or np.size(value) != 1
    ):
        refuse(name, "a number", value)


def numbers(name, value):
    """Real numbers: one, or one for each component."""
    if value.__class__ is float:
        return
    if isinstance(value, bool | np.bool_) or not are_real(value):
        refuse(name, "a number, or a number for each component", value)


def times(name, value):
    """A sequence of times."""
    if not are_real(value):
        refuse(name, "a sequence of times", value)


def whole(name, value):
    """A whole number, or one in the form of a float."""
    number(name, value)
    if value != value or (abs(value) != float("inf") and value != int(value)):
        refuse(name, "a whole number", value)


def flag(name, value):
    """True or False."""
    if not isinstance(value, bool | np.bool_ | int | None):
        refuse(name, "True or False", value)


def function(name, value):
    """A function of the time and the state."""
    if not callable(value):
        refuse(name, "a function of (t, y)", value)


def function_of(form):
    """The kind of functions that are called as `form` says."""

    def kind(name, value):
        if not callable(value):
            refuse(name, f"a function of {form}", value)

    return kind


def text(name, value):
    """A text."""
    if not isinstance(value, str):
        refuse(name, "a text", value)


def method(name, value):
    """The name of a method, or a class of SciPy's solvers."""
    if not isinstance(value, str | type):
        refuse(name, "the name of a method", value)


def several(name, value):
    """A list, a tuple or an array, or another collection."""
    if isinstance(value, str | bytes) or not np.iterable(value):
        refuse(name, "a list", value)


def result(name, value):
    """The result of a solve."""
    if not (hasattr(value, "t") and hasattr(value, "y")):
        refuse(name, "the result of a solve", value)


def results(name, value):
    """The result of a solve, or several by label."""
    labelled = isinstance(value, dict) and "y" not in value
    for one in value.values() if labelled else [value]:
        if not (hasattr(one, "t") and hasattr(one, "y")):
            refuse(name, "the result of a solve, or a dict of results by label", one)


def system(name, value):
    """A system, as of `fastdyn.systems` or a derivation."""
    if not (hasattr(value, "rhs") and hasattr(value, "states")):
        refuse(name, "a system", value)


def figure(name, value):
    """A figure of matplotlib."""
    if not hasattr(value, "savefig"):
        refuse(name, "a figure", value)


def path(name, value):
    """The name of a file or folder."""
    if not isinstance(value, str | os.PathLike):
        refuse(name, "the path of a file", value)


def executor(name, value):
    """An executor of functions in other processes: a client of Dask, or one of Python's."""
    if not (hasattr(value, "submit") or hasattr(value, "get_executor")):
        refuse(name, "a dask.distributed.Client or a concurrent.futures.Executor", value)


def store(name, value):
    """A folder, or a store of Zarr's."""
    if not (isinstance(value, str | os.PathLike | dict) or hasattr(value, "supports_writes")):
        refuse(name, "the path of a folder, or a store of Zarr's", value)


def array(name, value):
    """Numbers, real or complex, in any shape."""
    if not (are_real(value) or are_real(np.real(value))):
        refuse(name, "numbers", value)


def matrix(name, value):
    """A matrix of numbers, perhaps sparse."""
    if not (hasattr(value, "tocsc") or are_real(value)):
        refuse(name, "a matrix of numbers", value)


def matrix_or_function(name, value):
    """A matrix of numbers, perhaps sparse, or a function that returns one."""
    if not (callable(value) or hasattr(value, "tocsc") or are_real(value)):
        refuse(name, "a matrix of numbers, or a function of (t, y)", value)


def jacobian(name, value):
    """As `matrix_or_function`, or a word, which `jacobian.options_of` knows."""
    if not isinstance(value, str):
        matrix_or_function(name, value)


def seed(name, value):
    """What makes a generator of random numbers, as `numpy.random.default_rng` takes it."""
    try:
        np.random.default_rng(value)
    except (TypeError, ValueError):
        refuse(name, "a seed, a SeedSequence or a Generator", value)


def are_real(value):
    """Whether a value is a real number, or an array of them in any form."""
    if isinstance(value, abstract.Real):
        return True
    if isinstance(value, dict | set | frozenset | str | bytes):
        return False
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        return False
    if array.dtype.kind == "O":  # numbers of other libraries
        try:
            return None not in array.ravel() and array.astype(float) is not None
        except (TypeError, ValueError):
            return False
    return array.dtype.kind in "fiub"
