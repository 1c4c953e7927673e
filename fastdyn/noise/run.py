"""Takes all paths from one output time to the next, on threads that share nothing but the paths.

A path depends on the key and its number alone, so that neither the number of threads, nor the
blocks, nor the pieces of a run change a bit of a path.
"""

from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import Any

import numpy as np

from fastdyn import code_store
from fastdyn.compile.compare import compare_along
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.sentences import GaveUp
from fastdyn.ensemble.threads import LOOK
from fastdyn.kernels.calls.block import FAULT, RAISED_WORD, TIME
from fastdyn.kernels.noise.arguments import N_ROWS, N_SCRATCH, RUN, Places, rows_of_noise
from fastdyn.run.functions.interruptible import Interruptible

BLOCK = 512  # paths of a task: their states stay in the first cache; threads end together
PIECE = 2**22  # steps of all paths of a task between two looks at Ctrl-C: 0.05 s
FEW = 4  # paths whose ends are compared with the functions in Python


class LanesOfPaths:
    """The memory of one thread, and its call of the kernel."""

    def __init__(self, kernel, plan, grid, key, y, places, friction):
        width = kernel.width
        m = plan.n_sources
        self.run: Any = np.zeros(1, RUN)
        self.run["key"], self.run["t0"], self.run["h"] = key, grid.t0, grid.h
        self.run["interval"], self.run["refine"] = grid.interval, grid.refine
        noise = np.zeros((rows_of_noise(grid.refine), m * width))
        work = np.zeros((N_ROWS, plan.n * width))
        for row, numbers in friction.items():
            work[row] = np.repeat(np.tile(numbers, plan.n // len(numbers)), width)
        units = np.repeat(np.eye(m), width, axis=1) * np.sqrt(grid.h)
        scratch = np.zeros((len(places.times) * N_SCRATCH, width))
        places = places._replace(scratch=scratch, units=units)
        self.call = code_store.Call(kernel.code, self.run, kernel.block, y, noise, work, *places)

    def take(self, first, last, begin, end, stopped):
        """Take the paths from `first` to `last` through the steps from `begin` to `end`."""
        most = max(1, PIECE // (last - first))
        self.run["first"] = first
        self.run["last"] = last
        while begin < end and not stopped:
            self.run["begin"], self.run["end"] = begin, min(begin + most, end)
            self.call()
            begin += most


class Runner:
    """All paths of a solve, and the threads that take them on.

    Parameters
    ----------
    kernel : plan.NoiseKernel
    plan : plan.NoisePlan
    grid : grid.Grid
    key : int
        The key of the random numbers, 64 bits as a signed number.
    y0 : ndarray, shape (n, M)
    directions : list of float
        The direction of each event.
    friction : dict of int to ndarray
        Rows of the work array that are given.
    n_threads : int
    """

    def __init__(self, kernel, plan, grid, key, y0, directions, friction, n_threads):
        self.n_paths = y0.shape[1]
        width = kernel.width
        padded = -(-self.n_paths // width) * width
        self._y = np.ascontiguousarray(np.pad(y0, ((0, 0), (0, padded - self.n_paths)), "edge"))
        self._times = np.full((len(directions), padded), np.nan)
        places = Places(np.ones(padded), self._times, None, np.array(directions, float), None)
        self._callbacks = [b.callback for b in kernel.bounds if b.callback is not None]
        for callback in self._callbacks:
            callback.writes = None
        tasks = range(0, padded, BLOCK)
        self._tasks = [(first, min(first + BLOCK, padded)) for first in tasks]
        n = 1 if self._callbacks else max(1, min(n_threads, len(self._tasks)))
        self._lanes = [
            LanesOfPaths(kernel, plan, grid, key, self._y, places, friction) for _ in range(n)
        ]
        self._kernel = kernel

    @property
    def y(self):
        """The states, shape (n, M)."""
        return self._y[:, : self.n_paths]

    @property
    def seen(self):
        """The states for functions of the user, which must not write to them."""
        view = self.y.view()
        view.flags.writeable = False
        return view

    @property
    def passages(self):
        """The times of the first passages, shape (n_events, M)."""
        return self._times[:, : self.n_paths]

    def to(self, ends, each, bar=None):
        """Take all paths to the step `ends[k]` and call ``each(k)``, for each k."""
        begin = 0
        stopped = []
        for callback in self._callbacks:
            callback.begin()
        with ThreadPoolExecutor(len(self._lanes), thread_name_prefix="fastdyn") as pool:
            for k, end in enumerate(ends):
                try:
                    self._segment(pool, begin, end, stopped)
                except BaseException:
                    stopped.append(True)
                    raise
                begin = end
                each(k)
                if bar is not None:
                    bar.update(end - bar.n)

    def _segment(self, pool, begin, end, stopped):
        if len(self._lanes) == 1:
            with Interruptible(self._callbacks):
                for first, last in self._tasks:
                    self._lanes[0].take(first, last, begin, end, stopped)
                    self._raise()
            return
        queue = iter(self._tasks)  # `next` of an iterator of a list is one operation

        def work(lanes):
            for first, last in queue:
                lanes.take(first, last, begin, end, stopped)

        running = {pool.submit(work, lanes) for lanes in self._lanes}
        while running:
            done, running = wait(running, LOOK, FIRST_EXCEPTION)
            for future in done:
                future.result()
        self._raise()

    def _raise(self):
        """Raise the exception of a function: the kept exception, or that of a new call."""
        for bound in self._kernel.bounds:
            if bound.callback is not None and bound.callback.exception is not None:
                raise bound.callback.exception
            if bound.block[RAISED_WORD]:
                t = bound.block[TIME : TIME + 1].view(float)[0]
                y = bound.block[bound.block[FAULT] :].view(float)
                evaluate(bound.python, bound.mode, np.float64(t), y.copy())
                raise GaveUp(bound, t)

    def compare(self, t):
        """Raise Different if compiled functions differ from the functions at ends of paths."""
        y = self.y
        chosen = np.unique(np.linspace(0, y.shape[1] - 1, FEW).astype(int))
        states = [y[:, i].copy() for i in chosen if np.isfinite(y[:, i]).all()]
        for bound in self._kernel.bounds:
            if bound.function is not None and states:
                compare_along(bound, [t] * len(states), states)
