"""
The systems of the course: ``fastdyn.systems.satellite(GM=1, R=1, V=1).solve().plot()``.

Every file of this folder that defines a `System` is found here and its class is offered under
the system's name, so a new system is a new file and nothing else.
"""

import importlib
import inspect
import pkgutil

from fastdyn.words.near import did_you_mean

from .base import (
    State,
    System,
    constraint,
    derived,
    event,
    initial,
    invariant,
    parameter,
    quantity,
)

__all__ = [
    "SYSTEMS", "State", "System", "constraint", "derived", "event", "initial", "invariant",
    "parameter", "quantity",
]  # fmt: skip


def _discovered() -> dict[str, type[System]]:
    found = {}
    for entry in pkgutil.iter_modules(__path__):
        if entry.ispkg:
            continue
        module = importlib.import_module(f"{__name__}.{entry.name}")
        for member in vars(module).values():
            if inspect.isclass(member) and issubclass(member, System) and member is not System:
                found[member.name] = _complete(member, entry.name)
    return dict(sorted(found.items(), key=lambda item: (item[1].source, item[0])))


def _complete(system, file):
    """The class of a system, if it declares what every command asks for."""
    asked = ("title", "source", "states", "t_end", "rhs")
    if lacking := [name for name in asked if not hasattr(system, name)]:
        raise TypeError(
            f"{system.__name__} of fastdyn/systems/{file}.py declares no {', no '.join(lacking)}."
        )
    return system


SYSTEMS = _discovered()
globals().update(SYSTEMS)


def __getattr__(name: str) -> type[System]:
    said = "" if name.startswith("_") else did_you_mean(name, SYSTEMS)
    raise AttributeError(
        f"module {__name__!r} has no attribute {name!r}{f'; {said}' if said else ''}"
    )
