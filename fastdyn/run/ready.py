"""Runs that are ready for the next solve with other values: the fast way of repeated solves.

One rule: `ReadyRun` makes plain solves only, and passes every other solve, with the same values, to
the code that solves a problem for the first time.  Only that code validates, raises and warns.  A
check here may therefore be too strict, but never too weak, and no check has a message.
"""

import math
from time import perf_counter
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.bind import leave_to_python, numpy_errors_are_heard
from fastdyn.compile.sentences import GaveUp, WritesToState
from fastdyn.compile.traced.known import N_LEFT
from fastdyn.kernels.calls.block import SIDES
from fastdyn.kernels.state.record import BAD_STATE, EVENT, FINISHED
from fastdyn.problem.step_options import LATEST, fixed_step
from fastdyn.problem.validate import output_times

from .begin import fill_atol, fill_span
from .functions.interruptible import Interruptible
from .functions.readers import ARRAY, FLOAT, NUMBERS, is_left, reader_of, state_writer
from .laid_out import new_memory
from .loop import announce
from .memory import MEMORY, Y0
from .outcome import SUCCESS, TERMINATED, result_of, results
from .stiffness import MANY

FEW_WORDS = 2**14  # memory up to this size is used for all solves, and results are copies
# A ReadyRun is made, in 0.3 ms, after so many solves in a row that went the long way.  The number
# doubles with each ReadyRun up to MOST_MISSES, and beyond for functions that get no ReadyRun.
FEWEST_MISSES, MOST_MISSES = 2, 8
# Solves in Python after which compiled code is looked for again, which takes 0.3 to 0.7 ms.
FEWEST_IN_PYTHON, MOST_IN_PYTHON = 8, 256
LOOK_EVERY = 32  # solves after which a faster kernel may take over
ENDS = {FINISHED: (0, SUCCESS), EVENT: (1, TERMINATED)}  # of plain solves


class ReadyRun:
    """A Run with what its solves share; one thread at a time has the ReadyRun.

    Parameters
    ----------
    run : loop.Run
        A plain Run, as `Run.is_plain` tells.
    problem : validate.Problem
        The problem of all solves, without values of one solve that must not be kept.
    functions : sequence of callable
        The functions of the bounds of the Run; `args` are their arguments at present.
    finish : callable
        ``finish(ready, memory, status, fun, args, events)`` returns the result of a solve after its
        first chunk of steps, or None.
    check : callable, optional
        ``check(ready, y0, args, events)`` tells whether other things than values suit the Run.
    sizes : tuple of float, optional
        The least and the largest size of a state for which the order of a series is unchanged.
    options : dict, optional
        The options `step` and `max_step` of the solve, for other spans.
    make : callable, optional
        In place of `outcome.results`.

    Attributes
    ----------
    go : callable
        ``go(fun, y0, args, events=(), t_span=None, t_eval=None)`` returns the result, or None if
        the values need the long way.  Without a span, span and times are those of the problem.
    room : ndarray
        The initial state of the next solve.
    span : tuple or None
        The `t_span` that was taken last; the same tuple needs no second look.
    left : float
        The solves until functions that run in Python are compiled again, if they can be; then the
        ReadyRun is given up.
    """

    go: Any
    left: float = math.inf

    def __init__(
        self, run, problem, functions, args, finish, check=None, sizes=None, options=None,
        make=None,
    ):  # fmt: skip
        self._make = make
        self.run, self.problem, self._finish = run, problem, finish
        self._check, self._sizes = check, sizes
        self._readers = [
            (reader_of(run.problem, bound, fun, args), bound.block)
            for bound, fun in zip(run.bounds, functions, strict=True)
        ]
        options = options or {}
        self._step, self._limited = options.get("step"), options.get("max_step") is not None
        self.room, self._n = run.problem.y0.copy(), len(run.problem.y0)
        if problem.mode.sensitivities:  # which follow the state, and begin as they are
            self._n = problem.fun.n
        self._image, self._t_eval = run.first_memory()
        self.span: Any = None
        self._span = problem.t0, problem.tf, problem.h, problem.h_max
        self._switched: Any = None  # the key of the switching times that the image has
        self.sizes: Any = None  # of the values of sensitivities, whose tolerances the image has
        self._times = b""
        self.in_python = any(bound.callback is not None for bound in run.bounds)
        if self.in_python:  # a warning that is not given yet would keep the function alive
            announce(run.bounds)
        self.lay()

    def lay(self):
        """Make `go` for the present layout of the memory and the present stepping kernel."""
        run, problem, room = self.run, self.problem, self.room
        run.problem, run.memory, self._switched = problem, None, None
        run.make_room()  # as long as the last output
        for bound in run.bounds:  # nothing of the user's is kept between solves
            bound.held.take(None, ())
        plan, tier, compared, (words, launch) = run.plan, run.tier, run.compared, run.words()
        self.first = max(1, min(run.n_first(), MANY - 1))  # longer solves are examined
        words[plan.at["n_steps"]], advance = self.first, plan.at["kernels.advance"]
        words[advance], launch[Y0], until_look = tier.address, address_of(room), 1
        kernel = self._calling_python if self.in_python else plan.launch
        at, size, bounds = run.launch_at, plan.size, run.bounds
        n_left, left, seen = -1, compared.left, compared.sides  # -1: this solve may have left one
        sides = [(memoryview(block), i) for i, block in enumerate(compared.deciding)]
        is_open, take_state = tier.open, state_writer(room, self._n, self._sizes)
        (read, block), alone = self._readers[0], len(bounds) == 1 and run.switching is None
        own = None
        if not problem.dense_output and size <= FEW_WORDS:
            own = new_memory(size)
            launch[MEMORY] = address_of(own)
        result, check = (self._make or results)(problem, plan, own), self._check

        def go(fun, y0, args, events=(), t_span=None, t_eval=None):
            nonlocal is_open, n_left, until_look
            if numpy_errors_are_heard():
                return None
            if t_span is not self.span and not self.take_span(t_span):
                return None
            if t_eval is not None and not self.take_times(t_eval):
                return None
            if check is not None and not check(self, y0, args, events):
                return None
            if N_LEFT[0] != n_left:
                if is_left(problem, bounds, (fun, *events), args):
                    return None
                n_left = N_LEFT[0]
            if not take_state(y0):
                return None
            held = read(fun, args, block) if alone else self._read_all(fun, args, events)
            if held is None:
                return None
            memory = own
            if memory is None:
                memory = new_memory(size)
                launch[MEMORY] = address_of(memory)
            if left[0] <= 1:  # a comparison is due
                run.take_snapshots(compared.most_places)
            until_look -= is_open
            if until_look:
                status = kernel(at)
            else:  # one of LOOK_EVERY solves speaks for all
                began, until_look = perf_counter(), LOOK_EVERY
                status = kernel(at)
                tier.record_time(LOOK_EVERY * (perf_counter() - began))
                tier.promote()
                words[advance], is_open = tier.address, tier.open
            if status == BAD_STATE:
                return None
            if status not in ENDS or left[0] <= 1:
                return self._finish(self, memory, status, fun, args, events)
            for its_block, i in sides:
                if its_block[SIDES] & ~seen[i]:
                    return self._finish(self, memory, status, fun, args, events)
            left[0] -= 1
            return result(memory, None, *ENDS[status])

        self.go = go

    def _calling_python(self, at):
        """Start the kernel of functions that run in Python; nothing of the user's is kept."""
        run = self.run
        self.left -= 1
        for bound in run.bounds:
            bound.callback.begin()
        with Interruptible(run.callbacks):
            status = run.plan.launch(at)
        for bound in run.bounds:
            bound.held.take(None, ())
        return status

    def _read_all(self, fun, args, events) -> Any:
        """The values of all functions, which live until the kernel ends; None as of a reader."""
        held = []
        for (read, block), function in zip(self._readers, (fun, *events), strict=True):
            held.append(read(function, args, block))
            if held[-1] is None:
                return None
        if self.run.switching is not None:
            self._switch(held)
        return held

    def _switch(self, given):
        """Let the steps end at the switching times for the given values of the functions."""
        t0, tf, h, h_max = self._span
        asked = self.problem.segments
        found = self.run.switching.segments(given, self.room, t0, tf, h_max, asked)
        if found is not self._switched:
            segments, h_max = self._switched = found
            self.run.lay_segments(segments)
            fill_span(self._image, t0, tf, h, h_max, segments)

    def go_on(self, problem, memory, status):
        """Continue the solve of a problem after the first chunk, as any Run; return the status."""
        run = self.run
        run.problem, run.memory = problem, memory
        return run.solve(problem.y0, (status, self.first, self.first * run.cost))

    def take_span(self, t_span):
        """Take another span; False if the span needs the long way."""
        kind = t_span.__class__
        if kind is list or (kind is ARRAY and t_span.dtype == FLOAT):
            t_span = tuple(t_span)
        elif kind is not tuple:
            return False
        if len(t_span) != 2 or not NUMBERS.issuperset(map(type, t_span)):
            return False
        if t_span == self.span:
            return True
        t0, tf = t_span
        p, length = self.problem, abs(tf - t0)
        elsewhere = len(p.segments) and (t0, tf) != (p.t0, p.tf)  # with other breakpoints
        if elsewhere or not (length > 0.0 and abs(t0) <= LATEST and abs(tf) <= LATEST):
            return False
        h, h_max = p.h, p.h_max
        if not p.method.error_order:
            try:
                h = fixed_step({"step": self._step}, t0, tf, p.method.name)
            except ValueError:
                return False
        elif h > length:
            return False
        elif not self._limited:
            h_max = length * p.method.h_max_share
        elif h_max < 10 * math.ulp(max(abs(t0), abs(tf))):  # the run might never end
            return False
        fill_span(self._image, t0, tf, h, h_max, p.segments)
        self.span, self._times, self._span = t_span, b"", (float(t0), float(tf), h, h_max)
        self._switched = None
        return True

    def take_times(self, t_eval):
        """Take other times of output; False if the times need the long way.

        Times whose bytes were checked with the present span need no other check.
        """
        kind, own = t_eval.__class__, self._t_eval
        if kind is range or (kind in (list, tuple) and NUMBERS.issuperset(map(type, t_eval))):
            t_eval = np.array(t_eval)
        elif kind is not ARRAY:
            return False
        if t_eval.dtype != self.problem.t_eval.dtype or t_eval.shape != own.shape:
            return False
        times = t_eval.tobytes()
        if times != self._times:
            try:
                output_times(t_eval, *map(float, self.span))
            except ValueError:
                return False
            own[:], self._times = t_eval, times
        return True

    def given(self, fun, args):
        """The values of the parameters of the equations, read again; None as of a reader."""
        read, block = self._readers[0]
        return read(fun, args, block)

    def take_atol(self, atol):
        """Take other absolute tolerances, one for each component."""
        fill_atol(self._image, self.run.plan, atol)

    def taken(self):
        """The span, the step sizes, segments and times of output that the next solve has."""
        (t0, tf, h, h_max), times = self._span, self._t_eval
        segments, h_max = self._switched or (self.problem.segments, h_max)
        return {
            "t0": t0, "tf": tf, "h": h, "h_max": h_max, "segments": segments,
            "t_eval": None if times is None else times.astype(self.problem.t_eval.dtype),
        }  # fmt: skip


class Solver:
    """Makes solves of one kind on Runs that are ready.

    Attributes
    ----------
    problem : validate.Problem
        The problem of all solves, whose values solves replace.
    idle : list of ReadyRun
        The runs that no thread uses.
    """

    problem: Any

    def __init__(self):
        self.idle: list[ReadyRun] = []
        self._misses, self._most, self._is_refused = 0, FEWEST_MISSES, True
        self._lasts = FEWEST_IN_PYTHON

    def solve(self, fun, y0, args, others=(), t_span=None, t_eval=None):
        """The result of a solve; None if it needs the long way.

        `others` are the functions that are called between steps.
        """
        idle = self.idle
        try:
            ready = idle.pop()
        except IndexError:  # there is none, or other threads have them
            return None
        result = ready.go(fun, y0, args, others, t_span, t_eval)
        if ready.left > 0:
            idle.append(ready)
        if self._misses and result is not None:
            self._misses = 0
        return result

    def prepare(self, problem):
        """Prepare a run before the first solve."""
        self._most = 1
        self.count(problem)

    def count(self, problem):
        """Count a solve that went the long way; perhaps prepare a run for more solves like it.

        That is after some such solves in a row, as values of other types may have come to stay, and
        if other threads have all runs.
        """
        self._misses += 1
        if self._misses >= self._most:
            self.idle, self._misses = self._for_a_while(self.ready(problem)), 0
            self._is_refused = not self.idle
            self._most *= 2 if self._is_refused or self._most < MOST_MISSES else 1
        elif not (self.idle or self._is_refused):
            self.idle += self._for_a_while(self.ready(problem))

    def _for_a_while(self, made):
        """ReadyRuns; those of functions in Python for twice as many solves as the last ones."""
        for ready in made:
            if ready.in_python:
                ready.left = self._lasts
                self._lasts = min(2 * self._lasts, MOST_IN_PYTHON)
        return made

    def ready(self, problem) -> list[ReadyRun]:
        """A ReadyRun for a problem, or none if no solve of the problem is plain."""
        raise NotImplementedError

    def present(self, ready, fun, args, others):
        """The problem of the solve that a ReadyRun has begun."""
        raise NotImplementedError

    def goes_on(self, problem, run):
        """Called before a solve goes on after its first chunk."""

    def ended(self, problem, run):
        """Called after such a solve."""

    def finish(self, ready, memory, status, fun, args, others):
        """The result of a solve after its first chunk of steps; None if the code gave up."""
        if (run := ready.run).doubts(memory):
            return None
        p = self.present(ready, fun, args, others)
        for bound, function in zip(run.bounds, (fun, *others), strict=True):
            bound.held.take(function, args)
        self.goes_on(p, run)
        try:
            result = result_of(p, ready.go_on(p, memory, status), run)
            self.ended(p, run)
        except WritesToState:  # of a function that has not written before: SciPy solves
            return None
        except GaveUp as reason:
            result = None
            if not p.mode.sensitivities:  # these are not computed in Python
                leave_to_python(reason.bound, reason)
        ready.lay()
        return result
