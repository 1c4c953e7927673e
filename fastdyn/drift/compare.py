"""Drift of several methods side by side, at equal work or in equal time."""

from __future__ import annotations

import pathlib
import statistics
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.plot.displayed import display
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .energy import LENGTHS, energy_drift, length_of
from .methods import NAME, method_of
from .pilot import Pilot, is_adaptive

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Path

EPS = float(np.finfo(float).eps)


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


@shown_when_wrong(
    methods=kinds.several, evaluations=kinds.number, seconds=kinds.number, checkpoint=kinds.path
)
def compare_drift(
    system: Any,
    methods: Iterable[str],
    *,
    evaluations: float | None = None,
    seconds: float | None = None,
    progress: bool = False,
    checkpoint: Path | None = None,
    **options: Any,
) -> Comparison:
    """
    Follow the invariants of a system with several methods: at equal work, in equal time, as given.

    Parameters
    ----------
    system : System, callable or pair of callables
        As for `energy_drift`; functions come with `period`.
    methods : iterable of str
        Names of methods.
    evaluations : float, optional
        Evaluations of the right-hand side in a period, equal for all methods, which determines the
        steps, and `rtol` of adaptive methods.
    seconds : float, optional
        Instead, the time of a period on this machine, evaluations of the invariants included.  The
        steps follow from the time of a step in short runs of compiled code; the table shows the
        time of the whole run.
    checkpoint : str or path, optional
        As for `energy_drift`; the name of a method among several is appended.  Not with `seconds`,
        because measured steps differ from run to run.
    progress, **options
        As for `energy_drift`: the length of the run, and without `evaluations` and `seconds` also
        `step` or `steps_per_period`.  Adaptive methods without `rtol` then get the one with which
        their largest error is that of the other methods (the geometric mean), if there are others.

    Returns
    -------
    Comparison
        A dict of Study by method, with ``plot()``; prints as a table.

    Raises
    ------
    ValueError, TypeError
        As `energy_drift`; if `evaluations`, `seconds` and steps are given together; for
        `checkpoint` with `seconds`.
    """
    given = [options.get(name) is not None for name in ("step", "steps_per_period")]
    if sum([evaluations is not None, seconds is not None, any(given)]) > 1:
        raise ValueError("give one of `evaluations`, `seconds`, `step`, `steps_per_period`.")
    if seconds is not None:
        if checkpoint is not None:
            raise ValueError("`checkpoint` needs the same steps again; `seconds` measures them.")
        options.setdefault("compile", "inlined")  # the timed kernel is the kernel of the run
    names = list(methods)
    studies = {}
    for name in names:
        method_of(system, name)  # ValueError for an unknown one
    for name in sorted(names, key=is_adaptive):
        own = {key: value for key, value in options.items() if key != "corrector" or name == NAME}
        pilot = Pilot(system, name, own)
        if is_adaptive(name):
            for key in LENGTHS:
                own.pop(key, None)
            own["t_end"] = length_of(system, name, options)
            if own.get("rtol") is None and (
                rtol := _tolerance(pilot, evaluations, seconds, studies)
            ):
                own["rtol"] = rtol
        elif evaluations is not None:
            own["steps_per_period"] = pilot.steps(evaluations, pilot.evaluations)
        elif seconds is not None:
            own["steps_per_period"] = pilot.steps(seconds, pilot.seconds)
        if checkpoint is not None:
            file = pathlib.Path(checkpoint)
            several = len(names) > 1
            own["checkpoint"] = file.with_stem(f"{file.stem}-{name}") if several else file
        studies[name] = energy_drift(system, name, progress=progress, **own)
    return Comparison((name, studies[name]) for name in names)


def _tolerance(pilot, evaluations, seconds, studies):
    """`rtol` for the same work, or for the errors of the methods before; None if there are none."""
    if evaluations is not None:
        return pilot.tolerance(evaluations, "nfev")
    if seconds is not None:
        return pilot.tolerance(seconds, "seconds")
    errors = [max(next(iter(s.drifts.values())).largest, EPS) for s in studies.values()]
    return pilot.tolerance_of_error(statistics.geometric_mean(errors)) if errors else None
