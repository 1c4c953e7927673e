"""The chunk loop: advance, grow the output, show progress, stop on Ctrl-C."""

import math
import struct
import time
from typing import Any

import numpy as np

from .callback import evaluate, interruptible
from .kernels.calls import FAULT, RAISED, TIME
from .kernels.events import EVENTS
from .kernels.state import ATOL, FULL, INTERRUPTED, RTOL, RUNNING, STATE, STEP_LIMIT, K, Y
from .kernels.state import RAISED as RAISED_STATUS
from .kernels.watch import OUTPUT
from .specialise import Tier, events_kernel, start_kernel, watch_kernel

CHUNK_SECONDS = 0.05  # between two looks at Ctrl-C, the progress bar and the tier
PIECE = 128  # points in the first piece of the output; later ones double
PIECE_NUMBERS = 2**22  # numbers in one piece at most
NO_EVENTS = np.zeros(0, EVENTS)
NO_TIMES = np.empty(0)
NO_OCCURRENCES = np.empty(0, np.int64), np.empty(0), np.empty((0, 0))


def _record(dtype):
    """A function from the fields, all of 8 bytes, to an array of one record."""
    codes = [{"f": "d", "i": "q"}[dtype[name].kind] for name in dtype.names]
    pack = struct.Struct("".join(codes)).pack
    return lambda *fields: np.frombuffer(bytearray(pack(*fields)), dtype)


STATE_RECORD, OUTPUT_RECORD = _record(STATE), _record(OUTPUT)  # half the time of np.array


def counters(state):
    """n_accepted, n_rejected and n_extra of a state."""
    return struct.unpack_from("3q", state, STATE.fields["n_accepted"][1])


class Output:
    """Arrays that the kernels fill, in pieces, so that growing never copies what is there."""

    def __init__(self, problem, n):
        self._n, self._rows = n, problem.method.n_dense + 1
        self._points, self._dense, self._events = [], [], []
        self._m = len(problem.events or ())
        self.every_step, self.dense = problem.t_eval is None, problem.dense_output
        n_first = 1 if self.every_step else 0
        self.record: Any = OUTPUT_RECORD(
            self.every_step, self.dense, n_first, n_first, 0, 0, 0, 0, problem.t0
        )
        self._n_places = n_places = PIECE if self.every_step else len(problem.t_eval)
        self.t, self.y = np.empty(n_places), np.empty((n_places, n))
        if self.every_step:
            self.t[0], self.y[0] = problem.t0, problem.y0
        self._n_polynomials = PIECE if self.dense else 1
        self._new_polynomials()
        self.e_index, self.e_t, self.e_y = NO_OCCURRENCES
        if self._m:
            self._n_occurrences = PIECE
            self._new_events()

    def _larger(self, size, numbers):
        return max(min(2 * size, PIECE_NUMBERS // numbers), size if size <= PIECE else PIECE)

    def _new_polynomials(self):
        self.d = np.empty((self._n_polynomials, self._rows, self._n))
        self.spans = np.empty((self._n_polynomials, 2))

    def _new_events(self):
        size = self._n_occurrences + self._m
        self.e_index = np.empty(size, np.int64)
        self.e_t, self.e_y = np.empty(size), np.empty((size, self._n))

    def make_room(self):
        """New arrays for those that are full; what they hold is kept aside."""
        o = self.record[0]
        if self.every_step and o["n_out"] == len(self.t):
            self._points.append((self.t, self.y))
            self._n_places = self._larger(self._n_places, self._n)
            self.t, self.y = np.empty(self._n_places), np.empty((self._n_places, self._n))
            o["n_out"] = 0
        if self.dense and o["n_dense"] == len(self.d):
            self._dense.append((self.d, self.spans))
            self._n_polynomials = self._larger(self._n_polynomials, self._n * self._rows)
            self._new_polynomials()
            o["n_dense"] = 0
        if self._m and o["n_events"] + self._m > len(self.e_t):
            self._events.append(self._found(o["n_events"]))
            self._n_occurrences = self._larger(self._n_occurrences, self._n)
            self._new_events()
            o["n_events"] = 0

    def _found(self, n):
        return self.e_index[:n], self.e_t[:n], self.e_y[:n]

    def points(self):
        """All stored (t, y), y of shape (n_points, n)."""
        n = self.record["n_out" if self.every_step else "i_eval"][0]
        last = self.t[:n], self.y[:n]
        return _join([*self._points, last]) if self._points else last

    def polynomials(self):
        """All stored (polynomials, spans)."""
        n = self.record[0]["n_dense"]
        return _join([*self._dense, (self.d[:n], self.spans[:n])])

    def found_so_far(self):
        """All occurrences of events as (index, t, y)."""
        return _join([*self._events, self._found(self.record[0]["n_events"])])

    def put_back(self, arrays):
        """Go on behind the output of a checkpoint."""
        self.record[:] = arrays["record"]
        o = self.record[0]
        if self.every_step:
            self._points, o["n_out"] = [(arrays["t"], arrays["y"])], 0
        else:
            n = len(arrays["t"])
            self.t[:n], self.y[:n] = arrays["t"], arrays["y"]
        if self.dense:
            self._dense, o["n_dense"] = [(arrays["polynomials"], arrays["spans"])], 0
        if self._m:
            found = tuple(arrays[name] for name in ("e_index", "e_t", "e_y"))
            self._events, o["n_events"] = [found], 0

    def occurrences(self):
        """t_events and y_events."""
        index, t, y = self.found_so_far()
        which = [index == i for i in range(self._m)]
        return [t[w] for w in which], [y[w] if w.any() else np.empty(0) for w in which]


def _join(pieces):
    return pieces[0] if len(pieces) == 1 else tuple(map(np.concatenate, zip(*pieces, strict=True)))


def begin(problem) -> Any:
    """The state record and the work array before the first step."""
    n, p = len(problem.y0), problem
    direction = 1.0 if p.tf >= p.t0 else -1.0
    t0, end = map(float, p.legs[0, :2]) if len(p.legs) else (p.t0, p.tf)
    state = STATE_RECORD(t0, t0, end, end, t0, direction, p.h, p.h_max, 0.0, 0, 0, 0)
    work = np.zeros((K + p.method.n_rows, n))
    work[Y], work[RTOL], work[ATOL] = p.y0, p.rtol, p.atol
    return state, work


def _event_table(problem, bound_events, state, work, scratch):
    """EVENTS records with the values at the start, and the status."""
    if not bound_events:
        return NO_EVENTS, RUNNING
    table: Any = np.zeros(len(bound_events), EVENTS)
    for i, bound in enumerate(bound_events):
        _, limit, direction = problem.events[i]
        row = table[i]
        row["block"], row["limit"], row["direction"] = bound.block.ctypes.data, limit, direction
    return table, events_kernel().call(table, problem.t0, work[Y], scratch[1])


def raise_kept(bounds):
    """Raise what a user's function raised: from Python, or by asking it again in Python."""
    for bound in bounds:
        if bound.block[RAISED]:
            if bound.callback is not None and bound.callback.exception is not None:
                raise bound.callback.exception
            t = float(bound.block[TIME : TIME + 1].view(float)[0])
            y = bound.block[bound.block[FAULT] :].view(float)
            evaluate(bound.python, bound.mode, t, y.copy())
            raise RuntimeError(f"the compiled function raised at t = {t!r}, y = {y!r}")


def run(problem, bound, bound_events, projection):
    """Solve; returns (status, state, work, output).

    `bound`, `bound_events` and `projection` (None, or what takes a state to its constraints) are
    the functions as `adapt.bind` gives them.
    """
    p = problem
    n = len(p.y0)
    state, work = begin(p)
    output = Output(p, n)
    scratch = np.empty((2, n))
    tier = Tier(p.method.name, bound, n, p.tier)
    kernel = (p.method.name, bool(bound.parts))
    start, watch = start_kernel(*kernel).call, watch_kernel(*kernel).call
    block, t_eval = bound.block, NO_TIMES if p.t_eval is None else p.t_eval.astype(float)
    bar = progress_bar(p) if p.progress else None
    everyone = [*bound.parts, bound, *bound_events]
    if projection is not None:
        everyone.append(projection)
    project = 0 if projection is None else projection.block.ctypes.data
    if callbacks := [b.callback for b in everyone if b.callback is not None]:
        watch = interruptible(callbacks)(watch)
    status, left = INTERRUPTED, p.max_steps
    file: Any = None
    if p.checkpoint is not None:
        from .resume import checkpoint_of, from_arrays, to_arrays

        file = checkpoint_of(p, everyone)
    table: Any = NO_EVENTS
    try:
        began = time.perf_counter()
        status = start(state, work, block, float(p.method.error_order), p.method.last)
        cost = time.perf_counter() - began
        table, opened = _event_table(p, bound_events, state, work, scratch)
        status = opened if status == RUNNING else status
        if file is not None and (saved := file.load()) is not None:
            status = from_arrays(saved, state, work, output, table)  # pyright: ignore
        chunk = max(1, int(CHUNK_SECONDS / (cost * (p.method.cost or p.method.n_stages + 1))))
        while status in (RUNNING, FULL):
            if left != math.inf:
                left = p.max_steps - int(state["n_accepted"][0])
                if left <= 0:
                    status = STEP_LIMIT
                    break
            n_steps = chunk if chunk < left else int(left)
            began = time.perf_counter()
            status = watch(
                tier.address, state, work, block, output.record, output.t, output.y, output.d,
                output.spans, t_eval, p.legs, project, table, output.e_index, output.e_t,
                output.e_y, scratch, n_steps,
            )  # fmt: skip
            spent = time.perf_counter() - began
            tier.spend(spent)
            if status == FULL:
                output.make_room()
            elif status == RUNNING:
                chunk = max(1, int(n_steps * min(4.0, CHUNK_SECONDS / max(spent, 1e-9))))
                tier.review()
            if bar is not None:
                bar.update(abs(float(state["t"][0]) - p.t0) - bar.n)
            if file is not None and (file.due() or status not in (RUNNING, FULL)):
                file.save(to_arrays(status, state, work, output, table))  # pyright: ignore
    except KeyboardInterrupt:
        if file is not None and status in (RUNNING, FULL):
            file.save(to_arrays(status, state, work, output, table))  # pyright: ignore
        if p.on_interrupt != "return":
            raise
        status = INTERRUPTED
    finally:
        if bar is not None:
            bar.close()
    if status == RAISED_STATUS:
        try:
            raise_kept(everyone)
        except KeyboardInterrupt:
            if p.on_interrupt != "return":
                raise
            status = INTERRUPTED
    return status, state, work, output


def progress_bar(problem):
    from tqdm.auto import tqdm

    return tqdm(
        total=abs(problem.tf - problem.t0),
        desc=problem.method.name,
        bar_format="{l_bar}{bar}| t {n:.4g}/{total:.4g} [{elapsed}<{remaining}]",
    )
