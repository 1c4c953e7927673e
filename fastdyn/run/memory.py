"""The memory of a solve: its arrays in one piece of memory, its arguments in words."""

import struct
from array import array
from typing import Any

import numpy as np

from fastdyn.code_store import meant_for
from fastdyn.code_store.call import KERNEL, address_of
from fastdyn.compile import memory
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.kernels.output.arguments import EVENTS, OUTPUT, SCHEDULES, Launch
from fastdyn.kernels.state.record import STATE, K
from fastdyn.specialise.scalar import (
    dense_rows_kernel,
    events_kernel,
    launch_kernel,
    start_kernel,
    whole_solve_kernel,
)

FLOAT = np.dtype("f8")
INT = np.dtype("i8")


def scratch_shape(method, n_events, rows, n):
    """Two rows, and a copy of the work array where series of events are searched in parts."""
    return 2 + (rows if method.series and n_events else 0), n


class Plan:
    """The layout of the memory, for one method, number of components and size of the output.

    Parameters
    ----------
    name : str
        The name of the method.
    pair : bool
        True if the equations are a Pair.
    n : int
        Number of components.
    n_events, n_schedules : int
    n_points, n_occurrences : int
        Room for points, and for events of all steps but the last.
    polynomials : tuple of int
        Room for polynomials, and the rows of each.
    matrix_rows : int
        Rows of the work array that a matrix takes.

    Attributes
    ----------
    arrays : dict of str to (first word, past its last, dtype, shape)
        The place in the memory of each array, by the name of the kernel's argument.
    head, size : int
        The number of words that are initialised (the image: all but matrices and room for the
        output), and the number of all words.
    words : array.array
        The arguments of the kernel, without addresses in the memory and values of one solve.
    places : ndarray, shape (n_arrays, 2)
        The words that name arrays of the memory, and the offsets of these arrays in bytes.
    at : dict of str to int
        The index of the word of each argument.
    at_once : int
        The most events in one step.
    kernel, launch : callable
        ``kernel(address of the words)`` returns the status; `launch` takes the words of a Launch.
    """

    def __init__(
        self, name, pair, n, n_events, n_schedules, n_points, polynomials, n_occurrences,
        matrix_rows,
    ):  # fmt: skip
        method = BY_NAME[name]
        self.n = n
        self.room = n_points
        meant_for(name.removesuffix(ON_PAIRS))
        self.n_events = n_events + n_schedules
        self.at_once = n_events * method.events_at_once + n_schedules
        n_occurrences += self.at_once
        self._code = whole_solve_kernel()
        self.kernel, self.launch = map(KERNEL, (self._code.address, launch_kernel().address))
        self.at = {name: argument.at for name, argument in self._code.layout.items()}
        self.words = array("q", bytes(8 * (1 + max(self.at.values()))))
        rows = K + method.rows(matrix_rows)
        shapes: dict[str, Any] = {
            "solve.state": (STATE, (1,)),
            "output.record": (OUTPUT, (1,)),
            "events.table": (EVENTS, (n_events,)),
            "events.schedules": (SCHEDULES, (n_schedules,)),
            "solve.work": (FLOAT, (rows, n)),
            "scratch": (FLOAT, scratch_shape(method, n_events, rows, n)),
            "output.t": (FLOAT, (n_points,)),
            "output.y": (FLOAT, (n_points, n)),
            "output.d": (FLOAT, (*polynomials, n)),
            "output.spans": (FLOAT, (polynomials[0], 2)),
            "events.index": (INT, (n_occurrences,)),
            "events.t": (FLOAT, (n_occurrences,)),
            "events.y": (FLOAT, (n_occurrences, n)),
        }
        self._lay_out(shapes)
        self.head = self.arrays["solve.work"][0] + (K + method.n_rows) * n
        self._counts = {}
        lay(self.words, self.at["begin.y0"], 0, (n,))
        kernels = {
            "kernels.start": start_kernel(name, pair),
            "kernels.dense_rows": dense_rows_kernel(name, pair),
        }
        if n_events:
            kernels["begin.open"] = events_kernel()
        for argument, kernel in kernels.items():
            self.words[self.at[argument]] = kernel.address
        self.words[self.at["kernels.fsal_stage"]] = method.fsal_stage
        self.words[self.at["begin.before_events"]] = method.before_events
        self.words[self.at["kernels.past"]] = method.past
        self.words[self.at["kernels.n_past"]] = method.n_past
        (order,) = struct.unpack("q", struct.pack("d", method.error_order))
        self.words[self.at["kernels.order"]] = order

    def _lay_out(self, shapes):
        self.arrays = {}
        places = []
        self.size = 0
        for name, (dtype, shape) in shapes.items():
            end = self.size + int(np.prod(shape)) * dtype.itemsize // 8
            self.arrays[name] = self.size, end, dtype, shape
            if end > self.size:
                places.append((self.at[name], 8 * self.size))
            lay(self.words, self.at[name], 0, shape)
            self.size = end
        self.places = np.array(places)

    def view(self, memory, name):
        """The array `name` of a memory."""
        begin, end, dtype, shape = self.arrays[name]
        return memory[begin:end].view(dtype).reshape(shape)

    def counts(self, *names):
        """``unpack(memory)``: a tuple of counts of a solve, fields of STATE and then of OUTPUT.

        The names are in the order of the fields.
        """
        unpack = self._counts.get(names)
        if unpack is None:
            form = "="
            at = 0
            for place in map(self.place, names):
                form = f"{form}{place - at}xq"
                at = place + 8
            unpack = self._counts[names] = struct.Struct(form).unpack_from
        return unpack

    def place(self, name):
        """The offset in bytes of a count, a field of STATE or of OUTPUT."""
        if name in STATE.names:
            return STATE.fields[name][1]
        return 8 * self.arrays["output.record"][0] + OUTPUT.fields[name][1]

    def launch_words(self, words, image, places):
        """The words of a Launch; each solve sets the words MEMORY and Y0."""
        launch = array("q", [self._code.address, words.buffer_info()[0], 0, 0])
        for given in (image, places):
            launch.extend((address_of(given), *given.shape))
        return launch


MEMORY, Y0 = map(Launch._fields.index, ("memory", "y0"))  # words of a Launch
plan = memory.cached(Plan)


def lay(words, at, address, shape):
    """Write the address and the shape of an array into words."""
    words[at] = address
    for extent in shape:
        at += 1
        words[at] = extent
