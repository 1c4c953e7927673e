"""The figures of the pendulums: by angle, on the circle, and on a cable that goes slack."""

import math

import numpy as np

from . import solution, style
from .scene import Scene

DOTS = 220  # dots of the exact solution, far enough apart to show the computed line


def by_angle(results, **options):
    """The computed and the exact angle, in parts of pi, and the tension, against time."""
    with style.slides():
        figure, (angle, force) = style.column(2, **options)
        for label, result in results.items():
            t, y = solution.curve(result)
            system = result.system
            angle.plot(t, y[0], label=label)
            force.plot(t, system.along(system.quantities["tension"], t, y))
            exact = solution.exact_curve(system, t)[0]
            angle.plot(t, exact, "k--", lw=1.2, label="exact", zorder=3)
        angle.set_ylabel("angle θ (rad)")
        style.in_pi(angle.yaxis)
        bottom_edge = min(force.get_ylim()[0], 0.0)
        force.axhspan(bottom_edge, 0.0, color="0.88", zorder=0, label="R < 0: a cable is slack")
        style.legend(figure, angle, force)
        force.set(xlabel="t (s)", ylabel="cable tension R (N)")
        force.set_ylim(bottom=bottom_edge)
    return figure


def small_angle(pendulum, t):
    """
    The solution for small angles beside the exact solution of a `Pendulum`.

    Returns figure and axes; the lower axes are empty, for further curves over w0 t.
    """
    with style.slides():
        figure, (angle, below) = style.column(2, figsize=(11, 8.5), sharex=False)
        phase = pendulum.natural_frequency * t
        degrees = math.degrees(pendulum.largest_angle)
        angle.plot(
            phase, np.degrees(pendulum.exact(t)[0]), label=f"exact, amplitude {degrees:.0f}°"
        )
        angle.plot(
            phase, np.degrees(pendulum.small_angle(t)[0]), "k--", lw=1.4, label="small angles"
        )
        angle.set(xlabel="ω₀ t (rad)", ylabel="angle θ (°)")
        style.in_pi(angle.xaxis)
        style.own_legend(angle)
    return figure, below


def on_circle(results, length, **options):
    """x and y of the first result, computed and exact, its tension; distances from the circle."""
    with style.slides():
        figure, (place, force, off) = style.column(3, **{"figsize": (12, 8.5)} | options)
        first = next(iter(results.values()))
        t, y = solution.curve(first)
        system = first.system
        dots = np.linspace(t[0], t[-1], DOTS)
        exact = solution.exact_curve(system, dots)
        for i, name in enumerate("xy"):
            label = f"{name}, {'downwards' if i else 'sideways'}"
            place.plot(t, y[i], lw=1.6, color=style.COLOURS[4 + i], label=label)
            if not np.isnan(exact).any():
                place.plot(dots, exact[i], "k.", ms=3, label=None if i == 0 else "exact")
        pull = system.along(system.quantities["tension"], t, y)
        force.plot(t, pull, color="0.3", lw=1.6)
        for label, result in results.items():
            distance = style.sizes(result.residuals()["circle"])
            off.semilogy(result.t, distance, lw=1.6, label=label)
        place.set_ylabel("position (m)")
        force.set_ylabel("cable tension R (N)")
        off.set(ylabel="distance from\nthe circle (m)", xlabel="t (s)")
        style.own_legend(place)
        if len(results) > 1:
            style.own_legend(off)
    return figure


def cable(results, length, **options):
    """Paths, and tension and slack against time."""

    def slack(result, t, y):
        system = result.system
        return t, system.l - system.along(system.quantities["distance"], t, y)

    return _paths(results, length, slack, {"ylabel": "slack of the cable (m)"}, options)


def _paths(results, length, last, labels, options):
    """Paths in the plane with the circle; tension, none in a flight, and `last` against time."""
    with style.slides():
        figure, (path,), (force, off) = style.pictures_and_panels(1, 2, **options)
        around = np.linspace(0.0, 2.0 * np.pi, 361)
        path.plot(length * np.sin(around), length * np.cos(around), color="0.8", lw=1.2)
        style.at_equal_scales(path, ylabel="y (m), downwards")
        path.invert_yaxis()
        force.set_ylabel("cable tension R (N)")
        widths = np.linspace(5.0 if len(results) > 1 else 2.0, 2.0, len(results))
        for (label, result), width in zip(results.items(), widths, strict=True):
            t, y = solution.curve(result)
            system = result.system
            path.plot(*y[:2], label=label, lw=width)  # the last line hides no other line
            pull = system.along(system.quantities["tension"], t, y)
            pull[in_flight(t, result.get("phases", ()))] = 0.0
            force.plot(t, pull, label=label)
            off.plot(*last(result, t, y), label=label)
        path.plot(0.0, 0.0, "o", color="0.4", ms=8, label="pivot")
        off.set(xlabel="t (s)", **labels)
        style.legend(figure, path)
    return figure


def in_flight(t, phases):
    """
    Whether each time belongs to a flight.

    Parameters
    ----------
    t : ndarray, shape (n_points,)
        Times. A flight contains its end, but not its start.
    phases : list of (str, float, float)
        Name, start and end of each phase.

    Returns
    -------
    ndarray of bool, shape (n_points,)
    """
    flying = np.zeros(len(t), bool)
    for name, begin, end in phases:
        if name == "flight":
            flying |= (t != begin) & ((t - begin) * (end - t) >= 0.0)
    return flying


def scene(length, w):
    """The cable and the mass, for moving pictures; a slack cable is bent."""
    x = w[0]
    y = -w[1]
    r = math.hypot(x, y)
    sag = 0.5 * math.sqrt(max(length * length - r * r, 0.0)) if r < 0.999 * length else 0.0
    line = ([0.0, 0.5 * x, x], [0.0, 0.5 * y - sag, y])
    reach = 1.1 * length
    frame = ((-reach, -reach), (reach, reach))
    return Scene([line], [(x, y)], [(0.0, 0.0)], frame=frame)
