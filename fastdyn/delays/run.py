"""A Run whose function reads the dense output of the Run itself."""

import math
import weakref
from contextlib import contextmanager
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.sentences import warn
from fastdyn.kernels.calls.block import PAST_OF_RARE, RARE
from fastdyn.kernels.output import arguments as words
from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE, K
from fastdyn.run import output
from fastdyn.run.begin import shape_of
from fastdyn.run.enough_memory import check_room
from fastdyn.run.functions.compared import LATER
from fastdyn.run.loop import Run
from fastdyn.run.memory import plan
from fastdyn.run.resume import checkpoint_of
from fastdyn.run.stiffness import watch
from fastdyn.specialise import rare
from fastdyn.specialise.scalar import dense_rows_kernel, residual_filters, within_past_kernel

from .past import history_of
from .points import Carried
from .to_and_fro import BLOCK, told_of

N_DENSE = OUTPUT.fields["n_dense"][1]  # the place of the number of polynomials in the record
NOW = STATE.fields["t"][1]  # the place of the time that is reached
# A time that depends on the state is as wrong as the state: later than t by less than these
# tolerances, it counts as t.
SLACK = 10.0


# Numbers of polynomials (8 MB) from which on those that no delay reads any more are dropped.
FEW_NUMBERS = 2**20
SHARE = 0.5  # of the machine's memory, which the polynomials may take


class OnePiece(output.Output):
    """The output of a solve whose polynomials stay in one piece.

    Attributes
    ----------
    longest : float or None
        The longest delay: polynomials that no delay reads any more make room for new ones, so that
        the memory of a long solve is bounded.  None if they are all kept.
    run : DelayRun
        A weak reference: a Run that holds its output is freed with its last name.
    """

    longest: Any = None
    run: Any = None

    def _grow_dense(self, o):
        d = self.d
        spans = self.spans
        n = len(d)
        first = 0
        if self.longest is not None and d.size >= FEW_NUMBERS:
            # The last step may be cut by an event; one polynomial more for roundings.
            needed = spans[n - 1, 0] - self.longest
            first = max(int(np.searchsorted(spans[:, 0], needed, "right")) - 2, 0)
        left = n - first
        if first:
            self.run().compare()
        if 2 * left > n:
            self._n_polynomials = 2 * n
            self._check_memory()
            self._new_polynomials()
        self.d[:left] = d[first:]
        self.spans[:left] = spans[first:]
        o["n_dense"] = left

    def _check_memory(self):
        t = self.spans[-1].sum()
        check_room(
            self._n_polynomials * self._rows * self._n,
            f"room for twice the steps of the delay equation up to t = {t:.10g} takes",
            "steps are kept as long as any delay may read them, all of them where delays depend "
            "on the time or the state, or with `dense_output`. End the span earlier, or loosen "
            "`rtol` and `atol`",
            SHARE,
        )

    def since(self, t0):
        """The time from which on functions can be called: all that they read is kept."""
        first = float(self.spans[0, 0]) if self.record["n_dense"][0] else t0
        return first + self.longest if first > t0 and self.longest is not None else -math.inf

    def put_back(self, arrays):
        """Continue behind the output of a checkpoint."""
        super().put_back(arrays)
        ((polynomials, spans),) = self._dense
        self._dense = []
        n = len(polynomials)
        if n >= len(self.d):
            self._n_polynomials = 2 ** int(n + 1).bit_length()
            self._new_polynomials()
        self.d[:n] = polynomials
        self.spans[:n] = spans
        self.record["n_dense"] = n


class DelayRun(Run):
    """A Run that tells the words of its history where its polynomials are."""

    carried: Carried | None = None
    turns = ""  # what is said of a time of the past that runs to and fro, where the run ended
    _of_state = False
    _n_polynomials = 0  # least room
    longest: float | None = None

    def __init__(self, problem, *given):
        self.laid_out = problem.args[0]
        self._whole = self.laid_out.view(np.int64)
        super().__init__(problem, *given)

    def begin_with(self, problem, known, starts, looks, slope, longest=None):
        """Take the problem, whose jumps the delays carry on; the past becomes that of this Run.

        `known` are the Delays, `starts` the times of jumps that are known before, `looks` tells how
        steps are looked at, see `kernels/output/past/steps.py`; `slope` is the derivative at the
        start, `longest` the longest delay if older steps need not be kept.  Returns the Carried.
        """
        self.longest = longest
        if self.switching is not None and self.switching.follows:
            raise ValueError(
                "`fun` switches at times that depend on components which `on_event` changes: "
                "delays do not carry such times on. Let an event act at the switch, or give the "
                "times by `at`."
            )
        carried = Carried(problem, known, starts)
        self.take(carried.taken(problem))
        self.carried = carried if problem.acts else None
        if not carried.whole and looks & words.GROWN:  # jumps may be within steps
            looks = looks & ~words.GROWN | words.RESIDUALS
        self._first_slope = slope
        self.n_own = len(slope)
        self._lay_own_past(looks)
        this = weakref.proxy(self)  # a Run that holds itself is not freed with its last name
        watch(self.problem, this)
        self.turns = ""
        self._of_state = known.of_state
        self.at_looks = (lambda: this._looked()) if known.of_state else None
        return carried

    def _lay_own_past(self, looks):
        """Lay out the memory of steps that contain their own past."""
        p = self.problem
        rows = K + p.method.n_rows
        n = len(p.y0)
        polynomial = self.plan.arrays["output.d"][3][1] * n
        self._own_past = np.zeros(2 + 2 * polynomial + 4 * n + STATE.itemsize // 8 + rows * n)
        self._rare = np.zeros(PAST_OF_RARE + 1, np.int64)
        self._rare[PAST_OF_RARE] = address_of(self.laid_out)
        self.laid_out[words.PAST_SLACK] = SLACK * np.max(p.rtol)
        whole = self._whole
        whole[words.PAST_TRIAL] = address_of(self._own_past)
        whole[words.PAST_LOOKS] = looks
        whole[words.PAST_DENSE_ROWS] = dense_rows_kernel(p.method.name).address
        by_matrix = residual_filters.get(p.method.name)
        whole[words.PAST_FILTER] = by_matrix().address if by_matrix else 0
        whole[words.PAST_FSAL] = p.method.fsal_stage
        whole[words.PAST_N_ROWS] = rows
        whole[words.PAST_HINT :] = 0
        whole[words.PAST_COUPLED] = words.COUPLED * (p.method.name == "Radau")

    def _looked(self):
        """Whether the last steps are for nothing, because a time of the past runs to and fro."""
        self.turns = told_of(self, BLOCK)
        return bool(self.turns)

    def tell_jumps(self):
        """As `Run.tell_jumps`; times of the past that run to and fro, too."""
        super().tell_jumps()
        if self._of_state and not self.turns and (said := told_of(self)):
            warn(said)

    def steps(self, n_last=None):
        """The starts of the last steps, or of all, shape (m,), and the states there, (n, m)."""
        of = self.grown
        names = "d", "spans", "record"
        d, spans, record = [
            self.view(f"output.{name}") if of is None else getattr(of, name) for name in names
        ]
        count = int(record["n_dense"][0])
        steps = slice(0 if n_last is None else max(0, count - n_last), count)
        return spans[steps, 0], d[steps, 0, : self.n_own].T

    def follower(self):
        """What carries the jumps of actions on; None without actions."""
        return self.carried

    def _plan(self, problem, n_points=None):
        """The plan, with as much room for polynomials as the last solve needed."""
        problem = problem._replace(dense_output=True)  # also where results have none
        *shape, (polynomials, rows), room = shape_of(problem, bool(self._own.pair), n_points)
        polynomials = max(polynomials, self._n_polynomials), rows
        return plan(*shape, polynomials, room, self._matrices.rows)

    def make_room(self):
        """As `Run.make_room`."""
        if self.grown is not None:
            wanted = 2 ** int(self.grown.record["n_dense"][0]).bit_length()
            most = output.PIECE_NUMBERS // self.grown.d[0].size
            self._n_polynomials = min(wanted, most)
        super().make_room()

    def places(self, plan):
        """As `LaidOut.places`: the words of the history name polynomials and records, too."""
        arrays = plan.arrays
        self._whole[words.PAST_ROWS] = arrays["output.d"][3][1]
        first = (address_of(self.laid_out) - self._words.buffer_info()[0]) // 8
        named = (
            (words.PAST_D, "output.d", 0), (words.PAST_SPANS, "output.spans", 0),
            (words.PAST_COUNT, "output.record", N_DENSE), (words.PAST_NOW, "solve.state", NOW),
        )  # fmt: skip
        own = [(first + word, 8 * arrays[name][0] + offset) for word, name, offset in named]
        return np.concatenate([plan.places, own])

    @property
    def since(self):
        """As `LaidOut.since`."""
        return -math.inf if self.grown is None else self.grown.since(self.problem.t0)

    def compare(self):
        """Compare code and functions along the steps that are about to be dropped."""
        if self.snapshots is not None:
            self.compared.now(self, LATER)
            self.take_snapshots(self.compared.most_places)

    def checkpoint(self):
        """As `Run.checkpoint`; the words of the past are of this process, the history of the run.

        Raises
        ------
        ValueError
        """
        p = self.problem
        if p.checkpoint is None:
            return None
        if p.acts:
            raise ValueError(
                "`checkpoint` and `on_event` do not go together in a delay equation: a file has no "
                "jumps that delays carry on. End the run at a terminal event with "
                "`dense_output=True`, and go on from the result."
            )
        alike = []
        for bound in (*self.bounds, *history_of(self.laid_out).bounds):
            values = [each for each in bound.values if each[1] is not self.laid_out]
            alike.append(bound._replace(values=values))
        return checkpoint_of(p, alike)

    @contextmanager
    def another(self):
        """None: the past is that of one Run at a time."""
        yield None

    def stepping(self):
        """The address of the kernel that takes steps again which contain their own past."""
        whole = self._whole
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
        self._whole[words.PAST_OPEN] = 1
        return super().begin(y0, n_steps, snapshots)

    @property
    def output(self):
        """The output of the last solve."""
        if self.grown is None:
            self.grown = OnePiece(self.plan, self.memory)
            self.grown.longest = self.longest
            self.grown.run = weakref.ref(self)
        return self.grown

    def lay_output(self):
        super().lay_output()
        self._whole[words.PAST_D] = address_of(self.output.d)
        self._whole[words.PAST_SPANS] = address_of(self.output.spans)
