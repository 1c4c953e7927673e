"""A Run whose function reads the dense output of the Run itself."""

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.kernels.output import arguments as words
from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE
from fastdyn.run import output
from fastdyn.run.loop import Run

from .points import Carried

N_DENSE = OUTPUT.fields["n_dense"][1]  # the place of the number of polynomials in the record
NOW = STATE.fields["t"][1]  # the place of the time that is reached


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

    def begin_with(self, problem, known, starts):
        """Take the problem, whose jumps the delays carry on; the past is now that of this Run.

        `known` are the Delays, `starts` the times of jumps that are known before.  Returns the
        Carried.
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
        self.laid_out.view(np.int64)[words.PAST_BEGINS] = 0
        return carried

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
