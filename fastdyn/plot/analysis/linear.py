"""Eigenvalues in the complex plane, and the shapes of modes."""

import itertools

import numpy as np

from fastdyn.plot import style

MOST_MODES = 6  # whose shapes are drawn
STABLE = "#eaf3ee"


def figure(linearisation, **options):
    """Eigenvalues beside the shapes of the modes."""
    one = linearisation
    modes = linearisation.modes[:MOST_MODES]
    with style.slides():
        size = {"figsize": (13, 1.9 + 1.35 * max(3, len(modes)))}
        drawing = style.new_figure(**size | options)
        grid = drawing.add_gridspec(max(1, len(modes)), 2)
        plane = drawing.add_subplot(grid[:, 0])
        marks = [(mode.eigenvalue, colour) for mode, colour in zip(modes, _colours(), strict=False)]
        for value, colour in marks:
            for each in {value, value.conjugate()}:
                plane.plot(each.real, each.imag, "o", ms=10, color=colour)
        _complex_plane(plane, [value for value, _ in marks])
        plane.set_title(f"eigenvalues: {one.title}")
        labels = [label.name for label in one.equations.labels(len(one.y))]
        for row, (mode, colour) in enumerate(zip(modes, _colours(), strict=False)):
            _shape(drawing.add_subplot(grid[row, 1]), mode, labels, colour)
    return drawing


def _colours():
    return itertools.cycle(style.COLOURS)


def _shape(axes, mode, labels, colour):
    """The components of a mode as bars; the part a quarter of a period later is paler."""
    n = len(labels)
    half = n // 2
    oscillators = n == 2 * half and np.allclose(
        mode.shape[half:], mode.eigenvalue * mode.shape[:half], atol=1e-9 * abs(mode.shape).max()
    )
    shown = half if oscillators and half else n
    shape = mode.shape[:shown]
    places = np.arange(shown)
    later = np.abs(shape.imag).max() > 1e-9 * np.abs(shape).max()
    axes.bar(places - 0.16 * later, shape.real, 0.3, color=colour)
    if later:
        axes.bar(places + 0.16, shape.imag, 0.3, color=colour, alpha=0.4)
    axes.axhline(0.0, color="0.3", lw=1.0)
    axes.set_xticks(places, labels[:shown])
    axes.grid(visible=False, axis="x")
    axes.set_yticks([-1, 0, 1])
    axes.set(ylim=(-1.25, 1.25), xlim=(-0.6, shown - 0.4))
    axes.set_title(_about(mode), loc="left", fontsize=13)


def _about(one):
    value = one.eigenvalue
    if not one.oscillates:
        return f"{one.name}, {value.real:+.4g}"
    damping = f", damping ratio {one.damping_ratio:.3g}" if value.real else ""
    return f"{one.name}\nω = {one.frequency:.4g}{damping}"


def eigenvalues(equilibria, **options):
    """The eigenvalues of several equilibria in one plane."""
    with style.slides():
        drawing, plane = style.single(**{"figsize": (9, 7.2)} | options)
        found = list(equilibria)
        for one, colour in zip(found, _colours(), strict=False):
            place = ", ".join(f"{round(value, 9) + 0.0:.3g}" for value in one.y)
            values = one.eigenvalues
            plane.plot(
                values.real, values.imag, "o", ms=10, color=colour, label=f"{one.title} ({place})"
            )
        _complex_plane(plane, np.concatenate([one.eigenvalues for one in found] or [[0.0]]))
        if found:
            style.legend(drawing, plane)
        else:
            plane.set_title("no equilibrium")
    return drawing


def roots(found, **options):
    """The characteristic roots of a delay equation."""
    with style.slides():
        drawing, plane = style.single(**{"figsize": (9, 7.2)} | options)
        plane.plot(found.roots.real, found.roots.imag, "o", ms=10)
        _complex_plane(plane, found.roots)
        plane.set_title(f"characteristic roots: {found.kind}")
    return drawing


def _complex_plane(axes, values):
    """Axes through zero, the stable half shaded, all values inside."""
    values = np.asarray(values, complex)
    values = values[np.isfinite(values)] if np.isfinite(values).any() else np.zeros(1)
    parts = np.real(values), np.imag(values)
    reach = [1.25 * max(np.abs(part).max(), 0.12 * np.abs(values).max(), 1e-9)
             for part in parts]  # fmt: skip
    axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]))
    axes.axvspan(-reach[0], 0.0, color=STABLE, zorder=0)
    axes.axhline(0.0, color="0.5", lw=1.0)
    axes.axvline(0.0, color="0.5", lw=1.0)
    axes.text(0.02, 0.02, "decays", transform=axes.transAxes, color="0.45", fontsize=12)
    axes.text(0.98, 0.02, "grows", transform=axes.transAxes, color="0.45", fontsize=12, ha="right")
    axes.set(xlabel="real part (growth)", ylabel="imaginary part (angular frequency)")
