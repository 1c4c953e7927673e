"""The loop over Taylor steps of one trajectory, as a kernel ``int64 kernel(int64 *words)``.

The words are the arguments of ``advance(state, work, block, n_steps)``; see
`kernels/state/record.py`.
"""

from fastdyn.kernels.state.record import ATOL, RTOL, Y
from fastdyn.kernels.state.series import LOW

from .coefficients.online import Online
from .recurrences.deceptive import is_deceptive
from .steps import coarse, proof
from .steps.accuracy import ALLOWANCE, DITHER, GOLDEN, ROUND_OFF
from .steps.kinks import Kinks
from .steps.leave import leave
from .steps.pace import Clock, chosen, longest, unit_of, wildness
from .steps.step import Step
from .text.frame import AT, WORDS, Kernel, asked, counted, fields, read_words, step_taken
from .text.instructions import ONE, ZERO, Text, hexadecimal

AT_REST = 2.0**-40  # of the time: a shorter step is one at a jump


class Driver(Kernel):
    """Emits the kernel of a plan.

    Parameters
    ----------
    plan : Plan
    order : int
    fine : bool
        True for tolerances near rounding: see `accuracy.py`.
    fused : str
        See `Text`.
    width : int
        Lanes of a vector register.
    """

    def __init__(self, plan, order, fine, fused, width=4):
        self.plan, self.order, self.fine = plan, order, fine
        self.text, self.width, self.n = Text(fused), width, len(plan.outputs)
        lanes = 4 if self.n <= 4 else 8
        self.row = -(-self.n // lanes) * lanes
        self.kinks = Kinks(plan, self.text, order - 1)
        self.deceptive = is_deceptive(plan)

    # -- parts

    def _begin(self):
        """Emit the reads of the record and the rows, and the allocations."""
        text, n = self.text, self.n
        read_words(text, WORDS)
        self.field = fields(text)
        self.rows = text.slot("double", (self.order + 1) * self.row)
        names = ("y", "low", "low_old", "probe", "probe_low", "rtol", "atol", "weights")
        self.room = {name: text.slot("double", self.row) for name in names}
        for i in range((self.order + 1) * self.row if n < self.row else 0):
            if i % self.row >= n:
                text.store(ZERO, text.at(self.rows, i))
        for name, row in (("y", Y), ("low", LOW), ("rtol", RTOL), ("atol", ATOL)):
            for i in range(self.row):
                value = text.load(text.at("%work", row * n + i)) if i < n else ZERO
                text.store(value, text.at(self.room[name], i))
        self.y = [text.slot("double") for _ in range(n)]  # the state, in registers
        for i, place in enumerate(self.y):
            text.store(text.load(text.at(self.room["y"], i)), place)
        self.var = {name: text.slot("double") for name in ("t", "t_old", "h", "scale", "cap")}
        for name in ("t", "t_old", "h"):
            text.store(self.field[name], self.var[name])
        text.store(ONE, self.var["scale"])
        self.tolerance = text.add(*[text.load(text.at(self.room[n], 0)) for n in ("rtol", "atol")])
        if self.fine:
            rtol = text.load(text.at(self.room["rtol"], 0))
            finest = text.compare("ole", rtol, hexadecimal(ROUND_OFF))
            self.dither = text.select(finest, hexadecimal(-DITHER), ZERO)
        self.taken, self.out = text.slot("i64"), text.slot("double", self.row)
        self.refused, self.status, self.at_rest = (text.slot("i64") for _ in range(3))
        for place in (self.taken, self.refused, self.at_rest):
            text.put(f"store i64 0, ptr {place}")
        text.store(proof.INFINITE, self.var["cap"])
        proof.begin(self)
        self.rooted = bool(self.plan.rooted)
        if self.rooted:
            coarse.begin(self)
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
        y = [text.load(place) for place in self.y]
        scale = unit_of(text, text.load(var["h"]))
        inverse = text.div(ONE, scale)
        kinks = self.kinks
        if kinks.count:
            kinks.forget()
            text.put("br label %series")
            text.label("series")
        series = Online(
            self.plan, self.order, text, self.width, self._invariant, self.rows, self.row, scale,
            kinks,
        )  # fmt: skip
        series.exact = self.fine
        series.begin(t, y)
        if self.plan.raises():
            text.put(f"br i1 {kinks.raising}, label %raises, label %defined")
            text.label("defined")
        proof.check(self, series.slopes())
        text.store(scale, var["scale"])
        for i, value in enumerate(y):
            text.store(value, text.at(self.rows, i))
        series.emit()
        if kinks.count:
            text.put(f"br i1 {kinks.decide()}, label %series, label %decided")
            text.label("decided")
        step = Step(text, n, self.order, self.rows, self.row)
        step.weights(self.room["y"], self.room["rtol"], self.room["atol"], self.room["weights"])
        x, size = step.length(self.room["weights"], ALLOWANCE[self.order], self.tolerance)
        if self.fine:
            x = self._dithered(x)
        pace, scale, inverse, cut = self._pace(t, x, size, scale, inverse, step)
        step.copy(self.room["low"], self.room["low_old"])
        x = text.mul(pace.signed, inverse)
        step.end(x, self.room["y"], self.room["low"], self.y)
        text.store(proof.INFINITE, var["cap"])
        status, stops = step_taken(self, t, pace)
        text.put(f"store i64 {status}, ptr {self.status}")
        if self.plan.signed:
            self._count_if_at_rest(pace)
        proof.within(self, step, pace, x, inverse)
        proof.predict(self, pace, x, inverse, cut)
        proof.ask(self, stops)
        proof.take_back(self)

    def _pace(self, t, x, size, scale, inverse, step):
        """The Pace, the unit of time, 1 over the unit, and whether a change of sign cuts the step.

        Of a series that is not finite, the step begins again with a shorter unit.
        """
        text, var, kinks = self.text, self.var, self.kinks
        wild, shorter, short = wildness(text, t, size, scale)
        text.put(f"br i1 {wild}, label %wild, label %fine")
        text.label("wild")
        text.store(shorter, var["h"])
        if self.rooted:
            text.store(ZERO, var["reached"])
        text.put(f"br i1 {short}, label %{'coarse' if self.rooted else 'lost'}, label %step")
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
        shortened = cut[0] if cut else None
        if self.rooted:
            coarse.choose(self, t, pace, shortened)
            coarse.emit(self, step, t)
        else:
            text.put(f"br i1 {pace.stuck}, label %lost, label %go")
        text.label("go")
        if self.rooted:
            pace, scale, shortened = coarse.taken(self, pace)
            inverse = text.div(ONE, scale)
        return pace, scale, inverse, shortened

    def _count_if_at_rest(self, pace):
        """Count a step that hardly changes the time, as those along a jump."""
        text = self.text
        least = text.mul(text.intrinsic("fabs", pace.t), hexadecimal(AT_REST))
        more = text.new(f"zext i1 {text.compare('ole', pace.h, least)} to i64")
        counted(text, self.at_rest, more)

    def _dithered(self, x):
        """Vary the length x from step to step, for tolerances near rounding: see `DITHER`."""
        text = self.text
        before = text.new(f"load i64, ptr {text.at('%state', AT['n_accepted'])}")
        count = text.new(f"add i64 {before}, {text.new(f'load i64, ptr {self.taken}')}")
        turns = text.mul(text.new(f"sitofp i64 {count} to double"), hexadecimal(GOLDEN))
        share = text.sub(turns, text.intrinsic("floor", turns))
        return text.fma(text.mul(self.dither, share), x, x)

    def _leave(self):
        leave(self)

    def _functions(self):
        return self.kinks.functions()

    def asked(self, t, state="y"):
        """Call the function at a state; return a truth value: the function raises.

        The derivative goes to `out`.
        """
        return asked(self.text, t, self.room[state], self.n, self.out)
