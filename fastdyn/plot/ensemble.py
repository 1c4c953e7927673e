"""The figures of ensembles: fans against time, sweeps over a parameter, maps over two."""

from typing import NamedTuple

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.letters import letters
from fastdyn.words.near import did_you_mean

from . import style

MOST = 8  # most panels
FEW = 6  # up to so many trajectories are drawn one by one
BANDS = ((0.05, 0.95, 0.18, "90 % of all"), (0.25, 0.75, 0.35, "half of all"))
TITLES = {
    "y_end": "{} at the end", "final": "{} at the end", "max": "largest {}", "min": "smallest {}",
    "max_time": "time of the largest {}", "min_time": "time of the smallest {}",
    "mean": "mean of {}", "rms": "rms of {}",
}  # fmt: skip


def figure(trajectories, of=None, over=None, components=None, **options):
    """The figure of `Trajectories.plot`."""
    e = trajectories
    chosen = _components(e, components)
    if of is None:
        of = list(e.reduced) or ("y" if np.ndim(e.y) == 3 else "y_end")
    if not isinstance(of, str):
        kinds.several("of", of)
    names = [of] if isinstance(of, str) else list(of)
    for name in names:
        if name not in ["y", "y_end", *e.reduced] or (name == "y" and np.ndim(e.y) < 3):
            there = ["y"] * (np.ndim(e.y) == 3) + ["y_end", *e.reduced]
            advice = did_you_mean(name, there, form='"{}"') or f"choose from {', '.join(there)}."
            raise ValueError(f"`of={name!r}` is not there; {advice}")
    if "y" in names and len(names) > 1:
        raise ValueError('`of="y"` is a figure of its own.')
    if not e.success.any():
        raise ValueError("no trajectory has got to its end; nothing can be drawn.")
    columns = _columns(e, over)
    with style.slides():
        if names == ["y"]:
            return _fan(e, chosen, columns, options)
        if len(columns) == 1:
            return _sweep(e, names, chosen, columns[0], options)
        if len(columns) == 2:
            return _map(e, names, chosen, columns, options)
        return _histograms(e, names, chosen, options)


def _columns(e, over):
    """The columns to draw over: the columns in `over`, else parameters, else initial states."""
    parameters, starts = e.varied()
    if over is None:
        return parameters or starts
    known = {label.name: (label, column) for label, column in parameters + starts}
    if not isinstance(over, str):
        kinds.several("over", over)
    names = [over] if isinstance(over, str) else list(over)
    for name in names:
        if not isinstance(name, str) or name not in known:
            advice = did_you_mean(name, known) or f"choose from {', '.join(known)}."
            raise ValueError(f"`over={name!r}` does not vary; {advice}")
    return [known[name] for name in names]


def _components(e, components):
    """Indices of the components to draw."""
    known = [label.name for label in e.labels]
    if components is None:
        return list(range(min(len(known), MOST)))
    if not isinstance(components, str | int):
        kinds.several("components", components)
    given = [components] if isinstance(components, str | int) else components
    for one in given:
        if one not in known and one not in range(len(known)):
            advice = did_you_mean(one, known) or f"choose from {', '.join(known)}."
            raise ValueError(f"`components={one!r}` is unknown; {advice}")
    return [known.index(one) if isinstance(one, str) else one for one in given]


def _fan(e, chosen, columns, options):
    """Median and bands of each component against time; the trajectories themselves if few."""
    y = np.asarray(e.y[:])
    figure, panels = style.column(len(chosen), **options)
    for axes, i in zip(panels, chosen, strict=True):
        values = y[:, i]
        if len(values) <= FEW:
            for number, line in enumerate(values):
                axes.plot(e.t, line, label=_told(columns, number))
        else:
            _bands(axes, e.t, values)
        axes.set_ylabel(style.named(e.labels[i]))
    panels[-1].set_xlabel(style.with_unit("t", _second(e)))
    style.legend(figure, panels[0])
    return figure


def _bands(axes, t, values):
    there = np.isfinite(values).any(axis=0)
    t = t[there]
    values = values[:, there]
    for low, high, alpha, label in BANDS:
        edges = np.nanquantile(values, [low, high], axis=0)
        axes.fill_between(t, *edges, color=style.COLOURS[0], alpha=alpha, lw=0, label=label)
    low, high = axes.get_ylim()  # the limits of the bands, not of single trajectories
    axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
    for number, i in enumerate(np.linspace(0, len(values) - 1, 3).astype(int)):
        label = None if number else "three of them"
        axes.plot(t, values[i], color="0.35", lw=0.8, label=label)
    axes.plot(t, np.nanmedian(values, axis=0), color=style.COLOURS[0], label="median")


def _told(columns, number):
    """The label of a trajectory: its parameters."""
    told = [f"{letters(one.name)} = {column[number]:.4g} {one.unit}" for one, column in columns[:2]]
    return ", ".join(told).strip() or f"trajectory {number}"


def _sweep(e, names, chosen, over, options):
    """Lines over the only parameter that varies."""
    label, column = over
    found = _quantities(e, names, chosen)
    panels_of = list(dict.fromkeys(quantity.panel for quantity in found))[:MOST]
    order = np.argsort(column, kind="stable")
    figure, panels = style.column(len(panels_of), **options)
    for axes, panel in zip(panels, panels_of, strict=True):
        mine = [quantity for quantity in found if quantity.panel == panel]
        for quantity in mine:
            marker = "-" if len(order) > FEW else "o-"
            axes.plot(column[order], quantity.values[order], marker, label=quantity.title)
        axes.set_ylabel(style.with_unit(mine[0].title if len(mine) == 1 else panel[0], panel[1]))
        if len(mine) > 1:
            axes.legend()
    panels[-1].set_xlabel(style.named(label))
    if _geometric(column[order]):
        panels[-1].set_xscale("log")
    _failures(figure, e)
    return figure


def _map(e, names, chosen, columns, options):
    """A picture of each quantity over the two parameters that vary."""
    (label_x, x), (label_y, y) = columns
    found = _quantities(e, names, chosen)[:MOST]
    figure, panels = _grid(len(found), **options)
    at_x = np.unique(x)
    at_y = np.unique(y)
    i = np.searchsorted(at_x, x)
    j = np.searchsorted(at_y, y)
    grid = len(at_x) * len(at_y) == len(x) == len(np.unique(j * len(at_x) + i))
    for axes, quantity in zip(panels, found, strict=True):
        if grid:
            picture = np.empty((len(at_y), len(at_x)))
            picture[j, i] = quantity.values
            drawn = axes.pcolormesh(at_x, at_y, picture, shading="nearest", rasterized=True)
        else:
            drawn = axes.scatter(x, y, c=quantity.values, s=max(2.0, min(60.0, 2e4 / len(x))))
        axes.grid(visible=False)
        figure.colorbar(drawn, ax=axes, label=quantity.unit)
        axes.set(title=quantity.title, xlabel=style.named(label_x), ylabel=style.named(label_y))
        axes.set_xscale("log" if _geometric(at_x) else "linear")
        axes.set_yscale("log" if _geometric(at_y) else "linear")
    _failures(figure, e)
    return figure


def _histograms(e, names, chosen, options):
    """A histogram of each quantity, for more than two varying parameters."""
    found = _quantities(e, names, chosen)[:MOST]
    figure, panels = _grid(len(found), **options)
    for axes, quantity in zip(panels, found, strict=True):
        values = quantity.values[np.isfinite(quantity.values)]
        bins = min(80, max(8, round(2.0 * len(values) ** (1.0 / 3.0))))  # Rice's rule
        axes.hist(values, bins=bins, alpha=0.6)
        axes.axvline(np.median(values), color="k", ls="--", lw=1.2, label="median")
        axes.set(xlabel=style.with_unit(quantity.title, quantity.unit), ylabel="trajectories")
    style.legend(figure, panels[0])
    _failures(figure, e)
    return figure


class Quantity(NamedTuple):
    """A number for each trajectory, NaN for failed trajectories; `panel` names its panel."""

    title: str
    unit: str
    values: np.ndarray
    panel: tuple


def _quantities(e, names, chosen):
    found = []
    for name in names:
        values = e.y_end if name == "y_end" else e.reduced[name]
        if values.ndim == 1:  # the values of a Fold
            found.append(Quantity(name, "", np.where(e.success, values, np.nan), (name, "")))
            continue
        values = np.where(e.success[:, None], values, np.nan)
        unit = _second(e)
        if name == "first_event":
            for event, times in zip(e.event_names, values.T, strict=True):
                panel = ("time of events", unit)
                found.append(Quantity(f"time of the first {event}", unit, times, panel))
            continue
        for i in chosen:
            label = e.labels[i]
            title = TITLES[name].format(letters(e.labels[i].name))
            panel = (letters(label.name), label.unit)
            if e.is_time(name):
                panel = (f"time of extremes of {letters(label.name)}", unit)
            found.append(Quantity(title, panel[1], values[:, i], panel))
    return found


def _grid(n_panels, **options):
    """Figure of panels side by side, in rows of at most three."""

    n_columns = n_panels if n_panels <= 3 else 2 if n_panels == 4 else 3
    n_rows = -(-n_panels // n_columns)
    size = (max(7.5, 5.6 * n_columns), 0.6 + 4.4 * n_rows)
    figure = style.new_figure(**{"figsize": size} | options)
    panels = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
    for empty in panels[n_panels:]:
        empty.remove()
    return figure, list(panels[:n_panels])


def _geometric(values):
    """Whether sorted values are spread evenly on a logarithmic axis, over more than a decade."""
    if len(values) < 3 or values[0] <= 0.0 or values[-1] < 10.0 * values[0]:
        return False
    steps = np.diff(np.log(values))
    return bool(np.ptp(steps) < 0.5 * steps.mean())


def _failures(figure, e):
    """Say how many trajectories are missing."""
    failed = int((~e.success).sum())
    if failed:
        figure.suptitle(f"{failed} of {len(e)} trajectories did not get to the end", fontsize=12)


def _second(e):
    return "s" if e.system is not None else ""
