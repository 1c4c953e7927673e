"""A Run whose function reads the dense output of the Run itself."""

from contextlib import contextmanager

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import PAST_OF_RARE, RARE
from fastdyn.kernels.output import arguments as words
from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE, K
from fastdyn.run import output
from fastdyn.run.loop import Run
from fastdyn.specialise import rare
from fastdyn.specialise.scalar import dense_rows_kernel, within_past_kernel

from .points import Carried

N_DENSE = OUTPUT.fields["n_dense"][1]  # the place of the number of polynomials in the record
NOW = STATE.fields["t"][1]  # the place of the time that is reached
# A time that depends on the state is as wrong as the state: later than t by less than these
# tolerances, it counts as t.
SLACK = 10.0


class OnePiece(output.Output):
    """The output of a solve whose polynomials stay in one piece."""

    def _grow_dense(self, o):
        d = self.d
        spans = self.spans
        self._n_polynomials = 2 * len(d)
        self._new_polynomials()
        self.d[: len(d)] = d
        self.spans[: len(d)] = spans


class DelayRun(Run):
    """A Run that tells the words of its history where its polynomials are."""

    laid_out: np.ndarray
    carried: Carried | None = None

    def begin_with(self, problem, known, starts, looks, slope):
        """Take the problem, whose jumps the delays carry on; the past is now that of this Run.

        `known` are the Delays, `starts` the times of jumps that are known before, `looks` tells how
        steps are looked at, see `kernels/output/past/steps.py`; `slope` is the derivative at the
        start.  Returns the Carried.
        """
        if self.switching is not None and self.switching.follows:
            raise ValueError(
                "`fun` switches at times that depend on components which `on_event` changes: "
                "delays do not carry such times on. Let an event act at the switch, or give the "
                "times by `at`."
            )
        carried = Carried(problem, known, starts)
        self.take(carried.taken(problem))
        self.carried = carried if problem.acts else None
        self.laid_out = problem.args[0]
        self._first_slope = slope
        self._lay_own_past(looks)
        self.laid_out.view(np.int64)[words.PAST_BEGINS] = 0
        return carried

    def _lay_own_past(self, looks):
        """Lay out the memory of steps that contain their own past."""
        p = self.problem
        rows = K + p.method.n_rows
        n = len(p.y0)
        polynomial = self.plan.arrays["output.d"][3][1] * n
        self._own_past = np.zeros(2 + 2 * polynomial + 3 * n + STATE.itemsize // 8 + rows * n)
        self._rare = np.zeros(PAST_OF_RARE + 1, np.int64)
        self._rare[PAST_OF_RARE] = address_of(self.laid_out)
        self.laid_out[words.PAST_SLACK] = SLACK * np.max(p.rtol)
        whole = self.laid_out.view(np.int64)
        whole[words.PAST_TRIAL] = address_of(self._own_past)
        whole[words.PAST_LOOKS] = looks
        whole[words.PAST_DENSE_ROWS] = dense_rows_kernel(p.method.name).address
        whole[words.PAST_FSAL] = p.method.fsal_stage
        whole[words.PAST_N_ROWS] = rows
        whole[words.PAST_COUPLED] = words.COUPLED * (p.method.name == "Radau")

    def follower(self):
        """What carries the jumps of actions on; None without actions."""
        return self.carried

    def _tell(self, d, spans):
        whole = self.laid_out.view(np.int64)
        whole[words.PAST_D] = address_of(d)
        whole[words.PAST_SPANS] = address_of(spans)
        whole[words.PAST_COUNT] = address_of(self.view("output.record")) + N_DENSE
        whole[words.PAST_NOW] = address_of(self.view("solve.state")) + NOW
        whole[words.PAST_ROWS] = d.shape[1]
        whole[words.PAST_HINT :] = 0

    @contextmanager
    def another(self):
        """None: the past is that of one Run at a time."""
        yield None

    def stepping(self):
        """The address of the kernel that takes steps again which contain their own past."""
        whole = self.laid_out.view(np.int64)
        whole[words.PAST_ADVANCE] = self.tier.address
        self._rare[:PAST_OF_RARE] = rare.addresses[:PAST_OF_RARE]
        self._own.block[RARE] = address_of(self._rare)
        return within_past_kernel().address

    def begin(self, y0, n_steps=0, snapshots=0):
        """As `Run.begin`; until the first step, the past behind the start is the tangent."""
        self._own_past[:] = 0.0
        self._own_past[0] = self.problem.t0
        self._own_past[1] = 1.0
        n = len(y0)
        self._own_past[2 : 2 + n] = y0
        first = self._first_slope  # of the state, not of sensitivities behind
        self._own_past[2 + n : 2 + n + len(first)] = first
        self.laid_out.view(np.int64)[words.PAST_OPEN] = 1
        return super().begin(y0, n_steps, snapshots)

    def _new_memory(self):
        own = super()._new_memory()
        self._tell(self.view("output.d"), self.view("output.spans"))
        return own

    @property
    def output(self):
        """The output of the last solve."""
        if self.grown is None:
            self.grown = OnePiece(self.plan, self.memory)
        return self.grown

    def lay_output(self):
        super().lay_output()
        self._tell(self.output.d, self.output.spans)
