"""Distinguishes values of a user's class from values of libraries."""

import collections
import enum
import types

from ..numpy.stand_ins import IMPURE, PURE, root_of

OF_NAMED_TUPLES = frozenset(vars(collections.namedtuple("Any", "a"))) - {"a", "__doc__"}


def has_functions(cls):
    """Whether a user's class defines functions, apart from the functions of every named tuple."""
    return root_of(cls) not in PURE and any(
        isinstance(v, types.FunctionType | property | classmethod | staticmethod)
        and not (issubclass(cls, tuple) and name in OF_NAMED_TUPLES)
        for name, v in vars(cls).items()
    )


def members_of(outside, cls, row):
    """The own (name, member) pairs of a class; later calls check the number of own members."""
    outside.reads.expect(row, "size", len(vars(cls)))
    of_tuple = OF_NAMED_TUPLES.union(getattr(cls, "_fields", ())) if issubclass(cls, tuple) else ()
    return [(name, value) for name, value in vars(cls).items() if name not in of_tuple]


def is_instance(value, kind):
    made_in_python = kind.__flags__ & (1 << 9)
    if isinstance(value, types.SimpleNamespace):
        return True
    simple = not isinstance(value, type | types.ModuleType | list | dict | set | str | enum.Enum)
    return bool(made_in_python and simple and root_of(kind) not in PURE | IMPURE)
