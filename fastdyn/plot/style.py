"""Fonts, colours, panels and legends of all figures."""

import contextlib
import math
from typing import Any

import numpy as np

from .needed import needed

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
"""Okabe and Ito's palette, told apart also by colour-blind readers."""
GROUND = "#b9a98b"
ROUNDING = 2.0**-54  # half the rounding of numbers near 1


@contextlib.contextmanager
def slides():
    """Fonts, lines and colours that can be read from the back of a lecture room."""
    matplotlib = needed("matplotlib")

    settings: Any = {
        "font.size": 14,
        "axes.titlesize": 14,
        "legend.fontsize": 12,
        "lines.linewidth": 2.0,
        "axes.grid": True,
        "grid.alpha": 0.3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
        "savefig.dpi": 100,
    }
    with matplotlib.rc_context(settings):
        yield


def legend(figure, *panels):
    """One legend above all panels, which hides no data; equal labels appear once."""
    entries = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if "exact" in entries:
        entries["exact"] = entries.pop("exact")  # after all that is computed
    longest = max(map(len, entries))
    n_columns = min(len(entries), 2 if longest > 30 else 3 if longest > 22 else 5)
    figure.legend(entries.values(), entries, loc="outside upper center", ncols=n_columns)


def column(n_panels, sharex: Any = True, **options):
    """A figure of panels in a column, which share the time axis by default."""
    pyplot = needed("matplotlib.pyplot")

    options = {"figsize": (10, 2.2 + 2.2 * n_panels), "layout": "constrained"} | options
    figure = pyplot.figure(**options)
    panels = figure.subplots(n_panels, 1, sharex=sharex, squeeze=False)
    return figure, list(panels[:, 0])


def row(n_panels, **options):
    """A figure of panels in a row."""
    pyplot = needed("matplotlib.pyplot")

    given: Any = {"layout": "constrained"} | options
    figure = pyplot.figure(**given)
    return figure, list(figure.subplots(1, n_panels, squeeze=False)[0])


def pictures_and_panels(n_pictures, n_panels, **options):
    """Figure of square pictures with panels below, or beside a single picture."""
    pyplot = needed("matplotlib.pyplot")

    size = (13.0, 6.5) if n_pictures == 1 else (4.6 * n_pictures, 8.5)
    figure = pyplot.figure(**{"figsize": size, "layout": "constrained"} | options)
    if n_pictures == 1:
        grid = figure.add_gridspec(n_panels, 2)
        return (
            figure,
            [figure.add_subplot(grid[:, 0])],
            [figure.add_subplot(grid[row, 1]) for row in range(n_panels)],
        )
    width = math.lcm(n_pictures, n_panels)
    grid = figure.add_gridspec(2, width, height_ratios=(3, 2))
    rows = []
    for row, count in enumerate((n_pictures, n_panels)):
        cells = [grid[row, i * width // count : (i + 1) * width // count] for i in range(count)]
        rows.append([figure.add_subplot(cell) for cell in cells])
    return figure, *rows


def at_equal_scales(axes, ylabel="y (m)"):
    """Name the axes of a plane, at equal scales, with few numbers on them."""
    axes.set(xlabel="x (m)", ylabel=ylabel, aspect="equal")
    axes.locator_params(nbins=5)


def sizes(values):
    """Absolute values for a logarithmic axis; values below ROUNDING become ROUNDING."""
    return np.maximum(np.abs(values), ROUNDING)


def in_pi(axis):
    """Ticks of an angle in parts of pi, some five of them; numbers in a small part of a turn."""
    ticker = needed("matplotlib.ticker")

    low, high = axis.get_view_interval()
    if high - low < 0.75 * math.pi:
        return
    parts = min((0.25, 0.5, 1.0, 2.0, 5.0, 10.0), key=lambda p: abs((high - low) / math.pi / p - 5))
    axis.set_major_locator(ticker.MultipleLocator(parts * math.pi))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: _times_pi(value / math.pi)))


def _times_pi(value):
    """The text of a multiple of pi / 4."""
    quarters = round(4 * value)
    if quarters == 0:
        return "0"
    divisor = 4 // math.gcd(4, quarters)
    number = quarters * divisor // 4
    sign, number = "\N{MINUS SIGN}" * (number < 0), abs(number)
    return f"{sign}{number if number > 1 else ''}π{f'/{divisor}' if divisor > 1 else ''}"


def with_unit(title, unit):
    """The label of an axis."""
    return f"{title} ({unit})" if unit else title


def save(figure, path):
    """Write a figure to a file, its format from the ending, and close it."""
    pyplot = needed("matplotlib.pyplot")

    figure.savefig(path)
    pyplot.close(figure)
