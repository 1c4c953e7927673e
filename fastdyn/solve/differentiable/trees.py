"""Arguments that are containers: their numbers side by side, and functions that get them whole.

A dict, a NamedTuple or a dataclass that holds numbers of a kind (`Free`, arrays of another library)
is taken apart into its leaves, which are arguments then; a function of the leaves gives the user's
function the container again.
"""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from fastdyn.problem.events import Event
from fastdyn.problem.schedules import Schedule


class Tree(NamedTuple):
    """A container without its leaves: its class, the names of its parts, and these parts.

    A part is a Tree, or None for a leaf.
    """

    kind: type
    keys: tuple[Any, ...]
    parts: tuple

    def built(self, leaves):
        """The container with the next of the leaves, an iterator."""
        values = [next(leaves) if p is None else p.built(leaves) for p in self.parts]
        if self.kind is list:
            return values
        if self.kind is tuple:
            return tuple(values)
        if self.kind is dict:
            return dict(zip(self.keys, values, strict=True))
        return self.kind(**dict(zip(self.keys, values, strict=True)))


def parts_of(value, rows) -> Any:
    """(class, names, parts) of a container; None for a leaf. Lists and tuples if `rows`."""
    kind: Any = type(value)
    if kind is dict:
        return kind, tuple(value), tuple(value.values())
    if isinstance(value, tuple) and hasattr(kind, "_fields"):
        return kind, kind._fields, tuple(value)
    if rows and kind in (list, tuple):
        return kind, tuple(range(len(value))), tuple(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = tuple([each.name for each in dataclasses.fields(value) if each.init])
        return kind, names, tuple([getattr(value, name) for name in names])
    return None


def taken_apart(value, holds: Callable, rows=False):
    """(Tree or None, leaves, names of the leaves) of an argument.

    Parameters
    ----------
    value
        A container is taken apart if ``holds(leaf)`` for one of its leaves; else it is a leaf.
    holds : callable
    rows : bool
        Whether lists and tuples are containers.
    """
    found = parts_of(value, rows)
    if found is None:
        return None, [value], [""]
    kind, keys, values = found
    each = [taken_apart(one, holds, rows) for one in values]
    leaves = [leaf for _, some, _ in each for leaf in some]
    if not any(holds(leaf) for leaf in leaves):
        return None, [value], [""]
    names = [
        f"{key}.{name}" if name else str(key)
        for key, (_, _, own) in zip(keys, each, strict=True)
        for name in own
    ]
    return Tree(kind, keys, tuple([tree for tree, _, _ in each])), leaves, names


class Apart(NamedTuple):
    """Arguments side by side: a Tree or None for each, the leaves of all, and their names."""

    trees: tuple
    leaves: tuple
    names: tuple

    def whole(self, leaves):
        """The arguments as the user gave them, with these leaves."""
        return whole(self.trees, leaves)

    def function(self, fun) -> Any:
        """A function of (t, y, *leaves)."""
        return fun if not any(self.trees) else of_leaves(fun, _one(self.trees))

    def event(self, event) -> Any:
        """An event as one of (t, y, *leaves), with the rules that it has now; schedules stay."""
        if not any(self.trees) or isinstance(event, Schedule):
            return event
        event = Event.of(event)
        return event.like(self.function(event.function))


def apart(args, holds, rows=False, labels=None):
    """The Apart of arguments; a leaf that is an argument has the name that `labels` give it."""
    each = [taken_apart(value, holds, rows) for value in args]
    leaves = tuple([leaf for _, some, _ in each for leaf in some])
    own = labels or [f"args[{j}]" for j in range(len(each))]
    names = tuple(
        [name or label for label, (_, _, of) in zip(own, each, strict=True) for name in of]
    )
    return Apart(tuple([tree for tree, _, _ in each]), leaves, names)


def whole(trees, leaves):
    """Arguments from their leaves."""
    rest = iter(leaves)
    return tuple([next(rest) if tree is None else tree.built(rest) for tree in trees])


@functools.lru_cache(256)
def _one(trees):
    """One object for equal trees: traces look at the identity of what a function uses."""
    return trees


def of_leaves(fun, trees):
    """``fun(t, y, *args)`` as a function of the leaves of its arguments."""

    def of_leaves(t, y, *leaves):
        return fun(t, y, *whole(trees, leaves))

    of_leaves.__name__ = of_leaves.__qualname__ = getattr(fun, "__name__", "fun")
    return of_leaves
