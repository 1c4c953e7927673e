"""Ensembles in blocks: on the workers of a client, or one block after the other into a store."""

import functools
import pickle
import sys
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from typing import Any, NamedTuple

import numba
from numba import cloudpickle

from fastdyn import __version__
from fastdyn.compile.bind import bind, or_in_python
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.kernels.state.record import INTERRUPTED
from fastdyn.problem.members import Shared
from fastdyn.run import resume
from fastdyn.run.checkpoint import fingerprint

from . import reductions
from .plan import planned, sizes
from .results import Results
from .threads import LOOK, n_processors, solve_here
from .workers import functions_of

FEWEST = 64  # blocks, if there are enough trajectories
SMALLEST = 64  # trajectories in a block
LARGEST = 2**24  # bytes of states in a block


class Job(NamedTuple):
    """The common data of all blocks of an ensemble.

    `given` are arguments of `plan.planned`, `first` the arguments of the function in the first
    trajectory; `header` is the `description` that a worker must find, too.
    """

    given: dict
    first: tuple
    threads: int | None
    header: dict


class _Here(Executor):
    """An executor that runs a function when the function is submitted."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def in_blocks(ensemble, client, store, block, threads, options):
    """Results for all members, and ``solve(bar)``, which fills them; see `solve_ensemble`."""
    e = ensemble
    p = ensemble.problem
    if p.schedules:
        raise ValueError(
            "schedules (`at`, `every`) are for ensembles on the threads of this process: without "
            "`client` and `store`."
        )
    executor, n_waiting = executor_of(client)
    header = description(e, e.members.first)
    n = e.members.n // reductions.n_copies(e.wanted)
    row_bytes = 8 * n * (1 if p.t_eval is None else 1 + len(p.t_eval))
    block = block_size(block, e.members.count, row_bytes, n_waiting)
    if store is None:
        results = Results(*sizes(e))
        missing = range(0, e.members.count, block)
    else:
        from .zarr_store import Archived

        if e.members.complex:
            raise ValueError("`store` takes real states: give real and imaginary parts as one.")
        results = Archived(store, sizes(e), e.members, header, p.t_eval, n, block)
        block = results.block
        missing = results.missing()
    given = {
        "fun": p.fun, "t_span": (p.t0, p.tf), "method": p.method.name.removesuffix(ON_PAIRS),
        "t_eval": p.t_eval,
        "events": p.events and [_as_given(event) for event in p.events], "reduce": e.wanted,
        "simd": e.vector is not None, "options": options,
    }  # fmt: skip
    job = Job(given, e.members.first, threads if client is None else threads or 1, header)
    sent = job if client is None else _packed(job)
    parts = ((start, *_part(e.members, n, slice(start, start + block))) for start in missing)
    return results, functools.partial(solve_parts, executor, n_waiting, sent, parts, results)


def executor_of(client):
    """The executor of a client, and the number of blocks that may wait or run in it."""
    if client is None:
        return _Here(), 1
    if hasattr(client, "get_executor"):  # of dask; an adaptive cluster may have no worker yet
        return client.get_executor(pure=False), 2 * max(2, sum(client.nthreads().values()))
    return client, 2 * (getattr(client, "_max_workers", None) or n_processors())


def block_size(block, count, row_bytes, n_waiting):
    """The number of trajectories in a block, `block` if given.

    No block has a single trajectory of many: a parameter that is constant in a block takes another
    path through the code than a parameter that varies, with other last bits.
    """
    if block is None:
        block = max(SMALLEST, count // max(FEWEST, 4 * n_waiting))
        block = min(block, LARGEST // row_bytes)
    elif block != int(block) or block < 1:
        raise ValueError(f"`block` must be a whole number of trajectories; got {block!r}.")
    block = max(2, int(block))
    while block < count and count % block == 1:
        block += 1
    return block


def description(ensemble, first):
    """The identity of an ensemble, without its members, in JSON's types.

    `first` are arguments that stand for the arguments of all members.
    """

    p = ensemble.problem
    members = ensemble.members
    try:
        called = functions_of(p, reductions.folds(ensemble.wanted))
        functions = fingerprint(
            [bind(fun, first, mode, n, members.near(p, n)) for fun, mode, n in called]
        )
    except ValueError:
        functions = None
    return {
        "fastdyn": __version__,
        "numba": numba.__version__,
        "python": "{}.{}".format(*sys.version_info),
        **resume.description(p, functions),
        "max_steps": repr(p.max_steps),
        "simd": ensemble.vector is not None,
        "reduce": [reductions.described(item) for item in ensemble.wanted],
    }


def _as_given(event):
    """The Event of the state without the components that reductions add."""
    return event.changed(function=event.origin or event.function, origin=None, act=None)


def _packed(job):
    """A Job as bytes: functions of the main program by value, functions of modules by name."""
    try:
        return cloudpickle.dumps(job)
    except Exception as error:
        raise TypeError(f"`fun` and `args` cannot be sent to a worker: {error}.") from error


@functools.lru_cache(4)
def _unpacked(job) -> Job:
    return pickle.loads(job)


def _part(members, n, rows):
    """Initial states and varying arguments of some members."""
    y0 = members.y0[rows, :n] if len(members.y0) > 1 else members.y0[0, :n]
    y0 = y0.view(complex) if members.complex else y0
    return y0, {j: column[rows] for j, column in members.varying.items()}


def solve_block(job, y0, columns):
    """Solve a block on a worker.

    Parameters
    ----------
    job : Job or bytes
    y0 : ndarray, shape (m, n) or (n,)
    columns : dict of int to ndarray
        The arguments that vary.

    Returns
    -------
    results.Results
    """
    given, first, threads, header = job if isinstance(job, Job) else _unpacked(job)
    args = [columns.get(j, Shared(value)) for j, value in enumerate(first)]
    part = planned(y0=y0, args=args, **given)
    here = description(part, first)
    wrong = [name for name in header if here[name] != header[name]]
    if wrong:
        raise RuntimeError(
            f"a worker would solve something else; what differs: {', '.join(wrong)}. Install the "
            "same there, and pass numbers that change as `args`."
        )
    ready = [part]

    def solve():
        part = ready.pop() if ready else planned(y0=y0, args=args, **given)
        results = Results(*sizes(part))
        solve_here(part, results, threads, None)
        return results

    return or_in_python(solve)


def solve_parts(executor, n_waiting, job, parts, results, bar):
    """Solve blocks, each (start, initial states, arguments); finished blocks stay in the results.

    When a block fails, or on Ctrl-C, the other blocks are cancelled.
    """
    running: dict[Any, int] = {}
    if bar is not None:
        bar.update(int((results.status != INTERRUPTED).sum()))
    try:
        while True:
            for start, y0, columns in islice(parts, n_waiting - len(running)):
                running[executor.submit(solve_block, job, y0, columns)] = start
            if not running:
                return
            for future in wait(running, LOOK, FIRST_COMPLETED).done:
                part = future.result()
                results.put(running.pop(future), part)
                if bar is not None:
                    bar.update(len(part.t_end))
    finally:
        for future in running:
            future.cancel()
