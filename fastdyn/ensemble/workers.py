"""The workers of an ensemble: threads that take trajectories from one queue."""

import functools
import time
from typing import Any

import numpy as np
from numba import typeof, types

from fastdyn import code_store
from fastdyn.kernels.calls.user_function import FIRST
from fastdyn.kernels.ensemble.lanes import N_FIELDS
from fastdyn.kernels.ensemble.scheduler import FOLD, IDLE, WORKER, already, serve
from fastdyn.kernels.output.events import EVENTS
from fastdyn.kernels.output.sampling import OUTPUT
from fastdyn.kernels.state.record import ATOL, FULL, RTOL, RUNNING, STATE
from fastdyn.run.loop import CHUNK_SECONDS, begin
from fastdyn.run.output import OUTPUT_RECORD
from fastdyn.specialise.scalar import (
    MAX_TUPLE,
    enrich_kernel,
    events_kernel,
    inlined_kernel,
    shared_kernel,
    start_kernel,
    watch_kernel,
)
from fastdyn.specialise.signatures import ADVANCE

from . import reductions

ROOM = 256  # events in the first piece


@functools.cache
def _serving():
    """The compiled `serve`, one for every method and function."""

    def build():
        reals = [types.Array(types.float64, d, "C") for d in range(4)]
        whole = [types.Array(types.int64, d, "C") for d in range(3)]
        records = {d: typeof(np.zeros(1, d)) for d in (WORKER, STATE, OUTPUT, FOLD)}
        table = typeof(np.zeros((1, 1), EVENTS))
        signature = types.int64(
            whole[1], whole[1], records[WORKER], records[STATE], records[OUTPUT],
            reals[2], reals[2], whole[1], whole[2],
            whole[1], records[STATE], records[OUTPUT], table, reals[2], whole[1], whole[2],
            whole[2], reals[2],
            reals[1], reals[2], reals[2], reals[1], reals[3], reals[2], whole[1], reals[1],
            reals[2],
            reals[3], reals[2], reals[1], whole[1], whole[2], reals[3], reals[2], reals[2],
            whole[2], reals[1], reals[2], records[FOLD], reals[2], types.int64,
        )  # fmt: skip
        return serve, signature

    return code_store.compiled("serve", build)


@functools.cache
def _already():
    return code_store.compiled("already", lambda: (already, ADVANCE)).address


class Worker:
    """One thread's lanes, and the functions of the user with a block of its own.

    Parameters
    ----------
    problem : check.Problem
    members : members.Members
    vector : lanes.Kernel or None
    results : Results
    folds : sequence of reductions.Fold
    """

    def __init__(self, problem, members, vector, results, folds=()):
        p, n = problem, len(problem.y0)
        self._results, self.found = results, []
        width = vector.width if vector else 1
        state, self._work = begin(p)
        places, bounds = [], []
        for fun, mode, length in functions_of(p, folds):
            bound, offsets = members.bind(fun, mode, length)
            bounds.append(bound)
            address = bound.block.ctypes.data
            places += [(address + 8 * at, column, 0) for at, column in offsets]
        self.bounds = bounds
        blocks = [bound.block.ctypes.data for bound in bounds]
        many_block, many_places = np.zeros(FIRST + (vector.n_words if vector else 0), np.int64), []
        if vector:
            many_places = members.places(vector, many_block)
        name = p.method.name
        advance = vector
        if vector is None:
            function = bounds[0].function
            if function is not None and n <= MAX_TUPLE:
                advance = inlined_kernel(name, function, n)
            advance = advance or shared_kernel(name)
        addresses = np.array(
            [
                advance.address, start_kernel(name).address, watch_kernel().address,
                enrich_kernel(name).address,
                _already(), events_kernel().address, *blocks,
            ],
            np.int64,
        )  # fmt: skip
        n_events = len(p.events or ())
        events: Any = np.zeros((width, n_events), EVENTS)
        for i, bound in enumerate(bounds[1 : 1 + n_events]):
            _, limit, direction = p.events[i]
            events["block"][:, i] = bound.block.ctypes.data
            events["limit"][:, i], events["direction"][:, i] = limit, direction
        worker: Any = np.zeros(1, WORKER)
        worker["vector"], worker["order"] = vector is not None, p.method.error_order
        worker["last"], worker["max_steps"] = p.method.last, p.max_steps
        worker["t_final"] = p.tf
        worker["extrema"], worker["keep_found"] = results.extrema, results.keep_found
        worker["project"] = bounds[-1].block.ctypes.data if p.project is not None else 0
        worker["watches"] = watches = n_events > 0 and vector is not None and vector.watches
        worker["gathers"] = gathers = len(folds) > 0 and vector is not None and vector.gathers
        unwatched, ungathered = n_events > 0 and not watches, len(folds) > 0 and not gathers
        worker["each"] = p.project is not None or unwatched or ungathered
        fold_table: Any = np.zeros(len(folds), FOLD)
        for i, fold in enumerate(folds):
            fold_table[i] = bounds[1 + n_events + i].block.ctypes.data, fold.start
        self.record = worker
        many = np.zeros((len(self._work) + 2, n * width))
        for row in (RTOL, ATOL):
            many[row] = np.repeat(self._work[row], width)
        lanes = np.zeros((N_FIELDS + n_events * watches + len(folds) * gathers, width))
        n_times = 0 if p.t_eval is None else len(p.t_eval)
        rows = p.method.n_dense + 1
        e_room = n_events * (1 if vector else 8)
        given = (
            addresses, results.queue, worker, state,
            OUTPUT_RECORD(0, results.extrema, 0, 0, 0, 0, 0, 0, p.t0),
            lanes, many, many_block, _table(many_places),
            np.full(width, IDLE), np.zeros(width, STATE), np.zeros(width, OUTPUT), events,
            self._work, bounds[0].block, _table(places), members.words, members.y0,
            None if p.t_eval is None else p.t_eval.astype(float), p.legs, np.empty((2, n)),
            np.empty(n_times), np.empty((1, rows, n)), np.empty((1, 2)),
            np.empty(e_room, np.int64), np.empty(e_room), np.empty((e_room, n)),
            results.y_eval, results.y_end, results.t_end, results.status, results.counts,
            results.best, results.t_first, results.folded,
        )  # fmt: skip
        self._room = max(ROOM, width * e_room) if n_events else 0
        self._new_piece()
        self._chunk = 100
        folds = fold_table, np.empty((2, n + 1))
        self._serve = code_store.Call(_serving(), *given, *self._piece, *folds, self._chunk)

    def _new_piece(self):
        n, room = len(self._work[0]), self._room
        self._piece = np.empty((room, 2), np.int64), np.empty(room), np.empty((room, n))

    def _keep_piece(self):
        n = self.record["n_found"][0]
        if n:
            self.found.append(tuple(part[:n] for part in self._piece))
            self.record["n_found"] = 0
            self._room *= 2
            self._new_piece()
            for name, part in zip(("f_where", "f_t", "f_y"), self._piece, strict=True):
                self._serve[name] = part

    def run(self, stopped):
        """Serve until the queue is empty or `stopped()`."""
        status = RUNNING
        while status in (RUNNING, FULL) and not stopped():
            began = time.perf_counter()
            self._serve["n_steps"] = self._chunk
            status = self._serve()
            spent = time.perf_counter() - began
            if status == FULL:
                self._keep_piece()
            elif spent < CHUNK_SECONDS / 2:
                self._chunk *= 2
            elif spent > CHUNK_SECONDS:
                self._chunk = max(1, self._chunk // 2)
        self._keep_piece()


def functions_of(problem, folds=()):
    """The functions that are called in a solve: (function, mode, length of what it gets)."""
    p, n = problem, len(problem.y0)
    functions = [(p.fun, p.mode, n // 2 if p.method.second_order else n)]
    functions += [(event, "event", n) for event, _, _ in p.events or ()]
    n_parts = reductions.parts(p.mode.split())
    functions += [(fold.of_state(n, n_parts), "event", n + 1) for fold in folds]
    if p.project is not None:
        functions.append((p.project, "derivative", n))
    return functions


def _table(places):
    return np.array(places, np.int64).reshape(-1, 3)
