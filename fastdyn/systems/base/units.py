"""Numbers with a unit, as "45 deg" for an angle that is kept in radians."""

import math
import re

from fastdyn.compile.sentences import warn

from .dimensions import NAMES, near_unit, size_in

IN_RADIANS = {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": math.tau}
FACTORS = {
    "rad": IN_RADIANS,
    "rad/s": {f"{name}/s": size for name, size in IN_RADIANS.items()} | {"rpm": math.tau / 60.0},
}
HIGH = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
LOW = str.maketrans(HIGH, "-0123456789")
NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")


def is_number(text):
    """Whether a text is a number with or without a unit."""
    return bool(NUMBER.fullmatch(text))


def in_unit(text, unit):
    """
    The number in a text, converted to a unit.

    Parameters
    ----------
    text : str
        A number, in `unit`, or a number and its unit: "45 deg", "0.8 rad", "33.3 rpm", "2 m",
        "100 cm", "250 g", "3 kN/m".
    unit : str

    Raises
    ------
    ValueError
        For a text that is no number, and for a unit that cannot be converted.
    """
    found = NUMBER.fullmatch(text)
    if not found:
        raise ValueError(f"{text!r} is not a number.")
    value = float(found[1])
    given = found[2]
    if given is not None and re.match(r",\d", given):
        raise ValueError(
            f"{text!r} has a comma; a decimal number has a point, {text.replace(',', '.', 1)!r}."
        )
    known = FACTORS.get(unit, {unit: 1.0})
    if given is None or given == unit:
        return value
    if given not in known and (size := size_in(given, unit)):
        return value * size
    if given not in known:
        same = [*known, *(name for name in NAMES if size_in(name, unit))]
        near = near_unit(given, same) or near_unit(given)
        fits = near in same or (near and size_in(near, unit))
        said = f"; did you mean {near!r}?" if fits else "."
        raise ValueError(f"{text!r} is not in {' or '.join(known)}{said}")
    return value * known[given]


def magnitude(value, unit):
    """The number of a quantity of pint in a unit; any other object as it is.

    Raises
    ------
    ValueError
        If the quantity is of another kind.
    """
    if not (hasattr(value, "to") and hasattr(value, "magnitude") and hasattr(value, "units")):
        return value
    plain = re.sub(f"[{HIGH}]+", lambda found: "**" + found[0].translate(LOW), unit)
    try:
        return float(value.to(re.sub(r"(?<=\w) (?=\w)", " * ", plain) or "1").magnitude)
    except Exception as error:  # pint's own, a TypeError
        raise ValueError(f"{value} is not in {unit or 'a number'}: {error}") from None


def said_in_unit(about, text, unit):
    """As `in_unit`; warns of an angle without a unit that exceeds a full turn."""
    value = in_unit(text, unit)
    found = NUMBER.fullmatch(text)
    if found and found[2] is None:
        warn_of_degrees(about, value, unit)
    return value


def product_of(powers):
    """
    The product of powers of units, as a person writes it: "s²/m" for {"m/s²": -1}.

    Parameters
    ----------
    powers : dict of str to int
        Powers of units such as "kg", "m/s²", "N m", "J/kg".

    Returns
    -------
    str
        "" if everything cancels.
    """
    found: dict[str, int] = {}
    for unit, power in powers.items():
        sign = 1
        for part in re.findall(r"/|[^\s/·*()]+", unit):
            if part == "/":
                sign = -1
                continue
            symbol = part.rstrip(HIGH)
            exponent = int(part[len(symbol) :].translate(LOW) or 1)
            if symbol != "1":
                found[symbol] = found.get(symbol, 0) + sign * power * exponent
    above = [k + _high(n) for k, n in found.items() if n > 0]
    below = [k + _high(-n) for k, n in found.items() if n < 0]
    if not below:
        return " ".join(above)
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{under}"


def _high(n):
    return "" if n == 1 else str(n).translate({v: k for k, v in LOW.items()})


def other_unit_of(unit):
    """The unit to which fastdyn converts a unit, such as "rad" for "deg"; or None."""
    return next((own for own, others in FACTORS.items() if unit in others and unit != own), None)


def warn_of_degrees(about, value, unit):
    """Warn of an angle beyond a full turn, which was probably meant in degrees."""
    if unit == "rad" and abs(value) > math.tau:
        warn(
            f"{about} is {value:g} rad, more than a full turn: angles are in radians. For degrees "
            f"write '{value:g} deg'."
        )


def with_degrees(value, unit):
    """A value with its unit; an angle also in degrees."""
    beside = f" ({math.degrees(value):.6g}°)" if unit == "rad" and math.isfinite(value) else ""
    return f"{value:.10g} {unit}".rstrip() + beside
