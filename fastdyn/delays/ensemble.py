"""solve_dde_ensemble: one delay equation for many histories, delays and other arguments."""

from __future__ import annotations

import contextlib
import copy
import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.ensemble.labels import Label, argument_names
from fastdyn.ensemble.results import Results
from fastdyn.ensemble.solve import trajectory_bar
from fastdyn.ensemble.threads import number_of, work_off
from fastdyn.ensemble.trajectories import OF_STEPS, Trajectories
from fastdyn.kernels.state.record import EVENT, FINISHED, INTERRUPTED, RAISED, STEP_TOO_SMALL
from fastdyn.problem import validate
from fastdyn.problem.members import Members
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.table import refused_by
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equation import KINDS, Given
from .prepare import PreparedDelays

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Function, Functions, Times, TimeSpan

FEW = 8  # most trajectories with which a solver is prepared
CODES = {0: FINISHED, 1: EVENT, -2: INTERRUPTED}  # of the kernels, by SciPy's status
REFUSED = refused_by("solve_dde_ensemble") | {  # and arguments of other functions
    "dense_output": "`t_eval` has times of output; `solve_dde` has `sol`",
    "reduce": "compute it from `y`, or by a further component of the equations",
    "y0": "`history` is the state up to the start, a row a trajectory",
    "simd": "delay equations run one by one, on all threads",
}


@shown_when_wrong(**KINDS, threads=kinds.whole, progress=kinds.flag)
@filled("solve_dde_ensemble")
def solve_dde_ensemble(
    fun: Function,
    t_span: TimeSpan,
    history: Any,
    args: Args = (),
    method: str = "auto",
    t_eval: Times | None = None,
    events: Functions | None = None,
    delays: Times | None = None,
    jumps: Times | None = None,
    threads: int | None = None,
    progress: bool = False,
    **options: Any,
) -> DelayTrajectories:
    """Solve ``y' = fun(t, y, past, *args)`` for many histories and arguments, such as delays.

    Parameters
    ----------
    fun, t_span, method, t_eval, events, delays, jumps
        As in `solve_dde`.
    history : array_like, callable, OdeResult, or list of callables or OdeResults
        Constant histories, shape (M, n), or one for all, (n,); a function ``history(t)`` or
        ``history(t, *args)``, which gets the arguments of the trajectory; or one of these for each
        trajectory.
    args : tuple
        As in `solve_ensemble`: each argument is a number, or a 1-D array of M numbers, one for each
        trajectory.  An array that all trajectories share is given as ``Shared(array)``.
    threads : int, optional
        Number of threads; by default all processors.  The results do not depend on the number.
    progress : bool
        Show a progress bar.
    **options
        As in `solve_dde`, but for {refused}; `compile` is "inlined" by default.

    Returns
    -------
    DelayTrajectories
        `Trajectories` with `delays` and `jumps` of each trajectory.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and if every trajectory raises an exception.

    Notes
    -----
    Each trajectory has the bits of `solve_dde`.  A trajectory whose function or history raises an
    exception, or whose delay is negative, fails alone; ``message(i)`` says why.  Stiff methods,
    actions, steps that contain their own past, and earlier results as histories are prepared anew
    for each trajectory, one thread at a time; functions in Python run on one thread.

    Examples
    --------
    >>> late = solve_dde_ensemble(
    ...     lambda t, y, past, tau: -past(t - tau), (0, 9), [1.0], (np.linspace(0.5, 1.5, 100),)
    ... )
    >>> late.y_end[:, 0]
    """
    for name in REFUSED.keys() & options.keys():
        raise TypeError(f"`solve_dde_ensemble` takes no `{name}`: {REFUSED[name]}.")
    n_threads = number_of(threads)
    histories, states = _histories(history)
    members = Members(states, validate.extra_arguments(args), "history")
    if histories is not None and len(histories) not in (1, members.count):
        raise ValueError(
            f"`history` has {len(histories)} functions for {members.count} trajectories."
        )
    options = {"compile": "inlined", **options}
    given = Given(
        fun, t_span, None, method, t_eval, False, events, members.first, delays, jumps, options
    )
    ensemble = _Ensemble(given, members, histories)
    return ensemble.solved(ensemble.prepared(), n_threads, progress)


def _histories(history):
    """The histories that are functions or results, one or one a trajectory, and states of all.

    None for constant histories, which are the states; the state of others is a stand-in of one
    number.
    """
    if callable(history) or hasattr(history, "sol"):
        return [history], [0.0]
    functions = isinstance(history, list | tuple) and len(history)
    if functions and all(callable(each) or hasattr(each, "sol") for each in history):
        return list(history), np.zeros((len(history), 1))
    return None, history


class _Ensemble:
    """The values of all trajectories, and what becomes of them."""

    def __init__(self, given, members, histories):
        self._given = given
        self._members = members
        self._histories = histories
        self._constant = members.y0
        self._queue = iter(range(members.count))
        self.facts: Any = None

    def values(self, i):
        """The history and the arguments of trajectory i."""
        own = self._constant if self._histories is None else self._histories
        return own[i if len(own) > 1 else 0], self._members.args(i)

    def prepared(self):
        """A solver, prepared with the first trajectory that raises nothing, among FEW."""
        count = self._members.count
        if not count:
            raise ValueError("`history` has no rows: an ensemble of delay equations needs one.")
        errors: list = []
        for i in np.unique(np.linspace(0, count - 1, FEW).astype(int)).tolist():
            history, args = self.values(i)
            try:
                return PreparedDelays(self._given._replace(history=history, args=args))
            except Exception as error:
                errors.append(error)
        raise errors[0]

    def solved(self, solver, most, progress):
        """The DelayTrajectories, by solvers on at most so many threads."""
        members = self._members
        p = solver.problem
        members.n = len(p.y0)
        members.y0 = np.full((members.count, members.n), np.nan)
        n_times = 0 if p.t_eval is None else len(p.t_eval)
        results = Results(members.count, members.n, n_times, 0, False, True)
        self.facts = facts = DelayFacts(self._given.fun, members.count)
        n_threads = min(most, members.count)
        solvers = [solver]
        while len(solvers) < n_threads and not solver.in_python:  # Python runs one at a time
            solvers.append(copy.copy(solver))
        workers = [_Worker(each, self._queue, self._solve, results) for each in solvers]
        done = DelayTrajectories(facts, p, members, results, 1, "delay equations run one by one")
        with trajectory_bar(progress, p, members.count) as bar:
            try:
                work_off(workers, results, bar)
            except KeyboardInterrupt as interrupt:
                interrupt.result = done  # pyright: ignore
                raise
        if (results.status == RAISED).all():
            raise facts.raised[0]
        return done

    def _solve(self, solver, i, results):
        history, args = self.values(i)
        facts = self.facts
        try:
            found = solver(history, args)
        except Exception as error:
            results.status[i] = RAISED
            results.t_end[i] = solver.problem.t0
            facts.raised[i] = error
            facts.messages[i] = f"Trajectory {i} raised {type(error).__name__}: {error}"
            return
        self._members.y0[i] = solver.y0
        results.status[i] = CODES.get(found.status, STEP_TOO_SMALL)
        count = results.counts[i]
        ended, results.t_end[i], results.y_end[i] = solver.end(found)
        results.h_end[i] = ended.h
        for name in OF_STEPS:
            count[name] = getattr(ended, name)
        if solver.problem.t_eval is not None:
            count["n_times"] = len(found.t)
            results.y_eval[i, : len(found.t)] = found.y.T
        facts.take(i, found)


class _Worker:
    """A thread's solver, which takes trajectories from a queue; as `ensemble.workers.Worker`."""

    def __init__(self, solver, queue, solve, results):
        self._solver = solver
        self._queue = queue
        self._solve = solve
        self._results = results
        self.record = {"n_done": [0]}
        self.found: list = []

    def run(self, stopped):
        """Solve trajectories from the queue until the queue is empty or `stopped()`."""
        while not stopped():
            with contextlib.suppress(StopIteration):
                self._solve(self._solver, next(self._queue), self._results)
                self.record["n_done"][0] += 1
                continue
            return


class DelayFacts:
    """Facts about the trajectories of a delay equation that `Results` has no rows for."""

    def __init__(self, fun, count):
        self.fun = fun
        self.raised: dict = {}
        self.messages = [""] * count
        self.delays = [np.empty(0)] * count
        self.jumps = [np.empty(0)] * count
        self.t_events: list = [None] * count
        self.y_events: list = [None] * count

    def take(self, i, found):
        """Keep those of trajectory i."""
        for name in ("delays", "jumps", "t_events", "y_events"):
            getattr(self, name)[i] = found[name]
        self.messages[i] = found.message


class DelayTrajectories(Trajectories):
    """Trajectories of a delay equation; ``result[i]`` is that of `solve_dde`, without steps.

    Attributes
    ----------
    delays, jumps : list of ndarray
        The constant delays, and the times at which a derivative jumps, of each trajectory.
    y0 : ndarray, shape (M, n)
        The states at the start; nan for a trajectory that raised an exception there.
    """

    def __init__(self, facts, *given):
        super().__init__(*given)
        self._facts = facts
        self.delays = facts.delays
        self.jumps = facts.jumps

    @property
    def argument_labels(self):
        first = self.first
        names = [label.name for label in argument_names(self._facts.fun, first)][1:]  # behind past
        names += [f"args[{j}]" for j in range(len(names), len(first))]
        return [Label(name) for name in names[: len(first)]]

    def message(self, i):
        """The reason why trajectory i ended, in a sentence."""
        i = self._number(i)
        return self._facts.messages[i] or super().message(i)

    def _by_event(self, of_members, nothing):
        if self._problem.events is None and not self._problem.schedules:
            return None
        count = len(self.event_names)
        return [[nothing if each is None else each[k] for each in of_members] for k in range(count)]

    @property
    def t_events(self):
        return self._by_event(self._facts.t_events, np.empty(0))

    @functools.cached_property
    def y_events(self):
        return self._by_event(self._facts.y_events, np.empty((0, self._n)))

    def __getitem__(self, i):
        found = super().__getitem__(i)
        i = self._number(i)
        found["delays"] = self.delays[i]
        found["jumps"] = self.jumps[i]
        return found
