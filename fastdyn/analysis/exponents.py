"""Lyapunov exponents: the variational equations, orthogonalised at short intervals."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn.compile.derivatives.sensitivities import decides
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.state.record import FINISHED, Y
from fastdyn.plot.displayed import Displayed
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.second_order_and_pairs import mode_for
from fastdyn.problem.sensitivities import NEEDS, check_method, directions_of, with_sensitivities
from fastdyn.run.outcome import result_of
from fastdyn.run.solve_problem import run_of
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import NotConvergedError, SystemEquations, equations_of, positive, state_of
from .flow import METHOD, Flow, OverUnit, options_of

GROWTH = 4.0  # exponent of the fastest growth or decay within an interval
LOOKS = 40  # states at which the Jacobian is evaluated, to choose the interval
FEWEST = 200  # intervals: ten for each batch
MOST_INTERVALS = 20_000_000  # half an hour of Lorenz's equations: 0.1 ms an interval
BATCHES = 20  # number of batches whose means give the error
PARTED = 5.0  # logarithm of a growth of distances that regular motion does not reach
SHOWN = 1000  # points of the running estimates


@dataclasses.dataclass(frozen=True, repr=False)
class Exponents(Displayed):
    """
    The Lyapunov exponents of a solution.

    Attributes
    ----------
    values : ndarray, shape (n,)
        Exponents, per unit of time, in decreasing order.
    errors : ndarray, shape (n,)
        `scatter`, and the distance from the mean over the second half: exponents of regular motion
        fall to 0 as log(t) / t, which the scatter alone does not show.
    scatter : ndarray, shape (n,)
        Standard errors from the scatter of means over twentieths of the time.
    t : ndarray, shape (n_points,)
        Times since the transient.
    running : ndarray, shape (n, n_points)
        The estimates of the exponents at these times, which show the convergence.
    interval : float
        Time between two orthogonalisations.
    y : ndarray, shape (n,)
        The last state.
    """

    equations: SystemEquations
    values: np.ndarray
    errors: np.ndarray
    scatter: np.ndarray
    t: np.ndarray
    running: np.ndarray
    interval: float
    y: np.ndarray

    @property
    def dimension(self):
        """The Kaplan-Yorke dimension, the number of exponents whose sum is zero, interpolated."""
        sums = np.cumsum(self.values)
        if not len(sums) or sums[0] < 0.0:
            return 0.0
        k = int(np.flatnonzero(sums >= 0.0)[-1])
        if k + 1 == len(sums):
            return float(len(sums))
        return k + 1 + float(sums[k] / abs(self.values[k + 1]))

    @property
    def chaotic(self):
        """Whether neighbours part exponentially.

        True if the largest exponent exceeds zero by more than three standard errors, and if the
        distance of neighbours grows by more than e^5 also in the second half of the time. In
        regular motion the distance grows by about 2.
        """
        half = int(np.searchsorted(self.t, 0.5 * self.t[-1]))
        parting = self.running[0] * self.t
        late = parting[-1] - parting[half]
        return bool(self.values[0] > 3.0 * self.scatter[0] and late > PARTED)

    def __str__(self):
        pairs = zip(self.values, self.errors, strict=True)
        said = ", ".join(f"{value:.5f} ± {error:.5f}" for value, error in pairs)
        return f"Lyapunov exponents after t = {self.t[-1]:g}: {said}"

    @filled()
    def plot(self, **options) -> Any:
        """Draw the exponents up to a time over this time.

        Parameters
        ----------
        {figure}
        """
        from fastdyn.plot.analysis.chaos import exponents

        return exponents(self, **options)


@filled()
@shown_when_wrong(transient=kinds.number, interval=kinds.number, method=kinds.method)
def lyapunov(
    fun, y0=None, args=(), t_end=1000.0, transient=None, interval=None, method=METHOD, **options
):
    """All Lyapunov exponents of a solution.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    y0 : array_like, shape (n,), optional
        Start at t = 0; of a system, its initial state by default.
    args : tuple
        Arguments of a function.
    t_end : float
        Time over which the exponents are averaged. Errors decrease as 1 / sqrt(t_end).
    transient : float, optional
        Time before, which does not count; a tenth of `t_end` by default.
    interval : float, optional
        Time between two orthogonalisations; chosen from the eigenvalues of the Jacobian by default.
    method, **options
        As in `solve_ivp`; by default DOP853, rtol = {rtol of lyapunov}, atol =
        {atol of lyapunov}.

    Returns
    -------
    Exponents

    Raises
    ------
    NotConvergedError
        If the solution blows up, or a solve fails.
    ValueError
        For a function that cannot be traced or differentiated, or that jumps.

    Notes
    -----
    Compiled code solves the n (n + 1) equations of the solution and its variations between QR
    decompositions (Benettin et al., Meccanica 15 (1980) 9).

    Examples
    --------
    >>> def lorenz(t, y, s, r, b):
    ...     return [s * (y[1] - y[0]), y[0] * (r - y[2]) - y[1], y[0] * y[1] - b * y[2]]
    >>> print(lyapunov(lorenz, [1, 1, 1], (10.0, 28.0, 8 / 3)))  # 0.9056, 0, -14.572
    """
    equations = equations_of(fun, args)
    y = state_of(equations, y0)
    t_end = positive(t_end, "t_end")
    transient = 0.1 * t_end if transient is None else transient
    options = options_of(lyapunov, method, options)
    derivatives = equations.differentiated(0.0, y)
    flow = Flow(equations, options)
    start = 0.0
    states = y[:, None]
    if transient:
        start = positive(transient, "transient")
        states = flow.curve(y, 0.0, start, LOOKS)[1]
        y = states[:, -1]
    if interval is None:
        fastest = max(np.abs(np.linalg.eigvals(derivatives.at(0.0, s))).max() for s in states.T)
        interval = min(GROWTH / max(fastest, 1e-300), t_end / FEWEST)
    interval = positive(interval, "interval")
    n_intervals = max(BATCHES, math.ceil(t_end / interval))
    if n_intervals > MOST_INTERVALS:
        raise ValueError(
            f"{n_intervals:.3g} intervals are too many: `interval` is too short, or, if it is not "
            f"given, the solution blows up before `t_end` = {t_end:g}."
        )
    interval = t_end / n_intervals
    n = len(y)
    frame = np.eye(len(y))
    logs = np.empty((n_intervals, n))
    try:
        advance = _advance(flow, y, interval)
        for i in range(n_intervals):
            y, columns = advance(y, frame, start + i * interval)
            frame, triangle = np.linalg.qr(columns)
            with np.errstate(divide="ignore"):
                logs[i] = np.log(np.abs(np.diagonal(triangle)))
    except (Uncompilable, GaveUp) as reason:
        raise ValueError(NEEDS.format("lyapunov", reason)) from None
    if not np.isfinite(logs).all():
        raise NotConvergedError("A direction vanishes within an interval: give a shorter one.")
    return _result(equations, logs, interval, y)


def _advance(flow, y0, interval):
    """The function that takes state and frame over an interval, ``advance(y, frame, t)``."""
    n, e, options = len(y0), flow.equations, dict(flow.options)
    method = METHODS.get(options.pop("method"))
    clock = np.zeros(1)
    fun = OverUnit(e.fun)
    args = (clock, interval, *e.args)
    asked = Arguments(
        fun=fun, t0=0.0, tf=1.0, y0=y0, method=flow.options["method"], t_eval=np.ones(1),
        args=args, options=options,
    )  # fmt: skip
    check_method(asked, method)
    if method.second_order:
        raise ValueError(f"{method.name} is for q'' = a(t, q); `lyapunov` takes RK4 or Gauss8.")
    problem = validate.problem(asked, method, mode_for(asked, method))
    longer = with_sensitivities(problem, directions_of("y0", fun, y0, args))
    run = run_of(longer)
    if decides(run.bounds[0]):  # each solve is checked for jumps

        def watched(y, frame, t):
            passage = flow.passage(y, t, interval)
            return passage.y, passage.by_start @ frame

        return watched

    def advance(y, frame, t):
        clock[0] = t
        z = np.concatenate([y, frame.reshape(-1)])
        status = run.solve(z)
        if status != FINISHED:
            said = result_of(longer._replace(y0=z), status, run).message
            raise NotConvergedError(f"The solve fails after t = {t:g} (times in intervals): {said}")
        end = run.view("solve.work")[Y]
        return end[:n].copy(), end[n:].reshape(n, n).copy()

    return advance


def _result(equations, logs, interval, y):
    """The Exponents from the logarithms of each interval's growth, in decreasing order."""
    sums = np.cumsum(logs, axis=0)
    shown = np.unique(np.geomspace(1, len(logs), SHOWN).astype(int)) - 1
    times = interval * (shown + 1.0)
    values = sums[-1] / (interval * len(logs))
    means = np.array([part.mean(axis=0) for part in np.array_split(logs, BATCHES)]) / interval
    scatter = means.std(axis=0, ddof=1) / math.sqrt(BATCHES)
    errors = scatter + np.abs(values - means[BATCHES // 2 :].mean(axis=0))
    order = np.argsort(-values)
    running = (sums[shown] / times[:, None]).T
    return Exponents(
        equations, values[order], errors[order], scatter[order], times, running[order], interval, y
    )
