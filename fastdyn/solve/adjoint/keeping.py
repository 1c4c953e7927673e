"""A Run that stores the end of each step beside its output, for a sweep back over the steps."""

import numpy as np

from fastdyn.kernels.output.arguments import OUTPUT, WHOLE
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

    The rows are the ends of steps, and the states behind actions, whose times are not later than
    the row before.  If the states take more than `room` numbers, only the states behind actions,
    and those in each `apart`-th row, are kept.
    """

    def __init__(self, plan, memory, problem, room):
        super().__init__(plan, memory)
        p = problem
        n_eval = len(problem.t_eval)
        self._begin = n_eval + 1
        self._room = room
        self._last = p.t0
        self._sign = 1.0 if p.tf >= p.t0 else -1.0
        self.y[n_eval] = p.y0
        self._times = []
        self._states = []
        self._rows = []
        self._behind = []
        self.n_rows = 0
        self.apart = 1

    def make_room(self):
        """Put the rows aside; the arrays remain."""
        o = self.record[0]
        new = slice(self._begin, int(o["n_out"]))
        times = self.t[new].copy()
        behind = self._found_behind(self.t[new])
        rows = np.arange(self.n_rows + 1, self.n_rows + 1 + len(times))
        kept = behind | (rows % self.apart == 0)
        self._times.append(times)
        self._behind.append(rows[behind])
        self._rows.append(rows[kept])
        self._states.append(self.y[new][kept])
        self.n_rows += len(times)
        if len(times):
            self._last = times[-1]
        o["n_out"] = self._begin
        super().make_room()  # for occurrences of events
        while sum(map(len, self._rows)) * self._n > self._room and self.apart <= self.n_rows:
            self.apart *= 2
            for i, (rows, behind) in enumerate(zip(self._rows, self._behind, strict=True)):
                kept = (rows % self.apart == 0) | np.isin(rows, behind)
                self._rows[i], self._states[i] = rows[kept], self._states[i][kept]

    def _found_behind(self, times):
        """Which of new times are those of states behind actions."""
        return self._sign * np.diff(times, prepend=self._last) <= 0.0

    def points(self):
        """The times and states of `t_eval`, as far as they are reached."""
        n = int(self.record["i_eval"][0])
        return self.t[:n].copy(), self.y[:n].copy()

    def rows(self):
        """The times of all rows; the numbers of the rows that are kept, and their states.

        Row 0 is the initial state.  The last result has the rows of states behind actions.
        """
        n = int(self.record["n_out"][0])
        begin = self._begin
        if not self._times and (n - begin) * self._n <= self._room:
            times = self.t[begin:n]
            numbers = np.arange(n - begin + 1)
            return times, numbers, self.y[begin - 1 : n], numbers[1:][self._found_behind(times)]
        self.make_room()
        numbers = np.concatenate([[0], *self._rows])
        states = np.concatenate([self.y[begin - 1 : begin], *self._states])
        return np.concatenate(self._times), numbers, states, np.concatenate(self._behind)


class Keeping(Run):
    """A Run of a problem with `t_eval` that keeps its steps.

    Attributes
    ----------
    room : int
        The most numbers in the states that it keeps.
    kept : list of legs.Leg or None
        The steps of the last solve, if they are wanted later.
    """

    room = ROOM
    _piece = FIRST
    kept = None

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
        record["every_step"], record["n_out"] = WHOLE, len(problem.t_eval) + 1

    def make_room(self):
        """Prepare for the next solve, which may take as many steps as the last one."""
        self.take_snapshots(0)
        if self.grown is not None:
            steps = self.grown.n_rows
            self.grown = None
            wanted = min(2 ** int(steps).bit_length(), MOST)
            if wanted > self._piece:
                self._piece = wanted
                self._lay_out(self._plan(self.problem))
                self._lay_times()

    @property
    def output(self):
        """The output of the last solve."""
        if self.grown is None:
            self.grown = StepsAndOutput(self.plan, self.memory, self.problem, self.room)
        return self.grown

    def again(self):
        """Solve without a look at Python code; the status."""
        status = self.begin(self.problem.y0, TOGETHER)
        while status in GOES_ON:
            self.output.make_room()
            self.lay_output()
            status = self.step(TOGETHER)
        return status
