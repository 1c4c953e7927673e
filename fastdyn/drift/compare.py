"""Drift of several methods side by side, at equal work or in equal time."""

from __future__ import annotations

import pathlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from fastdyn.kernels.methods import METHODS
from fastdyn.plot.displayed import display

from .energy import energy_drift

if TYPE_CHECKING:
    from fastdyn.problem import argument_types as types

PILOT_STEPS = 40  # of the first pilot, which is repeated with more steps below PILOT_SECONDS
PILOT_SECONDS = 0.02  # least time of a pilot that measures time
ROUNDS = 8  # iterations of the search for the step with the wanted cost of a period


class Comparison(dict):
    """Studies by label; prints as a table."""

    def __str__(self):
        from .study import table

        return table(self)

    def __repr__(self):
        return f"<Comparison: {', '.join(self)}>"

    def _repr_html_(self):
        return display(self)

    def plot(self, **options):
        """Draw all studies in one figure: see `plot.studies.plot_studies`."""
        from fastdyn.plot.studies import plot_studies

        return plot_studies(self, **options)


def compare_drift(
    system: Any,
    methods: Iterable[str],
    *,
    evaluations: float | None = None,
    seconds: float | None = None,
    periods: float,
    progress: bool = False,
    checkpoint: types.Path | None = None,
    **options: Any,
) -> Comparison:
    """
    Follow the invariants of a system with several methods, at equal work or in equal time.

    Parameters
    ----------
    system : System, callable or pair of callables
        As for `energy_drift`; functions come with `period`.
    methods : iterable of str
        Names of methods with constant steps.
    evaluations : float, optional
        Evaluations of the right-hand side in a period, equal for all methods, which determines the
        steps.
    seconds : float, optional
        Instead, the time of a period on this machine, evaluations of the invariants included.  The
        steps follow from the time of a step in short runs of compiled code; the table shows the
        time of the whole run.
    periods : float
        Length of the run, in periods of the system.
    checkpoint : str or path, optional
        As for `energy_drift`, with the method appended to the name of the file; not with
        `seconds`, because measured steps differ from run to run.
    progress, **options
        As for `energy_drift`.

    Returns
    -------
    Comparison
        A dict of Study by method, with ``plot()``; prints as a table.
    """
    if (evaluations is None) == (seconds is None):
        raise ValueError("give `evaluations` or `seconds`: what is the same for all methods?")
    if seconds is not None:
        if checkpoint is not None:
            raise ValueError("`checkpoint` needs the same steps again; `seconds` measures them.")
        options.setdefault("compile", "inlined")  # the timed kernel is the kernel of the run
    found = Comparison()
    for name in methods:
        method = METHODS.get(name)
        if method is None or method.error_order:
            raise ValueError(f"`{name}` has no constant steps, so its work cannot be chosen.")
        pilot = _Pilot(system, name, options)
        if evaluations is not None:
            first = evaluations / (method.n_stages or method.cost)
            steps = pilot.steps(evaluations, pilot.evaluations, first)
        else:
            steps = pilot.steps(seconds, pilot.seconds, PILOT_STEPS)
        if checkpoint is not None:
            file = pathlib.Path(checkpoint)
            options["checkpoint"] = file.with_stem(f"{file.stem}-{name}")
        found[name] = energy_drift(
            system, name, steps_per_period=steps, periods=periods, progress=progress, **options
        )
    return found


class _Pilot:
    """Short runs that measure the cost of a step of a method."""

    def __init__(self, system, name, options):
        self._system, self._name = system, name
        self._options = {**options, "samples": 1, "checkpoint": None}
        self._n_steps = PILOT_STEPS

    def _run(self, steps):
        return energy_drift(
            self._system, self._name, steps_per_period=steps, n_steps=self._n_steps,
            **self._options,
        )  # fmt: skip

    def evaluations(self, steps):
        """The evaluations of a step; None if the equations of the step cannot be solved."""
        study = self._run(steps)
        return None if study.message else (study.nfev - 1) / study.n_steps

    def seconds(self, steps):
        """The shortest of three times of a step, s; None if its equations cannot be solved."""
        study = self._run(steps)
        while not study.message and study.seconds < PILOT_SECONDS:
            self._n_steps *= 4
            study = self._run(steps)
        times = [study.seconds, *(self._run(steps).seconds for _ in range(2))]
        return None if study.message else min(times) / study.n_steps

    def steps(self, whole, cost, steps):
        """The number of steps in a period with the total cost `whole`, by iteration.

        The number must be iterated, because the cost of a step depends on the step size.
        """
        fewest = 0.0
        for _ in range(ROUNDS):
            one = cost(steps)
            if one is None:
                fewest = max(fewest, 2.0 * steps)
            steps = fewest if one is None else max(whole / one, fewest)
        return steps
