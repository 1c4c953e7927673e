"""An ensemble on the threads of this process."""

import os
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait

import numpy as np

from fastdyn.compile.traced.known import Attempt
from fastdyn.kernels.ensemble.arguments import COUNT
from fastdyn.kernels.state.record import RAISED
from fastdyn.trace.reads.reads import flat

from . import reductions
from .status import what_raised
from .workers import Worker, functions_of

MOST_ASKED = 100  # failed trajectories whose exceptions are asked for before the result returns
LOOK = 0.1  # seconds between two checks of the workers by the main thread


def work_off(workers, results, bar):
    """Let all workers run to the end; after Ctrl-C, finished trajectories stay in the results."""
    stopped = []
    try:
        with ThreadPoolExecutor(len(workers), thread_name_prefix="fastdyn") as pool:
            try:
                running = {pool.submit(w.run, lambda: bool(stopped)) for w in workers}
                while running:
                    done, running = wait(running, LOOK, FIRST_EXCEPTION)
                    for future in done:
                        future.result()
                    if bar is not None:
                        bar.update(sum(int(w.record["n_done"][0]) for w in workers) - bar.n)
            finally:
                stopped.append(True)
                results.queue[COUNT] = 0
    finally:
        results.found = [piece for w in workers for piece in w.found]


def n_processors():
    """The number of processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def number_of(threads):
    """The number of threads that the argument `threads` asks for; None: all processors."""
    if threads is not None and threads < 1:
        raise ValueError(f"`threads` must be at least 1; got {threads}.")
    return int(threads or n_processors())


def solve_here(ensemble, results, threads, bar):
    """Solve an ensemble on the threads of this process."""
    members = ensemble.members
    problem = ensemble.problem
    vector = ensemble.vector
    width = vector.width if vector else 1
    n_workers = max(1, min(number_of(threads), -(-members.count // width)))
    folds = reductions.folds(ensemble.wanted)
    workers = [Worker(problem, members, vector, results, folds) for _ in range(n_workers)]
    in_python = any(bound.callback is not None for bound in workers[0].bounds)
    if in_python:
        del workers[1:]  # Python runs one thread at a time
    changed = _watched(workers[0], members, problem, folds) if in_python else []
    work_off(workers, results, bar)
    if changed:
        raise ValueError(
            f"`{changed[0]}` uses what another function of the ensemble changes: the trajectories "
            "would depend on their order. Solve them one by one, or pass what changes as `args`."
        )
    for i in np.flatnonzero(results.status == RAISED)[:MOST_ASKED].tolist():
        results.raised[i] = what_raised(members, problem, i)


def _watched(worker, members, problem, folds):
    """A list that receives the names of functions whose outside values change during the solve."""
    varying = tuple([j + 1 for j in members.varying])
    found = []
    changed = []
    for bound, (fun, mode, n) in zip(worker.bounds, functions_of(problem, folds), strict=True):
        if callable(fun) and bound.function is not None:
            known = Attempt(fun, members.first, mode, n, varying).known()
            if known is not None:
                found.append((known[0], flat(known[1]), fun))

    def look():
        for known, before, fun in found:
            now = known.read(fun, members.first)
            if now is None or not np.array_equal(flat(now), before, equal_nan=True):
                changed.append(getattr(fun, "__qualname__", repr(fun)))

    for bound in worker.bounds:
        if bound.callback is not None:
            bound.callback.after = look
    return changed
