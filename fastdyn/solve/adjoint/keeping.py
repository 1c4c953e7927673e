"""A Run that stores the end of each step beside its output, for a sweep back over the steps."""

import numpy as np

from fastdyn.kernels.methods.adjoint import Steps
from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE
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

    def __init__(self, plan, memory, n_eval, room):
        super().__init__(plan, memory)
        self._n_eval, self._room = n_eval, room
        self._times, self._states, self.n_steps, self.apart = [], [], 0, 1

    def make_room(self):
        """Put the steps aside; the arrays remain."""
        self._put_aside(copied=True)

    def _put_aside(self, copied):
        o = self.record[0]
        new = slice(self._n_eval, int(o["n_out"]))
        k = new.stop - new.start
        first = new.start + (-(self.n_steps + 1)) % self.apart
        states = self.y[first : new.stop : self.apart]
        self._times.append(self.t[new].copy())
        self._states.append(states.copy() if copied or self.apart > 1 else states)
        self.n_steps += k
        o["n_out"] = self._n_eval
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
        """The times at the ends of all steps, and the states after each `apart`-th of them."""
        self._put_aside(copied=False)
        return np.concatenate(self._times), np.concatenate(self._states)


class Keeping(Run):
    """A Run of a problem with `t_eval` that keeps its steps.

    Attributes
    ----------
    room : int
        The most numbers in the states that it keeps.
    """

    room, _piece = ROOM, FIRST

    def _plan(self, problem, n_points=None):
        shape = [*shape_of(problem, bool(self._own.pair))]
        room = max(min(self._piece, PIECE_NUMBERS // max(len(problem.y0), 1)), 4)
        shape[5] = len(problem.t_eval) + room
        return plan(*shape, self._matrices.rows)

    def take(self, problem):
        """Take another problem, with as many times of output."""
        super().take(problem)
        begin = STATE.itemsize // 8
        record = self._image[begin : begin + OUTPUT.itemsize // 8].view(OUTPUT)
        record["every_step"], record["n_out"] = 1, len(problem.t_eval)

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
            n_eval = len(self.problem.t_eval)
            self.grown = StepsAndOutput(self.plan, self.memory, n_eval, self.room)
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
        self.states = np.concatenate([problem.y0[None], states])
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

    def place(self, t):
        """For each time of output, its step and its place in the step, 1 at the end.

        Returns the places, and for each step the number of its first output.
        """
        sign = 1.0 if self.t[-1] >= self.t[0] else -1.0
        at = np.searchsorted(sign * self.t, sign * t, "left") - 1
        at = np.clip(at, 0, len(self.t) - 2)
        begin, end = self.steps.t[at], self.steps.end[at]
        x = np.clip((t - begin) / (end - begin), 0.0, 1.0)
        x[t == self.t[at + 1]] = 1.0
        return x, np.searchsorted(at, np.arange(len(self.t)))


def kept_of(run):
    """The Kept of a Keeping run that has reached the end."""
    times, states = run.output.steps()
    return Kept(run.problem, times, states, run.output.apart)
