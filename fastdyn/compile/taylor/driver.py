"""The loop over Taylor steps of one trajectory, with numbers in registers."""

from fastdyn.kernels.state.record import ATOL, RTOL, Y_OLD, K, Y
from fastdyn.kernels.state.series import HIGHEST, LOW

from .coefficients.online import Online
from .one_trajectory import OneTrajectory
from .recurrences.deceptive import is_deceptive
from .steps import coarse, proof
from .steps.accuracy import ALLOWANCE, DITHER, GOLDEN, ROUND_OFF
from .steps.kinks import Kinks
from .steps.pace import chosen, unit_of
from .steps.step import Step
from .text.frame import AT, asked, counted, invariants, step_taken
from .text.instructions import INFINITE, ONE, ZERO, Text, hexadecimal

ARRAYS = (
    "y", "low", "low_old", "probe", "probe_low", "rtol", "atol", "weights", "predicted",
)  # fmt: skip
AT_REST = 2.0**-40  # steps shorter than this share of the time count as steps at a jump


class Driver(OneTrajectory):
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
        self._functions = self.kinks.functions
        self.deceptive, self.rooted = is_deceptive(plan), bool(plan.rooted)
        self.counts = (*self.counts, "n_equal")
        if self.rooted:
            self.variables = (*self.variables, *coarse.VARIABLES)

    # -- parts

    def _make_room(self):
        text, n = self.text, self.n
        self.rows = text.slot("double", (self.order + 1) * self.row)
        self.room = {name: text.slot("double", self.row) for name in ARRAYS}
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
        self.out = text.slot("double", self.row)
        if self.fine:
            rtol = text.load(text.at(self.room["rtol"], 0))
            finest = text.compare("ole", rtol, hexadecimal(ROUND_OFF))
            self.dither = text.select(finest, hexadecimal(-DITHER), ZERO)
        self._invariant = invariants(text, self.plan.invariants)

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
        text.store(INFINITE, var["cap"])
        stops = step_taken(self, t, pace)
        if self.plan.signed:
            self._count_if_at_rest(pace)
        proof.within(self, step, pace, x, inverse)
        proof.predict(self, pace, x, inverse, cut)
        proof.ask(self, stops)
        proof.take_back(self)

    def _pace(self, t, x, size, scale, inverse, step):
        """The Pace, the unit of time, 1 over the unit, and whether a change of sign cuts the step.

        If the series is not finite, the step begins again with a shorter unit of time.
        """
        text, var, kinks = self.text, self.var, self.kinks
        if self.rooted:
            text.store(ZERO, var["reached"])
        self._retry(t, x, size, scale, "coarse" if self.rooted else "lost")
        cut: list = []

        def limited(x):
            shorter = kinks.limited(x, t, scale)
            cut.append(text.compare("une", shorter, x))
            return shorter

        pace = chosen(text, self._clock(t), x, size, scale, limited if kinks.count else None)
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
        """Count a step that hardly changes the time, as the steps at a jump do."""
        text = self.text
        least = text.mul(text.intrinsic("fabs", pace.t), hexadecimal(AT_REST))
        more = text.new(f"zext i1 {text.compare('ole', pace.h, least)} to i64")
        counted(text, self.count["n_equal"], more)

    def _dithered(self, x):
        """Vary the length x from step to step, for tolerances near rounding: see `DITHER`."""
        text = self.text
        name = "n_accepted"
        before = text.new(f"load i64, ptr {text.at('%state', AT[name])}")
        count = text.new(f"add i64 {before}, {text.new(f'load i64, ptr {self.count[name]}')}")
        turns = text.mul(text.new(f"sitofp i64 {count} to double"), hexadecimal(GOLDEN))
        share = text.sub(turns, text.intrinsic("floor", turns))
        return text.fma(text.mul(self.dither, share), x, x)

    # -- the end

    def _leave(self):
        text = self.text
        if self.plan.raises():
            text.label("raises")  # the series decided by rounded differences: call the function
            text.put(f"br i1 {self._raised()}, label %lost, label %defined")
        super()._leave()

    def _raised(self):
        return self.asked(self.text.load(self.var["t"]))

    def _write(self, name, row):
        self._copy(self.room[name], self.text.at("%work", row * self.n))

    def _copy(self, source, target):
        text = self.text
        for i in range(self.n):
            text.store(text.load(text.at(source, i)), text.at(target, i))

    def _write_series(self):
        text, n = self.text, self.n
        self._copy(self.rows, text.at("%work", Y_OLD * n))
        text.clear(text.at("%work", (K + self.order + 1) * n), n * (HIGHEST - self.order))
        with text.each(self.order + 1) as k:
            source = text.at(self.rows, text.new(f"mul i64 {k}, {self.row}"))
            place = text.new(f"add i64 {text.new(f'mul i64 {k}, {n}')}, {K * n}")
            self._copy(source, text.at("%work", place))

    def asked(self, t, state="y"):
        """Call the function at a state; return the truth value of "the function raises".

        The derivative goes to `out`.
        """
        return asked(self.text, t, self.room[state], self.n, self.out)
