"""Sections, running Lyapunov exponents, basins of attraction."""

import math
import textwrap
from typing import Any

import numpy as np

from fastdyn.plot import style
from fastdyn.plot.needed import needed
from fastdyn.words.near import did_you_mean

FEW = 12  # starts whose points have a colour of their own
COLOURS = ["#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#0072B2", "#D55E00", "#F0E442", "#999999"]
MANY = "tab20"  # the colours of more attractors
NOT_SETTLED = "#ffffff"
APART = "#d9d2c3"
FAILED = "#333333"
ROW, ALL = 84, 12  # letters of a row of the legend; entries above the picture, more stand beside it


def indices(labels, components):
    """Components as numbers, from names or numbers."""
    names = [label.name for label in labels]
    found = []
    for one in [components] if isinstance(components, str | int) else components:
        if isinstance(one, str) and one in names:
            found.append(names.index(one))
        elif not isinstance(one, str | bool) and one in range(len(names)):
            found.append(int(one))
        else:
            advice = did_you_mean(one, names) or f"choose from {', '.join(names)}."
            raise ValueError(f"There is no component {one!r}; {advice}")
    return found


def section(result, components, angles, **options):
    """The points of a section, a colour for each of a few starts."""
    labels = result.equations.labels(len(result.y))
    shown = indices(labels, components)
    wrapped = indices(labels, angles)
    if len(shown) != 2:
        raise ValueError(f"`components` must be two; got {components!r}.")
    y = result.y.copy()
    y[wrapped] = (y[wrapped] + math.pi) % math.tau - math.pi
    with style.slides():
        drawing, axes = style.single(**{"figsize": (9, 7.5)} | options)
        n_starts = len(result.y0)
        size = min(6.0, max(2.2, 250.0 / math.sqrt(max(len(result.t), 1))))
        for k in range(n_starts):
            points = y[:, result.start == k][shown]
            colour = style.COLOURS[k % 6] if n_starts <= FEW else "k"
            axes.plot(*points, ".", ms=size, mew=0, color=colour, rasterized=True)
        axes.set(xlabel=style.named(labels[shown[0]]), ylabel=style.named(labels[shown[1]]))
        for axis, k in zip((axes.xaxis, axes.yaxis), shown, strict=True):
            if k in wrapped:
                style.in_pi(axis)
        noun = "start" if n_starts == 1 else "starts"
        axes.set_title(f"{len(result.t)} points from {n_starts} {noun}")
    return drawing


def exponents(result, **options):
    """Running exponents against time; those that are much larger have a panel of their own."""
    ticker = needed("matplotlib.ticker")

    sizes = np.abs(result.values)
    small = sizes <= 0.2 * sizes.max()
    groups = (
        [np.flatnonzero(small), np.flatnonzero(~small)] if small.any() else [np.arange(len(sizes))]
    )
    if small.any() and result.values[~small].min() > 0.0:
        groups.reverse()
    with style.slides():
        size = {"figsize": (10, 2.5 + 2.7 * len(groups))}
        drawing, panels = style.column(len(groups), **size | options)
        for axes, group in zip(panels, groups, strict=True):
            for k in group:
                _running(axes, result, k)
            tail = result.running[group, len(result.t) // 5 :]
            margin = 0.1 * (np.ptp(tail) or 1.0)
            axes.set_ylim(tail.min() - margin, tail.max() + margin)
            if axes.get_ylim()[0] < 0.0 < axes.get_ylim()[1]:
                axes.axhline(0.0, color="0.3", lw=1.0)
            axes.set(xscale="log", ylabel="exponents\nup to this time")
            axes.xaxis.set_minor_formatter(ticker.NullFormatter())
        panels[-1].set_xlabel("time")
        panels[0].set_xlim(result.t[min(len(result.t) // 10, len(result.t) - 2)], result.t[-1])
        if len(sizes) <= 10:
            style.legend(drawing, *panels)
    return drawing


def _running(axes, result, k):
    """An exponent up to each time, and the last one with its error."""
    colour = style.COLOURS[k % 6]
    value = result.values[k]
    error = result.errors[k]
    label = f"$\\lambda_{{{k + 1}}}$ = {_with_error(value, error)}"
    axes.plot(result.t, result.running[k], color=colour, label=label)
    axes.axhspan(value - error, value + error, color=colour, alpha=0.2, lw=0)


def _with_error(value, error):
    """A number to the digits that its error leaves."""
    digits = max(0, min(8, 1 - math.floor(math.log10(max(error, 1e-9)))))
    return f"{value:.{digits}f} ± {error:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def basin(result, **options):
    """The plane of starts, a colour for each attractor, the attractors as marks."""
    colors = needed("matplotlib.colors")
    patches = needed("matplotlib.patches")

    n = len(result.attractors)
    i, j = result.components
    width = max(len(low) for low, _ in result.attractors) if n else max(i, j) + 1
    labels: Any = result.equations.labels(width)
    tones = COLOURS[:n] if n <= len(COLOURS) else _many(n)
    palette = colors.ListedColormap([APART, FAILED, NOT_SETTLED, *tones])
    with style.slides():
        drawing, axes = style.single(**{"figsize": (9.5, 8)} | options)
        axes.grid(visible=False)
        dx, dy = (0.5 * (v[1] - v[0]) for v in (result.x, result.y))
        extent = (result.x[0] - dx, result.x[-1] + dx, result.y[0] - dy, result.y[-1] + dy)
        axes.imshow(result.labels, origin="lower", extent=extent, cmap=palette, vmin=-3.5,
                    vmax=n - 0.5, aspect="auto", interpolation="nearest")  # fmt: skip
        if np.isclose(np.ptp(result.x), np.ptp(result.y)):
            axes.set_aspect("equal")
        entries = list(zip(tones, result.names, result.shares, strict=True))
        for tone, (share, name) in zip((NOT_SETTLED, APART, FAILED), result.others, strict=True):
            entries.append((tone, name, share))
        entries = [entry for entry in entries if entry[2] > 0.0]
        n_columns = 2 if max(len(name) + 6 for _, name, _ in entries) <= ROW // 2 else 1
        n_columns = n_columns if 1 < len(entries) <= ALL else 1
        row = ROW // 2 if len(entries) > ALL else ROW // n_columns
        handles = [
            patches.Patch(fc=tone, ec="0.4", label=textwrap.fill(f"{name} ({share:.1%})", row))
            for tone, name, share in entries
        ]
        for low, high in result.attractors:
            place = 0.5 * (low + high)[[i, j]]
            if np.abs(high - low).max() <= 1e-3 * max(1.0, np.abs(high).max()):
                axes.plot(*place, "o", mfc="white", mec="k", mew=1.8, ms=9)
        axes.set(
            xlim=extent[:2],
            ylim=extent[2:],
            xlabel=style.named(labels[i]),
            ylabel=style.named(labels[j]),
        )
        if drawing not in style.OURS:
            axes.legend(handles=handles)
            return drawing
        if len(entries) > ALL:
            drawing.set_size_inches(*(options.get("figsize") or (14, 8)))
        place = "outside upper center" if len(entries) <= ALL else "outside right upper"
        drawing.legend(handles=handles, loc=place, ncols=n_columns)
    return drawing


def _many(n):
    """Colours of more attractors than the palette has."""
    pyplot = needed("matplotlib.pyplot")

    return [pyplot.get_cmap(MANY)(k / 20) for k in range(n)]
