"""Figures of orbits by several methods side by side, and of the change of their energy."""

import itertools
from typing import Any

import numpy as np

from . import solution, style


def side_by_side(results, exact, **options):
    """
    An orbit in the plane for each result, three in a row, over the exact orbit.

    Parameters
    ----------
    results : dict of str to OdeResult
    exact : ndarray, shape (2, n_points)
    """

    rows = -(-len(results) // 3)
    with style.slides():
        size = {"figsize": (13, 1.0 + 4.4 * rows), "layout": "compressed"}
        figure = style.new_figure(**size | options)
        panels = figure.subplots(rows, 3, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, colour, (label, result) in zip(
            panels, itertools.cycle(style.COLOURS), results.items(), strict=False
        ):
            axes.plot(*exact, color="0.8", lw=7, label="exact", solid_capstyle="round")
            axes.plot(*solution.curve(result)[1][:2], color=colour, lw=1.0)
            axes.plot(0, 0, "o", color="0.4", ms=8, label="planet")
            end = "" if result.success else f", falls at t = {result.t[-1]:.0f} s"
            axes.set_title(f"{label}\n{result.n_accepted} steps{end}", color=colour, pad=10)
            axes.set_aspect("equal")
            axes.locator_params(nbins=5)
        for n, axes in enumerate(panels[: len(results)]):
            axes.set(ylabel="y (m)" if n % 3 == 0 else "", xlabel="x (m)" if n >= 3 else "")
        reach = 1.25 * np.abs(exact).max()
        panels[0].set(xlim=(-reach, reach), ylim=(-reach, reach))
        style.legend(figure, panels[0])
        spaces: Any = figure.get_layout_engine()
        if spaces is not None:
            spaces.set(h_pad=0.1)  # inches: above the titles, too
    return figure


def energies(results, zoom, lowest=-100.0, **options):
    """
    The change of the energy in per cent, in a panel of full range and in a panel of +-`zoom`.

    Parameters
    ----------
    results : dict of str to OdeResult
    zoom : float
        Per cent.
    lowest : float
        Lower limit of the picture, in per cent; runs that fail leave the picture.
    """
    with style.slides():
        figure, panels = style.column(2, **{"figsize": (12, 8)} | options)
        widths = np.linspace(5.0, 1.6, len(results))  # the last line hides no other line
        for (label, result), width in zip(results.items(), widths, strict=True):
            energy = result.invariants()["energy"]
            change = 100.0 * (energy - energy[0]) / abs(energy[0])
            for axes in panels:
                axes.plot(result.t, change, label=label, lw=width)
            if change.min() < lowest:
                left = result.t[np.argmax(change < lowest)]
                about = f"leaves the picture,\nstops at t = {result.t[-1]:.1f} s"
                panels[0].annotate(about, (left, lowest), xytext=(-45, 10), ha="right",
                                   textcoords="offset points", fontsize=12)  # fmt: skip
        panels[0].set(ylim=(lowest, 0.06 * abs(lowest)), ylabel="change of\nthe energy (%)")
        panels[1].set(ylim=(-zoom, 0.3 * zoom), xlabel="t (s)", ylabel="the same,\nmagnified (%)")
        style.legend(figure, panels[0])
    return figure
