"""solve_ensemble: many trajectories of one function."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from fastdyn.compile.bind import or_in_python
from fastdyn.plot.needed import progress_bar
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.validate import time_span
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .compared import compare_trajectories
from .longer.discrete import HybridTrajectories, with_discrete
from .longer.sensitive import SensitiveTrajectories
from .plan import planned, sizes
from .results import Results
from .status import tell_crawl
from .threads import solve_here
from .trajectories import Trajectories

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        Method,
        State,
        Times,
        TimeSpan,
    )

    from .reductions import Fold


@shown_when_wrong(
    client=kinds.executor, store=kinds.store, threads=kinds.whole, progress=kinds.flag,
    block=kinds.number,
)  # fmt: skip
@filled("solve_ensemble")
def solve_ensemble(
    fun: Function,
    t_span: TimeSpan,
    y0: State,
    args: Args = (),
    method: Method = "RK45",
    t_eval: Times | None = None,
    events: Functions | None = None,
    reduce: str | Fold | Sequence[str | Fold] | None = None,
    threads: int | None = None,
    progress: bool = False,
    simd: bool | Literal["auto"] = "auto",
    client: Any = None,
    store: Any = None,
    block: int | None = None,
    **options: Any,
) -> Trajectories:
    """Solve ``y' = fun(t, y, *args)`` for many initial states and parameters at once.

    Parameters
    ----------
    fun, t_span, method, t_eval, events
        As in `solve_ivp`; only fastdyn's own methods.
    y0 : array_like, shape (M, n) or (n,)
        Initial states, or one common initial state.  Trajectories of complex states run one by one.
        A trajectory whose state is not finite fails alone.
    args : tuple
        Each argument is a number, or a 1-D array of M numbers, one for each trajectory.  An array
        that all trajectories share is given as ``Shared(array)``.
    reduce : str, Fold or sequence of them, optional
        Numbers to gather along each trajectory, in constant memory, as `Trajectories.reduced`:
        "max", "min", "max_time", "min_time", "mean", "rms" of each component, "final",
        "first_event", the time of the first event of each kind (other events are not kept), or a
        Fold of a function of your own.  Extrema are taken from the interpolant, means are
        integrated as further components of the state, folds are updated after each accepted step.
    threads : int, optional
        Number of threads; by default all processors, or with a `client` one thread for each block.
        The results do not depend on the number of threads.
    progress : bool
        Show a progress bar.
    simd : {"auto", True, False}
        Whether to solve several trajectories in the vector registers of a processor.  "auto": if
        the function can be compiled for vectors.  True: always, or ValueError.
    client : dask.distributed.Client or concurrent.futures.Executor, optional
        The workers of the client solve the ensemble, in blocks.  The results do not depend on the
        client.
    store : str or path, optional
        Folder for a Zarr group, which receives each block when the block is solved.  After a break,
        the same call solves the missing blocks.  `Trajectories.y` is then a Zarr array, which is
        read when it is indexed.
    block : int, optional
        Trajectories in a block.
    **options
        {options}, as in `solve_ivp`.  Schedules of
        ``fastdyn.at(rows)`` among the events have times of each trajectory; `discrete`, of shape
        (M, m) or (m,), has discrete states; the result has a field `discrete`, too.  With
        `sensitivity`, trajectories run one by one, and the result has the field `sensitivity`, of
        shapes (M, n, ..., n_times) or (M, n, ...): the bits of solve_ivp.

    Returns
    -------
    Trajectories

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense.

    Notes
    -----
    Each trajectory has its own time, step and status: a trajectory that blows up, the order of the
    trajectories and the number of threads do not change a bit of another trajectory.  If possible,
    the state reaches `fun` as a tuple of vectors.  A function that branches on the state, or uses
    the state as an array, may run one trajectory at a time, some five times slower;
    `Trajectories.width` and `reason` tell.
    """
    n_discrete, discrete = 0, options.pop("discrete", None)
    if options.get("sensitivity") is not None:
        others = {"discrete": discrete, "client": client, "store": store}
        for name, value in {**others, "mass": options.get("mass")}.items():
            if value is not None:
                raise ValueError(f"an ensemble with `sensitivity` takes no `{name}`.")
    if discrete is not None:
        if store is not None:
            raise ValueError("a `store` has states alone: `discrete` is for ensembles without it.")
        t0, tf = time_span(t_span)
        asked = Arguments(
            fun=fun, t0=t0, tf=tf, y0=y0, method=method, events=events, options=options,
            discrete=discrete,
        )  # fmt: skip
        longer, n_discrete = with_discrete(asked)
        fun = longer.fun
        y0 = longer.y0
        events = longer.events
        options = longer.options
    given = (fun, t_span, y0, args, method, t_eval, events, reduce, simd, options)
    how = (threads, progress, client, store, block, options)

    def solve():
        ensemble = planned(*given)
        return solved(ensemble, _kind(ensemble, n_discrete), *how)

    return or_in_python(solve)


def _kind(ensemble, n_discrete):
    """The class of the result."""
    if n_discrete:
        return functools.partial(HybridTrajectories, n_discrete)
    if ensemble.directions:
        return functools.partial(SensitiveTrajectories, ensemble.directions)
    return Trajectories


def solved(ensemble, kind, threads, progress, client=None, store=None, block=None, options=None):
    """The Trajectories, of a `kind`, of a plan.Ensemble."""
    if client is None and store is None:
        results = Results(*sizes(ensemble))
        solve = functools.partial(solve_here, ensemble, results, threads)
    else:
        from .in_blocks import in_blocks

        results, solve = in_blocks(ensemble, client, store, block, threads, options)
    p = ensemble.problem
    vector = ensemble.vector
    width = vector.width if vector else 1
    done = kind(p, ensemble.members, results, width, ensemble.reason, ensemble.wanted)
    with trajectory_bar(progress, p, ensemble.members.count) as bar:
        try:
            solve(bar)
        except KeyboardInterrupt as interrupt:
            if p.on_interrupt != "return":
                interrupt.result = done  # pyright: ignore
                raise
    compare_trajectories(ensemble, results)
    tell_crawl(ensemble.members, p, results)
    return done


def trajectory_bar(wanted, problem, count):
    """A progress bar of trajectories."""
    return progress_bar(wanted, total=count, desc=problem.method.name, unit=" trajectories")
