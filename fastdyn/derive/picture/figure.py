"""The figure of a derived system: its picture with the paths of its bodies, and curves."""

import itertools
from typing import Any

import numpy as np

from fastdyn.plot import solution, style
from fastdyn.plot.animate import in_space
from fastdyn.plot.needed import needed
from fastdyn.plot.scene import frame
from fastdyn.words.letters import letters

GHOSTS = 7  # pictures of the system along its path
NEAR = 0.15  # of the way of the system: pictures that are nearer lie on top of each other
PER_STEP, BEND, MOST = (16, 64, 256), 0.2, 20_000  # points in a step, rad between them, points
PANELS = 4


def figure(results, **options):
    """
    The system at several times with its trail, beside coordinates and quantities against time.

    Parameters
    ----------
    results : dict of str to SystemResult
        Results by label; the picture is of the first.
    """
    first = next(iter(results.values()))
    panels = _panels(first.system)
    with style.slides():
        drawing = style.new_figure(**{"figsize": (14, 7.5)} | options)
        grid = drawing.add_gridspec(len(panels), 2, width_ratios=(1.0, 1.1))
        _picture(drawing, grid[:, 0], first)
        axes = None
        for row, (label, functions) in enumerate(panels):
            axes = drawing.add_subplot(grid[row, 1], sharex=axes)
            several = len(functions) > 1
            colours = itertools.cycle(style.COLOURS)
            for (said, result), (name, values) in itertools.product(results.items(), functions):
                about = ", ".join([name] * several + [said] * (len(results) > 1))
                look = {"color": next(colours), "lw": 1.6, "label": about}
                if name in result.system.invariants:
                    found = values(result.system, result.t, result.y)
                    solution.at_steps(axes, result.t, found, **look)
                    continue
                t, y = solution.curve(result)
                axes.plot(t, values(result.system, t, y), **look)
            axes.set_ylabel(label)
            axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
            axes.tick_params(labelbottom=row == len(panels) - 1)
            if several or len(results) > 1:
                style.own_legend(axes)
        if axes is not None:
            axes.set_xlabel("t (s)")
            drawing.align_ylabels(drawing.axes[1:])
    return drawing


def _panels(system):
    """The curves against time: [(label, [(name, function of (system, t, y))])], by unit."""
    n = len(system.states) // 2
    found: dict[str, list] = {}
    for row, state in enumerate(system.states[:n]):
        found.setdefault(state.unit, []).append((letters(state.name), _row(row)))
    panels = [(_label("coordinates", names, unit), names) for unit, names in found.items()]
    forces: dict[str, list] = {}
    for name, function in system.quantities.items():
        if name != "energy" and function.unit:
            forces.setdefault(function.unit, []).append((_words(name), _along(function)))
    panels += [(_label("reactions", names, unit), names) for unit, names in forces.items()]
    energy = system.invariants.get("energy") or system.quantities.get("energy")
    if energy is not None and len(panels) < PANELS:
        what = "change of the\nenergy (J)" if "energy" in system.invariants else "energy (J)"
        panels.append((what, [("energy", _change(energy, "energy" in system.invariants))]))
    return panels[:PANELS]


def _label(what, names, unit):
    return style.with_unit(names[0][0] if len(names) == 1 else what, unit)


def _row(row):
    return lambda system, t, y: y[row]


def _along(function):
    return lambda system, t, y: system.along(function, t, y)


def _change(function, kept):
    def values(system, t, y):
        found = system.along(function, t, y)
        return found - found[0] if kept else found

    return values


def _picture(drawing, cell, result):
    """The system at several times, the last one in full."""
    t, scenes, path = _smooth(result)
    last = scenes[-1]
    space = len(last.traced) == 3
    projection: Any = {"projection": "3d"} if space else {}
    axes: Any = drawing.add_subplot(cell, **projection)
    limits = frame(scenes)
    axes.set(**limits)
    axes.plot(*path.T, color=style.COLOURS[5], lw=1.4)
    for n in _apart(scenes):
        full = n == len(scenes) - 1
        alpha = 1.0 if full else 0.15
        if space and not full:
            continue
        for part in scenes[n].lines:
            axes.plot(*part, color="0.3", lw=2, alpha=alpha)
        for part in scenes[n].bodies:
            closed = [np.append(x, x[0]) for x in part]
            axes.plot(*closed, color="0.3", lw=1.2, alpha=alpha)
            if full and not space:
                axes.fill(*part, color=style.COLOURS[4])
            elif full:
                made = needed("mpl_toolkits.mplot3d.art3d").Poly3DCollection
                about = {"facecolor": style.COLOURS[4], "alpha": 0.75}
                axes.add_collection3d(made([np.column_stack(part)], **about), autolim=False)
        for part in scenes[n].points:
            axes.plot(*([x] for x in part), "o", color=style.COLOURS[0], ms=9, alpha=alpha)
    for part in last.fixed:
        axes.plot(*([x] for x in part), "o", color="0.5", ms=8)
    if space:
        in_space(axes, limits, last, zoom=0.78)
    else:
        axes.set(aspect="equal", xlabel=last.axes[0], ylabel=last.axes[1])
        axes.locator_params(nbins=5)
    notes = [f"t = {t[-1]:.4g} s, and before", last.note]
    axes.set_title(", ".join(filter(None, notes)), loc="left", fontsize=12)


def _smooth(result):
    """Times, scenes and the trail, at so many points that the trail is round."""
    t: Any
    scenes: Any
    path: Any
    t = scenes = path = None
    for per_step in PER_STEP:
        t, y = solution.curve(result, per_step)
        scenes = result.system.scenes(t, y)
        path = np.array([scene.traced for scene in scenes], float)
        steps = np.diff(path, axis=0)
        least = 1e-9 * max(np.ptp(path, axis=0).max(), 1e-300)
        steps = steps[np.linalg.norm(steps, axis=1) > least]
        sizes = np.linalg.norm(steps, axis=1)
        cosines = (steps[1:] * steps[:-1]).sum(axis=1) / (sizes[1:] * sizes[:-1])
        bends = np.arccos(np.clip(cosines, -1.0, 1.0))
        if not len(bends) or np.quantile(bends, 0.95) < BEND or len(t) > MOST:
            break
    return t, scenes, path


def _apart(scenes):
    """Numbers of scenes in which the system is elsewhere than in the others; the last one last."""
    tried = np.unique(np.linspace(0, len(scenes) - 1, 12 * GHOSTS).astype(int))
    places = np.array([
        np.concatenate([np.nanmean(np.array(part, float).reshape(len(part), -1), axis=1) for part in
                        (*scenes[n].bodies, *scenes[n].points, scenes[n].traced)])
        for n in tried
    ])  # fmt: skip
    chosen = [len(tried) - 1]
    off = np.linalg.norm(places - places[-1], axis=1)
    least = NEAR * off.max()
    while len(chosen) < GHOSTS and off.max() > least:
        chosen.append(int(np.argmax(off)))
        off = np.minimum(off, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return tried[np.sort(chosen)]


def _words(name):
    """A quantity in words; the N of `friction_N` is a force, and no newton."""
    of, _, reaction = name.partition("_")
    if of in ("friction", "slip") and reaction:
        return f"{of}, contact {letters(reaction)}"
    return letters(name).replace("_", " ")
