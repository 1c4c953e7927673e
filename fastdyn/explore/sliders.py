"""Ranges for sliders, from a number, its unit and its declaration."""

import math
from typing import NamedTuple

from fastdyn.words.letters import letters

STEPS = 200  # approximate number of steps of a slider
TOLERANCES = [10.0**-k for k in range(2, 14)]
CONSTANT_STEPS = [m * 10.0**-k for k in (4, 3, 2, 1) for m in (1.0, 2.0, 5.0)]  # s
END = 0.05, 5.0  # ends of the slider of the end of a run, and its step, the first of them
SMALL, LARGE = 0.5, 8.0  # the range of a default below SMALL extends to LARGE


class Slider(NamedTuple):
    """A number that can be moved between two ends."""

    name: str
    unit: str
    meaning: str
    value: float
    low: float
    high: float
    step: float
    initial: bool

    def title(self):
        """The text above the slider."""
        meaning = "" if self.meaning == self.name else f": {self.meaning}"
        unit = f" ({self.unit})" if self.unit else ""
        return f"{letters(self.name)}{unit}{meaning}"


def slider(field, value):
    """
    The slider of a field of a system.

    Parameters
    ----------
    field : dataclasses.Field
        Declared by `parameter` or `initial`.
    value : float
        The first value, which lies between the ends.
    """
    about = field.metadata
    low, high = _ends(about, float(field.default), value)
    step = round_step((high - low) / STEPS)
    low = step * math.floor(low / step + 1e-9)
    high = step * math.ceil(high / step - 1e-9)
    if about["positive"]:
        low = max(low, step)
    initial = "initial" in about
    return Slider(field.name, about["unit"], about["meaning"], value, low, high, step, initial)


def _ends(about, default, value):
    """The ends of a range around the default, with the value in it."""
    size = max(abs(default), abs(value))
    if about["positive"]:
        return min(0.1 * size, value), 3.0 * size
    if about["unit"] == "rad":
        size = max(math.pi, size)
    elif "initial" in about and size < SMALL:
        size = LARGE
    elif size == 0.0:
        size = 1.0
    else:
        size = 2.0 * size
    return (0.0 if not about["negative"] else -size), size


def round_step(step):
    """A round step near a given step, with the digit 1, 2 or 5."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(n * power for n in (1.0, 2.0, 5.0, 10.0) if n * power >= 0.999 * step)
