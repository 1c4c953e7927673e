"""A run that is surveyed: its steps, its invariants, its checkpoints."""

import time
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile.python_callback import interruptible
from fastdyn.kernels.output.invariants import INVARIANT, SURVEY, Bins
from fastdyn.kernels.state.record import RUNNING, Solve, Y
from fastdyn.run.begin import begin
from fastdyn.run.functions.compared import AT_FIRST, NEVER, WHEN, Schedule, compare_at
from fastdyn.run.loop import next_chunk
from fastdyn.run.matrices.layouts import full_matrices
from fastdyn.specialise.scalar import open_survey_kernel, start_kernel, survey_kernel
from fastdyn.specialise.shared_or_inlined import Tier

FIRST_STEPS = 64


class Survey:
    """The arrays of a study in progress, and the chunk loop over them."""

    def __init__(self, problem, bound, followed, samples, every):
        p, n, m = problem, len(problem.y0), len(followed)
        self._problem, self._bound, self._followed = p, bound, followed
        self.bounds = [*bound.pair, bound, *followed]
        self.state, self.work = begin(p)
        self._matrices = full_matrices(p, bound, ())
        self.invariants: Any = np.zeros(m, INVARIANT)
        self.record: Any = np.zeros(1, SURVEY)
        self.record[0]["every"] = every
        self.edges = np.linspace(p.t0, p.tf, samples + 1)[1:]
        self.bins = np.zeros((m, 3, samples))
        self.t_bins, self.y_bins = np.zeros(samples), np.zeros((samples, n))
        self._scratch = np.zeros(max(n, 1))
        self._fresh = True
        self._point()

    def _point(self):
        for record, bound in zip(self.invariants, self._followed, strict=True):
            record["block"] = bound.block.ctypes.data

    def arrays(self):
        """All that a resumed run needs."""
        names = ("state", "work", "invariants", "record", "bins", "t_bins", "y_bins")
        return {name: getattr(self, name) for name in names}

    def restore(self, arrays):
        """Go on from a checkpoint's arrays, if there are any; ValueError for those of no survey."""
        if arrays is not None:
            for name, mine in self.arrays().items():
                array = arrays.get(name)
                if array is None or (array.shape, array.dtype) != (mine.shape, mine.dtype):
                    raise ValueError(f"the checkpoint is not of this run: its `{name}` is another.")
                mine[...] = array
            self._fresh = False
            self._point()

    @property
    def t(self):
        return float(self.state["t"][0])

    def run(self, file, bar):
        """Step to the end, or to a failure; the status."""
        p = self._problem
        callbacks = [b.callback for b in self.bounds if b.callback is not None]
        tier = Tier(p, self._bound)
        status, chunk, past = RUNNING, FIRST_STEPS, Schedule(WHEN)
        solve = Solve(self.state, self.work, self._bound.block)
        survey = Call(
            survey_kernel(), tier.address, *solve, self.record,
            self.invariants, *Bins(self.edges, self.bins, self.t_bins, self.y_bins),
            self._scratch, chunk,
        )  # fmt: skip
        if self._fresh:
            start = start_kernel(p.method.name, bool(self._bound.pair))
            status = Call(start, *solve, p.method.error_order, p.method.fsal_stage)()
            if status == RUNNING:
                opened = (self.invariants, p.t0, self.work[0], self._scratch)
                status = Call(open_survey_kernel(), *opened)()
        with interruptible(callbacks):
            while status == RUNNING:
                began = time.perf_counter()
                survey["advance"], survey["n"] = tier.address, chunk
                status = survey()
                if past.after_one():
                    compare_at(self.bounds, self.t, self.work[Y].copy())
                spent = time.perf_counter() - began
                tier.record_time(spent)
                tier.promote()
                chunk = next_chunk(chunk, spent)
                if bar is not None:
                    bar.update(abs(self.t - p.t0) - bar.n)
                if file is not None and status == RUNNING and file.due():
                    file.save(self.arrays())
        if past.left[0] < NEVER:
            self._compare()
        return status

    def _compare(self):
        """Compare the code with its functions at the ends of some bins, the last among them."""
        filled = int(self.record["i_bin"][0])
        for i in np.unique(np.linspace(0, filled - 1, AT_FIRST).astype(int)) if filled else ():
            compare_at(self.bounds, float(self.t_bins[i]), self.y_bins[i].copy())
