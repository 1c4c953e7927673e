"""Numbers in files, as a person would write them."""

import math
import re

DIGITS = 15  # a sum such as 0.1 + 0.2 agrees with its decimal number, 0.3, to so many
FEWER = 12  # a number that has no more of these digits is one that somebody chose
ZEROS = re.compile(r"(e[+-])0")  # Python writes 1e-06


def source(value):
    """A value as source text that gives the same value: 1e-6, 0.3, 20.0."""
    return ZEROS.sub(r"\1", repr(value)) if isinstance(value, float) else repr(value)


def computed(value):
    """The fewest digits that give the same number when they are read; "" for none."""
    value = float(value)
    return source(value).removesuffix(".0") if math.isfinite(value) else ""


def chosen(value):
    """A number of a grid, such as a time of output: 0.3, also where its sum is one bit above."""
    short = computed(f"{float(value):.{FEWER}g}")
    return short if short == computed(f"{float(value):.{DIGITS}g}") else computed(value)


def table(columns, grid=()):
    """Columns by name as text with commas; those named in `grid` are chosen."""
    ways = [chosen if name in grid else computed for name in columns]
    rows = [
        ",".join(way(value) for way, value in zip(ways, row, strict=True))
        for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join([",".join(columns), *rows, ""])
