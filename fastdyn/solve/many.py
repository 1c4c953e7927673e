"""Many solves by a prepared solver in one call of a kernel: `Prepared.many`."""

import math
from time import perf_counter

import numpy as np

from fastdyn.code_store import Call
from fastdyn.code_store.call import address_of
from fastdyn.kernels.output.arguments import BEGUN, GIVEN_UP, NEXT, Many
from fastdyn.kernels.state.record import BORDER, EVENT, FINISHED, INTERRUPTED, RAISED, RUNNING
from fastdyn.problem.events import between_steps
from fastdyn.problem.second_order_and_pairs import given_state, probe_equations
from fastdyn.run.functions.bound import raise_kept
from fastdyn.run.functions.compared import LATER, compare
from fastdyn.run.functions.switching import switching_of
from fastdyn.run.loop import Progress, Run, next_chunk, reached
from fastdyn.run.outcome import LEFT
from fastdyn.run.result import Counted, OdeResult, counted
from fastdyn.run.solve_problem import verify
from fastdyn.specialise.scalar import many_kernel

FIRST_STEPS = 64
UNLIMITED = 2**62  # steps
MOST_AGAIN = 1000  # steps of a solve that is taken again
STATUS = {
    FINISHED: 0,
    EVENT: 1,
    INTERRUPTED: -2,
    BORDER: LEFT,
}  # SciPy's status; -1 for every failure


class Ends:
    """The results of many solves, in the arrays of `kernels.output.arguments.Many`."""

    def __init__(self, problem, m, n):
        self._problem, t_eval = problem, problem.t_eval
        self.t = np.full(m, math.nan)
        self.y = np.full((m, 1 if t_eval is None else len(t_eval), n), math.nan)
        self.counts = np.zeros((m, 4), np.int64)
        self.counts[:, 0] = INTERRUPTED

    def put(self, i, result):
        """Take over the result of solve i, which was solved by itself."""
        p, y = self._problem, np.asarray(result.y)
        if p.t_eval is None:
            self.t[i], self.y[i, 0] = result.t[-1], y[:, -1]
        elif y.size:
            self.y[i, : y.shape[1]] = y.T
        code = {code: status for status, code in STATUS.items()}.get(result.status, -1)
        taken = result.n_accepted, result.n_rejected
        self.counts[i] = code, *taken, result.nfev - p.method.n_stages * sum(taken)

    def result(self):
        p = self._problem
        status, n_accepted, n_rejected, n_extra = self.counts.T
        numbers = counted(p.method, Counted(n_accepted, n_rejected, n_extra))
        codes = np.array([STATUS.get(code, -1) for code in status.tolist()], np.int64)
        return OdeResult(
            t=self.t if p.t_eval is None else p.t_eval.copy(),
            y=self.y[:, 0] if p.t_eval is None else self.y.transpose(0, 2, 1),
            status=codes, success=codes >= 0,
            **{name: number.copy() for name, number in numbers.items() if number is not None},
        )  # fmt: skip


def solve_many(problem, members):
    """The Ends of all members; None if a function stays in Python, or switches at times of its own
    for each member."""
    p = problem._replace(y0=members.state(0).copy(), args=members.first)
    n = members.n
    functions = [(p.fun, p.mode, len(given_state(p)))]
    functions += [(*each, n) for each in between_steps(p)]
    found = [members.bind(*one, members.near(p, one[2])) for one in functions]
    bounds = [bound for bound, _ in found]
    if any(bound.function is None for bound in bounds):
        return None
    switching = switching_of(p, bounds[0])
    if switching is not None and switching.ends and switching.varying(members, bounds[0]):
        return None
    verify(bounds[0], lambda: probe_equations(p), n)
    run, ends = Run(p, bounds[0], bounds[1:]), Ends(p, members.count, n)
    places = [
        (address_of(bound.block) + 8 * word, column)
        for bound, where in found
        for word, column in where
    ]
    call = _call(run, members, np.array(places, np.int64).reshape(-1, 2), ends)
    try:
        _loop(run, members, *call)
    except KeyboardInterrupt:
        if p.on_interrupt != "return":
            raise
    _compare(run, members, found, ends)
    return ends


def _compare(run, members, found, ends):
    """Raise Different if code and function differ along some solves, which are taken again."""
    count = run.compared.due()
    if not count:
        return
    chosen = np.linspace(0, members.count - 1, max(2, count // LATER))
    with run.another() as again:
        for i in np.unique(chosen.astype(int)).tolist():
            for bound, where in found:
                bound.keepalive[1] = members.args(i)
                for word, column in where:
                    bound.block[word] = members.words[i, column]
            again.begin(members.state(i).copy(), MOST_AGAIN, run.compared.most_places)
            compare(again, LATER, {})


def _call(run, members, places, ends):
    """The kernel with its arguments, and the queue of the solves."""
    p, queue = run.problem, np.array([0, members.count, 0])
    launch = run.new_launch()
    records = [run.view(name) for name in ("solve.state", "output.record", "output.t", "output.y")]
    many = Many(
        queue, *records, members.y0, members.words, places, ends.t, ends.y, ends.counts,
        run.plan.at["n_steps"], UNLIMITED if p.max_steps == math.inf else int(p.max_steps),
    )  # fmt: skip
    return Call(many_kernel(), *launch, *many, FIRST_STEPS), queue


def _loop(run, members, call, queue):
    """Take chunks up to the end; a solve that stands is given up."""
    status, n_steps, state = RUNNING, FIRST_STEPS, run.view("solve.state")
    present, progress = -1, Progress(run.problem, run.problem.t0, 0)
    while status == RUNNING:
        call["budget"] = n_steps
        began = perf_counter()
        status = call()
        n_steps = next_chunk(n_steps, perf_counter() - began)
        if queue[BEGUN] and queue[NEXT] != present:
            present, progress = int(queue[NEXT]), Progress(run.problem, *reached(state[0]))
        elif queue[BEGUN] and progress.stands(*reached(state[0])):
            queue[BEGUN] = GIVEN_UP
    if status == RAISED:
        for bound in run.bounds:
            bound.keepalive[1] = members.args(int(queue[0]))
        raise_kept(run.bounds, run.problem)
        run.mass.raise_kept()
