"""Periodic orbits, branches of them over a parameter, frequency responses."""

import math

import numpy as np

from fastdyn.plot import style
from fastdyn.words.letters import letters

from .chaos import indices

MARKS = {"fold": "D", "period doubling": "^", "branch point": "s", "torus": "o"}
SWEEPS = {"exact": "-", "up": "-", "down": (0, (4, 3))}


def figure(orbit, components, **options):
    """The orbit in a plane, beside its multipliers and the unit circle."""
    labels = orbit.equations.labels(len(orbit.y0))
    with style.slides():
        size = {"figsize": (13, 6.3)}
        drawing, (plane, circle) = style.row(2, **size | options)
        if len(labels) > 1:
            i, j = indices(labels, components)
            (line,) = plane.plot(orbit.y[i], orbit.y[j], lw=2.2)
            at = len(orbit.t) // 3
            head = {"arrowstyle": "-|>", "color": line.get_color(), "mutation_scale": 24, "lw": 0}
            plane.annotate(
                "", xy=orbit.y[[i, j], at], xytext=orbit.y[[i, j], at - 1], arrowprops=head
            )
            plane.set(xlabel=style.named(labels[i]), ylabel=style.named(labels[j]))
        else:
            plane.plot(orbit.t, orbit.y[0], lw=2.2)
            plane.set(xlabel="t", ylabel=style.named(labels[0]))
        plane.margins(0.12)
        plane.set_title(f"period {orbit.period:.8g}")
        turn = np.linspace(0.0, 2.0 * math.pi, 361)
        circle.plot(np.cos(turn), np.sin(turn), color="0.5", lw=1.2)
        circle.fill(np.cos(turn), np.sin(turn), color="#eaf3ee", zorder=0)
        values = orbit.multipliers
        circle.plot(values.real, values.imag, "o", ms=10, color=style.COLOURS[1])
        reach = 1.2 * max(1.0, np.abs(values).max())
        circle.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        circle.set(xlabel="real part", ylabel="imaginary part")
        stable = {True: "stable", False: "unstable", None: "neither stable nor unstable"}
        circle.set_title(f"Floquet multipliers: {stable[orbit.stable]}")
    return drawing


def branch(result, component, **options):
    """Amplitude of a component, and the period, over the parameter."""
    labels = result.orbits[0].equations.labels(len(result.orbits[0].y0))
    (k,) = indices(labels, component)
    size = {"figsize": (10.5, 8.2)}
    with style.slides():
        drawing, (above, below) = style.column(2, **size | options)
        rows = ((above, result.amplitudes[k]), (below, result.periods))
        for axes, values in rows:
            _by_stability(axes, result.values, values, result.stable)
        for special in result.special:
            mark = {"marker": MARKS[special.kind], "ls": "", "ms": 10, "mfc": "white", "mec": "k",
                    "mew": 1.8, "zorder": 5}  # fmt: skip
            label = f"{special.kind}, {special.value:.6g}"
            above.plot(special.value, special.orbit.amplitude[k], label=label, **mark)
            below.plot(special.value, special.orbit.period, **mark)
        above.set_ylabel(f"amplitude of\n{style.named(labels[k])}")
        below.set(xlabel=style.with_unit(letters(result.parameter), result.unit), ylabel="period")
        above.set_ylim(bottom=0.0)
        style.legend(drawing, above)
    return drawing


def _by_stability(axes, x, y, stable):
    """A line, dashed where orbits are not stable."""
    begin = 0
    named = set()
    for end in [*(np.flatnonzero(np.diff(stable.astype(int))) + 1), len(x)]:
        what = bool(stable[begin])
        part = slice(max(begin - 1, 0) if not what else begin, end + (not what))
        label = None if what in named else ("stable" if what else "unstable")
        axes.plot(x[part], y[part], "-" if what else "--", color=style.COLOURS[0 if what else 1],
                  lw=2.4 if what else 1.8, label=label)  # fmt: skip
        named.add(what)
        begin = end


def response(result, components, **options):
    """Amplitude on a logarithmic axis, and phase, over the frequency."""
    first = next(iter(result.sweeps.values()))
    labels = result.equations.labels(len(first.amplitude))
    half = range(max(1, len(labels) // 2))
    shown = list(half) if components is None else indices(labels, components)
    size = {"figsize": (10.5, 8.2)}
    with style.slides():
        drawing, (above, below) = style.column(2, **size | options)
        for name, sweep in result.sweeps.items():
            for k in shown:
                colour = style.COLOURS[(k + len(shown) * (name == "down")) % 6]
                what = letters(labels[k].name)
                label = what if name == "exact" else f"{what}, sweep {name}"
                look = {"color": colour, "ls": SWEEPS[name], "label": label}
                if len(result.frequencies) < 20:
                    look["marker"] = "o"
                above.plot(result.frequencies, sweep.amplitude[k], **look)
                below.plot(result.frequencies, _unwrapped(sweep.phase[k]), **look)
        above.set(yscale="log", ylabel="amplitude")
        if len({labels[k].unit for k in shown}) == 1 and labels[shown[0]].unit:
            above.set_ylabel(f"amplitude ({labels[shown[0]].unit})")
        below.set(xlabel="angular frequency", ylabel=f"phase before {result.reference} ωt (rad)")
        style.in_pi(below.yaxis)
        style.legend(drawing, above)
    return drawing


def _unwrapped(phase):
    """A phase without jumps by whole turns, gaps left as they are."""
    found = phase.copy()
    known = np.isfinite(phase)
    found[known] = np.unwrap(phase[known])
    return found
