"""solve_ensemble: many trajectories of one function."""

import functools
import os
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.compile.diagnostics import GaveUp, Uncompilable
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.side_effects import check_independent
from fastdyn.kernels.state.record import RAISED
from fastdyn.problem import validate
from fastdyn.problem.equations import check_second_order
from fastdyn.solve.ivp import run_of

from . import reductions
from .members import Members
from .trajectories import Trajectories
from .workers import Results, Worker, work_off

LANES = ("auto", "scalar", "vector")


def n_processors():
    """Processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def solve_ensemble(
    fun,
    t_span,
    y0,
    args=(),
    method="RK45",
    t_eval=None,
    events=None,
    reduce=None,
    threads=None,
    progress=False,
    lanes="auto",
    client=None,
    store=None,
    block=None,
    **options,
):
    """Solve y' = fun(t, y, *args) for many initial states and parameters at once.

    Parameters
    ----------
    fun, t_span, method, t_eval, events
        As in `solve_ivp`; methods are ours (SciPy's Radau, BDF and LSODA are not offered).
    y0 : array_like, shape (M, n) or (n,)
        Initial states, or the one that all trajectories share.
    args : tuple
        Each a number, or a 1-D array of M numbers, one a trajectory.  An array that all share goes
        in as ``Shared(array)``.
    reduce : str, Fold or sequence of them, optional
        What to gather along each trajectory, in constant memory, as `Trajectories.reduced`:
        "max", "min", "max_time", "min_time", "mean", "rms" of each component, "final",
        "first_event", the time of the first event of each kind (other events are not kept), or a
        Fold of a function of your own.  Extrema are those of the interpolant, means are integrated
        by the method itself, folds see the end of each step.
    threads : int, optional
        All processors unless given, one for each block if there is a `client`.  The results do not
        depend on it.
    progress : bool
    lanes : {"auto", "scalar", "vector"}
        Whether several trajectories share the vector registers of a processor: where the function
        can be compiled for it, never, or always (raises where it cannot).
    client : dask.distributed.Client or concurrent.futures.Executor, optional
        Whose workers solve the ensemble, in blocks.  The results do not depend on it.
    store : str or path, optional
        Folder for a Zarr group, which each block is written to when it is solved.  The same call
        after a break goes on with the blocks that are not there.  `Trajectories.y` is then a Zarr
        array, and read when it is indexed.
    block : int, optional
        Trajectories in a block.
    **options
        `rtol`, `atol`, `max_step`, `first_step`, `step`, `max_steps`, `breakpoints`, `project`,
        `on_interrupt`, as in `solve_ivp`.

    Returns
    -------
    Trajectories

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense.

    Notes
    -----
    Each trajectory has its own time, step and status: one that blows up leaves the others alone,
    to the last bit, and neither their order nor the number of threads changes any.  The state
    reaches `fun` as a tuple of vectors where that is possible; what branches on the state, or uses
    it as an array, runs one trajectory at a time, some five times slower.  `Trajectories.width`
    and `reason` tell which it was.
    """
    given = (fun, t_span, y0, args, method, t_eval, events, reduce, lanes, options)
    how = (threads, progress, client, store, block, options)
    return or_in_python(lambda: _solve(checked(*given), *how))


def _solve(ensemble, threads, progress, client, store, block, options):
    if client is None and store is None:
        results = Results(*sizes(ensemble))
        solve = functools.partial(solve_here, ensemble, results, threads)
    else:
        from .distribute import in_blocks

        results, solve = in_blocks(ensemble, client, store, block, threads, options)
    p, vector = ensemble.problem, ensemble.vector
    width = vector.width if vector else 1
    done = Trajectories(p, ensemble.members, results, width, ensemble.reason, ensemble.wanted)
    bar = _bar(ensemble.members.count, p.method.name) if progress else None
    try:
        solve(bar)
    except KeyboardInterrupt as interrupt:
        if p.on_interrupt != "return":
            interrupt.result = done  # pyright: ignore
            raise
    finally:
        if bar is not None:
            bar.close()
    return done


class Ensemble(NamedTuple):
    """A checked ensemble; `vector` is None where each trajectory runs alone, for the `reason`."""

    members: Members
    problem: validate.Problem
    vector: Any
    reason: str
    wanted: tuple


def sizes(ensemble):
    """Arguments of `Results`."""
    members, p, wanted = ensemble.members, ensemble.problem, ensemble.wanted
    n_times = 0 if p.t_eval is None else len(p.t_eval)
    return (
        members.count, members.n, n_times, len(p.events or ()),
        reductions.extrema(wanted), "first_event" not in wanted, len(reductions.folds(wanted)),
    )  # fmt: skip


def solve_here(ensemble, results, threads, bar):
    """Solve an ensemble on the threads of this process."""
    members, problem, vector = ensemble.members, ensemble.problem, ensemble.vector
    width = vector.width if vector else 1
    n_workers = max(1, min(threads or n_processors(), -(-members.count // width)))
    folds = reductions.folds(ensemble.wanted)
    workers = [Worker(problem, members, vector, results, folds) for _ in range(n_workers)]
    if any(bound.callback is not None for bound in workers[0].bounds):
        del workers[1:]  # Python runs one thread at a time
    work_off(workers, results, bar)
    raised = np.flatnonzero(results.status == RAISED)
    if len(raised):
        _ask_again(members, problem, int(raised[0]))


def _ask_again(members, problem, i):
    """Raise GaveUp if trajectory i raised only because its function is compiled."""
    p = problem._replace(y0=members.state(i), args=members.args(i), tier="pointer")
    try:
        run_of(p).solve()
    except GaveUp:
        raise
    except Exception:  # which it raises in Python too: its status says so
        pass


def checked(fun, t_span, y0, args, method, t_eval, events, reduce, lanes, options):
    """The arguments of `solve_ensemble` as an Ensemble, its functions compiled."""
    wanted = reductions.wanted(reduce, events)
    ours = validate.method_named(method)
    if ours is None:
        raise ValueError(f"`method={method!r}` is SciPy's; ensembles take fastdyn's own methods.")
    if lanes not in LANES:
        raise ValueError(f"`lanes={lanes!r}` is unknown; choose from {', '.join(LANES)}.")
    for name in ("checkpoint", "tier", "dense_output"):
        if name in options:
            raise TypeError(f"an ensemble takes no `{name}`.")
    t0, tf = validate.time_span(t_span)
    if t0 == tf:
        raise ValueError("`t_span` must not be empty.")
    members = Members(y0, validate.extra_arguments(args))
    if members.n == 0:
        raise ValueError("`y0` has no components.")
    smallest = abs(members.y0).min(axis=0) if len(members.y0) else np.ones(members.n)
    mode, n = "derivative", members.n
    if ours.second_order:
        mode, n = "acceleration", members.n // 2
        if members.count:
            check_second_order(fun, t0, members.state(0), members.first, ours.name)
    problem = validate.problem(
        fun, t0, tf, smallest, ours, t_eval, False, events, members.first, mode, options
    )
    if moments := reductions.moments(wanted):
        problem = reductions.extended(problem, moments, members)
        mode, n = moments, members.n

    folds = [fold.function for fold in reductions.folds(wanted)]
    project = [problem.project] if problem.project is not None else []
    check_independent([fun, *(event for event, _, _ in problem.events or ()), *folds, *project])

    def look():
        if members.count:
            start = members.state(0)[:n].copy()
            evaluate(lambda t, y: fun(t, y, *members.first), mode, t0, start)

    members.bind(fun, mode, n, look)
    vector, reason = None, '`lanes` is "scalar"'
    if lanes != "scalar":
        try:
            vector, reason = _on_vectors(problem, members, wanted)
        except Uncompilable as error:
            reason = str(error)
            if lanes == "vector":
                raise ValueError(f"`fun` has no form for vectors: {reason}.") from error
    return Ensemble(members, problem, vector, reason, wanted)


def _on_vectors(problem, members, wanted):
    """The kernel for vectors, and why it leaves the events or folds to one trajectory at a time."""
    from fastdyn.specialise.vector import kernel

    p = problem
    varying = tuple(j in members.varying for j in range(len(members.first)))
    given = (
        p.method.name, p.fun, members.first, varying, p.mode, members.n, reductions.extrema(wanted)
    )  # fmt: skip
    events, folds = [event for event, _, _ in p.events or ()], reductions.folds(wanted)
    others = [fold.of_state(members.n, reductions.parts(wanted)) for fold in folds]
    reason = ""
    if (events or others) and p.project is None:
        try:
            return kernel(*given, events, others), ""
        except Uncompilable as error:
            reason = f"events and folds one by one: {error}"
    return kernel(*given), reason


def _bar(count, name) -> Any:
    from tqdm.auto import tqdm

    return tqdm(total=count, desc=name, unit=" trajectories")
