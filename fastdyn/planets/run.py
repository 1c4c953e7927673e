"""A run of WisdomHolman: its memory, its chunks of steps, its outputs and checkpoints."""

import time
from itertools import chain
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods.method import Facts
from fastdyn.kernels.methods.wisdom_holman.steps import KERNEL, N_STEPS, N_WORDS, WORDS
from fastdyn.kernels.state.record import FINISHED, MEETING, RUNNING, STATE, Y
from fastdyn.problem import validate
from fastdyn.problem.step_options import fixed_step
from fastdyn.run.checkpoint import Checkpoint, fill
from fastdyn.run.loop import next_chunk, time_bar
from fastdyn.run.outcome import SUCCESS, outcome
from fastdyn.run.result import Ended, made
from fastdyn.specialise.scalar import wisdom_holman_by_words_kernel, wisdom_holman_kernel
from fastdyn.words import kinds

from .corrector import PAIRS, sequence
from .room import HILL, laid_out

NAME = "WisdomHolman"
FIRST_STEPS = 64
ON_STEP = 1e-9  # an output closer to a step, as a share of a step, is at the step


def facts(corrector):
    """The Facts of the method: perturbations are evaluated twice a step, without corrector once."""
    return Facts(
        NAME, order=2, error_order=0, n_stages=2 if corrector else 1, n_rows=0, fsal_stage=0,
        n_dense=0, dense_order=0, start="", dense_rows="", second_order=True, projects=False,
    )  # fmt: skip


class PlanetSteps:
    """The arrays and the kernel of a run.

    Parameters
    ----------
    planets : Planets
    step : float
        Positive.
    t0, tf : float
    corrector : int

    Attributes
    ----------
    state, work, block : ndarray
        As other kernels take them; row Y of `work` is the state at the time of `state`.
    calls : ndarray
        A record of CALLS.
    method : Facts
    y0, h, t0, tf
        As those of a problem.
    bounds : tuple
        Empty: there are no functions of the user.
    settings : tuple
        What distinguishes the run from others, for its checkpoint.
    """

    bounds = ()

    def __init__(self, planets, step, t0, tf, corrector):
        kinds.whole("corrector", corrector)
        if corrector not in PAIRS:
            orders = ", ".join(map(str, [*PAIRS][1:]))
            raise ValueError(f"`corrector={corrector!r}` must be {orders}, or 0 for none.")
        kinds.number("step", step)
        step = fixed_step({"step": step}, t0, tf, NAME)
        self.planets, self.method = planets, facts(corrector)
        self.h = step
        self.t0 = t0
        self.tf = tf
        self.settings = ("corrector", int(corrector), planets.G, planets.masses.tolist())
        order = planets.arranged()
        self.work, self.calls, *motions_and_room = laid_out(
            planets.masses[order], planets.q0[order], planets.v0[order], planets.G, order[1:],
            sequence(int(corrector) if len(order) > 2 else 0),
        )  # fmt: skip
        self.calls["modified"] = bool(corrector)
        self.y0 = planets.initial_state()
        self.work[Y] = self.y0
        self.state: Any = np.zeros(1, STATE)
        self.block = np.zeros(N_WORDS, np.int64)
        s = self.state[0]
        s["t"] = t0
        s["t_old"] = t0
        s["t_start"] = t0
        s["t_end"] = tf
        s["t_stop"] = tf
        s["h"] = step
        s["direction"] = 1.0 if tf >= t0 else -1.0
        s["n_extra"] = self.method.n_stages
        rows = chain(*motions_and_room)
        given = self.state, self.calls, *rows, self.work[Y], 0
        self._advance = Call(wisdom_holman_kernel(), *given)
        self.block[KERNEL] = wisdom_holman_kernel().address
        self.block[WORDS] = self._advance.words.buffer_info()[0]
        self.block[N_STEPS] = self._advance.place("n_steps")

    @property
    def address(self):
        """The address of the kernel, in the form of other kernels."""
        return wisdom_holman_by_words_kernel().address

    def start(self):
        """The status before the first step: the kernel starts by itself."""
        return RUNNING

    def took(self, seconds):
        """Nothing: there is one kernel only."""

    @property
    def t(self):
        return float(self.state["t"][0])

    @property
    def n_steps(self):
        return int(self.state["n_accepted"][0])

    def advance(self, n_steps, ahead=0.0):
        """Take steps, then look ahead; the status."""
        self.calls["ahead"] = ahead
        self._advance["n_steps"] = n_steps
        status = self._advance()
        self.calls["ahead"] = 0.0
        return status

    def message(self, status):
        """The sentence about a run that ended with a failure."""
        if status == MEETING:
            met = self.calls[0]
            i, j = sorted([int(met["met"]), int(met["met_by"])])
            return (
                f"Bodies {i} and {j} come closer than {HILL:g} mutual Hill radii at t = "
                f"{met['met_at']:.10g}: WisdomHolman does not follow encounters. Go on "
                "from an output before by an adaptive method with `Planets.rhs`."
            )
        return outcome(status, self.state, self.work, self)[1]

    def tell(self):
        """Warn of steps too long for a passage near the star; two bodies are exact."""
        coarse = int(self.calls["n_coarse"][0])
        if coarse and len(self.planets.masses) > 2:
            warn(
                f"{coarse} of {self.n_steps} steps were longer than an eighth of a revolution at "
                "the distance of a planet there: its perturbations are too coarse, and the energy "
                "may drift. Reduce `step`.",
                RuntimeWarning,
            )


def header_of(steps, t_eval):
    """The identity of a run, for its checkpoint."""
    return {
        "method": NAME, "span": [steps.t0, steps.tf], "step": steps.h,
        "settings": repr(steps.settings), "initial state": steps.y0.tolist(),
        "outputs": t_eval.tolist(),
    }  # fmt: skip


def solve(planets, t_span, step, t_eval, corrector, checkpoint, progress):
    """`Planets.solve`."""
    t0, tf = validate.time_span(t_span)
    if not np.isfinite(tf):
        raise ValueError("`t_span` must end: a run at constant step has no last step otherwise.")
    kinds.flag("progress", progress)
    if checkpoint is not None:
        kinds.path("checkpoint", checkpoint)
    t_eval = validate.output_times(t_eval, t0, tf)
    t_eval = np.array([t0, tf] if t_eval is None else t_eval, float)
    steps = PlanetSteps(planets, step, t0, tf, corrector)
    found = _Outputs(steps, t_eval, checkpoint)
    with time_bar(progress, steps) as bar:
        status = found.run(bar)
    steps.tell()
    n = int(found.filled[0])
    return made(
        steps.method, Ended.of(steps.state[0]), t=t_eval[:n].copy(), y=found.y[:n].T.copy(),
        status=0 if status == FINISHED else -1,
        message=SUCCESS if status == FINISHED else steps.message(status),
    )  # fmt: skip


class _Outputs:
    """The states at the times of output, and the chunks of steps on the way to them."""

    def __init__(self, steps, t_eval, checkpoint):
        self._steps = steps
        self._t_eval = t_eval
        self.y = np.zeros((len(t_eval), steps.work.shape[1]))
        self.filled = np.zeros(1, np.int64)
        self._file = None
        if checkpoint is not None:
            self._file = Checkpoint(checkpoint, header_of(steps, t_eval))
            arrays = self._file.load()
            if arrays is not None:
                fill(self._arrays(), arrays)

    def _arrays(self):
        return {
            "state": self._steps.state, "work": self._steps.work, "y": self.y,
            "filled": self.filled,
        }  # fmt: skip

    def run(self, bar):
        """Fill the outputs and go to the end; the status."""
        try:
            for i in range(int(self.filled[0]), len(self._t_eval)):
                status = self._reach(float(self._t_eval[i]), bar)
                if status != RUNNING:
                    return status
                self.y[i] = self._steps.work[Y]
                self.filled[0] = i + 1
            status = self._reach(self._steps.tf, bar)
        except KeyboardInterrupt:
            if self._file is not None:
                self._file.save(self._arrays())
            raise
        if self._file is not None:
            self._file.save(self._arrays())
        return FINISHED if status == RUNNING else status

    def _reach(self, t, bar):
        """Take the whole steps before t, and write the state at t to row Y; the status."""
        s = self._steps
        shares = abs(t - s.t0) / s.h
        whole = round(shares) if abs(shares - round(shares)) < ON_STEP else int(shares)
        chunk = FIRST_STEPS
        left = whole - s.n_steps
        while left > chunk:
            began = time.perf_counter()
            status = s.advance(chunk)
            left = left - chunk
            if status not in (RUNNING, FINISHED):
                return status
            chunk = next_chunk(chunk, time.perf_counter() - began)
            if bar is not None:
                bar.update(abs(s.t - s.t0) - bar.n)
            if self._file is not None and self._file.due():
                self._file.save(self._arrays())
        sign = 1.0 if s.tf >= s.t0 else -1.0
        ahead = (
            0.0
            if whole >= shares or abs(shares - whole) < ON_STEP
            else t - s.t0 - sign * whole * s.h
        )
        status = s.advance(left, ahead) if left or ahead or t != s.t0 else RUNNING
        return RUNNING if status == FINISHED else status
