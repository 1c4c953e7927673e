"""Calls that do not fit a signature: Python's TypeError, with a note that shows how to call."""

import functools
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from .near import did_you_mean

Public = TypeVar("Public", bound=Callable)


def shown_when_wrong(advice="") -> Callable[[Public], Public]:
    """Make a decorator of public functions: a call with wrong arguments shows the right form.

    `advice` is a sentence on the form that newcomers take it for.
    """

    def decorate(function) -> Any:
        @functools.wraps(function)
        def called(*args, **named):
            try:
                return function(*args, **named)
            except TypeError as error:
                if error.__traceback__ is not None and error.__traceback__.tb_next is None:
                    error.add_note(_form(function, named, advice))  # the call itself failed
                raise

        return called

    return decorate


def _form(function, named, advice):
    """How a function is called, and what may be meant by names that it does not take."""
    known = inspect.signature(function).parameters
    words = [name for name, one in known.items() if one.kind is not one.KEYWORD_ONLY]
    form = f"The call is {function.__name__}({', '.join(words)})"
    by_name = [name for name, one in known.items() if one.kind is one.KEYWORD_ONLY]
    if by_name:
        form = f"{form[:-1]}, *, {', '.join(by_name[:3])}, ...)"
    meant = [did_you_mean(name, known) for name in named if name not in known]
    return " ".join([f"{form}.", *filter(None, meant), *filter(None, [advice])])
