"""An exploration: a system with its values, one or two ways to solve it, and the results."""

import copy
import dataclasses
import time
from typing import Any

import numpy as np

from fastdyn.kernels.methods import METHODS
from fastdyn.plot.chords import times
from fastdyn.plot.scene import frame
from fastdyn.plot.solution import between
from fastdyn.problem.options.table import OPTIONS

from .sliders import slider

POINTS = 500  # points of the curve of an invariant, two for each bin
COARSE = 25  # scenes from which the frame of the picture is found, beside the extremes
MOST_STEPS = 100_000  # most steps of a solve, so that no slider makes a page wait
HAND = 5  # digits of a place that a hand chose: more than pixels
GROUND = "ground"  # the event at which a run ends


@dataclasses.dataclass
class Way:
    """A method and its accuracy: `rtol` for an adaptive method, otherwise `step`."""

    method: str = "RK45"
    rtol: float = OPTIONS["rtol"].of["systems"]
    step: float = 0.01

    @property
    def adaptive(self):
        return bool(METHODS[self.method].error_order)

    def options(self):
        """The options of `System.solve`."""
        if self.adaptive:
            return {"rtol": self.rtol, "atol": 1e-3 * self.rtol}
        return {"step": self.step}

    def __str__(self):
        accuracy = f"rtol {self.rtol:.0e}" if self.adaptive else f"h = {self.step:g} s"
        return f"{self.method}, {accuracy}"


@dataclasses.dataclass
class Shown:
    """The results of a solve that a page shows: curves against `t`, and numbers."""

    label: str
    run: Any
    t: np.ndarray
    y: np.ndarray
    kept_t: np.ndarray
    kept: np.ndarray
    kept_name: str
    seconds: float

    def numbers(self):
        """(name, value) of the numbers of a run."""
        found = {"steps": f"{self.run.n_accepted}", "evaluations": f"{self.run.nfev}"}
        found["time of the solve"] = f"{1e3 * self.seconds:.2f} ms"
        if len(self.kept):
            found[f"largest {self.kept_name}"] = f"{np.abs(self.kept).max():.2e}"
        if self.run.status != 0:
            found["end"] = str(self.run.message)
        return found


class Exploration:
    """
    A system with values that can be changed.

    Parameters
    ----------
    source : Source

    Attributes
    ----------
    sliders : list of Slider
    values : dict of str to Any
        The values of the fields of the system.
    y0 : list of float or None
        A start that was dragged by hand; None for the start from the fields.
    t_end : float
    ways : list of Way
        One way, or two ways to compare.
    project : bool
        Whether the constraints are held by projection.
    shown : list of Shown
        The results of the last `solve`.
    """

    def __init__(self, source):
        self.source = source
        self.make = source.make
        fields = dataclasses.fields(source.make)
        self.values = {one.name: source.values.get(one.name, one.default) for one in fields}
        numbers = [one for one in fields if "unit" in one.metadata]
        self.sliders = [slider(one, float(self.values[one.name])) for one in numbers]
        self.choices = {name: dict(known) for name, known in source.make.choices.items() if known}
        self.y0: list | None = None
        self.t_end = float(source.make.t_end)
        self.ways = [Way()]
        self.project = False
        self.shown: list[Shown] = []
        self._warm: set = set()  # shared by the copies
        n = len(source.make.states)
        self.across = 0
        self.upwards = n // 2 if n > 1 else 0

    def copied(self):
        """The exploration as it is now, which further changes leave alone."""
        found = copy.copy(self)
        found.values, found.ways = dict(self.values), [copy.copy(way) for way in self.ways]
        return found

    @property
    def system(self) -> Any:
        """The system with its present values."""
        return self.make(**self.values)

    @property
    def kept(self):
        """(name, function) of the first invariant, or else of the first constraint."""
        for group in (self.make.invariants, self.make.constraints):
            for name, function in group.items():
                return name, function
        return None

    def start(self):
        """The state at the beginning."""
        return list(self.y0) if self.y0 is not None else list(self.system.initial_state())

    def drag(self, x, y):
        """Move the start to a point of the phase plane, in round numbers."""
        y0 = self.start()
        for i, value in ((self.upwards, y), (self.across, x)):
            y0[i] = float(f"{value:.{HAND}g}")
        self.y0 = y0

    def new_methods(self):
        """Names of the methods with which this kind of system was not solved before."""
        return [way.method for way in self.ways if self._kind(way) not in self._warm]

    def solve(self):
        """
        Solve in each way, and put the results into `shown`.

        Raises
        ------
        ValueError, TypeError, ArithmeticError
            With a sentence about the mistake; `shown` is unchanged.
        """
        system = self.system
        self.shown = [self._shown(system, way) for way in self.ways]

    def arguments(self, way):
        """The arguments of `System.solve`, but for output."""
        options: dict[str, Any] = {"method": way.method} | way.options()
        if self.y0 is not None:
            options["y0"] = list(self.y0)
        if GROUND in self.make.events:
            options["events"] = GROUND
        if self.project:
            options["project"] = True
        return options

    def _solved(self, system, way):
        # Warnings go to the terminal: pages solve in threads, where filters cannot be changed.
        return system.solve(
            (0.0, self.t_end), **self.arguments(way), dense_output=True, max_steps=MOST_STEPS
        )

    def _kind(self, way):
        """Solves of one kind run the same compiled code."""
        chosen = tuple(id(self.values[name]) for name in self.choices)
        return way.method, self.project, chosen

    def _shown(self, system, way):
        kind = self._kind(way)
        if kind not in self._warm:
            self._solved(system, way)  # compiles, so that the next solve can be timed
            self._warm.add(kind)
        begun = time.thread_time()  # other work of the machine, and of the page, does not count
        run = self._solved(system, way)
        seconds = time.thread_time() - begun
        if len(run.t) < 2 or not np.isfinite(run.y).all():
            raise ValueError(f"{way.method} found no solution: {run.message}")
        sol: Any = between(run)
        t = times(sol, run.t)
        every = max(1, len(run.t) // (2 * POINTS))
        kept_t = run.t[::every]
        kept_y = run.y[:, ::every]
        change = np.array([])
        name = ""
        if self.kept:
            name = f"change of {self.kept[1].label}"
            change = system.along(self.kept[1], kept_t, kept_y)
            if change[0]:
                name += " (relative)"
            change = (change - change[0]) / (abs(change[0]) or 1.0)
        return Shown(str(way), run, t, sol(t), kept_t, change, name, seconds)

    def stage(self):
        """The limits of the axes, and ``show(time, way)``, which returns a `Scene`; None without
        a view."""
        first = self.shown[0]
        system = first.run.system
        low = first.y.argmin(axis=1)
        high = first.y.argmax(axis=1)
        even = np.linspace(0, len(first.t) - 1, COARSE).astype(int)
        some = np.unique(np.concatenate([low, high, even]))
        t = first.t[some]
        y = first.y[:, some]
        try:
            scene = system.stage(t, y)
            limits = frame([scene(time, state) for time, state in zip(t, y.T, strict=True)])
        except ValueError:
            return None

        ways = [(between(one.run), one.t[-1]) for one in self.shown]

        def show(time, way=0):
            sol, end = ways[way]
            return scene(min(time, end), sol(min(time, end)))

        return limits, show
