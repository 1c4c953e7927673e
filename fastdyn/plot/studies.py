"""The figure of drift studies: log-log, with the guides that tell growth."""

import numpy as np

from . import style


def plot_studies(studies, **options):
    """
    Draw the drift of each invariant against time, all studies in one panel.

    Parameters
    ----------
    studies : dict of str to Study
        Studies by label.

    Returns
    -------
    matplotlib.figure.Figure
    """
    names = list(next(iter(studies.values())).drifts)
    phases = [study.phase is not None for study in studies.values()]
    with style.slides():
        n_panels = len(names) + all(phases)
        size = {"figsize": (max(9.0, 5.2 * n_panels), 6.4)}
        figure, panels = style.row(n_panels, **size | options)
        for axes, name in zip(panels, names, strict=False):
            for label, study in studies.items():
                drift = study.drifts[name]
                size = np.maximum(np.abs(drift.low), np.abs(drift.high))
                known = f"{label} ({name.replace('_', ' ')}: {drift.growth.verdict})"
                axes.plot(study.t, style.sizes(size), lw=1.4, label=known)
            relative = all(study.drifts[name].start for study in studies.values())
            axes.set_title(f"change of {name.replace('_', ' ')}")
            axes.set_ylabel("relative to the start" if relative else "change")
        if all(phases):
            for study in studies.values():
                panels[-1].plot(study.t, style.sizes(study.phase), lw=1.4)
            panels[-1].set(title="phase error", ylabel="phase error (s)")
        for axes in panels:
            axes.set(xscale="log", yscale="log")
            _guides(axes)
            axes.set_xlabel("t (s)")
        style.legend(figure, panels[0])
    return figure


def _guides(axes):
    """Lines for sqrt t and t through the lower left corner of the data."""
    drawn = [line.get_ydata() for line in axes.lines]
    t = axes.lines[0].get_xdata()
    last = [np.nanmax(y[len(y) // 2 :]) for y in drawn if np.isfinite(y[len(y) // 2 :]).any()]
    if not last or len(t) < 2:
        return
    low = min(last)
    for power, dashes, label in ((0.5, ":", "√t"), (1.0, "--", "t")):
        guide = low * (t / t[-1]) ** power
        axes.plot(t, guide, color="0.6", ls=dashes, lw=1.0, label=f"~ {label}", zorder=0)
