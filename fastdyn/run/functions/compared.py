"""Comparison of compiled code with its Python function at states of the solution."""

import os
from array import array
from typing import Any

import numpy as np

from fastdyn.compile.callables import codes
from fastdyn.compile.compare import compare_along, sides_at
from fastdyn.compile.derivatives.compare import compare_jacobian, compare_sensitivities
from fastdyn.kernels.calls.block import SIDES
from fastdyn.kernels.state.record import RUNNING, Y_OLD, Y
from fastdyn.kernels.state.snapshot_table import PLACE, SIZE, STATE, TIME

from ..output import occurrences_in, points_in
from .bound import type_of_time

MOST_NUMBERS = 2**18  # numbers in all states of a comparison, and in all snapshots of a solve
PLACES = 32  # most places for snapshots
OFF = 0.1  # displacement of a derivative, as a share of its size
AT_FIRST, LATER = 32, 4  # states of a comparison, after the first solve and after later solves
NEVER = 2**62  # solves
MOST_SEARCHES = 16  # failed searches for a state on a new side; then the side is left out
LOOKED_AT = 512  # states of the output that are searched for sides that decisions took
# Steps that are taken again for this search, so many at a time; some 5 ms of a small system.
REPEATED = 20_000
REPEATED_NUMBERS = 2**21
TOGETHER = 64
WHEN = os.environ.get("FASTDYN_COMPARE", "auto")


class Schedule:
    """The schedule of comparisons for some functions and one method, common to all Runs.

    `left` is the number of solves until the next comparison.  `sides` has a word for each function
    with decisions: the sides that were compared.  `ReadyRun.go` reads both, and lowers `left`.
    """

    def __init__(self, when, n_deciding=0):
        self._always = when == "always"
        self._due = 1 if when != "never" else 0  # the number of the next solve that is compared
        self.left, self.sides = array("q", [self._due or NEVER]), array("q", [0] * n_deciding)
        self.searches = 0  # searches that found no state on a new side

    def after_one(self):
        """The number of states to compare after one more solve; 0 without a comparison."""
        self.left[0] -= 1
        if self.left[0] > 0:
            return 0
        count = AT_FIRST if self._due == 1 else LATER
        self.left[0] = 1 if self._always else self._due
        self._due += self.left[0]
        return count


class Compared:
    """The schedule of comparisons of a Run.

    The code is compared after solves 1, 2, 4, 8, ..., and after a solve in which a decision took a
    side for the first time.  `deciding` are the blocks of the functions with decisions.  With `of`
    "steps", the schedule counts the single steps of a Stepper instead of solves.
    """

    def __init__(self, run, when=None, of="solves"):
        when = WHEN if when is None else when
        functions = [b for b in run.bounds if b.function is not None and not b.mode.constant]
        traced = [(b.block, b.function.traced) for b in functions if b.function.traced is not None]
        self.deciding = [block for block, each in traced if each.decisions and when != "never"]
        place = of, when, run.problem.method.name, *[
            (codes(b.held.fun, b.held.args), b.function.key) for b in functions
        ]  # fmt: skip
        if functions:
            notes = functions[0].function.notes
            known = ("compared", place)
            past = notes.setdefault(known, Schedule(when, len(self.deciding)))
        else:  # all functions run in Python
            past = Schedule("never")
        self._past = past
        self.left = past.left
        self.sides = past.sides
        self.most_places = max(2, min(PLACES, MOST_NUMBERS // max(run.plan.n, 1) // 2 * 2))

    def places(self):
        """The places for snapshots in the next solve; 0 if the solve will not be compared."""
        return self.most_places if self.left[0] <= 1 else 0

    def after(self, run):
        """Compare after a solve if a comparison is due; raise Different on a difference."""
        count = self.due()
        if count:
            self.now(run, count)
        elif self.deciding:
            if any(b[SIDES] & ~seen for b, seen in zip(self.deciding, self.sides, strict=True)):
                self.now(run, AT_FIRST)
        run.take_snapshots(0)

    def due(self):
        """The number of states to compare after one more solve; 0 without a comparison."""
        return self._past.after_one()

    def now(self, run, count):
        """Compare at `count` states; raise Different on a difference."""
        fresh = [int(block[SIDES]) & ~seen for block, seen in zip(
            self.deciding, self.sides, strict=True
        )]  # fmt: skip
        by_block = {id(b): new for b, new in zip(self.deciding, fresh, strict=True)}
        with run.not_repeated():
            hidden = compare(run, count, by_block)
        self._past.searches += any(hidden.values())
        for i, (block, new) in enumerate(zip(self.deciding, fresh, strict=True)):
            kept = hidden.get(id(block), 0) if self._past.searches < MOST_SEARCHES else 0
            self.sides[i] |= new & ~kept


def compare(run, count, fresh) -> dict[int, int]:
    """Raise Different if code and function differ at one of `count` states of a solve.

    `fresh` has, by the id of a block, the word of the sides that were not compared before; states
    on these sides are compared, too.  Derivatives are compared if `count` is AT_FIRST: after the
    first solve, and after a solve with a new side.  Returns, by the id of a block, the word of the
    sides that no state searched shows, and that are therefore not compared.
    """
    hidden: dict[int, int] = {}
    p = run.problem
    bounds = run.compiled()
    if not any(b.mode.compared or b.mode.sensitivities for b in bounds):
        return hidden
    solution = states_of(run, count)
    derivatives = count == AT_FIRST
    run.take_snapshots(0)  # long states fill much memory
    time = type_of_time(p)
    for bound in bounds:
        if bound.mode.sensitivities and derivatives:
            compare_sensitivities(bound, p.fun, p.args, *solution)
        if not bound.mode.compared:
            continue
        t, y = _given(run, bound, count) if bound.mode.acts_at_events else solution
        half = bound.mode.half
        more = ([], [])
        given = parts(bound, y)
        missing = fresh.get(id(bound.block), 0)
        if missing and half is None:
            more, hidden[id(bound.block)] = _showing(run, bound, missing, t, y)
        times = [*t, *more[0]]
        states = [*given, *more[1]]
        together = max(1, MOST_NUMBERS // max(run.plan.n, 1))  # values in memory at one time
        for i in range(0, len(times), together):
            compare_along(bound, times[i : i + together], states[i : i + together], time)
        if derivatives and p.method.n_matrices and bound.function.traced is not None:
            compare_jacobian(bound, t, [each[: bound.n] for each in given])
    return hidden


def compare_at(bounds, t, y):
    """Raise Different if code and function differ at a time and a state, shape (n,)."""
    if not np.isfinite(y).all():
        return
    for bound in bounds:
        if bound.function is not None and bound.mode.compared and not bound.pair:
            compare_along(bound, [t], parts(bound, [y]))


def off_the_solution(both):
    """[y, y'] with another y'.

    The residual of a solution is the rounding error of its terms, which no two compilers share.
    """
    y, yp = np.split(both, 2)
    size = np.abs(yp)
    return np.concatenate([y, yp + OFF * (size + (size.max(initial=0.0) or 1.0))])


def parts(bound, states):
    """States, or the halves of states that a function of a pair is given."""
    if bound.mode.residual:
        return [off_the_solution(each) for each in states]
    half = bound.mode.half
    return states if half is None else [np.split(each, 2)[half] for each in states]


def _showing(run, bound, missing, t, y):
    """Search a solve for states on the sides `missing` that none of (t, y) shows.

    Returns (times, states), and the word of the sides that neither LOOKED_AT states of the output
    nor the steps show.
    """
    n = bound.n
    found = ([], [])
    for at, state in zip(t, y, strict=True):
        missing &= ~sides_at(bound, at, state[:n])
    for states in (_of_output, _of_steps) if missing else ():
        for at, state in states(run, bound, missing):
            new = missing & sides_at(bound, at, state[:n])
            if new:
                missing &= ~new
                found[0].append(at)
                found[1].append(state)
            if not missing:
                return found, missing
    return found, missing


def _of_output(run, bound, missing):
    """(time, state) of LOOKED_AT states of the output of a solve, or of its events."""
    if bound.mode.acts_at_events:
        return zip(*_given(run, bound, LOOKED_AT), strict=True)
    t, y = run.grown.points() if run.grown else points_in(run.plan, run.memory)
    if run.since > -np.inf:
        known = t >= run.since
        t = t[known]
        y = y[known]
    chosen = apart(len(t), min(LOOKED_AT, MOST_NUMBERS // max(run.plan.n, 1)))
    return zip(t[chosen].tolist(), y[chosen], strict=True)


def _of_steps(run, bound, missing):
    """(time, state) of the start and the end of the steps in which decisions take new sides.

    The steps of the solve are taken again, REPEATED at most; there are none if Python code runs.
    """
    block = bound.block
    kept = int(block[SIDES])
    left = int(min(REPEATED, REPEATED_NUMBERS // max(run.plan.n, 1)))
    with run.another() as again:
        if again is None:
            return
        try:
            block[SIDES] = 0
            status = again.begin(run.problem.y0)
            while status == RUNNING and left > 0:
                before = again.memory.copy()
                block[SIDES] = 0
                status = again.step(TOGETHER)
                left -= TOGETHER
                if not missing & int(block[SIDES]):
                    continue
                again.memory[:] = before
                status = RUNNING
                for _ in range(TOGETHER):
                    block[SIDES] = 0
                    status = again.step() if status == RUNNING else status
                    if missing & int(block[SIDES]):
                        state = again.view("solve.state")[0]
                        work = again.view("solve.work")
                        yield float(state["t_old"]), work[Y_OLD].copy()
                        yield float(state["t"]), work[Y].copy()
        finally:
            block[SIDES] = kept


def _given(run, bound, count):
    """Times and states at which a solve called a function: events, if the function acts there."""
    if bound.mode.acts_at_events:
        o = run.grown
        _, t, y = o.found_so_far() if o else occurrences_in(run.plan, run.memory)
        if len(t):
            chosen = np.unique(np.linspace(0, len(t) - 1, count).astype(int))
            return t[chosen].tolist(), [*y[chosen]]
    return states_of(run, count)


def states_of(run, count):
    """Times and states of the last solve, at most `count`, the last among them.

    The states are those of the shortest steps, and of steps at equal distances: of the snapshots of
    a solve, or else of its output.
    """
    count = max(2, min(count, MOST_NUMBERS // max(run.plan.n, 1))) - 1
    state: Any = run.view("solve.state")[0]
    if run.snapshots is None:
        t, y = run.grown.points() if run.grown else points_in(run.plan, run.memory)
        chosen = apart(len(t), count)
    else:
        table = taken(run)
        table = table[table[:, TIME] != state["t"]]
        t = table[:, TIME]
        y = table[:, STATE : STATE + run.plan.n]
        shortest = shortest_first(table[:, SIZE])[: -(-count // 2)].tolist()
        others = sorted({*range(len(t))} - {*shortest})
        chosen = sorted([*shortest, *[others[i] for i in apart(len(others), count // 2)]])
    times = [float(state["t"]), *t[chosen].tolist()]
    states = [run.view("solve.work")[Y], *y[chosen]]
    if not np.isfinite(states).all() or min(times) < run.since:
        both = zip(times, states, strict=True)
        good = [i for i, (t, y) in enumerate(both) if np.isfinite(y).all() and t >= run.since]
        times = [times[i] for i in good]
        states = [states[i] for i in good]
    return times, states


def shortest_first(sizes):
    """The indices of steps: steps shorter than their neighbours first, then the other steps.

    Both by size.  Without this order, the steps at the start, each longer than the step before,
    would leave out the step in a pulse.
    """
    before = np.r_[np.inf, sizes[:-1]]
    after = np.r_[sizes[1:], np.inf]
    return np.lexsort((sizes, (sizes > before) | (sizes > after)))


def taken(run):
    """The snapshots that a solve has taken: see `kernels/state/snapshots.py`."""
    table = run.snapshots
    table = table[1 : 1 + int(table[0, PLACE])]
    return table[np.isfinite(table[:, SIZE])]


def apart(n, count):
    """At most `count` indices below n, at equal distances, the first and the last among them."""
    return sorted({int(i * (n - 1) / max(count - 1, 1)) for i in range(count)}) if n else []
