"""The workers of an ensemble: each runs in one thread; all take trajectories from one queue."""

import time
from itertools import chain
from typing import Any

import numpy as np

from fastdyn import code_store
from fastdyn.compile.mode import EVENT
from fastdyn.kernels.calls.block import FIRST, MASS
from fastdyn.kernels.ensemble import arguments
from fastdyn.kernels.ensemble.lane_transfer import N_EXTREMA
from fastdyn.kernels.methods.taylor.accuracy import order_of_many
from fastdyn.kernels.output.arguments import OUTPUT, SCHEDULES
from fastdyn.kernels.state.lane_fields import ACCEPTED, N_FIELDS, T
from fastdyn.kernels.state.record import ATOL, FULL, RTOL, RUNNING, STATE, K
from fastdyn.problem.domains.options import keeps
from fastdyn.problem.events import between_steps
from fastdyn.problem.step_options import last_time
from fastdyn.run.begin import begin, event_table, first_output, schedule_table, watch_of
from fastdyn.run.loop import Progress, next_chunk, reached
from fastdyn.run.matrices.layouts import matrices_of_member
from fastdyn.run.matrices.mass import mass_of
from fastdyn.run.memory import scratch_shape
from fastdyn.run.output import OUTPUT_RECORD
from fastdyn.specialise.scalar import (
    already_kernel,
    dense_rows_kernel,
    events_kernel,
    inlined_kernel,
    inlines,
    serve_kernel,
    shared_kernel,
    start_kernel,
    watch_kernel,
)
from fastdyn.specialise.series import series_kernel

from .times import of_members

ROOM = 256  # least number of events for which the first piece of `found` has room


class Worker:
    """The lanes of one thread, and the user's functions with the thread's own blocks.

    Parameters
    ----------
    problem : problem.validate.Problem
    members : members.Members
    vector : specialise.vector.Kernel or None
    results : results.Results
    folds : sequence of reductions.Fold
    """

    def __init__(self, problem, members, vector, results, folds=()):
        p = problem
        n = len(problem.y0)
        self.found = []
        self._chunk = 100
        width = vector.width if vector else 1
        n_events = len(p.events or ())
        segments, rows_of_segments = members.segments or (
            p.segments,
            np.array([0, len(p.segments)]),
        )
        places = self._bind(p, members, folds)
        state, work = begin(p, self._matrices.rows)
        places += members.tolerances(work)
        scheduled = of_members(schedule_table(p, self._between), members)
        at_events = n_events > 0 and vector is not None and vector.watches
        at_folds = len(folds) > 0 and vector is not None and vector.accumulates
        self.record = self._record(p, vector, results, at_events, at_folds, folds)
        task = arguments.Task(
            self._addresses(p, vector, members.segments), results.queue, self.record, state,
            OUTPUT_RECORD(*first_output(p, False, results.extrema)),
            members.words, members.y0, scheduled, rows_of_segments,
        )  # fmt: skip
        rows = N_FIELDS + 2 * n_events * at_events + len(folds) * at_folds
        lanes = self._lanes = self._new_lanes(p, members, vector, work, rows)
        self._problem, self._progress = p, [(arguments.IDLE, Progress(p, p.t0, 0))] * width
        extended = np.empty((2, n + 1))
        scratch = np.empty(scratch_shape(p.method, n_events, len(work), n))
        block = self.bounds[0].block
        single = arguments.Single(work, block, _table(places), scratch, extended)
        e_room = n_events * p.method.events_at_once * (1 if vector else 8)
        if p.schedules:  # which act at the start of a trajectory, and behind a step
            e_room += n_events * p.method.events_at_once + 2 * len(p.schedules)
        n_dense = order_of_many(p.rtol, p.atol) if p.method.series else p.method.n_dense
        room = arguments.Room(
            np.empty(0 if p.t_eval is None else len(p.t_eval)),
            np.empty((1, n_dense + 1, n)), np.empty((1, 2)),
            np.empty(0) if p.t_eval is None else p.t_eval.astype(float), segments,
            np.empty(e_room, np.int64), np.empty(e_room), np.empty((e_room, n)),
        )  # fmt: skip
        self._room = max(ROOM, (width + 1) * e_room) if e_room else 0
        self._n = n
        self._piece = self._new_piece()
        done = arguments.Results(*(getattr(results, name) for name in arguments.Results._fields))
        given = task, lanes, single, room, done, self._piece
        folds = self._folds(folds)
        kernel = serve_kernel(*given, folds, 0)
        self._serve = code_store.Call(kernel, *chain(*given), folds, self._chunk)

    def _bind(self, p, members, folds):
        """Bind all functions to blocks of this worker; returns the places of varying parameters."""
        places = []
        self.bounds = []
        for fun, mode, length in functions_of(p, folds):
            bound, offsets = members.bind(fun, mode, length, members.near(p, length))
            self.bounds.append(bound)
            address = bound.block.ctypes.data
            places += [(address + 8 * at, column, 0) for at, column in offsets]
        others = self.bounds[1 : len(self.bounds) - len(folds)]
        self._matrices = matrices_of_member(p, self.bounds[0], others)
        self._mass = mass_of(p, self.bounds[0])
        self._between = self._mass.consistent(self.bounds[1:])
        return places

    def _addresses(self, p, vector, segments):
        name = p.method.name
        n = len(p.y0)
        advance = vector
        if vector is None and p.method.series:
            advance = series_kernel(p, self.bounds[0], order_of_many(p.rtol, p.atol))
        elif vector is None:
            function = self.bounds[0].function
            if function and inlines(name, n, function):
                advance = inlined_kernel(name, function, n)
            advance = advance or shared_kernel(name)
        scalar = advance if p.method.series else shared_kernel(name)
        watch = watch_kernel() if segments else watch_of(p)
        kernels = (
            advance, start_kernel(name), watch, dense_rows_kernel(name), already_kernel(),
            events_kernel(), scalar,
        )  # fmt: skip
        self._kernels = kernels  # kept alive: the kernel gets their addresses
        blocks = [bound.block.ctypes.data for bound in self.bounds]
        blocks += [block.ctypes.data for block in self._mass.blocks]
        return np.array([*(kernel.address for kernel in kernels), *blocks], np.int64)

    def _record(self, p, vector, results, at_events, at_folds, folds):
        record: Any = np.zeros(1, arguments.WORKER)
        record["vector"], record["order"] = vector is not None, p.method.error_order
        record["fsal_stage"], record["max_steps"] = p.method.fsal_stage, p.max_steps
        record["t_final"] = last_time(p.tf)
        record["extrema"], record["keep_found"] = results.extrema, results.keep_found
        record["keeps"], record["past"] = keeps(p), p.method.past
        record["n_past"] = p.method.n_past
        last = -1 - len(folds) - (p.jac is not None)
        if p.project is not None:
            record["project"] = self.bounds[last].block.ctypes.data
            last -= 1
        if p.inside is not None:
            record["inside"] = self.bounds[last].block.ctypes.data
        record["watches"] = at_events
        record["accumulates"] = at_folds
        alone = (p.events and not at_events) or (folds and not at_folds)
        record["each"] = p.project is not None or keeps(p) != 0 or bool(alone)
        return record

    def _new_lanes(self, p, members, vector, work, rows):
        n = len(p.y0)
        width = vector.width if vector else 1
        block = np.zeros(FIRST + (vector.n_words if vector else 0), np.int64)
        places = []
        block[MASS] = self.bounds[0].block[MASS]
        if vector:
            places = members.places(vector, block)
        events = event_table(p, self._between, order_of_many(p.rtol, p.atol))
        rows_of_lanes = K + p.method.n_rows + N_EXTREMA
        many = np.zeros((rows_of_lanes, n * width))
        for row in (RTOL, ATOL):
            many[row] = np.repeat(work[row], width)
        return arguments.Lanes(
            np.zeros((rows, width)), many, block, _table(places), np.full(width, arguments.IDLE),
            np.zeros(width, STATE), np.zeros(width, OUTPUT), np.repeat(events[None], width, axis=0),
            np.zeros((width, len(p.schedules)), SCHEDULES),
        )  # fmt: skip

    def _folds(self, folds):
        table: Any = np.zeros(len(folds), arguments.FOLD)
        for i, fold in enumerate(folds):
            table[i] = self.bounds[i - len(folds)].block.ctypes.data, fold.start
        return table

    def _new_piece(self):
        room = self._room
        where = np.empty((room, 2), np.int64)
        t = np.empty(room)
        y = np.empty((room, self._n))
        return arguments.Found(where, t, y)

    def _keep_piece(self):
        n = self.record["n_found"][0]
        if n:
            self.found.append(tuple(part[:n] for part in self._piece))
            self.record["n_found"] = 0
            self._room *= 2
            self._piece = self._new_piece()
            for name, part in self._piece._asdict().items():
                self._serve[f"found.{name}"] = part

    def run(self, stopped):
        """Solve trajectories from the queue until the queue is empty or `stopped()`."""
        status = RUNNING
        while status in (RUNNING, FULL) and not stopped():
            began = time.perf_counter()
            self._serve["n_steps"] = self._chunk
            status = self._serve()
            spent = time.perf_counter() - began
            if status == FULL:
                self._keep_piece()
            elif status == RUNNING:
                self._chunk = next_chunk(self._chunk, spent)
                self._give_up_what_stands()
        self._keep_piece()

    def _give_up_what_stands(self):
        """Mark the trajectories whose ends are out of reach."""
        for lane, member in enumerate(self._lanes.members.tolist()):
            if member < 0:
                continue
            now = self._reached(lane)
            present, progress = self._progress[lane]
            if member != present:
                self._progress[lane] = member, Progress(self._problem, *now)
            elif progress.stands(*now):
                self._lanes.members[lane] = arguments.GIVEN_UP - member

    def _reached(self, lane):
        if not self.record["vector"][0]:
            return reached(self._lanes.states[lane])
        fields = self._lanes.fields
        return float(fields[T, lane]), int(fields[ACCEPTED, lane]), 0


def functions_of(problem, folds=()):
    """The functions of a solve: (function, mode, length of the function's y)."""
    p = problem
    n = len(problem.y0)
    functions = [(p.fun, p.mode, n // 2 if p.method.second_order else n)]
    functions += [(*each, n) for each in between_steps(p)]
    functions += [(fold.of_state(n, p.mode.n_copies), EVENT, n + 1) for fold in folds]
    return functions


def _table(places):
    return np.array(places, np.int64).reshape(-1, 3)
