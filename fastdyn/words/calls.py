"""Calls that do not fit a signature: Python's TypeError, with a note that shows how to call."""

import functools
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from fastdyn.words.near import did_you_mean

PLACED = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
Public = TypeVar("Public", bound=Callable)


def shown_when_wrong(advice="", **kinds) -> Callable[[Public], Public]:
    """Make a decorator of public functions: a call with wrong arguments shows the right form.

    `advice` is a sentence on the form that newcomers take it for.  `kinds` are the kinds of
    arguments, by name: a value of another kind is refused, but for a default of None.
    """

    def decorate(function) -> Any:
        known = inspect.signature(function).parameters.values()
        places = [one.name for one in known if one.kind is not one.KEYWORD_ONLY]
        optional = {one.name for one in known if one.default is None}

        @functools.wraps(function)
        def called(*args, **named):
            if kinds:
                check(args, named)
            try:
                return function(*args, **named)
            except TypeError as error:
                if error.__traceback__ is not None and error.__traceback__.tb_next is None:
                    error.add_note(_form(function, named, advice))  # the call itself failed
                raise

        def check(args, named):
            for name, value in (*zip(places, args, strict=False), *named.items()):
                if name in kinds and not (value is None and name in optional):
                    kinds[name](name, value)

        return called

    return decorate


def takes(name, function, form, advice=""):
    """Raise TypeError unless a function may be called with the arguments of ``form``."""
    try:
        inspect.signature(function).bind(*form.split(", "))
    except ValueError:  # it tells no signature
        return
    except TypeError as error:
        said = f"`{name}` is called as {name}({form}): {error}. {advice}"
        raise TypeError(said.rstrip()) from None


def _form(function, named, advice):
    """How a function is called, and what may be meant by names that it does not take."""
    known = inspect.signature(function).parameters
    words = [name for name, one in known.items() if one.kind in PLACED]
    owner, _, name = function.__qualname__.rpartition(".")
    if words[:1] in (["self"], ["cls"]):
        words = words[1:]
    name = owner if name == "__init__" else name
    form = f"The call is {name}({', '.join(words)})"
    by_name = [name for name, one in known.items() if one.kind is one.KEYWORD_ONLY]
    if by_name:
        form = f"{form[:-1]}, *, {', '.join(by_name[:3])}, ...)"
    open_ended = any(one.kind is one.VAR_KEYWORD for one in known.values())
    lacking = [n for n, one in known.items() if one.default is one.empty and n not in named]
    near = lacking if open_ended else known
    meant = [(name, did_you_mean(name, near)) for name in named if name not in known]
    meant = [f"`{name}`: {said}" for name, said in meant if said]
    return " ".join([f"{form}.", *meant, *filter(None, [advice])])
