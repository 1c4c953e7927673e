"""The kernel of a function: its series, and a frame that calls the loop over steps.

The frame, ``int64 kernel(int64 *words)``, has the arguments of `adaptive.kernel`, or of
`lanes.adaptive`.  The frame makes the room for all numbers, and calls a loop of
`kernels/methods/taylor`, which calls the series: see `kernels/methods/taylor/description.py`.

The lanes of the vectors are orders of one series (`OfOrders`), nodes of equal formulas
(`OfElements`), or trajectories (`OfTrajectories`).
"""

import math
from typing import Any

from fastdyn.kernels.calls.block import FAILED
from fastdyn.kernels.methods.taylor import description as d

from .coefficients.online import Online, Watched
from .coefficients.places import Places
from .coefficients.rows import Rows
from .recurrences.deceptive import held, is_deceptive
from .text.instructions import Text, hexadecimal

ON_STACK = 2**13  # most numbers of a room on the stack
CODE = "double %t, double %scale, ptr %room"  # the arguments of the codes that a loop calls
LANES = 4  # of the vectors of the loop around one trajectory: its eight sums stay in registers
LINE = 8  # numbers of a cache line, to which the parts of the room are aligned


class Kernel:
    """Emits the kernel of a plan.

    Attributes
    ----------
    series : Text
        The lines of the series, in which %t, %scale and %room are defined.
    size : int
        The number of doubles in the room.
    lanes : int
        Lanes of the vectors of the loop.
    loop : str
        The loop that the frame calls.
    n_words, block_at : int
        The number of words of the frame's arguments, and the word with the address of the block.
    """

    fill_room: Any
    codes = ("ptr @series",)  # the words of the codes that the loop calls
    loop = "series"
    n_words = 8
    block_at = 5
    lanes = LANES

    def __init__(self, plan, order, width, fused):
        self.plan = plan
        self.order = order
        self.width = width
        self.series, self.frame, self.size = Text(fused), Text(fused), 0
        self.frame.declarations = self.series.declarations

    def room(self, count):
        """Reserve numbers in the room; return their place."""
        place = self.size
        self.size += -(-count // LINE) * LINE
        return place

    def make_room(self, lanes, watched, before=0):
        """Reserve the arrays, with some numbers before, and the table of watched numbers."""
        self.arrays = before + self.room(before + d.N_ARRAYS * lanes)
        self.table = self.room(d.N_OF_WATCHED * watched)

    def emit(self, symbol, declared, flags, states, watched, truth="false"):
        """LLVM's text of the kernel, without the declarations in `declared`.

        `states` has the stride of coefficients, the places of the vectors and the component of each
        lane; `watched` has the stride, the places and, by lanes, (kind, width, share).  `truth` is
        what the series returns.
        """
        stride, places, lanes = states
        kinds = [kind for kind, *_ in watched[2]]
        words = [self.lanes, stride, len(places), self.arrays, flags]
        words += [len(watched[1]), watched[0], self.table]
        words += [*places, *lanes, *watched[1], *kinds]
        self.series.put(f"ret i64 {self.series.new(f'zext i1 {truth} to i64')}")
        self._emit_frame(words, _rows_of(watched[2]))
        series = self.series.function(f"internal i64 @series({CODE})", "%room")
        frame = self.frame.function(f"i64 @{symbol}(ptr %words)", "%words")
        return self.series.listing(declared, series, *self.functions(), frame)

    def functions(self):
        """The texts of further functions."""
        return []

    def _emit_frame(self, words, constants):
        text = self.frame
        loop = f"fastdyn_{self.loop}_{self.order}_{self.lanes}"
        text.read_words({"block": (self.block_at, "ptr")})
        on_stack = self.size <= ON_STACK
        if on_stack:
            place = text.slot("double", self.size)
            text.put(f"%room = getelementptr double, ptr {place}, i64 0")
        else:
            self._allocate()
        text.clear("%room", self.size)
        self.fill_room()
        if constants:
            values = text.table("watched", constants)
            with text.each(len(constants)) as i:
                value = text.load(text.at(values, i))
                text.store(value, text.at(text.at("%room", self.table), i))
        words_at = text.words("words", words)
        given = [
            *self.codes, "ptr %room", f"i64 {self.size}", f"ptr {words_at}", f"i64 {len(words)}",
        ]  # fmt: skip
        at = text.slot("i64", self.n_words + len(given))
        size = 8 * self.n_words
        text.declarations["copy"] = "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)"
        text.put(f"call void @llvm.memcpy.p0.p0.i64(ptr {at}, ptr %words, i64 {size}, i1 false)")
        for i, word in enumerate(given, self.n_words):
            text.put(f"store {word}, ptr {text.at(at, i)}")
        text.declarations[loop] = f"declare i64 @{loop}(ptr)"
        status = text.new(f"call i64 @{loop}(ptr {at})")
        if not on_stack:
            text.put("call void @free(ptr %memory)")
        text.put(f"ret i64 {status}")

    def _allocate(self):
        text = self.frame
        text.declarations["malloc"] = "declare ptr @malloc(i64)"
        text.declarations["free"] = "declare void @free(ptr)"
        text.put(f"%memory = call ptr @malloc(i64 {8 * (self.size + LINE)})")
        none = text.new("icmp eq ptr %memory, null")
        text.put(f"br i1 {none}, label %failed, label %allocated")
        text.label("failed")
        text.put(f"ret i64 {FAILED}")
        text.label("allocated")
        address = text.new("ptrtoint ptr %memory to i64")
        aligned = text.new(f"and i64 {text.new(f'add i64 {address}, 63')}, -64")
        text.put(f"%room = inttoptr i64 {aligned} to ptr")


def _rows_of(watched):
    """The rows of WATCHED, from (kind, width, share) of each lane."""
    found = [[0.0] * len(watched) for _ in range(d.N_OF_WATCHED if watched else 0)]
    for i, (kind, width, share) in enumerate(watched):
        found[d.WIDTHS][i] = width
        found[d.SHARES][i] = share
        found[d.TOUCHING][i] = float(bool(kind & d.TOUCHES))
        found[d.FREE][i] = 0.0 if kind & (d.SIGNED | d.TOUCHES) else math.inf
    return [x for row in found for x in row]


class OfOrders(Kernel):
    """The kernel of a plan, with vectors over the orders: see `online.py`."""

    def __init__(self, plan, order, fine, fused):
        super().__init__(plan, order, LANES, fused)
        self.fine = fine
        self.invariants = self.room(max(len(plan.invariants), 1))

    def __call__(self, symbol, declared):
        plan = self.plan
        text = self.series
        width = self.width
        n = len(plan.outputs)
        watched = self._watched()
        row = -(-n // width) * width
        row_of_watched = len(watched)
        rows = self.room((self.order + 1) * row)
        watched_rows = self.room(self.order * row_of_watched)
        self.make_room(row, row_of_watched)
        at = {key: i for i, key in enumerate(plan.invariants)}
        values = {key: text.load(text.at("%room", self.invariants + i)) for key, i in at.items()}

        def factor(node):
            return hexadecimal(node.data) if node.op == "const" else values[node.key]

        place = text.at("%room", rows)
        kinks = Watched(
            plan, text, text.at("%room", watched_rows), row_of_watched,
            text.at("%room", self.table + d.CHOSEN),
        )  # fmt: skip
        series = Online(plan, self.order, text, 4, factor, place, row, "%scale", kinks)
        series.exact = self.fine
        series.begin("%t", [text.load(text.at(place, i)) for i in range(n)])
        series.emit()
        flags = d.FINE * self.fine | d.DECEPTIVE * is_deceptive(plan)
        flags |= d.ROOTED * bool(plan.rooted) | d.JUMPS * bool(plan.signed)
        lanes = [*range(n), *[-1] * (row - n)]
        states = row, range(rows, rows + row, width), lanes
        places = range(watched_rows, watched_rows + row_of_watched, width)
        return self.emit(
            symbol, declared, flags, states, (row_of_watched, places, watched), kinks.raising
        )

    def _watched(self):
        """(kind, width, share) of each watched number, and of the lanes that fill their vectors."""
        plan = self.plan
        found = []
        for key in plan.watched:
            kind = d.SIGNED * (key in plan.signed) | d.TOUCHES * (key in plan.rooted)
            hold = plan.held.get(key)
            far = (math.inf, 0.0) if hold is None else (hold.width, hold.share)
            found.append((kind | d.HOLDS * (hold is not None), *far))
        return found + [(0, math.inf, 0.0)] * (-len(found) % self.width)

    def fill_room(self):
        self.frame.put("call void @fastdyn_invariants(ptr %block, ptr %room)")


class OfRows(Kernel):
    """The kernel of a plan in vectors of nodes: see `rows.py`.

    Parameters
    ----------
    plan : bundles.Bundles or bundles.Single
    order, width : int
    raises, deceptive : bool
        Whether the function may raise, and whether series and function are compared inside each
        step: see `deceptive.py`.
    fused, together
        See `Text` and `places.Places`.
    """

    before = 0  # vectors of the loop before its arrays

    def __init__(self, plan, order, width, raises, deceptive, fused, together):
        super().__init__(plan, order, width, fused)
        self.flags = d.DECEPTIVE * deceptive | d.MAY_RAISE * raises
        self.raises = raises
        places = Places(plan, order, width, together)
        self.rows = Rows(plan, order, self.series.of(width), "%room", places)
        self.room(places.size)
        holds = list(filter(None, map(held, plan.steps)))
        self.states, self.held = (
            [places.at[node.key] + i for node in nodes for i in range(0, width, self.lanes)]
            for nodes in (plan.states, [hold.node for hold in holds])
        )
        self.watched = [(d.HOLDS, one.width, one.share) for one in holds for _ in range(width)]
        self.make_room(len(self.states) * self.lanes, len(self.watched), self.before * width)

    def __call__(self, symbol, declared):
        self.rows.begin(*self.start(self.rows.text))
        self.rows.emit()
        states = self.width, self.states, self.plan.components
        watched = self.width, self.held, self.watched
        return self.emit(symbol, declared, self.flags, states, watched)

    def start(self, text):
        """The time and the unit of time of the series."""
        raise NotImplementedError


class OfElements(OfRows):
    """The kernel of a large system, with nodes of equal formulas in the lanes."""

    def start(self, text):
        return [text.splat(x, self.width) for x in ("%t", "%scale")]

    def fill_room(self):
        """Store each invariant in the lanes that need it."""
        text = self.frame
        plan = self.plan
        at = {key: i for i, key in enumerate(plan.invariants)}
        found = [at[node.key] for f in plan.factors for node in f.nodes]
        if found:
            pool = text.slot("double", len(at))
            table = text.indices("factors", found)
            text.put(f"call void @fastdyn_invariants(ptr %block, ptr {pool})")
            with text.each(len(found)) as i:
                text.store(text.load(text.at(pool, text.index(table, i))), text.at("%room", i))


class OfTrajectories(OfRows):
    """The kernel of a plan with a trajectory in each lane.

    The module has ``fastdyn_slopes(t, y, block, out)`` and, if the function may raise,
    ``fastdyn_raises(t, y, block)``, which is 1 in lanes where the function raises.
    """

    codes = "ptr @series", "ptr @ask"
    loop = "lanes"
    n_words = 11
    block_at = 8
    before = d.N_OF_LANES

    def __init__(self, plan, order, width, *given):
        self.lanes = width
        super().__init__(plan, order, width, *given)
        self.block = self.room(1)

    def start(self, text):
        return [text.load(self._of_lanes(text, name)) for name in (d.TIMES, d.UNITS)]

    def _of_lanes(self, text, name):
        return text.at("%room", self.arrays - (d.N_OF_LANES - name) * self.width)

    def _array(self, text, name):
        return text.at("%room", self.arrays + name * len(self.states) * self.width)

    def functions(self):
        """The code ``ask``."""
        text = Text(lanes=self.width)
        text.put(f"%block = load ptr, ptr {text.at('%room', self.block)}")
        t = text.load(self._of_lanes(text, d.TIMES))
        y, out = (self._array(text, name) for name in (d.NOW, d.GIVEN))
        text.put(f"call void @fastdyn_slopes({text.kind} {t}, ptr {y}, ptr %block, ptr {out})")
        if self.raises:
            call = f"call {text.kind} @fastdyn_raises({text.kind} {t}, ptr {y}, ptr %block)"
            text.store(text.new(call), self._of_lanes(text, d.RAISES))
        text.put("ret i64 0")
        return [text.function(f"internal i64 @ask({CODE})", "%room")]

    def fill_room(self):
        self.frame.put("call void @fastdyn_invariants(ptr %block, ptr %room)")
        self.frame.put(f"store ptr %block, ptr {self.frame.at('%room', self.block)}")
