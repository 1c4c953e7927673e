"""The arrays that the kernels fill: points, polynomials, events."""

import functools
import struct
from typing import Any

import numpy as np

from fastdyn.kernels.output.arguments import OUTPUT
from fastdyn.kernels.state.record import STATE

PIECE = 128  # points in the first piece of the output; each later piece is twice as long
PIECE_NUMBERS = 2**22  # most numbers in a piece
FEWEST = 4  # fewest places in the first piece
MOST_COPIES = 64  # numbers of points whose slices are kept, of some 500 bytes each
FLOAT = np.dtype(float)
OCCURRENCES = ("events.index", "events.t", "events.y")


def _words(dtype):
    """The packing of the fields of a record, all of 8 bytes."""
    return struct.Struct("".join([{"f": "d", "i": "q"}[dtype[name].kind] for name in dtype.names]))


def _record(words, dtype):
    """A function that makes an array of one record from its fields, twice as fast as np.array."""
    return lambda *fields: np.frombuffer(bytearray(words.pack(*fields)), dtype)


STATE_WORDS = _words(STATE)
OUTPUT_WORDS = _words(OUTPUT)
STATE_RECORD = _record(STATE_WORDS, STATE)
OUTPUT_RECORD = _record(OUTPUT_WORDS, OUTPUT)


def first_piece(numbers):
    """The number of places in the first piece, if each place takes `numbers` numbers."""
    return min(PIECE, max(PIECE_NUMBERS // numbers, FEWEST))


def points_in(plan, memory):
    """All stored (t, y) of a solve whose output lies in the memory of the solve."""
    record: Any = plan.view(memory, "output.record")
    n = record["n_out" if record["every_step"][0] else "i_eval"][0]
    return plan.view(memory, "output.t")[:n], plan.view(memory, "output.y")[:n]


def occurrences_in(plan, memory):
    """All occurrences of events as (index, t, y), of a solve whose output lies in its memory."""
    n = int(plan.view(memory, "output.record")["n_events"][0])
    return tuple([plan.view(memory, name)[:n] for name in OCCURRENCES])


class Output:
    """The stored output of a solve, in pieces: growth adds a piece and copies nothing.

    The first piece lies in the memory of the solve.
    """

    def __init__(self, plan, memory):
        self._n, self._m, view = plan.n, plan.n_events, functools.partial(plan.view, memory)
        self.record: Any = view("output.record")
        self.every_step = bool(self.record["every_step"][0])
        self.dense = bool(self.record["dense"][0])
        self._points = []
        self._dense = []
        self._events = []
        self.t, self.y = view("output.t"), view("output.y")
        self.d, self.spans = view("output.d"), view("output.spans")
        self._n_places, self._n_polynomials, self._rows = len(self.t), *self.d.shape[:2]
        self.e_index, self.e_t = view("events.index"), view("events.t")
        self.e_y = view("events.y")
        self._at_once = plan.at_once
        self._n_occurrences = len(self.e_t) - plan.at_once

    def arrays(self):
        """The arrays of the present pieces, by the names of the kernel's arguments."""
        return {
            "output.t": self.t, "output.y": self.y, "output.d": self.d, "output.spans": self.spans,
            "events.index": self.e_index, "events.t": self.e_t, "events.y": self.e_y,
        }  # fmt: skip

    def _larger(self, size, numbers):
        return max(min(2 * size, PIECE_NUMBERS // numbers), size if size <= PIECE else PIECE)

    def _grow_dense(self, o):
        self._dense.append((self.d, self.spans))
        self._n_polynomials = self._larger(self._n_polynomials, self._n * self._rows)
        self._new_polynomials()
        o["n_dense"] = 0

    def _new_polynomials(self):
        self.d = np.empty((self._n_polynomials, self._rows, self._n))
        self.spans = np.empty((self._n_polynomials, 2))

    def _new_events(self):
        size = self._n_occurrences + self._at_once
        self.e_index = np.empty(size, np.int64)
        self.e_t, self.e_y = np.empty(size), np.empty((size, self._n))

    def make_room(self):
        """Replace full arrays by new arrays, and keep the full arrays aside."""
        o = self.record[0]
        n = o["n_out"]
        if self.every_step and n + o["jumps"] >= len(self.t):
            self._points.append((self.t[:n], self.y[:n]))
            self._n_places = self._larger(self._n_places, self._n)
            self.t, self.y = np.empty(self._n_places), np.empty((self._n_places, self._n))
            o["n_out"] = 0
        if self.dense and o["n_dense"] == len(self.d):
            self._grow_dense(o)
        if self._m and o["n_events"] + self._at_once > len(self.e_t):
            self._events.append(self._found(o["n_events"]))
            self._n_occurrences = self._larger(self._n_occurrences, self._n)
            self._new_events()
            o["n_events"] = 0

    def _found(self, n):
        return self.e_index[:n], self.e_t[:n], self.e_y[:n]

    def n_points(self):
        """The number of points in all pieces."""
        return self.record["n_total"][0]

    def points(self):
        """All stored (t, y), y of shape (n_points, n)."""
        n = self.record["n_out" if self.every_step else "i_eval"][0]
        last = self.t[:n], self.y[:n]
        if self._points:
            return _join([*self._points, last])
        return last

    def polynomials(self):
        """All stored (polynomials, spans)."""
        n = self.record[0]["n_dense"]
        return _join([*self._dense, (self.d[:n], self.spans[:n])])

    def found_so_far(self):
        """All occurrences of events as (index, t, y)."""
        return _join([*self._events, self._found(self.record[0]["n_events"])])

    def put_back(self, arrays):
        """Continue behind the output of a checkpoint."""
        self.record[:] = arrays["record"]
        o = self.record[0]
        if self.every_step:
            self._points = [(arrays["t"], arrays["y"])]
            o["n_out"] = 0
        else:
            n = len(arrays["t"])
            self.t[:n], self.y[:n] = arrays["t"], arrays["y"]
        if self.dense:
            self._dense = [(arrays["polynomials"], arrays["spans"])]
            o["n_dense"] = 0
        if self._m:
            found = tuple(arrays[name] for name in ("e_index", "e_t", "e_y"))
            self._events = [found]
            o["n_events"] = 0


class Copies(dict):
    """By the number of points, the functions that copy the times and the states of a memory.

    The bound methods of two slices, laid out once, copy in half of the time.  With `divided` of
    `outcome.results`, (name, function) pairs follow, for the parts of `sensitivity`.
    """

    def __init__(self, plan, own, divided):
        self._t, self._y = [plan.view(own, name) for name in ("output.t", "output.y")]
        self._divided = divided

    def __missing__(self, k):
        if len(self) >= MOST_COPIES:
            self.clear()
        states = self._y[:k]
        parts: tuple = ()
        if self._divided is not None:
            states, named = self._divided(states)
            parts = tuple([(name, part.__copy__) for name, part in named.items()])
        found = self[k] = self._t[:k].copy, states.T.__copy__, parts  # which keeps the order
        return found


def add_parts(found, copied, *_):
    """Add the field `sensitivity`, from an entry of Copies."""
    parts = found["sensitivity"] = {}
    for name, copy in copied[2]:
        parts[name] = copy()


def as_components(problem, numbers):
    """Numbers along the last axis as components of the state, complex if the state is."""
    if not problem.mode.complex_numbers:
        return numbers
    return np.ascontiguousarray(numbers).view(complex)


def conversion(problem):
    """``convert(t, y)``: times and states in the types of the problem; None if they have these."""
    p = problem
    dtype = None if p.t_eval is None or p.t_eval.dtype == FLOAT else p.t_eval.dtype
    is_complex = p.mode.complex_numbers
    if dtype is None and not is_complex:
        return None

    def convert(t, y):
        if dtype is not None:
            t = t.astype(dtype, copy=False)
        return t, as_components(p, y.T).T if is_complex else y

    return convert


def occurrences(index, t, y, n_events):
    """The fields t_events and y_events: copies of the occurrences, event by event."""
    known = {*index.tolist()}
    times = []
    states = []
    for i in range(n_events):
        if i not in known:
            times.append(np.empty(0))
            states.append(np.empty(0))
            continue
        which = index == i if len(known) > 1 else slice(None)
        times.append(unshared(t[which]))
        states.append(unshared(y[which]))
    return times, states


def unshared(numbers):
    """An array, copied if it is a part of another one."""
    return numbers if numbers.base is None else numbers.copy()


def _join(pieces):
    return pieces[0] if len(pieces) == 1 else tuple(map(np.concatenate, zip(*pieces, strict=True)))
