"""A Run that stores the end of each step beside its output, for a sweep back over the steps."""

import numpy as np

from fastdyn.kernels.methods.adjoint import Steps
from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE, Y
from fastdyn.run.begin import shape_of
from fastdyn.run.loop import GOES_ON, Run
from fastdyn.run.memory import plan
from fastdyn.run.output import PIECE_NUMBERS, Output

ROOM = 2**24  # numbers in the states that a solve keeps: 128 MB
FIRST, MOST = 512, 2**16  # steps in a piece of the output
TOGETHER = 1000  # steps, after which Ctrl-C acts


class StepsAndOutput(Output):
    """The output at the times of `t_eval`, and behind it, in the same arrays, the steps.

    If the states take more than `room` numbers, only the state after each `apart`-th step is kept.
    """

    def __init__(self, plan, memory, y0, n_eval, room):
        super().__init__(plan, memory)
        self._begin, self._room = n_eval + 1, room
        self.y[n_eval] = y0
        self._times, self._states, self.n_steps, self.apart = [], [], 0, 1

    def make_room(self):
        """Put the steps aside; the arrays remain."""
        o = self.record[0]
        new = slice(self._begin, int(o["n_out"]))
        first = new.start + (-(self.n_steps + 1)) % self.apart
        self._times.append(self.t[new].copy())
        self._states.append(self.y[first : new.stop : self.apart].copy())
        self.n_steps += new.stop - new.start
        o["n_out"] = self._begin
        super().make_room()  # for occurrences of events
        while self.n_steps // self.apart * self._n > self._room:
            before = 0
            for i, piece in enumerate(self._states):  # those at odd places are dropped
                self._states[i] = piece[(before + 1) % 2 :: 2].copy()
                before += len(piece)
            self.apart *= 2

    def points(self):
        """The times and states of `t_eval`, as far as they are reached."""
        n = int(self.record["i_eval"][0])
        return self.t[:n].copy(), self.y[:n].copy()

    def steps(self):
        """The times at the ends of all steps; the initial state, and each `apart`-th state."""
        n, begin = int(self.record["n_out"][0]), self._begin
        if not self._times and (n - begin) * self._n <= self._room:
            self.n_steps = n - begin
            return self.t[begin:n], self.y[begin - 1 : n]
        self.make_room()
        return np.concatenate(self._times), np.concatenate(
            [self.y[begin - 1 : begin], *self._states]
        )


class Keeping(Run):
    """A Run of a problem with `t_eval` that keeps its steps.

    Attributes
    ----------
    room : int
        The most numbers in the states that it keeps.
    kept : Kept or None
        The steps of the last solve, if they are wanted later.
    """

    room, _piece, kept = ROOM, FIRST, None

    def _plan(self, problem, n_points=None):
        shape = [*shape_of(problem, bool(self._own.pair))]
        room = max(min(self._piece, PIECE_NUMBERS // max(len(problem.y0), 1)), 4)
        shape[5] = len(problem.t_eval) + 1 + room
        return plan(*shape, self._matrices.rows)

    def take(self, problem):
        """Take another problem, with as many times of output."""
        super().take(problem)
        begin = STATE.itemsize // 8
        record = self._image[begin : begin + OUTPUT.itemsize // 8].view(OUTPUT)
        record["every_step"], record["n_out"] = 1, len(problem.t_eval) + 1

    def make_room(self):
        """Prepare for the next solve, which may take as many steps as the last one."""
        self.take_snapshots(0)
        if self.grown is not None:
            steps, self.grown = self.grown.n_steps, None
            wanted = min(2 ** int(steps).bit_length(), MOST)
            if wanted > self._piece:
                self._piece = wanted
                self._lay_out(self._plan(self.problem))
                self._lay_times()

    @property
    def output(self):
        """The output of the last solve."""
        if self.grown is None:
            y0, n_eval = self.problem.y0, len(self.problem.t_eval)
            self.grown = StepsAndOutput(self.plan, self.memory, y0, n_eval, self.room)
        return self.grown

    def again(self):
        """Solve without a look at Python code; the status."""
        status = self.begin(self.problem.y0, TOGETHER)
        while status in GOES_ON:
            self.output.make_room()
            self.lay_output()
            status = self.step(TOGETHER)
        return status


class Kept:
    """The steps of a solve: a Steps, and the states after each `apart`-th of them, y0 included.

    Attributes
    ----------
    t : ndarray, shape (n_steps + 1,)
        The times of the steps as the output has them.
    steps : Steps
    states : ndarray, shape (n_kept, n)
    apart : int
    """

    def __init__(self, problem, times, states, apart):
        self.t, self.apart = np.concatenate([[problem.t0], times]), apart
        self.states = states
        begin, end = self.t[:-1].copy(), times.copy()
        fresh = np.zeros(len(times), np.int64)
        fresh[:1] = 1
        if len(problem.segments):
            of_t = {stored: i for i, stored in enumerate(problem.segments[:, 2].tolist())}
            begin[0] = problem.segments[0, 0]
            for j in np.flatnonzero(np.isin(times, problem.segments[:, 2])):
                i = of_t[times[j]]
                end[j] = problem.segments[i, 1]
                if j + 1 < len(times):
                    begin[j + 1], fresh[j + 1] = problem.segments[i + 1, 0], 1
        self.steps = Steps(begin, end, fresh)

    def end_with_step(self, run):
        """Let the last step of a run that an event ended have its whole length."""
        end = float(run.view("solve.state")["t"][0])
        self.t[-1] = self.steps.end[-1] = end
        if self.apart == 1:
            self.states[-1] = run.view("solve.work")[Y]


def kept_of(run):
    """The Kept of a Keeping run that has reached the end."""
    times, states = run.output.steps()
    return Kept(run.problem, times, states, run.output.apart)


def kept_in(problem, plan, memory, shared):
    """The Kept of a solve whose steps all lie in its memory, which later solves may share."""
    n_eval, n = len(problem.t_eval), int(plan.view(memory, "output.record")["n_out"][0])
    t, y = [plan.view(memory, name) for name in ("output.t", "output.y")]
    y[n_eval] = problem.y0
    states = y[n_eval:n]
    return Kept(problem, t[n_eval + 1 : n], states.copy() if shared else states, 1)
