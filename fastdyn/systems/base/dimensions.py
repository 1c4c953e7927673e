"""Converts units between texts and powers of kg, m, s and others."""

import re
from fractions import Fraction
from typing import Any, NamedTuple

from fastdyn.words.near import near_names

BASE = ("kg", "m", "s", "A", "K", "mol")
NAMES = {  # factor to SI, then powers of the base
    "1": (1.0,), "rad": (1.0,), "rev": (1.0,), "kg": (1.0, 1), "m": (1.0, 0, 1),
    "s": (1.0, 0, 0, 1), "A": (1.0, 0, 0, 0, 1), "K": (1.0, 0, 0, 0, 0, 1),
    "mol": (1.0, 0, 0, 0, 0, 0, 1), "N": (1.0, 1, 1, -2), "J": (1.0, 1, 2, -2),
    "W": (1.0, 1, 2, -3), "Pa": (1.0, 1, -1, -2), "Hz": (1.0, 0, 0, -1), "C": (1.0, 0, 0, 1, 1),
    "V": (1.0, 1, 2, -3, -1), "g": (1e-3, 1), "t": (1e3, 1), "mm": (1e-3, 0, 1),
    "cm": (1e-2, 0, 1), "km": (1e3, 0, 1), "ms": (1e-3, 0, 0, 1), "min": (60.0, 0, 0, 1),
    "h": (3600.0, 0, 0, 1), "kN": (1e3, 1, 1, -2), "kJ": (1e3, 1, 2, -2), "kW": (1e3, 1, 2, -3),
    "MPa": (1e6, 1, -1, -2), "bar": (1e5, 1, -1, -2),
}  # fmt: skip
PREFIXES = {
    "G": 1e9, "M": 1e6, "k": 1e3, "d": 1e-1, "c": 1e-2, "m": 1e-3, "µ": 1e-6, "μ": 1e-6, "u": 1e-6,
    "n": 1e-9,
}  # fmt: skip
PREFIXED = {"m", "s", "g", "N", "J", "W", "Pa", "Hz", "A", "V", "C", "K", "mol", "bar"}
OTHER_UNITS = {
    "sec": "s", "second": "s", "seconds": "s", "meter": "m", "metre": "m", "meters": "m",
    "metres": "m", "kilogram": "kg", "kilograms": "kg", "kgs": "kg", "kilo": "kg", "gram": "g",
    "newton": "N", "joule": "J", "watt": "W", "pascal": "Pa", "hertz": "Hz", "minute": "min",
    "minutes": "min", "hour": "h", "hours": "h", "hr": "h", "degree": "deg", "degrees": "deg",
    "radian": "rad", "radians": "rad",
}  # fmt: skip
CLOSE = 0.7  # likeness of a unit that may be meant: kgg and kg, not ft and t
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
WORD = re.compile(r"([A-Za-zµμ]+|1)(?:\^|\*\*)?(-?\d+)?")


class Dimension(NamedTuple):
    """Powers of `BASE`, and the size of the unit in SI."""

    powers: tuple
    factor: float = 1.0

    def times(self, other, power: Any = 1):
        """The product with a power of another Dimension."""
        pairs = zip(self.powers, other.powers, strict=True)
        powers = tuple(a + power * b for a, b in pairs)
        return Dimension(powers, self.factor * other.factor ** float(power))

    def agrees(self, other):
        """Whether quantities of the two units may be added."""
        return self.powers == other.powers and abs(self.factor / other.factor - 1.0) < 1e-9

    def __str__(self):
        parts = {True: "", False: ""}
        for name, power in zip(BASE, self.powers, strict=True):
            if power:
                raised = "" if abs(power) == 1 else _raised(abs(power))
                parts[power > 0] += f" {name}{raised}"
        above = parts[True].strip() or "1"
        below = parts[False].strip()
        below = f"/({below})" if " " in below else f"/{below}" if below else ""
        size = "" if abs(self.factor - 1.0) < 1e-9 else f"{self.factor:.6g} "
        return f"{size}{above}{below}"


NONE = Dimension((Fraction(0),) * len(BASE))


def _raised(power):
    if power.denominator > 1:
        return f"^({power})"
    return str(power).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def dimension_of(unit):
    """The Dimension of a unit in text, "kg m²" or "N s/m"; None for an unknown unit."""
    text = unit.translate(RAISED).replace("·", " ").strip()
    text = re.sub(r"(?<![*])\*(?![*])", " ", text)
    above, *below = text.split("/")
    found = _product(above)
    for n, part in enumerate(below):
        part = part.strip()
        inside = part[1:-1] if part.startswith("(") and part.endswith(")") else part
        if inside is part and " " in part:
            return None  # N/m s may be either
        divisor = _product(inside)
        if found is None or divisor is None or (n and inside is not part):
            return None
        found = found.times(divisor, -1)
    return found


def _product(text):
    """The product of the units in a text without a stroke."""
    total = NONE
    words = text.split()
    for word in words:
        match = WORD.fullmatch(word)
        named = match and _named(match[1])
        if not match or not named:
            return None
        factor, *powers = named
        powers = [*map(Fraction, powers), *[Fraction(0)] * (len(BASE) - len(powers))]
        total = total.times(Dimension(tuple(powers), factor), Fraction(int(match[2] or 1)))
    return total if words else None


def _named(name):
    """The factor and the powers of a unit, with or without a prefix; None for another word."""
    if name in NAMES:
        return NAMES[name]
    if name[:1] in PREFIXES and name[1:] in PREFIXED:
        factor, *powers = NAMES[name[1:]]
        return (PREFIXES[name[0]] * factor, *powers)
    return None


def near_unit(unit, known=()):
    """The unit that may be meant by one with unknown words, 'm/s²' for 'm/sec²'; or "".

    `known` are names that may be meant; by default those that have a dimension.
    """
    known = known or (*NAMES, "deg", "kHz", "mA", "MW")
    found = unit
    others = {name: own for name, own in OTHER_UNITS.items() if own in known}
    for word in re.findall(r"[A-Za-zµμ]{2,}", unit):
        near = [] if _named(word) else near_names(word, (*known, *others), others, CLOSE)
        if near:
            found = found.replace(word, others.get(near[0], near[0]))
    return "" if found == unit else found


def size_in(given, unit):
    """How many of a unit one of the given units is; None for another kind, or an unknown unit.

    Angles have no dimension, and are not compared: Hz are no rad/s.
    """
    if any(re.search(r"rad|rev|deg", one) for one in (given, unit)):
        return None
    a = dimension_of(given)
    b = dimension_of(unit)
    if a is None or b is None or a.powers != b.powers:
        return None
    return a.factor / b.factor
