"""The figure and the scene of a drive: the path, steering, speed and forces on the wheels."""

import math

import numpy as np

from . import solution, style
from .scene import Scene

FORCES = ("front_force", "rear_force")
DASHES = ("-", (0, (4, 3)))  # dashes, because front and rear force nearly coincide
MARKS = 8  # arrows along the path
LARGER = 4.0  # scale of the car in a moving picture


def figure(results, **options):
    """Path with its direction, beside steering angle, speed and wheel forces against time."""
    with style.slides():
        size = {"figsize": (14, 8)}
        drawing, (path,), (steering, fast, force) = style.pictures_and_panels(
            1, 3, **size | options
        )
        colours = style.COLOURS[len(results) :] + style.COLOURS
        for label, result in results.items():
            t, y = solution.curve(result)
            system = result.system
            (line,) = path.plot(y[0], y[1], lw=1.6, label=label)
            _arrows(path, y, line.get_color())
            columns = zip(t, y.T, strict=True)
            angle = np.degrees([system.driver(time, state)[0] for time, state in columns])
            steering.plot(t, angle, color=line.get_color())
            fast.plot(t, system.along(system.quantities["speed"], t, y), color=line.get_color())
            for name, dashes in zip(FORCES, DASHES, strict=True):
                function = system.quantities[name]
                about = function.label if len(results) == 1 else f"{label}, {function.label}"
                values = system.along(function, t, y)
                force.plot(t, values, color=colours.pop(0), ls=dashes, lw=1.6, label=about)
        first = next(iter(results.values())).y
        path.plot(*first[:2, 0], "o", color="k", ms=9, label="start")
        style.at_equal_scales(path)
        steering.set_ylabel("steering\nangle α (°)")
        fast.set_ylabel("speed (m/s)")
        fast.set_ylim(bottom=0.0)
        force.set(xlabel="t (s)", ylabel="force (N)")
        for panel in (steering, fast):
            panel.sharex(force)
            panel.tick_params(labelbottom=False)
        style.own_legend(path)
        style.own_legend(force)
    return drawing


def _arrows(axes, y, colour):
    """Arrows along a path, in the direction of the motion, equally far apart."""
    steps = np.hypot(*np.diff(y[:2], axis=1))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if not way[-1] > 0.0:
        return
    once = min(way[-1], 3.0 * max(np.ptp(y[0]), np.ptp(y[1])))  # about the first round of a path
    for at in np.searchsorted(way, once * (np.arange(MARKS) + 0.5) / MARKS):
        ahead = min(at + 1, y.shape[1] - 1)
        if (y[:2, at] != y[:2, ahead]).any():
            head = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 22}
            axes.annotate("", xy=y[:2, ahead], xytext=y[:2, at], arrowprops=head)


def scene(system, t, w):
    """The car from above, LARGER times its size: body, mass and both wheels."""
    x, y, th = w[:3]
    alpha, _, _ = system.driver(t, w)
    size = LARGER * system.L
    middle = np.array([x, y])
    along, across = _axes(th)
    body = [middle + a * along + b * across for a, b in _BODY * size]
    lines = [tuple(np.array([middle - 0.5 * size * along, middle + 0.5 * size * along]).T)]
    for place, angle in ((-0.5, th), (0.5, th + alpha)):
        centre = middle + place * size * along
        rolling = _axes(angle)[0]
        wheel = [centre - 0.17 * size * rolling, centre + 0.17 * size * rolling]
        lines.append(tuple(np.array(wheel).T))
    note = f"car drawn {LARGER:g} times its size"
    return Scene(lines, [(x, y)], [], bodies=[tuple(np.array(body).T)], note=note)


_BODY = np.array([[-0.65, -0.22], [0.45, -0.22], [0.65, 0.0], [0.45, 0.22], [-0.65, 0.22]])


def _axes(angle):
    """Unit vectors along and across a heading; the angle counts clockwise from x."""
    c = math.cos(angle)
    s = math.sin(angle)
    return np.array([c, -s]), np.array([s, c])
