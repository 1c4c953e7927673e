"""Fonts, colours, panels and legends of all figures."""

import contextlib
import math
import weakref
from typing import Any

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.kinds import noted
from fastdyn.words.letters import letters

from .needed import needed

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
"""Okabe and Ito's palette, told apart also by colour-blind readers."""
GROUND = "#b9a98b"
ROUNDING = 2.0**-54  # half the rounding of numbers near 1
OF_FIGURES = "A figure takes `ax`, or the options of plt.figure: `figsize`, `dpi`, `layout`."
OURS: Any = weakref.WeakSet()  # figures, and parts of figures, that nobody else draws in


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
    if figure in OURS:
        figure.legend(entries.values(), entries, loc="outside upper center", ncols=n_columns)
    else:
        panels[0].legend(entries.values(), entries)


def own_legend(axes):
    """A legend of one panel, above its right end, where it hides no data."""
    axes.legend(ncols=4, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)


def new_figure(ax: Any = None, layout: Any = "constrained", **options: Any) -> Any:
    """A figure; with `ax`, the part of a figure in which this Axes of a grid stood until now."""
    if ax is None:
        try:
            figure = needed("matplotlib.pyplot").figure(layout=layout, **options)
        except AttributeError as error:
            raise noted(TypeError(str(error)), OF_FIGURES) from None
    else:
        figure = _axes(ax).figure.add_subfigure(ax.get_subplotspec())
        ax.remove()
    OURS.add(figure)
    return figure


def single(ax: Any = None, projection: Any = None, **options: Any) -> Any:
    """(figure, axes) of a figure of one panel, which is `ax` if given."""
    if ax is not None:
        return _axes(ax).figure, ax
    figure = new_figure(**options)
    return figure, figure.add_subplot(projection=projection)


def _axes(ax):
    placed = getattr(ax, "figure", None) is not None and hasattr(ax, "get_subplotspec")
    if not placed or not ax.get_subplotspec():
        raise TypeError(f"`ax` must be one Axes of a grid, as of plt.subplots; got {ax!r}.")
    return ax


@shown_when_wrong(n_panels=kinds.whole)
def column(n_panels, sharex: Any = True, **options: Any) -> Any:
    """A figure of panels in a column, which share the time axis by default."""
    options = {"figsize": (10, 2.2 + 2.2 * n_panels)} | options
    if n_panels == 1:
        figure, axes = single(**options)
        return figure, [axes]
    figure = new_figure(**options)
    panels = list(figure.subplots(n_panels, 1, sharex=sharex, squeeze=False)[:, 0])
    figure.align_ylabels(panels)
    return figure, panels


def row(n_panels, **options) -> Any:
    """A figure of panels in a row."""
    figure = new_figure(**options)
    return figure, list(figure.subplots(1, n_panels, squeeze=False)[0])


def pictures_and_panels(n_pictures, n_panels, **options) -> Any:
    """Figure of square pictures with panels below, or beside a single picture."""
    size = (13.0, 6.5) if n_pictures == 1 else (4.6 * n_pictures, 8.5)
    figure = new_figure(**{"figsize": size} | options)
    if n_pictures == 1:
        grid = figure.add_gridspec(n_panels, 2)
        pictures = [figure.add_subplot(grid[:, 0])]
        panels = [figure.add_subplot(grid[row, 1]) for row in range(n_panels)]
        figure.align_ylabels(panels)
        return figure, pictures, panels
    width = math.lcm(n_pictures, n_panels)
    grid = figure.add_gridspec(2, width, height_ratios=(3, 2))
    rows = []
    for row, count in enumerate((n_pictures, n_panels)):
        cells = [grid[row, i * width // count : (i + 1) * width // count] for i in range(count)]
        rows.append([figure.add_subplot(cell) for cell in cells])
    return figure, *rows


def ground(axes, xlim, ylim, height):
    """Draw the ground in the axes of a picture in space."""
    x, y = np.meshgrid(xlim, ylim)
    drawn = axes.plot_surface(x, y, height + 0.0 * x, color=GROUND, alpha=0.35, shade=False)
    drawn.set_clip_on(False)
    return drawn


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
    sign = "\N{MINUS SIGN}" * (number < 0)
    number = abs(number)
    return f"{sign}{number if number > 1 else ''}π{f'/{divisor}' if divisor > 1 else ''}"


def with_unit(title, unit):
    """The label of an axis."""
    return f"{title} ({unit})" if unit else title


def named(one):
    """The label of an axis for what has a name and a unit, such as a `State`: "θ (rad)"."""
    return with_unit(letters(one.name), one.unit)


@shown_when_wrong(figure=kinds.figure, path=kinds.path)
def save(figure, path):
    """Write a figure to a file, its format from the ending, and close it."""
    pyplot = needed("matplotlib.pyplot")

    figure.savefig(path)
    pyplot.close(figure)
