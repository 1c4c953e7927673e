"""The named objects of a model: coordinates, numbers, reactions, functions of drivers."""

import keyword
from collections.abc import Callable
from typing import Any, NamedTuple

import sympy as sp

from fastdyn.systems.base import System
from fastdyn.systems.base.dimensions import dimension_of, near_unit
from fastdyn.systems.base.units import other_unit_of
from fastdyn.words.kinds import text

from .checks.inputs import UNSAID, default_of, refuse_degrees, refuse_unknown_unit
from .code import RESERVED
from .notation import of_time


class Coordinate(NamedTuple):
    """A coordinate: function of time, name, name of its rate, unit, whether the unit was given."""

    function: Any
    name: str
    rate: str
    unit: str
    said: bool


class Number(NamedTuple):
    """A parameter, or a number that sets the start (`initial`)."""

    symbol: sp.Symbol
    default: float
    unit: str
    meaning: str
    positive: bool
    initial: bool


class Reaction(NamedTuple):
    """A reaction of unknown size, and whether its unit was given."""

    function: Any
    name: str
    unit: str
    said: bool = False


class Input(NamedTuple):
    """A function of time from a driver, its name, and the names of its rates."""

    function: Any
    symbols: tuple[str, ...]


class Driver(NamedTuple):
    """A function of (t, w) that the user may replace, and the names of its results."""

    name: str
    default: Callable
    gives: tuple[str, ...]


class Constraint(NamedTuple):
    """An expression of positions or velocities that stays zero; the body that rolls, if any."""

    expression: Any
    name: str
    unit: str
    rolling: Any = None


class Drawn(NamedTuple):
    """A drawing between points: "spring", "damper", "line", "edge" or "surface".

    A point is (body, place), the body None for the ground; `across` is the normal of an edge or of
    a surface.
    """

    kind: str
    points: tuple
    across: Any = None


class UserDeclaration(NamedTuple):
    """A quantity, invariant or event that the user adds."""

    kind: str
    name: str
    expression: Any
    unit: str
    label: str
    event: dict


class Declarations:
    """The declared objects of a model, by unique names."""

    def __init__(self, name):
        self._taken: set[str] = {"t", "_", "energy", "derivation", *RESERVED, *dir(System)}
        self.name = _identifier(name)
        self.coordinate_list: list[Coordinate] = []
        self.numbers: list[Number] = []
        self.reaction_list: list[Reaction] = []
        self.inputs: list[Input] = []
        self.drivers: list[Driver] = []

    def coordinates(self, names, units="", rates=None) -> Any:
        """
        Declare coordinates, functions of time.

        Parameters
        ----------
        names : str
            Names, separated by spaces.
        units : str
            One unit for all names, or one unit for each name; by default m.
        rates : str, optional
            Names of the rates in the state; by default "v" and the name of the coordinate.

        Returns
        -------
        One function, or a list of functions.
        """
        text("names", names)
        words = names.split()
        for unit in units.split() if isinstance(units, str) else units:
            if unit not in UNSAID and dimension_of(unit) is None and not other_unit_of(unit):
                near = f"did you mean {near_unit(unit)!r}?" if near_unit(unit) else ""
                said = near or (
                    "if it is a coordinate, several names are one text: "
                    f"coordinates('{names} {unit}')."
                )
                raise ValueError(f"{unit!r} is no unit that fastdyn knows; {said}")
        speeds = rates.split() if rates else [f"v{word}" for word in words]
        said = bool(units)
        units = _each(units or "m", words)
        for name, unit, speed in zip(words, units, _each(speeds, words), strict=True):
            refuse_degrees(name, unit)
            self.declare(name, speed, f"{name}_dd", f"d_{name}", f"d_{speed}")
            function = of_time(name)
            self.coordinate_list.append(Coordinate(function, name, speed, unit, said))
        return _one_or_all([one.function for one in self.coordinate_list[-len(words) :]])

    def parameters(self, *, positive=True, **given) -> Any:
        """
        Declare numbers of the equations.

        Parameters
        ----------
        positive : bool
            Whether the numbers are greater than zero, which shortens formulas and is checked.
        **given : tuple
            name=(default, unit) or (default, unit, meaning); for an angle also
            name=("45 deg", "rad").

        Returns
        -------
        One symbol, or a list of symbols.
        """
        return self._numbers(given, positive, False)

    def initial(self, *, positive=False, **given) -> Any:
        """Declare numbers that only set the start, with the arguments of `parameters`."""
        return self._numbers(given, positive, True)

    def reactions(self, names, units="") -> Any:
        """Declare reactions of unknown size, in N by default; arguments as of `coordinates`."""
        words = names.split()
        for name, unit in zip(words, _each(units or "N", words), strict=True):
            refuse_unknown_unit(name, unit)
            self.declare(name)
            self.reaction_list.append(Reaction(of_time(name), name, unit, bool(units)))
        return _one_or_all([one.function for one in self.reaction_list[-len(words) :]])

    def driver(self, gives, default, name="driver") -> Any:
        """
        Declare functions of time that a function ``driver(t, w)``, a parameter, returns.

        Parameters
        ----------
        gives : str
            The names of the results, in order; a name with ' is the rate of a result.
        default : callable
            A plain Python function of numbers.
        name : str
            Name of the parameter.

        Returns
        -------
        One function of time, or a list of functions; `rate` gives their rates.
        """
        self.declare(name)
        words = [(word.rstrip("'"), word.count("'")) for word in gives.split()]
        orders: dict[str, int] = {}
        for word, order in words:
            if order != orders.get(word, -1) + 1:
                raise ValueError(f"{gives!r} must name a function, then its rates in order.")
            orders[word] = order
        for word, highest in orders.items():
            symbols = tuple(_rate_name(word, n) for n in range(highest + 1))
            self.declare(*symbols)
            self.inputs.append(Input(of_time(word), symbols))
        self.drivers.append(Driver(name, default, tuple(_rate_name(*word) for word in words)))
        return _one_or_all([one.function for one in self.inputs[-len(orders) :]])

    def declare(self, *names):
        """Reserve names; raises ValueError for a name that is declared already."""
        for name in map(_identifier, names):
            if name in self._taken:
                raise ValueError(
                    f"The name `{name}` of {self.name} is taken: by another of its declarations, "
                    "or by something that every system has."
                )
            self._taken.add(name)

    def free_name(self, stem):
        """A free name: the stem and a number."""
        return next(s for n in range(1, 1000) if (s := f"{stem}{n}") not in self._taken)

    def _numbers(self, given, positive, initial):
        for name, about in given.items():
            known = isinstance(about, tuple) and len(about) in (2, 3)
            default, unit, meaning = (*about, "")[:3] if known else (None, "", "")
            if known:
                refuse_unknown_unit(name, unit)
            default = default_of(name, default, unit)
            if default is None:
                raise TypeError(
                    f"`{name}` is declared by (default, unit) or (default, unit, meaning), as in "
                    f"{name}=(1.0, 'kg'); got {about!r}."
                )
            if positive and default <= 0:
                raise ValueError(
                    f"The default of `{name}` is {default:g}, but it is declared greater than "
                    "zero: say positive=False."
                )
            self.declare(name)
            assumption = {"positive": True} if positive else {"real": True}
            symbol = sp.Symbol(name, **assumption)
            number = Number(symbol, default, unit, meaning or name, positive, initial)
            self.numbers.append(number)
        return _one_or_all([one.symbol for one in self.numbers[-len(given) :]])


def _rate_name(word, order):
    return word if not order else f"{word}_{'d' * order}"


def _identifier(name):
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name):
        raise ValueError(f"{name!r} is no name that Python takes for a variable.")
    return name


def _each(words, names):
    """One word for all names, or as many words as there are names."""
    words = words.split() if isinstance(words, str) else words
    words = list(words) * len(names) if len(words) == 1 else list(words)
    if len(words) != len(names):
        raise ValueError(f"{len(names)} names ({' '.join(names)}) have {len(words)} of {words}.")
    return words


def _one_or_all(items):
    return items[0] if len(items) == 1 else items
