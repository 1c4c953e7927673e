"""Runs that are ready for the next solve with other values: the fast way of repeated solves.

One rule: `ReadyRun` makes plain solves only, and passes every other solve, with the same values, to
the code that solves a problem for the first time.  Only that code validates, raises and warns.  A
check here may therefore be too strict, but never too weak, and no check has a message.
"""

import math
import struct
from time import thread_time
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.bind import USUAL_ERRORS, current_errors, numpy_errors_are_heard
from fastdyn.compile.traced.known import N_LEFT
from fastdyn.kernels.calls.block import SIDES
from fastdyn.kernels.state.record import BAD_STATE, EVENT, FINISHED
from fastdyn.problem.step_options import LATEST, fixed_step, unit_of_times
from fastdyn.problem.validate import output_times
from fastdyn.specialise.builtin import builtin
from fastdyn.trace.reads.program import same

from .begin import fill_atol, fill_span
from .functions.readers import ARRAY, FLOAT, NUMBERS, is_left, reader_of, taken_from, together
from .laid_out import new_memory
from .loop import announce
from .memory import MEMORY, Y0
from .outcome import SUCCESS, TERMINATED, result_of, results
from .result import OdeResult
from .stiffness import MANY

FEW_WORDS = 2**14  # memory up to this size is used for all solves, and results are copies
LOOK_EVERY = 32  # solves after which a faster kernel may take over
FEWEST_BY_BUILTIN = 16  # solves until a comparison; the first of a process takes 27 ms
MOST_IN_A_LIST = 100  # components of an array; 2 take 0.6 of the time so, 60 take 0.84
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
        Those that the Run calls; `args` are their arguments at present.
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
        ``go(fun, y0, args, events=(), t_span=None, t_eval=None)``: the result of a solve, or None
        if the values need the long way.  Without a span, span and times are those of the problem.
    room : ndarray
        The initial state of the next solve.
    span : tuple or None
        The `t_span` that was taken last; the same tuple needs no second look.
    last : ndarray or None
        The memory of the last solve.
    most : int
        The most steps of a plain solve; longer solves are examined.
    state_sizes : tuple of float or None
        The `sizes`.
    is_traced : bool
        Whether the code of the equations is that of their graph.
    left : float
        The solves until functions that run in Python are compiled again, if they can be; then the
        ReadyRun is given up.
    """

    __slots__ = (
        "_check", "_finish", "_image", "_limited", "_make", "_may_build", "_n", "_n_left", "_open",
        "_own", "_pack_times", "_quick", "_readers", "_result", "_segments", "_sides", "_span",
        "_stays", "_step", "_switched", "_t_eval", "_times", "_until_look", "first", "go",
        "in_python", "is_traced", "last", "left", "most", "problem", "room", "run", "sizes", "span",
        "state_sizes",
    )  # fmt: skip

    def __init__(
        self, run, problem, functions, args, finish, check=None, sizes=None, options=None,
        make=None,
    ):  # fmt: skip
        self._make = make
        self.run, self.problem, self._finish = run, problem, finish
        self._check, self.state_sizes = check, sizes
        self._readers = [
            (reader_of(run, bound, fun, args), bound.block)
            for bound, fun in zip(run.called, functions, strict=True)
        ]
        self.left = math.inf
        options = options or {}
        self._step, self._limited = options.get("step"), options.get("max_step") is not None
        self.room, self._n = run.problem.y0.copy(), len(run.problem.y0)
        if problem.mode.sensitivities:  # which follow the state, and begin as they are
            self._n = problem.fun.n
        self._image, self._t_eval = run.first_memory()
        if self._t_eval is not None:
            self._pack_times = struct.Struct(f"{len(self._t_eval)}d").pack
        self.span: Any = None
        self._span = problem.t0, problem.tf, problem.h, problem.h_max
        self._switched: Any = None  # the segments that the image has, after switching times
        self._segments: Any = None  # those of the last solve, also where the image has none
        self.sizes: Any = None  # of the values of sensitivities, whose tolerances the image has
        self._times = b""
        equations = run.bounds[0].function
        self.is_traced = equations is not None and equations.traced is not None
        self.in_python = any(bound.callback is not None for bound in run.bounds)
        announce(run.bounds)  # a warning that is not given yet would keep a function alive
        self._stays = self._may_build = False
        self.most = MANY - 1
        self.lay()

    def lay(self):
        """Lay out the next solves for the present memory and kernel; little, if both stay."""
        run = self.run
        run.problem = problem = self.problem
        run.memory = None
        self._switched = None
        before = run.plan
        run.make_room()  # as long as the last output, in another plan
        plan = run.plan
        run.look_no_more()
        run.hold_nothing()
        words, launch = run.words()
        self.first = max(1, run.n_first(self.most))
        words[plan.at["n_steps"]] = self.first
        words[plan.at["kernels.advance"]] = run.stepping()
        may_build = run.compared.left[0] >= FEWEST_BY_BUILTIN
        stays = self._stays and plan is before and run.tier.open == self._open
        self._stays = False
        if stays and may_build <= self._may_build:
            self.last = self._own
            return
        self._n_left, self._open, self._may_build = -1, run.tier.open, may_build
        launch[Y0] = address_of(self.room)
        kernel = plan.launch
        if self.in_python:
            kernel = self._calling_python
        elif run.tier.open:
            self._until_look = 1
            kernel = self._counting
        self._sides = [(memoryview(block), i) for i, block in enumerate(run.compared.deciding)]
        self._own = new_memory(plan.size) if plan.size <= FEW_WORDS else None
        if self._own is not None:
            launch[MEMORY] = address_of(self._own)
        self.last = self._own
        self._result = (self._make or results)(problem, plan, self._own)
        self.go = self._laid(kernel)

    def forget(self):
        """Hold no memory of the last solve that its result may have."""
        self.last = self._own

    def _laid(self, kernel):
        """`go`, a closure over what solves share, which takes a fifth less than a method."""
        state = self.room[: self._n]
        words = memoryview(self.room).cast("B")  # gives its address in a third of an array's time
        pack = struct.Struct(f"{self._n}d").pack_into
        least, most = self.state_sizes or (0.0, 0.0)
        read, block = together(self._readers, self.run.switching and self._switch)
        check, finish, sides = self._check, self._finish, self._sides
        at, own, size, make = self.run.launch_at, self._own, self.run.plan.size, self._result
        told, left = self.run.tells_of(), self.run.compared.left
        in_pairs = self.problem.mode.complex_numbers
        quick = self._quick = self._builtin(kernel, read, block)
        short = self._n <= MOST_IN_A_LIST

        def go(fun, y0, args, events=(), t_span=None, t_eval=None):
            if current_errors() is not USUAL_ERRORS and numpy_errors_are_heard():
                return None
            if t_span is not self.span and not self.take_span(t_span):
                return None
            if t_eval is not None and not self.take_times(t_eval):
                return None
            if check is not None and not check(self, y0, args, events):
                return None
            if N_LEFT[0] != self._n_left and self._is_left(fun, args, events):
                return None
            memory = own
            status = None
            if quick is not None:
                given = y0.tolist() if y0.__class__ is np.ndarray and short else y0
                status = quick(fun, given, args, events)
            if status.__class__ is OdeResult:
                return status
            if status is None:
                kind = y0.__class__
                if not in_pairs and (kind is list or kind is tuple):
                    for number in y0:  # twice as fast as a set of types
                        if number.__class__ is not float and number.__class__ not in NUMBERS:
                            return None
                    try:
                        pack(words, 0, *y0)
                    except struct.error:  # another length, or a number beyond all floats
                        return None
                elif not taken_from(y0, state, in_pairs):
                    return None
                if most and not least <= max(map(abs, state)) <= most:
                    return None
                held = read(fun, args, events if block is None else block)
                if held is None:
                    return None
                if left[0] <= 1:  # a comparison is due
                    self.run.take_snapshots(self.run.compared.most_places)
                if memory is None:
                    memory = self.last = new_memory(size)
                    self.run.words()[1][MEMORY] = address_of(memory)
                status = kernel(at)
            if status == BAD_STATE:
                return None
            if told is not None and any(told(memory)):
                return finish(self, memory, status, fun, args, events)
            if left[0] <= 1 or status not in ENDS or (sides and self._takes_new_side()):
                return finish(self, memory, status, fun, args, events)
            left[0] -= 1
            if status == FINISHED:
                return make(memory)
            return make(memory, None, *ENDS[status])

        return go

    def _builtin(self, kernel, read, block):
        """The builtin that starts a kernel; None if solves by the kernel need other checks."""
        run = self.run
        if kernel is not run.plan.launch or self._own is None or self.state_sizes:
            return None
        if run.compared.left[0] < FEWEST_BY_BUILTIN or run.problem.mode.complex_numbers:
            return None
        names = run.to_tell()
        told = address_of(self._own) + run.plan.place(names[0]) if names else None
        is_plain = not self._sides and len(names) < 2
        parts = getattr(self._result, "plain", None) if is_plain else None
        given = run.compared.left, self.room[: self._n], told, parts
        return builtin(kernel, run.launch_at, read, block, *given)

    def _is_left(self, fun, args, events):
        """Whether a function is left to Python; looked at after another one was left."""
        if is_left(self.problem, self.run.called, (fun, *events), args):
            return True
        self._n_left = N_LEFT[0]
        return False

    def _takes_new_side(self):
        """Whether a decision of the last solve took a side for the first time."""
        return any(block[SIDES] & ~self.run.compared.sides[i] for block, i in self._sides)

    def _counting(self, at):
        """Start the kernel, which a faster one may replace; one of LOOK_EVERY solves speaks."""
        run = self.run
        self._until_look -= 1
        if self._until_look:
            return run.plan.launch(at)
        self._until_look = LOOK_EVERY
        began = thread_time()
        status = run.plan.launch(at)
        tier = run.tier
        tier.record_time(LOOK_EVERY * (thread_time() - began))
        tier.promote()
        words, _ = run.words()
        words[run.plan.at["kernels.advance"]] = run.stepping()
        if not tier.open:
            self.go = self._laid(run.plan.launch)
        return status

    def _calling_python(self, at):
        """Start the kernel of functions that run in Python; nothing of the user's is kept."""
        self.left -= 1
        status = self.run.launch()
        self.run.hold_nothing()
        return status

    def _switch(self, given):
        """Let the steps end at the switching times for the given values of the functions."""
        t0, tf, h, h_max = self._span
        asked = self.problem.segments
        found = self.run.switching.segments(given, self.room, t0, tf, h_max, asked)
        self._segments = found
        if found is not self._switched:
            segments, h_max = self._switched = found
            self.run.lay_segments(segments)
            fill_span(self._image, t0, tf, h, h_max, segments)

    def go_on(self, problem, memory, status):
        """Continue the solve of a problem after the first chunk, as any Run; return the status."""
        run = self.run
        run.problem, run.memory = problem, memory
        return run.solve(problem.y0, (status, self.first, self.first * run.cost))

    def finished(self, problem, status):
        """The result of a solve of a problem that went on to its end."""
        if status not in ENDS or self._make is not None:  # results may keep the memory
            return result_of(problem, status, self.run)
        self._stays = True
        return self._result(self.run.memory, self.run.grown, *ENDS[status])

    def take_span(self, t_span):
        """Take another span; False if the span needs the long way."""
        kind = t_span.__class__
        if kind is list or (kind is ARRAY and t_span.dtype == FLOAT):
            t_span = tuple(t_span)
        elif kind is not tuple:
            return False
        if len(t_span) != 2 or not NUMBERS.issuperset(map(type, t_span)):
            return False
        t0, tf = t_span
        if t_span == self.span and ((t0 and tf) or all(map(same, t_span, self.span))):
            return True
        p, length = self.problem, abs(tf - t0)
        elsewhere = len(p.segments) and (t0, tf) != (p.t0, p.tf)  # with breakpoints or schedules
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
        if self.run.switching is None:  # else see `_switch`
            fill_span(self._image, t0, tf, h, h_max, p.segments)
        if p.events:
            table = self.run.plan.view(self._image, "events.table")
            table["unit"] = unit_of_times(p.events_as_scipy, t0, tf)
        self.span, self._times, self._span = t_span, b"", (float(t0), float(tf), h, h_max)
        self._switched = None
        self._segments = None
        return True

    def take_times(self, t_eval):
        """Take other times of output; False if the times need the long way.

        Times whose bytes were checked with the present span need no other check.
        """
        kind = t_eval.__class__
        own = self._t_eval
        dtype = self.problem.t_eval.dtype
        if kind is list or kind is tuple:
            types = {*map(type, t_eval)}
            if not types <= NUMBERS:
                return False
            if dtype == FLOAT and types != {int} and len(t_eval) == len(own):
                times = self._pack_times(*t_eval)  # in a third of the time of an array
                if times == self._times:
                    return True
                t_eval = np.frombuffer(times)
            else:
                t_eval = np.array(t_eval)
        elif kind is range:
            t_eval = np.array(t_eval)
        elif kind is not ARRAY:
            return False
        if t_eval.dtype != dtype or t_eval.shape != own.shape:
            return False
        times = t_eval.tobytes()
        if times != self._times:
            try:
                output_times(t_eval, *map(float, self.span))
            except ValueError:
                return False
            own[:] = t_eval
            self._times = times
        return True

    def given(self, fun, args):
        """The values of the parameters of the equations, read again; None as of a reader."""
        read, block = self._readers[0]
        return read(fun, args, block)

    def take_atol(self, atol):
        """Take other absolute tolerances, one for each component."""
        fill_atol(self._image, self.run.plan, atol)

    def taken(self):
        """The span, the step sizes, segments and times of output of the last solve begun."""
        (t0, tf, h, h_max), times = self._span, self._t_eval
        segments, h_max = self._segments or (self.problem.segments, h_max)
        return {
            "t0": t0, "tf": tf, "h": h, "h_max": h_max, "segments": segments,
            "t_eval": None if times is None else times.astype(self.problem.t_eval.dtype),
        }  # fmt: skip
