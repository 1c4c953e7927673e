"""The results of a drift study: tables, figures, verdicts."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn.plot.displayed import display
from fastdyn.run.result import Ended, following

from .growth import Growth, growth
from .phase import phase


@dataclasses.dataclass
class Drift:
    """The drift of one invariant.

    Attributes
    ----------
    name : str
    start : float
        Value of the invariant at the start.
    largest, rms : float
        Largest size and root mean square of the change since the start, relative to `start`
        (absolute if `start` is 0), over all evaluations.
    mean, low, high : ndarray, shape (n_bins,)
        Mean, minimum and maximum of the change in each bin.
    growth : Growth
        Slope, exponent and verdict.
    rounding : float
        Size at the end of the part of the change that is rounding, as a random walk; NaN if that
        was not asked for, or cannot be told because the motion is chaotic.
    """

    name: str
    start: float
    largest: float
    rms: float
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    growth: Growth
    rounding: float = math.nan

    def verdict(self):
        """The growth in words, and how much of the change is rounding."""
        if not math.isfinite(self.rounding):
            return self.growth.verdict
        return f"{self.growth.verdict}, rounding {self.rounding:.1e}"


class Study:
    """
    The result of `energy_drift`.

    Attributes
    ----------
    method : str
    step : float
        0 for adaptive methods, which have `rtol`.
    rtol : float or None
    n_steps, nfev : int
    seconds, preparation : float
        Wall time of the steps, and of what came before them: tracing, compiling.
    t : ndarray, shape (n_bins,)
        Ends of the bins.
    y : ndarray, shape (n, n_bins)
        States at the ends of the bins.
    drifts : dict of str to Drift
        By the name of the invariant.
    phase : ndarray, shape (n_bins,), or None
        Time in s by which the motion is ahead of the exact motion, if that is known.
    message : str
        The reason of an early end; empty otherwise.
    """

    def __init__(self, system, problem, names, survey, times, message):
        ended = Ended.of(survey.state[0])
        n_bins = int(survey.record["i_bin"][0])
        n_looks = int(survey.record["n"][0])
        self.system = system
        self.message = message
        self.seconds, self.preparation = times
        self.method = problem.method.name
        self.step = 0.0 if problem.method.error_order else problem.h
        self.rtol = float(np.max(problem.rtol)) if problem.method.error_order else None
        self.n_steps = ended.n_accepted
        self.nfev = following(problem.method, ended)["nfev"]
        self.t = survey.t_bins[:n_bins]
        self.y = survey.y_bins[:n_bins].T
        self.drifts = {}
        for name, record, bins in zip(names, survey.invariants, survey.bins, strict=True):
            mean, low, high = bins[:, :n_bins]
            rms = math.sqrt(record["sum_sq"] / n_looks) if n_looks else 0.0
            self.drifts[name] = Drift(
                name, float(record["start"]), float(record["max"]), rms, mean, low, high,
                growth(self.t - problem.t0, mean, float(np.median(high - low)) if n_bins else 0.0),
            )  # fmt: skip
        self.phase = self._phase()

    def _phase(self):
        system = self.system
        if system is None or not len(self.t):
            return None
        try:
            system.exact(self.t)
        except ValueError:
            return None
        try:
            period = system.period
        except (AttributeError, ValueError):
            period = None
        return phase(
            system.exact, lambda t, w: system.rhs(t, w, *system.args), self.t, self.y, period
        )

    def __str__(self):
        return table({self.method: self})

    def __repr__(self):
        largest = ", ".join(f"{d.name} {d.largest:.1e}" for d in self.drifts.values())
        return f"<Study: {self.method}, {self.n_steps} steps, largest drift of {largest}>"

    def _repr_html_(self):
        return display(self)

    def plot(self, **options) -> Any:
        """Draw the drift of each invariant over time: see `plot_studies`.

        Parameters
        ----------
        **options
            Options of `plot_studies`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.studies import plot_studies

        return plot_studies({self.method: self}, **options)


SAID = 0.05  # seconds of preparation above which the table tells them
HEAD = (
    f"{'method':<22}{'invariant':<18}{'step':>12}{'steps':>11}{'evaluations':>13}{'us / time':>11}"
    f"{'largest':>10}{'rms':>10}{'exponent':>17}  verdict"
)


def table(studies):
    """Studies by label as a table: effort, size of the drift, how it grows."""
    lines = [HEAD]
    for label, study in studies.items():
        span = study.t[-1] if len(study.t) else math.nan
        step = f"{study.step:.3g}" if study.rtol is None else f"rtol {study.rtol:.0e}"
        for drift in study.drifts.values():
            g = drift.growth
            exponent = f"{'none yet':>17}"
            if math.isfinite(g.exponent):
                low, high = g.interval
                exponent = f"{g.exponent:>6.2f} ({low:.2f}-{high:.2f})"
            lines.append(
                f"{label:<22}{drift.name:<18}{step:>12}{study.n_steps:>11}{study.nfev:>13}"
                f"{study.seconds / span * 1e6:>11.3g}{drift.largest:>10.1e}{drift.rms:>10.1e}"
                f"{exponent}  {drift.verdict()}"
            )
        if study.message:
            lines.append(f"  {study.message}")
    spent = {label: s.preparation for label, s in studies.items() if s.preparation > SAID}
    if spent:
        each = ", ".join(f"{label} {seconds:.2g} s" for label, seconds in spent.items())
        lines.append(f"before the first step, to trace and to compile: {each}")
    return "\n".join(lines)
