"""The chunk loop: advance, grow the output, show progress, stop on Ctrl-C."""

import struct
from time import perf_counter
from typing import Any

import numpy as np
from numpy.linalg import LinAlgError

from fastdyn.kernels.calls.block import RAISED_WORD
from fastdyn.kernels.methods.method import SHARED_METHODS
from fastdyn.kernels.state.record import (
    FINISHED,
    FULL,
    INTERRUPTED,
    RUNNING,
    STATE,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    STOPPED,
    Y,
)
from fastdyn.plot.needed import progress_bar

from .functions.compared import Compared
from .functions.crawling import counts_beyond
from .laid_out import LaidOut
from .resume import checkpoint_of, from_arrays, to_arrays

CHUNK_SECONDS = 0.05  # length of a chunk; Ctrl-C, progress bar and tier act between two chunks
GOES_ON = (RUNNING, FULL)
# A run is judged after FIRST_LOOK steps, and again after as many steps, or after LATER times all
# steps so far: by steps and not by chunks, so that the clock decides nothing.  A run that cannot
# go on has then lost a third of its time at most; a look by "auto" takes up to 1 ms, and a run of
# 10^6 steps is looked at 16 times.
FIRST_LOOK = 2000
LATER = 0.5
# A run by series stands if the mean step between two looks is shorter than STANDS times the longest
# mean step before, and the end is more than MOST_AHEAD such steps away.  MANY_AHEAD takes the place
# of MOST_AHEAD if another method may follow, or if one of SLIDING steps is a step at a jump.
STANDS = 1e-3
FEWEST = 1000
MANY_AHEAD = 1e6
MOST_AHEAD = 1e8
SLIDING = 4
# A run slides along a jump if NOWHERE steps advance so little that FOR_EVER steps of their mean
# length would cover neither the way to the end nor the way from the start.
NOWHERE = 10_000
FOR_EVER = 1e11


def counters(state):
    """n_accepted, n_rejected and n_extra of a state."""
    return struct.unpack_from("3q", state, STATE.fields["n_accepted"][1])


def reached(state):
    """The time of a STATE, the number of steps, and for Taylor the number of steps at a jump."""
    return float(state["t"]), int(state["n_accepted"]), int(state["n_equal"])


def announce(bounds):
    """Warn of each function that stays in Python."""
    for bound in bounds:
        if bound.callback is not None:
            bound.callback.announce()


def next_chunk(n_steps, spent):
    """The number of steps of the next chunk, when `n_steps` took `spent` seconds."""
    return max(1, int(n_steps * min(4.0, CHUNK_SECONDS / max(spent, 1e-9))))


def next_look(n_steps):
    """The number of steps of the first look after `n_steps` steps."""
    at = FIRST_LOOK
    while at <= n_steps:
        at += max(FIRST_LOOK, int(LATER * at))
    return at


class Progress:
    """Judges between steps whether a solve can reach its end.

    A Taylor series does not pass a singularity, but its steps may alternate for ever between the
    two sides of a singularity, or of a surface on which the state slides.

    Parameters
    ----------
    problem : problem.validate.Problem
    t : float
        The time after the first `n_steps` steps.
    n_steps, n_at_jumps : int
        Steps so far, and steps at a jump so far.
    most : float
        The number of steps to the end above which a Taylor series stands.
    """

    def __init__(self, problem, t, n_steps, n_at_jumps=0, most=MOST_AHEAD):
        self._t0 = problem.t0
        self._tf = problem.tf
        self._series = problem.method.series
        self._longest = abs(t - problem.t0) / max(n_steps, 1)
        self._most = most
        self._last = (t, n_steps, n_at_jumps)
        self._mark = (t, n_steps)

    def from_step(self):
        """The number of steps from which on `stands` may be true, or may note something."""
        return 0 if self._series else self._mark[1] + NOWHERE

    def stands(self, t, n_steps, n_at_jumps=0):
        """True if the steps since the last call are so short that the end is out of reach."""
        before, taken, at_jumps = self._last
        taken = n_steps - taken
        at_jumps = n_at_jumps - at_jumps
        self._last = t, n_steps, n_at_jumps
        if self._series:
            step = abs(t - before) / max(taken, 1)
            ahead = MANY_AHEAD if SLIDING * at_jumps > taken else self._most
            if taken > FEWEST and step < STANDS * self._longest:
                if abs(self._tf - t) > ahead * step:
                    return True
            self._longest = max(self._longest, step)
        before = self._mark[0]
        taken = n_steps - self._mark[1]
        if taken < NOWHERE:
            return False
        self._mark = t, n_steps
        return min(abs(self._tf - t), abs(t - self._t0)) > FOR_EVER * abs(t - before) / taken


class Looks:
    """Looks at a Run after fixed numbers of steps: whether it goes on, and whether it crawls.

    Parameters
    ----------
    run : Run
    most : float
        As of Progress.
    crawls_to : float
        The number of steps to the end above which a run that crawls ends.
    """

    def __init__(self, run, done, most, crawls_to=np.inf):
        p = run.problem
        self.run = run
        self._crawls_to = crawls_to
        self._progress = Progress(p, p.t0, 0, most=most)
        self._at = self._next(done - 1)

    def _next(self, done):
        """The steps of the next look after `done` steps, without those that can see nothing."""
        if self.run.at_looks is None:
            done = max(done, self._progress.from_step() - 1)
        return next_look(done)

    def left(self, done):
        """The number of steps up to the next look, after `done` steps."""
        samples = self.run.samples
        return min(self._at - done, np.inf if samples is None else samples.left(done))

    def end(self, done):
        """Look after `done` steps; whether the run ends, as no step is short enough."""
        run = self.run
        samples = run.samples
        if done < self._at and (samples is None or samples.left(done) > 1):
            return False
        state = run.view("solve.state")[0]
        if done >= self._at:
            if self._progress.stands(*reached(state)):
                return True
            if run.at_looks is not None and run.at_looks():
                return True
            self._at = self._next(done)
        if samples is None or samples.left(done) > 1:
            return False
        step = samples.take(done, float(state["t"]), run.view("solve.work")[Y])
        return step is not None and abs(run.problem.tf - state["t"]) > self._crawls_to * step


def stops(callback, solver):
    """Call the user's `callback` after a step; True if the callback ends the run."""
    try:
        found = callback(solver)
    except StopIteration:
        return True
    return isinstance(found, bool | np.bool_) and bool(found)


class Raised(Exception):
    """The equations raised the exception `error` where another method may never call them."""

    def __init__(self, error):
        super().__init__(str(error))
        self.error = error


class Run(LaidOut):
    """A solve: the loop over chunks of steps, from the initial state to the end."""

    at_looks: Any = None  # a function called after fixed numbers of steps; if true, the run ends
    at_end: Any = None  # a function called after the steps, which tells what they did
    may_follow = False  # whether another method follows if this one fails
    samples: Any = None  # the crawling.Samples of its steps
    looks: Any = None  # the Looks, of a Run of which every step is taken alone

    def __init__(self, *given):
        super().__init__(*given)
        self.compared = Compared(self)

    def let_go(self):
        super().let_go()
        self.look_no_more()

    def look_no_more(self):
        """Drop what looks at the steps of a solve, which refers to its functions."""
        self.at_looks = None
        self.at_end = None
        self.samples = None

    def n_first(self, most=FIRST_LOOK):
        """The steps of the first chunk, at most `most`.

        Equations in Python are interrupted within a step: their chunks may be long.
        """
        if self.follower() is not None:
            return 1
        if self._own.function is None and not self.watched:
            return int(min(most, self.problem.max_steps))
        return int(min(CHUNK_SECONDS / self.cost, most, self.problem.max_steps))

    def follower(self):
        """The object that follows the state between steps, chunks of one step each; or None."""
        return self.switching if self.switching is not None and self.switching.follows else None

    def solve(self, y0, begun=None):
        """Solve from an initial state to the end; the status.

        `begun` are the status, the steps and the seconds of a first chunk that is taken already.
        """
        if (follower := self.follower()) is not None:
            follower.begin(y0)
        try:
            if begun is None:
                first = self.n_first()
                began = perf_counter()
                status = self.tier.timed(self.begin, y0, first, self.compared.places())
                spent = perf_counter() - began
            else:
                status, first, spent = begun
                self.tier.record_time(spent)
            if status in GOES_ON or self.watched:
                status = self._go_on(status, first, spent)
        except KeyboardInterrupt:
            if self.problem.on_interrupt != "return":
                raise
            return INTERRUPTED
        self.tier.promote()
        if status != FINISHED:
            self._told(status)
        self.compared.after(self)
        self.tell_jumps()
        return status

    def tell_jumps(self):
        """Warn if a step jumped over changes of the equations or crossings, or is wrong."""
        self.tell_lost()
        if self.switching is not None:
            self.switching.tell(self.view("output.record"))
        if self.at_end is not None:
            self.at_end()

    def _told(self, status):
        """Raise the exception of a user's function; as a Raised, if another method may follow."""
        try:
            self.check(status)
        except (ArithmeticError, ValueError) as error:
            of_stage = isinstance(error, ArithmeticError | LinAlgError) or type(error) is ValueError
            if not (self.may_follow and of_stage and self._own.block[RAISED_WORD]):
                raise
            raise Raised(error) from error

    def checkpoint(self):
        """The Checkpoint of the solve, or None."""
        return checkpoint_of(self.problem, self.bounds)

    def is_plain(self):
        """Whether functions are all compiled, or all in Python, and nothing watches or catches."""
        bare = not self._late and (self._followed is None or self._is_in_python())
        left_alone = not self.watched and self.problem.on_interrupt == "raise"
        return (
            bare
            and left_alone
            and self.follower() is None
            and not self._own.pair
            and self.n_first() > 0
        )

    def _is_in_python(self):
        """Whether each function runs in Python, and nothing else does."""
        return all(b.callback is not None for b in self.bounds) and not self._matrices.solver

    def words(self):
        """The words of the kernel's arguments and of its Launch; both change with the plan."""
        return self._words, self._launch

    def to_tell(self):
        """The names of the counts of what a solve is to tell, steps and crossings."""
        return ["n_standing"] * counts_beyond(self.problem) + ["lost"] * self.tells

    def tells_of(self):
        """``told(memory)``: the counts of what a solve is to tell; or None."""
        names = self.to_tell()
        return self.plan.counts(*names) if names else None

    def doubts(self, memory):
        """Whether a step of a ReadyRun may have jumped over changes, of which nobody decided."""
        if self.switching is None:
            return False
        return self.switching.doubts(self.plan.view(memory, "output.record"))

    def first_memory(self):
        """The first content of a ReadyRun's memory, and its times of output or None."""
        if self.switching is not None:
            self.switching.leave_undecided()
        return self._image, self._t_eval

    def _go_on(self, status, n_steps, spent):
        """Take chunks up to the end, after a first chunk of `n_steps`; the status."""
        p = self.problem
        chunk = max(1, int(CHUNK_SECONDS / (spent * self.evaluations)))
        if n_steps:
            chunk = next_chunk(n_steps, spent)
        if self.snapshots is None and self.compared.deciding:  # in a long run they cost nothing
            self.take_snapshots(self.compared.most_places)
        follower = self.follower()
        file: Any = self.checkpoint()
        if file is not None and (saved := file.load()) is not None:
            status = from_arrays(saved, self)
            self.lay_output()
        if not p.progress:
            return self._in_chunks(status, chunk, follower, file)
        with time_bar(p.progress, p) as bar:
            return self._in_chunks(status, chunk, follower, file, bar)

    def _in_chunks(self, status, chunk, follower, file, bar=None):
        """`_go_on` behind the preparations; `follower`, `file` and `bar` may be None."""
        p = self.problem
        tier = self.tier
        state = self.view("solve.state")
        done = int(state["n_accepted"][0])
        crawls_to = np.inf if p.method.name in SHARED_METHODS else MOST_AHEAD
        looks = Looks(self, done, MANY_AHEAD if self.may_follow else MOST_AHEAD, crawls_to)
        try:
            while status in GOES_ON:
                if looks.end(done):
                    return STEP_TOO_SMALL
                if status == FULL:
                    self.output.make_room()
                    self.lay_output()
                left = p.max_steps - done
                if left <= 0:
                    return STEP_LIMIT
                alone = p.callback or follower is not None
                n_steps = 1 if alone else int(min(chunk, left, looks.left(done)))
                if follower is not None:
                    follower.follow(self)
                began = perf_counter()
                status = tier.timed(self.step, n_steps)
                spent = perf_counter() - began
                before = done
                done = int(state["n_accepted"][0])
                if status == RUNNING:
                    chunk = next_chunk(chunk, spent * chunk / n_steps)  # as if no look had cut it
                    tier.promote()
                if bar is not None:
                    bar.update(abs(float(state["t"][0]) - p.t0) - bar.n)
                if file is not None and (file.due() or status not in GOES_ON):
                    file.save(to_arrays(status, self))
                if p.callback and done > before:
                    if stops(p.callback, self) and status in GOES_ON:
                        return STOPPED
                    self.follow_again()
        except KeyboardInterrupt:
            if file is not None and status in GOES_ON:
                file.save(to_arrays(status, self))
            raise
        return status


def time_bar(wanted, problem):
    """A progress bar of the time."""
    return progress_bar(
        wanted,
        total=abs(problem.tf - problem.t0),
        desc=problem.method.name,
        bar_format="{l_bar}{bar}| t {n:.4g}/{total:.4g} [{elapsed}<{remaining}]",
    )
