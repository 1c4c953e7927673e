"""Which switching times matter, decided in compiled code for values that change between solves.

A first solve decides by NumPy (`trace.switching.decided`), in a millisecond and without new machine
code.  From the MANYth decision on, the numbers that meet the state have code of their own.
"""

import struct
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.code_store.call import address_of
from fastdyn.compile.mode import TIMED
from fastdyn.kernels.calls.block import ADDRESS, FIRST
from fastdyn.specialise.scalar import decide_kernel
from fastdyn.trace.graph.refusal import Refusal
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.reads.reads import flat
from fastdyn.trace.switching import decided

MANY = 3  # decisions; the code costs as much as some five decisions by NumPy
KEPT = 1.0  # of the kernel's marks; SHARP is larger
MOST_KEPT = 16  # Times of the same Candidates
POINTS = 7  # rows of room, see the kernel
_pack_span = struct.Struct("2d").pack_into


class Deciding:
    """Decides for the present values in the block of a Bound which Candidates matter.

    `sharp` tells whether anybody asks which of them are sharp; `fixed` are the indices of the
    values by which no derivatives are taken.
    """

    def __init__(self, bound, switches, sharp, fixed):
        self._bound = bound
        self._switches = switches
        self._sharp = sharp
        self._fixed = fixed
        self._count = 0
        self._found = None
        self._marks = b""
        self._call: Any = None
        self._times: Any = None
        self._by_marks: dict = {}
        self._others: Any = None  # for other values of what is differentiated: their key, marks

    def times(self, found, given, y):
        """The Times among Candidates; the same object if nothing has changed."""
        plain = not len(found.at_ends[0]) and (found.sure or not len(found.t))
        if plain:
            return self.all_of(found)
        self._count += 1
        if self._count >= MANY and self._compiled() is not None:
            return self._by_code(found, given)
        values = self._switches.values(flat(given), y)
        times = decided.decided(self._switches, found, values, {})
        self._found = found
        self._times = times
        self._marks = b""
        return times

    def all_of(self, found):
        """The Times if all Candidates matter."""
        if found is not self._found or self._marks:
            self._found = found
            self._marks = b""
            self._times = decided.all_of(found)
        return self._times

    def _by_code(self, found, given):
        call = self._call
        block = self._block
        block[FIRST:] = self._bound.block[FIRST:]
        if found is not self._found or not self._marks:
            self._lay(found)
        if len(self._switches.differentiated):
            self._take_others(found, given)
        call()
        room = self._room if self._others is None else np.maximum(self._room, self._others[1])
        marks = room.tobytes() if self._sharp else (room >= KEPT).tobytes()
        if marks != self._marks:
            self._marks = marks
            times = self._by_marks.get(marks)
            if times is None:
                if len(self._by_marks) == MOST_KEPT:
                    self._by_marks.clear()
                n = len(found.t)
                masks = room[:n] >= KEPT, room[:n] > KEPT, room[n:] >= KEPT
                times = self._by_marks[marks] = decided.with_ends(found, *masks)
            self._times = times
        return self._times

    def _take_others(self, found, given):
        """Decide for other values of what is differentiated, once for those that are fixed."""
        key = key_of(given, self._fixed)
        if self._others is None or self._others[0] != key:
            looked_at = self._switches.looked_at(flat(given))[1:]
            keep, sharp, at_ends = decided.masks(self._switches, found, looked_at, {})
            self._others = key, KEPT * np.concatenate([keep * (1.0 + sharp), at_ends])

    def _lay(self, found):
        """Give the kernel other times; those that are sure are marked once."""
        self._found = found
        self._marks = b""
        self._by_marks = {}
        self._others = None
        self._ends = ends = np.ascontiguousarray(found.at_ends[1])
        n = len(found.t)
        self._room = room = np.empty(n + len(ends))
        room[:] = 2.0 * KEPT
        room = room[n:] if found.sure else room
        n = 0 if found.sure else n
        given = (found.t, n), (found.weight, n), (ends, len(ends)), (room, len(room))
        words = self._call.words
        span, *places = self._places
        _pack_span(words, 8 * span, *found.span)
        for at, (array, count) in zip(places, given, strict=True):
            words[at] = address_of(array)
            words[at + 1] = count

    def _compiled(self):
        """The call of the kernel; None if the numbers have no code of their own."""
        bound = self._bound
        switches = self._switches
        function = bound.function
        if self._call is not None or function.in_batches or switches.held or not function.address:
            return self._call
        function = function.derived(("numbers of the time", switches), self._made)
        if function is None:
            return None
        n = len(switches.seen)
        self._function, self._block = function, bound.block.copy()
        self._block[ADDRESS] = function.address
        limits = (
            0.0, 1.0, decided.NEAR, decided.NEAR_END, decided.NOISE, decided.CHORD, decided.SHARP,
            1e-3 * decided.FAR,
        )  # fmt: skip
        room = (np.zeros((POINTS, n)), np.zeros((2, n)))
        nothing = np.empty(0)
        self._call = Call(decide_kernel(), self._block, *limits, *[nothing] * 3, *room, nothing)
        names = "limits.first", "t", "weight", "ends", "marks"
        self._places = [self._call.place(name) for name in names]
        return self._call

    def _made(self):
        traced = self._bound.function.traced
        g = self._switches.graph
        try:
            numbers = [_number(g, node) for node in self._switches.seen]
            made = traced.with_outputs(numbers, TIMED, self._bound.n, g.false)
            return made.compiled()
        except Refusal:
            return None


def key_of(given, places):
    """The values at these places, to be compared."""
    values = [given[i] for i in places]
    return [v.tobytes() if isinstance(v, np.ndarray) else v for v in values]


def _number(graph, node):
    """A node as a number: 1 or 0 for true or false."""
    told = node
    while told.op == "select":
        told = told.args[1]
    if not (OPERATIONS[told.op].truth or told in (graph.true, graph.false)):
        return node
    return graph.select(node, graph.const(1.0), graph.const(0.0))
