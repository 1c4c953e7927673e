"""Numbers with a unit, as "45 deg" for an angle that is kept in radians."""

import math
import re
import warnings

from fastdyn.compile.sentences import levels_inside

IN_RADIANS = {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": math.tau}
FACTORS = {
    "rad": IN_RADIANS,
    "rad/s": {f"{name}/s": size for name, size in IN_RADIANS.items()} | {"rpm": math.tau / 60.0},
}
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
        A number, in `unit`, or a number and its unit: "45 deg", "0.8 rad", "33.3 rpm", "2 m".
    unit : str

    Raises
    ------
    ValueError
        For a text that is no number, and for a unit that cannot be converted.
    """
    found = NUMBER.fullmatch(text)
    if not found:
        raise ValueError(f"{text!r} is not a number.")
    value, given = float(found[1]), found[2]
    known = FACTORS.get(unit, {unit: 1.0})
    if given is None or given == unit:
        return value
    if given not in known:
        raise ValueError(f"{text!r} is not in {' or '.join(known)}.")
    return value * known[given]


def said_in_unit(about, text, unit):
    """As `in_unit`; warns of an angle without a unit that exceeds a full turn."""
    value = in_unit(text, unit)
    found = NUMBER.fullmatch(text)
    if found and found[2] is None:
        warn_of_degrees(about, value, unit)
    return value


def other_unit_of(unit):
    """The unit to which fastdyn converts a unit, such as "rad" for "deg"; or None."""
    return next((own for own, others in FACTORS.items() if unit in others and unit != own), None)


def warn_of_degrees(about, value, unit):
    """Warn of an angle beyond a full turn, which was probably meant in degrees."""
    if unit == "rad" and abs(value) > math.tau:
        warnings.warn(
            f"{about} is {value:g} rad, more than a full turn: angles are in radians. For degrees "
            f"write '{value:g} deg'.",
            stacklevel=levels_inside(),
        )


def with_degrees(value, unit):
    """A value with its unit; an angle also in degrees."""
    beside = f" ({math.degrees(value):.6g}°)" if unit == "rad" and math.isfinite(value) else ""
    return f"{value:.10g} {unit}".rstrip() + beside
