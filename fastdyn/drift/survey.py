"""A run that is surveyed: its steps, its invariants, its checkpoints."""

import time
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.kernels.output.invariants import INVARIANT, SURVEY, Bins
from fastdyn.kernels.state.record import RUNNING, Solve, Y
from fastdyn.run.begin import begin
from fastdyn.run.checkpoint import fill
from fastdyn.run.functions.compared import AT_FIRST, NEVER, WHEN, Schedule, compare_at
from fastdyn.run.functions.interruptible import Interruptible
from fastdyn.run.loop import next_chunk
from fastdyn.run.matrices.layouts import matrices_of_member
from fastdyn.run.outcome import outcome
from fastdyn.specialise.scalar import open_survey_kernel, start_kernel, survey_kernel
from fastdyn.specialise.shared_or_inlined import Tier

FIRST_STEPS = 64


class Steps:
    """The arrays and kernels of a method for any equations.

    Attributes
    ----------
    state, work, block : ndarray
        As kernels take them.
    bounds : list of Bound
        The equations, to be compared with their code.
    settings : tuple
        What distinguishes the run from others, for its checkpoint.
    """

    def __init__(self, problem, bound):
        p = self._problem = problem
        self.bounds = [*bound.pair, bound]
        self.block = bound.block
        self.settings = (p.rtol, p.atol, p.h_max)
        self._matrices = matrices_of_member(p, bound, ())
        self.state, self.work = begin(p, self._matrices.rows)
        self._tier = Tier(p, bound)  # compiles
        self._start = start_kernel(p.method.name, bool(bound.pair))

    @property
    def address(self):
        """The address of the stepping kernel."""
        return self._tier.address

    def start(self):
        """The first derivative and step; the status."""
        solve = Solve(self.state, self.work, self.block)
        method = self._problem.method
        return Call(self._start, *solve, method.error_order, method.fsal_stage)()

    def took(self, seconds):
        """Count the time of a chunk, after which a faster kernel may take over."""
        self._tier.record_time(seconds)
        self._tier.promote()

    def tell(self):
        """Nothing to warn of after a run."""

    def message(self, status):
        """The sentence about a run that ended with a failure."""
        return outcome(status, self.state, self.work, self._problem)[1]


class Survey:
    """The arrays of a study in progress, and the chunk loop over them; its time in `seconds`."""

    def __init__(self, problem, steps, followed, samples, every):
        p = problem
        n = len(problem.y0)
        m = len(followed)
        self._problem = p
        self.steps = steps
        self._followed = followed
        self.bounds = [*steps.bounds, *followed]
        self.state = steps.state
        self.work = steps.work
        self.invariants: Any = np.zeros(m, INVARIANT)
        self.record: Any = np.zeros(1, SURVEY)
        self.record[0]["every"] = every
        self.edges = np.linspace(p.t0, p.tf, samples + 1)[1:]
        self.bins = np.zeros((m, 3, samples))
        self.t_bins, self.y_bins = np.zeros(samples), np.zeros((samples, n))
        self._scratch = np.zeros(max(n, 1))
        self._fresh = True
        self.seconds = 0.0
        self._point()
        self._kernels = survey_kernel(), open_survey_kernel()  # compiles

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
            fill(self.arrays(), arrays)
            self._fresh = False
            self._point()

    @property
    def t(self):
        return float(self.state["t"][0])

    def filled(self):
        """Times, states and means of the changes of the invariants, of the bins so far."""
        n = int(self.record["i_bin"][0])
        return self.t_bins[:n], self.y_bins[:n], self.bins[:, 0, :n].T * self.invariants["scale"]

    def run(self, file, bar):
        """Step to the end, or to a failure; the status."""
        p = self._problem
        callbacks = [b.callback for b in self.bounds if b.callback is not None]
        steps = self.steps
        look, opened = self._kernels
        status = RUNNING
        chunk = FIRST_STEPS
        past = Schedule(WHEN)
        solve = Solve(self.state, self.work, steps.block)
        survey = Call(
            look, steps.address, *solve, self.record,
            self.invariants, *Bins(self.edges, self.bins, self.t_bins, self.y_bins),
            self._scratch, chunk,
        )  # fmt: skip
        if self._fresh:
            status = steps.start()
            if status == RUNNING:
                status = Call(opened, self.invariants, p.t0, self.work[0], self._scratch)()
        with Interruptible(callbacks):
            while status == RUNNING:
                began = time.perf_counter()
                worked = time.thread_time()
                survey["advance"] = steps.address
                survey["n"] = chunk
                status = survey()
                worked = time.thread_time() - worked
                spent = time.perf_counter() - began
                self.seconds += spent
                if past.after_one():
                    compare_at(self.bounds, self.t, self.work[Y].copy())
                steps.took(worked)
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
