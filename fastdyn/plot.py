"""
Figures at slide size. Matplotlib is imported when the first figure is drawn, not before.

`plot` is what ``result.plot()`` calls. The other functions are the pieces that the figures of the
systems are put together from; all of them take results by label, so that drawing one run and
comparing several are the same thing.
"""

import contextlib

import numpy as np

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
"""Okabe and Ito's palette, told apart also by colour-blind readers."""


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
        Passed on to the system's figure, and from there to ``matplotlib.pyplot.figure``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the result holds no point.
    """
    several = isinstance(result, dict) and "y" not in result
    results = result if several else {label or "computed": result}
    if not results or any(len(one.t) == 0 for one in results.values()):
        raise ValueError("A result without points cannot be drawn; does `t_eval` hold any?")
    system = getattr(next(iter(results.values())), "system", None)
    if system is None:
        return components(results, **options)
    return system.figure(results, **options)


def components(results, **options):
    """Every component of the state against time, one panel each, results overlaid."""
    first = next(iter(results.values()))
    system = getattr(first, "system", None)
    names = [_axis(state.name, state.unit) for state in system.states] if system else None
    n_panels = min(len(first.y), 8)
    with slides():
        figure, panels = column(n_panels, **options)
        for label, result in results.items():
            t, y = curve(result)
            for axes, values in zip(panels, y, strict=False):
                axes.plot(t, values, label=label)
        for number, axes in enumerate(panels):
            axes.set_ylabel(names[number] if names else f"y[{number}]")
        panels[-1].set_xlabel("t (s)" if system else "t")
        panels[0].legend(loc="upper right")
        if len(first.y) > n_panels:
            figure.suptitle(f"the first {n_panels} of {len(first.y)} components")
    return figure


def invariants(panels, system, results):
    """
    Draw each invariant of a system against time, one panel each, with its value at the start.

    An axis reaches at most twice that value away from it: a run that has failed must not flatten
    the others.
    """
    for axes, function in zip(panels, system.invariants.values(), strict=True):
        start = np.nan
        for label, result in results.items():
            values = system.along(function, result.t, result.y)
            start = values[0]
            axes.plot(result.t, values, label=label)
        axes.axhline(start, color="k", ls="--", lw=1.2)
        low, high = axes.get_ylim()
        reach = 2.0 * abs(start) or np.inf
        axes.set_ylim(max(low, start - reach), min(high, start + reach))
        axes.set(xlabel="t (s)", ylabel=_axis(function.label, function.unit))


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
                size = np.abs(values)
                axes.plot(result.t, np.where(size > 0.0, size, np.nan), label=label)
        for axes, function in zip(panels, system.invariants.values(), strict=True):
            axes.set(yscale="log", ylabel=f"change of\n{function.label}\n(relative)")
        panels[-1].set_xlabel("t (s)")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def relative_changes(result):
    """Change of every invariant since the first point, divided by its size there, by name."""
    changes = {}
    for name, values in result.invariants().items():
        changes[name] = (values - values[0]) / (abs(values[0]) or 1.0)
    return changes


def curve(result, per_step=8):
    """
    Points for a smooth line, ``per_step`` in each step where the result has a dense output.

    Returns
    -------
    t : ndarray, shape (n_points,)
    y : ndarray, shape (n, n_points)
    """
    t, y = np.asarray(result.t, float), np.asarray(result.y)
    if result.sol is None or len(t) < 2:
        return t, y
    grid = np.interp(np.arange(per_step * (len(t) - 1) + 1) / per_step, np.arange(len(t)), t)
    return grid, result.sol(grid)


@contextlib.contextmanager
def slides():
    """Fonts, lines and colours that can be read from the back of a lecture room."""
    import matplotlib

    settings = {
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


def column(n_panels, **options):
    """Figure of panels above one another that share the time axis."""
    from matplotlib import pyplot

    options = {"figsize": (10, 2.2 + 2.2 * n_panels), "layout": "constrained"} | options
    figure = pyplot.figure(**options)
    panels = figure.subplots(n_panels, 1, sharex=True, squeeze=False)
    return figure, list(panels[:, 0])


def two_rows(n_above, n_below, **options):
    """Figure with a tall row of panels above a low one."""
    from matplotlib import pyplot

    options = {"figsize": (max(10.0, 4.6 * n_above), 8.5), "layout": "constrained"} | options
    figure = pyplot.figure(**options)
    rows = figure.add_gridspec(2, 1, height_ratios=(3, 2))
    above = rows[0].subgridspec(1, n_above)
    below = rows[1].subgridspec(1, n_below)
    return (
        figure,
        [figure.add_subplot(cell) for cell in above],
        [figure.add_subplot(cell) for cell in below],
    )


def save(figure, path):
    """Write a figure to a file, its format from the ending, and close it."""
    from matplotlib import pyplot

    figure.savefig(path)
    pyplot.close(figure)


def exact_curve(system, t):
    """Exact state along t, shape (n, n_points), all NaN where none is known."""
    try:
        return system.exact_along(t)
    except ValueError:
        return np.full((len(system.states), len(t)), np.nan)


def _axis(name, unit):
    return f"{name} ({unit})" if unit else name
