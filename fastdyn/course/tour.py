"""
The tour: the course's lessons replayed, each number beside the exact one.

`run` goes through the systems in order. A system's lesson is the function `lesson` in the file
``lessons/<name>.py``; a system without one gets `standard_lesson`, so that a new system
is on the tour from its first day. A lesson is given a `Board` and writes everything there.
"""

import contextlib
import importlib
import importlib.util
import textwrap
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fastdyn import plot
from fastdyn.systems import SYSTEMS

from . import derived
from .tolerances import TIGHT, tolerated


class Check(NamedTuple):
    """One row of the table; it passes if the difference is within the tolerance."""

    quantity: str
    computed: float
    exact: float
    tolerance: float

    @property
    def difference(self):
        return self.computed - self.exact

    @property
    def passes(self):
        return bool(abs(self.difference) <= self.tolerance)  # False for NaN

    def __str__(self):
        verdict = "ok" if self.passes else "FAILS"
        numbers = f"{self.computed:>14.8g} {self.exact:>14.8g} {self.difference:>10.1e}"
        return f"  {self.quantity:<46} {numbers} {self.tolerance:>9.1e}  {verdict}"


class Board:
    """
    What a tour has said, checked and drawn so far.

    Text goes to `write` line by line, figures to `folder`, made when it is not there.
    """

    HEAD = f"  {'quantity':<46} {'computed':>14} {'exact':>14} {'difference':>10} {'tolerance':>9}"

    def __init__(self, folder, write=print):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.write = write
        self.checks = []
        self.figures = []
        self.sections = []  # (heading, figures)
        self._in_table = False

    def heading(self, text):
        """Begin a lesson."""
        self.sections.append((text, []))
        self.write("")
        self.write(text)
        self.write("=" * len(text))
        self._in_table = False

    def say(self, text):
        """Explain what comes next, wrapped to the width of the table."""
        self.write("")
        for line in textwrap.wrap(" ".join(text.split()), 98):
            self.write(line)
        self.write("")
        self._in_table = False

    def check(self, quantity, computed, exact, tolerance):
        """Write and count one row; `tolerance` is the largest difference that passes."""
        if not self._in_table:
            self.write(self.HEAD)
            self._in_table = True
        row = Check(quantity, float(computed), float(exact), float(tolerance))
        self.checks.append(row)
        self.write(str(row))

    def zero(self, quantity, values, tolerance):
        """Check that the largest of an array's absolute values is within the tolerance."""
        self.check(quantity, np.abs(values).max(), 0.0, tolerance)

    def table(self, first, heads, rows):
        """Write a table: the head of its first column, the others, and {name: cells}."""
        width = max(map(len, [first, *rows])) + 2
        self.write("  " + f"{first:<{width}}" + "".join(f"{head:>14}" for head in heads))
        for name, cells in rows.items():
            self.write("  " + f"{name:<{width}}" + "".join(f"{cell:>14}" for cell in cells))
        self.write("")
        self._in_table = False

    @contextlib.contextmanager
    def panel(self, name, figsize):
        """Axes to draw in, one pair; their figure gets a legend and is saved."""
        with plot.slides():
            figure, (axes,) = plot.column(1, figsize=figsize)
            yield axes
            plot.legend(figure, axes)
        self.figure(name, figure)

    def figure(self, name, figure):
        """Save a figure in the folder under a name without ending, and close it."""
        path = self.folder / f"{name}.png"
        plot.save(figure, path)
        self.figures.append(path)
        if self.sections:
            self.sections[-1][1].append(path)

    @property
    def n_failed(self):
        """Number of checks that did not pass."""
        return sum(not row.passes for row in self.checks)


def run(folder="fastdyn-tour", names=None, write=print):
    """
    Go through the lessons of the named systems, all unless given; returns the `Board`.

    `folder` and `write` are those of the board.
    """
    begin = time.perf_counter()
    board = Board(folder, write)
    for name in names or SYSTEMS:
        board.heading(SYSTEMS[name].title)
        lesson_of(name)(board)
        derived.compare(board, SYSTEMS[name]())
    seconds = time.perf_counter() - begin
    n_passed = len(board.checks) - board.n_failed
    write("")
    write(f"{n_passed} of {len(board.checks)} checks passed in {seconds:.1f} s.")
    for row in board.checks:
        if not row.passes:
            write(f"FAILED: {row.quantity}: {row.computed:.10g} instead of {row.exact:.10g}")
    write(f"{len(board.figures)} figures in {board.folder}:")
    for path in board.figures:
        write(f"  {path.name}")
    return board


def lesson_of(name):
    """Function that tells a system's lesson to a board."""
    module = f"fastdyn.course.lessons.{name}"
    if importlib.util.find_spec(module) is None:
        return lambda board: standard_lesson(board, SYSTEMS[name]())
    return importlib.import_module(module).lesson


def standard_lesson(board, system):
    """Solve a system with its defaults; compare with what it knows of itself, and draw it."""
    result = system.solve(**TIGHT, dense_output=True)
    board.check("status of the run", result.status, 0, 0)
    allowed = tolerated(result)
    for name, change in plot.relative_changes(result).items():
        board.zero(f"relative change of {name}", change, allowed)
    with contextlib.suppress(ValueError):  # no exact solution
        board.zero("largest error of the state", result.error(), allowed)
    board.figure(system.name, result.plot())
