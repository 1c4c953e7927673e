"""The phase portrait: field, trajectories, nullclines, separatrices, equilibria."""

import numpy as np

from fastdyn.plot import style

ARROWS = 23  # of the field, a side
HEADS = (0.5,)  # shares of a trajectory at which an arrow head shows its direction
ANGLE = "rad"  # the unit of an axis in parts of pi
SEPARATRICES = {  # colour, width (both are seen where they coincide), label
    "to": ("#66c5ab", 4.2, "into a saddle"), "from": ("#D55E00", 1.8, "out of a saddle"),
}  # fmt: skip
NULLCLINES = ("#E69F00", "#CC79A7")


def figure(portrait, nullclines, **options):
    """Draw a Portrait."""
    p = portrait
    labels = portrait.equations.labels(2)
    with style.slides():
        drawing, axes = style.single(**{"figsize": (10.5, 8)} | options)
        axes.grid(visible=False)
        _field(axes, p)
        if nullclines:
            _nullclines(axes, p, labels)
        for curve in p.trajectories:
            _curve(axes, curve, style.COLOURS[0], 1.3, p.box)
        for kind, curve in sorted(p.separatrices, key=lambda pair: pair[0], reverse=True):
            _curve(axes, curve, *SEPARATRICES[kind][:2], p.box, SEPARATRICES[kind][2])
        for cycle in p.cycles:
            label = f"{'stable' if cycle.stable else 'unstable'} cycle, period {cycle.period:.4g}"
            style_of = "-" if cycle.stable else (0, (2, 1))
            axes.plot(*cycle.y, color="k", lw=2.6, ls=style_of, label=label, zorder=5)
        _equilibria(axes, p.equilibria)
        axes.set(
            xlim=p.box[0],
            ylim=p.box[1],
            xlabel=style.named(labels[0]),
            ylabel=style.named(labels[1]),
        )
        for axis, label in zip((axes.xaxis, axes.yaxis), labels, strict=True):
            if label.unit == ANGLE:
                style.in_pi(axis)
        if axes.get_legend_handles_labels()[0]:
            style.legend(drawing, axes)
    return drawing


def _field(axes, p):
    """Arrows of one length, as directions."""
    rows = np.linspace(0, len(p.y) - 1, ARROWS + 2).astype(int)[1:-1]
    columns = np.linspace(0, len(p.x) - 1, ARROWS + 2).astype(int)[1:-1]
    box = np.ptp(p.box, axis=1)
    u, v = p.field[:, rows[:, None], columns] / box[:, None, None]
    with np.errstate(all="ignore"):
        length = np.hypot(u, v)
        u = u / length
        v = v / length
    axes.quiver(
        p.x[columns], p.y[rows], u, v, color="0.82", pivot="mid", angles="uv", scale=38,
        width=0.0022, headwidth=4, zorder=1,
    )  # fmt: skip


def _nullclines(axes, p, labels):
    """Where the rates of the components vanish."""
    for part, colour, label in zip(p.field, NULLCLINES, labels, strict=True):
        if np.nanmin(part) < 0.0 < np.nanmax(part):
            axes.contour(p.x, p.y, part, [0.0], colors=[colour], linestyles=[(0, (5, 4))],
                         linewidths=1.6, zorder=2)  # fmt: skip
            axes.plot([], [], color=colour, ls=(0, (5, 4)), lw=1.6, label=f"{label.name} at rest")


def _curve(axes, curve, colour, width, box, label=None):
    """A curve with an arrow head in its middle, named once."""
    named = label not in axes.get_legend_handles_labels()[1]
    axes.plot(*curve, color=colour, lw=width, label=label if named else None, zorder=3)
    inside = ((curve >= box[:, :1]) & (curve <= box[:, 1:])).all(axis=0)
    shown = curve[:, inside]
    if shown.shape[1] < 3:
        return
    steps = np.hypot(*(np.diff(shown, axis=1) / np.ptp(box, axis=1)[:, None]))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    for share in HEADS:
        at = min(max(int(np.searchsorted(way, share * way[-1])), 1), shown.shape[1] - 1)
        ahead = shown[:, at] - shown[:, at - 1]
        if not np.any(ahead):
            continue
        head = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 17, "lw": 0}
        axes.annotate("", xy=shown[:, at], xytext=shown[:, at - 1], arrowprops=head, zorder=4)


def _equilibria(axes, equilibria):
    """Filled where stable, open where not, half tone where the linear part does not decide."""
    marks = {True: ("k", "stable"), False: ("white", "unstable"), None: ("0.6", "")}
    for one in equilibria or ():
        face, stability = marks[one.stable]
        square = one.kind == "saddle"
        told = square or not stability or stability in one.kind
        label = one.title if told else f"{one.title}, {stability}"
        if label in axes.get_legend_handles_labels()[1]:
            label = None
        axes.plot(*one.y, marker="s" if square else "o", ls="", mfc=face, mec="k", mew=1.8,
                  ms=10, label=label, zorder=6, clip_on=False)  # fmt: skip
