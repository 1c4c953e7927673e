"""The files that an exploration exports: a script, a table and a figure."""

import io
from typing import Any

import numpy as np

from fastdyn.plot.solution import between
from fastdyn.words import numbers

ROWS = 501  # of a table
HEAD = '"""{title}, as it was explored."""\n\n'


def script(exploration):
    """The few lines of Python that make the figure, as a text."""
    source = exploration.source
    name = exploration.source.name
    defaults = type(exploration.system)()
    given = []
    for key, value in exploration.values.items():
        if value is getattr(defaults, key) or _equal(value, getattr(defaults, key)):
            continue
        chosen = exploration.choices.get(key, {})
        for choice, known in chosen.items():
            if known is value:
                given.append(f'{key}={name}.choices["{key}"]["{choice}"]')
                break
        else:
            given.append(f"{key}={numbers.source(value)}")
    lines = [*source.lines, "", f"system = {name}({', '.join(given)})"]
    labels = [str(way) for way in exploration.ways]
    if len(set(labels)) > 1:
        lines[0:0] = ["from fastdyn import plot"]
        lines += ["runs = {"]
        for label, way in zip(labels, exploration.ways, strict=True):
            lines.append(f'    "{label}": {_solve(exploration, way)},')
        lines += ["}", "figure = plot.plot(runs)"]
    else:
        lines += [f"run = {_solve(exploration, exploration.ways[0])}", "figure = run.plot()"]
    lines += [f'figure.savefig("{name}.png")']
    return HEAD.format(title=exploration.make.title) + "\n".join(lines) + "\n"


def _equal(a, b):
    return isinstance(a, float | int) and isinstance(b, float | int) and a == b


def _solve(exploration, way):
    options = ", ".join(
        f"{key}={numbers.source(value)}" for key, value in exploration.arguments(way).items()
    )
    return f"system.solve((0.0, {numbers.source(exploration.t_end)}), {options})"


def table(exploration):
    """Time and state of the first way at equal distances in time, as text with commas."""
    run = exploration.shown[0].run
    t = np.linspace(run.t[0], run.t[-1], ROWS)
    sol: Any = between(run)
    names = [f"{one.name} ({one.unit})" for one in exploration.make.states]
    return numbers.table({"t (s)": t} | dict(zip(names, sol(t), strict=True)), grid=["t (s)"])


def picture(exploration):
    """The figure of the system, as PNG."""
    from fastdyn import plot
    from fastdyn.plot.needed import needed

    drawn = plot.plot({one.label: one.run for one in exploration.shown})
    file = io.BytesIO()
    drawn.savefig(file, format="png")
    needed("matplotlib.pyplot").close(drawn)
    return file.getvalue()
