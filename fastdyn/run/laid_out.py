"""A problem laid out for the kernels: its functions, its memory, its arguments in words."""

import ctypes
import math
from contextlib import contextmanager
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.code_store.call import address_of
from fastdyn.compile import budget
from fastdyn.kernels.calls.block import FAILED, JACOBIAN, RARE
from fastdyn.kernels.output.arguments import FRESH, Kernels
from fastdyn.kernels.state.record import RAISED
from fastdyn.kernels.state.snapshot_table import STATE, STRIDE
from fastdyn.problem.domains.options import keeps
from fastdyn.problem.step_options import unit_of_times
from fastdyn.specialise.rare import raise_failure
from fastdyn.specialise.scalar import interpolant_kernel, watch_kernel
from fastdyn.specialise.shared_or_inlined import Tier

from . import output
from .begin import (
    event_table,
    fill,
    fill_tolerances,
    jacobian_of,
    schedule_table,
    shape_of,
    watch_of,
)
from .functions.bound import raise_kept, type_of_time
from .functions.crossings import look_for_lost, tell_lost
from .functions.interruptible import Interruptible
from .functions.python_between import PythonBetween
from .functions.switching import switching_of
from .matrices.layouts import matrices_of
from .matrices.mass import mass_of
from .memory import MEMORY, Y0, lay, plan
from .resume import put_tables

MOST_PIECES = 16  # most pieces of output at the start of a solve, if the last solve needed them
NO_SNAPSHOTS = np.empty((0, 0))


def new_memory(size):
    """Memory of `size` words, not initialised: kernels write each word before they read it."""
    return np.empty(size)


class LaidOut(PythonBetween):
    """A problem in the form that kernels take: functions, memory, words.

    Parameters
    ----------
    problem : validate.Problem
    bound : bind.Bound
        The equations, from `bind.bind`.
    others : list of Bound
        The functions of `problem.events.between_steps`.
    n_extra : int
        Evaluations before the first step.

    Attributes
    ----------
    bounds : list of Bound
        All functions that the solve calls, and a Jacobian that is a matrix.
    called : list of Bound
        The `bounds` without the matrix.
    plan : memory.Plan
    memory : ndarray
        The memory of the last solve, also after a failure; each solve has its own memory.
    segments : ndarray
        The present segments of the span.
    grown : Output or None
        The output of the last solve, if Python needed the output before the end.
    snapshots : ndarray or None
        The table of the snapshots of the present solve; see `kernels/state/snapshots.py`.
    """

    suits: Any = None  # ``suits(values)``: whether the Run may solve with values of its equations
    since = -math.inf  # the time from which on functions can be called after a solve

    def __init__(self, problem, bound, others=(), n_extra=0):
        self.bounds = [*bound.pair, bound, *others]
        self.called = [bound for bound in self.bounds if not bound.mode.constant]
        self._own = bound
        self._others = others
        self._n_extra = n_extra
        last = len(others) - (problem.jac is not None)
        self._matrices = matrices_of(problem, bound, jacobian_of(problem, bound, others))
        self.mass = mass_of(problem, bound)
        self._between = self.mass.consistent(others)
        self._projection = others[last - 1] if problem.project is not None else None
        last -= problem.project is not None
        self._keeps = keeps(problem)
        self._inside = others[last - 1] if problem.inside is not None else None
        self.memory: Any = None
        self.grown: Any = None
        self.snapshots: Any = None
        self._asked = self._tolerances = self._rules = None
        self.tells = False  # whether crossings of events may be lost, and are not told yet
        plan = self._plan(problem)
        self._image = np.zeros(plan.head, np.int64)
        self._advance = plan.at["kernels.advance"]
        self._n_steps = plan.at["n_steps"]
        self._lay_out(plan)
        called = *(b.callback for b in self.bounds), self._matrices.solver
        self.callbacks = [c for c in called if c is not None]
        self._follow(problem, bound, others)
        self.switching: Any = switching_of(problem, bound, others, self._followed is not None)
        self._late = [c.account for c in self.callbacks if getattr(c, "account", None)]
        self.evaluations = problem.method.cost or problem.method.n_stages + 1
        seconds = (math.inf if b.function is None else b.function.seconds for b in self.bounds)
        self._seconds = self.evaluations * sum(seconds)
        self.take(problem)

    def _plan(self, problem, n_points=None):
        return plan(*shape_of(problem, bool(self._own.pair), n_points), self._matrices.rows)

    def _lay_out(self, plan):
        """Write the arguments in words, for a memory of this plan."""
        self.plan = plan
        self._words = plan.words[:]
        self._used = {}
        self._lay("solve.block", self._own.block)
        if self._projection is not None:
            self._words[plan.at["kernels.project"]] = address_of(self._projection.block)
        if self._inside is not None:
            self._words[plan.at["kernels.inside"]] = address_of(self._inside.block)
        self._words[plan.at["kernels.keeps"]] = self._keeps
        self._places = self.places(plan)
        self._launch = plan.launch_words(self._words, self._image, self._places)
        self.launch_at = ctypes.c_void_p(self._launch.buffer_info()[0])

    def places(self, plan):
        """As `Plan.places`: the words that name parts of the memory, and their offsets."""
        return plan.places

    def take(self, problem):
        """Take another problem of the same plan, with the same functions."""
        if self.switching is not None:
            problem = self.switching.taken(problem, self.bounds)
        self.problem: Any = problem
        p = problem
        for callback in self.callbacks:
            callback.later = type_of_time(p)
        if self._asked != p.compile or self.tier.open or p.method.series:
            self._asked, self.tier = p.compile, Tier(p, self._own, self._followed is None)
        self._t_eval = None if p.t_eval is None else p.t_eval.astype(float)
        self._lay_times()
        fill(self._image, p, self._n_extra)
        plain = p.rtol.__class__ is float and p.atol.__class__ is float
        tolerances = (p.rtol, p.atol) if plain else None
        if tolerances is None or self._tolerances != tolerances:
            self._tolerances = tolerances
            fill_tolerances(self._image, self.plan, p)
        rules = p.events and [
            unit_of_times(p.events_as_scipy, p.t0, p.tf),
            *[(e.rules, e.steers) for e in p.events],
        ]
        if rules and (self._rules != rules or p.method.series):
            self._rules = rules
            table = self.plan.view(self._image, "events.table")
            table[:] = event_table(p, self._between)
            self.tells = look_for_lost(table, p, self.bounds, self._others)
        if p.schedules:
            self.plan.view(self._image, "events.schedules")[:] = schedule_table(p, self._between)
        self.watched = p.progress or p.checkpoint is not None or p.callback is not None
        self.cost = math.inf if self.watched else self._seconds

    def tell_lost(self):
        """Warn if crossings of an event were lost within a step."""
        if self.tells and self.view("output.record")["lost"][0]:
            tables = [self.view("events.table"), self.plan.view(self._image, "events.table")]
            tell_lost(self.problem, self._others, *tables)
            self.view("output.record")["lost"] = 0

    def let_go(self):
        """Drop everything that belongs to the last solve."""
        self.make_room()
        self.problem = self.memory = self._t_eval = None
        self._used.clear()
        self._used["solve.block"] = self._own.block

    def _lay(self, name, array):
        """Give the kernel an array, and keep the array alive."""
        self._used[name] = array
        lay(self._words, self.plan.at[name], address_of(array), array.shape)

    def _lay_times(self):
        """Give the kernel the times of the output and the segments of the span."""
        if self._t_eval is not None:
            self._lay("output.t_eval", self._t_eval)
        if self.problem.told is not None:
            self._lay("output.told", self.problem.told)
        if self.switching is not None:
            self._lay("output.looks", self.switching.looks)
        self.lay_segments(self.problem.segments)

    def lay_segments(self, segments):
        """Give the kernel the segments of the span, or the changes that steps may jump over."""
        self.segments = segments
        switching = self.switching
        ends = len(segments)
        if ends or switching is not None:  # which may have had segments before
            self._lay("output.segments", segments)
        if switching is not None:
            self._lay("output.changes", switching.changes)
            ends += len(switching.changes)
        watch = watch_kernel() if ends else watch_of(self.problem)
        self._words[self.plan.at["begin.watch"]] = watch.address

    def make_room(self):
        """Prepare for the next solve; its first piece of output is as long as the last output.

        The length has limits.  No snapshots are taken.
        """
        self.take_snapshots(0)
        if self.grown is None:
            return
        wanted = min(2 ** int(self.grown.n_points()).bit_length(), MOST_PIECES * output.PIECE)
        n = self.plan.n
        wanted = max(min(wanted, output.PIECE_NUMBERS // n), output.first_piece(n))
        plan = self._plan(self.problem, wanted)
        if plan is self.plan:  # the kernel gets the first pieces again
            for name in self.grown.arrays():
                lay(self._words, plan.at[name], 0, plan.arrays[name][3])
                self._used.pop(name, None)
        else:
            self._lay_out(plan)
            self._lay_times()
        self.grown = None

    def take_snapshots(self, places):
        """Let the kernel take snapshots from now on, with room for an even number of `places`."""
        if places:
            self.snapshots = np.zeros((1 + places, STATE + max(self.plan.n, 1)))
            self.snapshots[0, STRIDE] = 1.0
            self._lay("output.snapshots", self.snapshots)
        elif self.snapshots is not None:
            self.snapshots = None
            self._lay("output.snapshots", NO_SNAPSHOTS)

    def lay_output(self):
        """Give the kernel the present pieces of the output."""
        for name, array in self.output.arrays().items():
            self._lay(name, array)

    def view(self, name):
        """An array of the memory, by the name of the kernel's argument."""
        return self.plan.view(self.memory, name)

    @property
    def output(self):
        """The output of the last solve."""
        if self.grown is None:
            self.grown = output.Output(self.plan, self.memory)
        return self.grown

    def begin(self, y0, n_steps=0, snapshots=0):
        """Begin at `y0`, n contiguous floats, and take at most `n_steps` steps; the status.

        `snapshots` is the number of places for snapshots.
        """
        self.make_room()
        self.take_snapshots(snapshots)
        words = self._words
        own = self._new_memory()
        launch = self._launch
        launch[MEMORY], launch[Y0] = address_of(own), address_of(y0)
        words[self._n_steps], words[self._advance] = n_steps, self.stepping()
        return self.launch()

    def launch(self):
        """Start the kernel, as the words of the Launch say; the status."""
        if not self.callbacks:
            return self.plan.launch(self.launch_at)
        for callback in filter(None, [b.callback for b in self.bounds]):
            callback.begin()
        return self._interruptible(self.plan.launch, self._launch)

    def hold_nothing(self):
        """Keep no function and no arguments of the user between solves."""
        for bound in self.bounds:
            bound.held.take(None, ())

    def stepping(self):
        """The address of the kernel that takes steps."""
        return self.tier.address

    def _new_memory(self):
        """The memory of the next solve."""
        self.memory = new_memory(self.plan.size)
        return self.memory

    def step(self, n_steps=1):
        """Go on for at most `n_steps` steps; the status."""
        words = self._words
        words[FRESH] = 0
        words[self._n_steps] = n_steps
        words[self._advance] = self.stepping()
        return self._interruptible(self.plan.kernel, words)

    def _interruptible(self, kernel, words):
        at = words.buffer_info()[0]
        if not self.callbacks:
            return kernel(at)
        if not self._late:
            with Interruptible(self.callbacks):
                return kernel(at)
        with budget.in_python(self._late), Interruptible(self.callbacks):
            return kernel(at)

    def check(self, status):
        """Raise the exception of a user's function, if the status stands for an exception."""
        raise_failure()
        if status == RAISED:
            for called in self.callbacks:
                if called.exception is not None:
                    raise called.exception
            with self.not_repeated():
                raise_kept(self.bounds, self.problem)
            self.mass.raise_kept()
        if status == FAILED:
            raise MemoryError("a kernel had no memory left")

    def go_on_from(self, own):
        """Take over the memory of a Run of the same plan, without pieces of output."""
        tables = [self.plan.view(own, f"events.{name}").copy() for name in ("table", "schedules")]
        self.memory = own
        for name in ("table", "schedules"):
            self.view(f"events.{name}")[:] = self.plan.view(self._image, f"events.{name}")
        put_tables(self, *tables)
        for at, offset in self._places.tolist():
            self._words[at] = address_of(own) + offset

    def interpolant(self):
        """The polynomial of the last step, shape (rows, n), and the start and end of the step."""
        plan = self.plan
        p = self.problem
        d = np.empty(plan.arrays["output.d"][3][1:])
        dense_rows = self._words[plan.at["kernels.dense_rows"]]
        kernels = Kernels(0, dense_rows, p.method.fsal_stage, 0, 0, 0.0, 0, 0, 0, 0)
        solve = self.view("solve.state"), self.view("solve.work"), self._own.block
        self.check(Call(interpolant_kernel(), *kernels, *solve, d)())
        (s,) = solve[0]
        return d, float(s["t_old"]), float(s["t"])

    @contextmanager
    def another(self):
        """A Run that takes the same steps, and stores the end only; None if steps have effects.

        Both Runs have the block of the equations, which names the matrices of one Run at a time.
        """
        p = self.problem
        block = self._own.block
        if self.callbacks or p.callback is not None:
            yield None
            return
        p = p._replace(t_eval=np.array([p.tf]), dense_output=False)
        named = block.copy()
        try:
            yield type(self)(p, self._own, self._others)
        finally:
            block[JACOBIAN:RARE] = named[JACOBIAN:RARE]
