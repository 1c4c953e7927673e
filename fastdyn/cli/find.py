"""The systems that a command line may name: from the course, derived, and from files."""

import inspect
import runpy
from pathlib import Path

from fastdyn.explore.page_names import PAGES
from fastdyn.words.near import did_you_mean

from . import checks


def systems(arguments):
    """Systems by name: the course's, and another one that the words of a command name."""
    from fastdyn.systems import SYSTEMS

    if len(arguments) < 2 or arguments[0] not in ("run", "drift", "sweep"):
        return SYSTEMS
    word = arguments[1]
    if word.endswith(".py") or ".py:" in word:
        return SYSTEMS | {word: in_file(word)}
    if word in PAGES and word not in SYSTEMS:
        return SYSTEMS | {word: derived(word)}
    return SYSTEMS


def any_system(word):
    """The system that a word names: of the course, derived, of a file; None for FILE:FUNCTION.

    Raises ValueError for a name that is not known.
    """
    from fastdyn.explore import sources

    if ".py" not in word:
        return sources.named(word).make
    path, _, name = word.partition(".py:")
    if name and callable(made := runpy.run_path(f"{path}.py").get(name)):
        if not inspect.isclass(made) and not hasattr(made, "derive"):
            return None
    return in_file(word)


def in_file(word):
    """
    The one system that a Python file makes: a `System`, or a `Model`.

    Parameters
    ----------
    word : str
        The path, ``file.py``; or ``file.py:name`` for one of several.
    """
    from fastdyn.systems import System

    path, _, name = word.partition(".py:")
    path = path if not name else f"{path}.py"
    if not Path(path).is_file():
        raise ValueError(checks.no_file(path))
    made = runpy.run_path(path)
    if name and name not in made:
        raise ValueError(f"{path} has no `{name}`; {did_you_mean(name, made)}".rstrip("; "))
    made = [made[name]] if name else list(made.values())
    classes = [one for one in made if inspect.isclass(one) and issubclass(one, System)]
    found = {one.name: one for one in classes if hasattr(one, "rhs")}
    for one in made:
        if hasattr(one, "derive") and hasattr(one, "bodies") and one.name not in found:
            found[one.name] = one.derive().system
    if len(found) != 1:
        names = ", ".join(found) or "none"
        raise ValueError(f"{word} must make one system or model; it makes {names}.")
    return found.popitem()[1]


def derived(name):
    """The system of a page of `fastdyn.derive.pages`."""
    try:
        from fastdyn.derive.pages import page
    except ImportError as error:
        raise ValueError(str(error)) from None
    return page(name).derive().system
