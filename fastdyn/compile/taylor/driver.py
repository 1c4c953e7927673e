"""The loop over steps as a kernel of the usual form, ``int64 kernel(int64 *words)``.

The words are those of ``advance(state, work, block, n_steps)``; see `kernels/state/record.py`.
"""

from fastdyn.kernels.calls.block import RAISED_WORD
from fastdyn.kernels.state.record import (
    ATOL,
    FINISHED,
    RTOL,
    RUNNING,
    Y,
)
from fastdyn.kernels.state.series import LOW

from . import proof
from .accuracy import ALLOWANCE, BELOW, ROUND_OFF
from .kinks import Kinks
from .leave import AT, leave
from .online import Online
from .pace import Clock, chosen, longest, unit_of, wildness
from .step import Step
from .text import ONE, ZERO, Text, hexadecimal

WORDS = {"state": 0, "work": 2, "block": 5, "n_steps": 7}


class Driver:
    """Emits the kernel of a plan.

    Parameters
    ----------
    plan : Plan
    order : int
    fused : str
        See `Text`.
    width : int
        Lanes of a register, of the series.
    """

    def __init__(self, plan, order, fused, width=4):
        self.plan, self.order = plan, order
        self.text, self.width, self.n = Text(fused), width, len(plan.outputs)
        lanes = 4 if self.n <= 4 else 8
        self.row = -(-self.n // lanes) * lanes
        self.kinks = Kinks(plan, self.text, order - 1)

    def __call__(self, symbol, declared):
        """LLVM's text: the kernel, which calls ``fastdyn_invariants(block, out)``."""
        text = self.text
        self._begin()
        text.put("br label %step")
        text.label("step")
        self._step()
        leave(self)
        body = text.function(f"i64 @{symbol}(ptr %words)")
        body = "\n".join([*self.kinks.functions(), body])
        heads = [line for name, line in text.declarations.items() if name not in declared]
        return "\n".join([*heads, body])

    # -- parts

    def _begin(self):
        """Read the record and the rows, and make room."""
        text, n = self.text, self.n
        for name, at in WORDS.items():
            kind = "i64" if name == "n_steps" else "ptr"
            text.put(f"%at_{name} = getelementptr i64, ptr %words, i64 {at}")
            text.put(f"%{name} = load {kind}, ptr %at_{name}")
        self.field = {name: text.load(text.at("%state", AT[name])) for name in (
            "t", "t_old", "t_end", "t_stop", "t_start", "direction", "h", "h_max", "h_first",
        )}  # fmt: skip
        self.rows = text.slot("double", (self.order + 1) * self.row)
        names = ("y", "low", "low_old", "probe", "probe_low", "rtol", "atol", "weights")
        self.room = {name: text.slot("double", self.row) for name in names}
        for i in range((self.order + 1) * self.row if n < self.row else 0):
            if i % self.row >= n:
                text.store(ZERO, text.at(self.rows, i))
        for name, row in (("y", Y), ("low", LOW), ("rtol", RTOL), ("atol", ATOL)):
            for i in range(self.row):
                value = text.load(text.at("%work", row * n + i)) if i < n else ZERO
                if name == "rtol" and i < n:
                    finest = text.compare("olt", value, hexadecimal(ROUND_OFF))
                    value = text.select(finest, text.mul(value, hexadecimal(BELOW)), value)
                text.store(value, text.at(self.room[name], i))
        self.var = {name: text.slot("double") for name in ("t", "t_old", "h", "scale", "cap")}
        for name in ("t", "t_old", "h"):
            text.store(self.field[name], self.var[name])
        text.store(ONE, self.var["scale"])
        self.tolerance = text.add(*[text.load(text.at(self.room[n], 0)) for n in ("rtol", "atol")])
        self.taken, self.out = text.slot("i64"), text.slot("double", self.row)
        self.refused, self.allowance = text.slot("i64"), ALLOWANCE[self.order]
        for place in (self.taken, self.refused):
            text.put(f"store i64 0, ptr {place}")
        text.store(proof.INFINITE, self.var["cap"])
        places = {key: i for i, key in enumerate(self.plan.invariants)}
        room = text.slot("double", max(len(places), 1))
        text.put(f"call void @fastdyn_invariants(ptr %block, ptr {room})")
        self.invariants = {key: text.load(text.at(room, i)) for key, i in places.items()}
        ahead = text.new(f"fsub double {self.field['t']}, {self.field['t_end']}")
        ahead = text.mul(self.field["direction"], ahead)
        over = text.new(f"fcmp oge double {ahead}, {ZERO}")
        text.put(f"br i1 {over}, label %over, label %first")
        text.label("first")

    def _invariant(self, node):
        return hexadecimal(node.data) if node.op == "const" else self.invariants[node.key]

    def _step(self):
        text, n, var = self.text, self.n, self.var
        t = text.load(var["t"])
        y = [text.load(text.at(self.room["y"], i)) for i in range(n)]
        for i, value in enumerate(y):
            text.store(value, text.at(self.rows, i))
        scale = unit_of(text, text.load(var["h"]))
        text.store(scale, var["scale"])
        kinks = self.kinks
        if kinks.count:
            kinks.forget()
            text.put("br label %series")
            text.label("series")
        series = Online(
            self.plan, self.order, text, self.width, self._invariant, self.rows, self.row, scale,
            kinks,
        )  # fmt: skip
        series.emit(t, y)
        if self.plan.raises():
            text.put(f"br i1 {kinks.raising}, label %raises, label %defined")
            text.label("defined")
        if kinks.count:
            text.put(f"br i1 {kinks.decide()}, label %series, label %decided")
            text.label("decided")
        step = Step(text, n, self.order, self.rows, self.row)
        step.weights(self.room["y"], self.room["rtol"], self.room["atol"], self.room["weights"])
        x, size = step.length(self.room["weights"], ALLOWANCE[self.order], self.tolerance)
        wild, shorter, short = wildness(text, t, size, scale)
        text.put(f"br i1 {wild}, label %wild, label %fine")
        text.label("wild")
        text.store(shorter, var["h"])
        text.put(f"br i1 {short}, label %lost, label %step")
        text.label("fine")
        f = self.field
        cut: list = []

        def limited(x):
            shorter = kinks.limited(x, t, scale)
            cut.append(text.compare("une", shorter, x))
            return shorter

        cap = longest(text, t, f["t_start"], f["h_first"], f["h_max"])
        cap = text.smaller(text.load(var["cap"]), cap)
        clock = Clock(t, f["t_end"], f["direction"], cap)
        pace = chosen(text, clock, x, size, scale, limited if kinks.count else None)
        text.put(f"br i1 {pace.stuck}, label %lost, label %go")
        text.label("go")
        for i in range(n):
            low = text.load(text.at(self.room["low"], i))
            text.store(low, text.at(self.room["low_old"], i))
        x = text.div(pace.signed, scale)
        step.end(x, self.room["y"], self.room["low"])
        proof.emit(self, step, pace, x, scale, cut[0] if cut else None)
        for name, value in (("t_old", t), ("t", pace.t), ("h", pace.h)):
            text.store(value, var[name])
        count = text.new(f"load i64, ptr {self.taken}")
        count = text.new(f"add i64 {count}, 1")
        text.put(f"store i64 {count}, ptr {self.taken}")
        past = text.mul(self.field["direction"], text.sub(pace.t, self.field["t_stop"]))
        past = text.new(f"fcmp oge double {past}, {ZERO}")
        enough = text.new(f"icmp sge i64 {count}, %n_steps")
        stop = text.new(f"or i1 {text.new(f'or i1 {past}, {enough}')}, {pace.ends}")
        text.put(f"%status = select i1 {pace.ends}, i64 {FINISHED}, i64 {RUNNING}")
        text.put(f"br i1 {stop}, label %done, label %step")

    def asked(self, t, state="y"):
        """Whether the function raises at a state; the derivative goes to `out`."""
        text = self.text
        function = text.new("load ptr, ptr %block")
        call = f"call i32 {function}(ptr null, ptr null, double {t}"
        text.new(f"{call}, ptr {self.room[state]}, i64 {self.n}, ptr %block, ptr {self.out})")
        at = text.new(f"getelementptr i64, ptr %block, i64 {RAISED_WORD}")
        return text.new(f"icmp ne i64 {text.new(f'load i64, ptr {at}')}, 0")
