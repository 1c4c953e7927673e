"""
Figures at slide size. Matplotlib is imported when the first figure is drawn, not before.

``result.plot()`` calls `plot`. The figures of the systems consist of the other functions. All
functions take results by label, for a single run as for a comparison of runs.
"""

from typing import Any

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .style import column, legend, named, sizes, slides

FEW = 120  # steps up to which each is a dot


@shown_when_wrong(result=kinds.results, label=kinds.text)
def plot(result, label=None, **options):
    """
    Draw a result: the figure of its system, or the components of the state against time.

    Parameters
    ----------
    result : OdeResult or dict of str to OdeResult
        One result, or several by label to compare them in one figure.
    label : str, optional
        Label of a single result in the legend.
    **options
        Passed on to the system's figure, and from there to ``matplotlib.pyplot.figure``; or `ax`,
        an Axes of a grid as of ``plt.subplots``: a figure of one panel is drawn there, a figure of
        several takes its place.

    Returns
    -------
    matplotlib.figure.Figure
        With `ax`, the figure of `ax`, or the SubFigure in its place.

    Raises
    ------
    ValueError
        If the result holds no point.
    TypeError
        If `ax` is no Axes of a grid.
    """
    several = isinstance(result, dict) and "y" not in result
    results: dict[str, Any] = result if several else {label or "computed": result}
    if not results or any(len(one.t) == 0 for one in results.values()):
        raise ValueError("A result without points cannot be drawn; does `t_eval` hold any?")
    system = getattr(next(iter(results.values())), "system", None)
    if system is None:
        return components(results, **options)
    return system.figure(results, **options)


@shown_when_wrong(results=kinds.results)
def components(results, **options):
    """Every component of the state against time, one panel each, results overlaid."""
    first = next(iter(results.values()))
    system = getattr(first, "system", None)
    names = [named(state) for state in system.states] if system else None
    n_panels = min(len(first.y), 8)
    with slides():
        figure, panels = column(n_panels, **options)
        for label, result in results.items():
            t, y = curve(result)
            dots = {} if between(result) is not None else {"marker": ".", "ms": 5}  # steps alone
            for axes, values in zip(panels, y, strict=False):
                axes.plot(t, values, label=label, **dots)
        for number, axes in enumerate(panels):
            axes.set_ylabel(names[number] if names else f"y[{number}]")
        panels[-1].set_xlabel("t (s)" if system else "t")
        if len(results) > 1:
            legend(figure, panels[0])
        if len(first.y) > n_panels:
            panels[0].set_title(f"the first {n_panels} of {len(first.y)} components")
    return figure


def invariants(panels, system, results):
    """
    Draw each invariant of a system against time, one panel each, with its value at the start.

    If an invariant changes by less than a hundredth in all results, its change is drawn instead,
    which needs fewer digits on the axis. The range of an axis is at most twice the value at the
    start, so that a failed run does not flatten the other curves.
    """
    for axes, function in zip(panels, system.invariants.values(), strict=True):
        curves = [system.along(function, one.t, one.y) for one in results.values()]
        start = curves[0][0]
        size = abs(start) or 1.0
        steady = max(np.abs(values - start).max() for values in curves) < 0.01 * size
        base = start if steady else 0.0
        for result, values, label in zip(results.values(), curves, results, strict=True):
            at_steps(axes, result.t, values - base, label=label)
        axes.axhline(start - base, color="k", ls="--", lw=1.2)
        shown = np.clip(np.concatenate(curves), start - 2.0 * size, start + 2.0 * size) - base
        margin = 0.06 * (np.ptp(shown) or size)
        axes.set_ylim(shown.min() - margin, shown.max() + margin)
        axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
        label = f"change of {function.label}" if steady else function.label
        axes.set(xlabel="t (s)", ylabel=function.unit)
        axes.set_title(label)


def at_steps(axes, t, values, **options):
    """
    Draw what a solver keeps at its steps alone: a line, with dots where steps are few.

    Between the steps, invariants have the errors of the interpolation, which are often larger.
    """
    dots = {"marker": ".", "ms": 6} if len(t) <= FEW else {}
    axes.plot(t, values, **dots | options)


def plane(axes, exact, path, colour, label=None):
    """
    Draw a computed and an exact path in the (x, y) plane, at equal scales.

    Parameters
    ----------
    exact, path : ndarray, shape (2, n_points)
        The axes show the whole exact path, or the whole computed path if `exact` is NaN.
    """
    axes.plot(*path, color=colour, lw=1.2, label=label)
    known = not np.isnan(exact).any()
    if known:
        axes.plot(*exact, "k--", lw=1.2, label="exact")
    frame = exact if known else path
    low = frame.min(axis=1)
    high = frame.max(axis=1)
    middle = 0.5 * (low + high)
    reach = 0.6 * max((high - low).max(), 1e-300)
    axes.set(xlim=middle[0] + reach * np.array([-1, 1]), aspect="equal")
    axes.set(ylim=middle[1] + reach * np.array([-1, 1]), xlabel="x (m)", ylabel="y (m)")
    axes.locator_params(nbins=6)


@shown_when_wrong(results=kinds.results)
def drift(results, **options):
    """
    Draw the relative change of every invariant against time, on a logarithmic axis.

    Parameters
    ----------
    results : dict of str to OdeResult
        Results of one system, by label.
    """
    system = next(iter(results.values())).system
    with slides():
        figure, panels = column(len(system.invariants), **options)
        for label, result in results.items():
            changes = relative_changes(result)
            for axes, values in zip(panels, changes.values(), strict=True):
                axes.plot(result.t, sizes(values), label=label)
        for axes, function in zip(panels, system.invariants.values(), strict=True):
            axes.set(yscale="log", ylabel=f"change of\n{function.label}\n(relative)")
        panels[-1].set_xlabel("t (s)")
        legend(figure, panels[0])
    return figure


@shown_when_wrong(result=kinds.result)
def relative_changes(result):
    """Change of every invariant since the first point, divided by its size there, by name."""
    changes = {}
    for name, values in result.invariants().items():
        changes[name] = (values - values[0]) / (abs(values[0]) or 1.0)
    return changes


def between(result):
    """The continuous solution of a result, or None if it is not available."""
    continuous = getattr(result, "continuous", None)
    return continuous() if continuous else result.sol


@shown_when_wrong(result=kinds.result, per_step=kinds.number)
def curve(result, per_step=16):
    """
    Points for a smooth line, from the continuous solution: ``per_step`` in each step, and at least
    some hundreds. Without a continuous solution, the points of the result.

    Returns
    -------
    t : ndarray, shape (n_points,)
    y : ndarray, shape (n, n_points)
    """
    t = np.asarray(result.t, float)
    y = np.asarray(result.y)
    if len(t) < 2 or (sol := between(result)) is None:
        return t, y
    per_step = max(per_step, 400 // (len(t) - 1))
    grid = np.interp(np.arange(per_step * (len(t) - 1) + 1) / per_step, np.arange(len(t)), t)
    return grid, sol(grid)


@shown_when_wrong(system=kinds.system, t=kinds.numbers)
def exact_curve(system, t):
    """The exact state along t, shape (n, n_points), or NaN if no exact solution is known."""
    try:
        return system.exact_along(t)
    except ValueError:
        return np.full((len(system.states), len(t)), np.nan)
