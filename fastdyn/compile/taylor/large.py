"""The loop over Taylor steps of a large system, with nodes of equal formulas in vector lanes.

The kernel has the form of `driver.py`.  Its numbers are in its own memory, with the states in the
order of their vectors.
"""

from fastdyn.kernels.state import record
from fastdyn.kernels.state.record import FINISHED, RAISED, STEP_TOO_SMALL, Y_OLD, Y
from fastdyn.kernels.state.series import LOW, SCALE

from .coefficients.memory import Memory
from .coefficients.places import Places
from .coefficients.rows import Rows
from .steps.accuracy import ALLOWANCE
from .steps.pace import LEAST, Clock, chosen, longest, unit_of
from .steps.proof import SHORTER, WITHIN
from .steps.proof_in_vectors import off
from .steps.step import TERMS, end, length, powers_of, weight
from .steps.vanish import excess, some_must_not
from .text.frame import (
    AT,
    HALF,
    RETRY,
    WORDS,
    Kernel,
    add,
    asked,
    fields,
    raised_word,
    read_words,
    step_taken,
)
from .text.instructions import ONE, ZERO, Text, hexadecimal

ROWS = {"y": Y, "low": LOW, "rtol": record.RTOL, "atol": record.ATOL}


class LargeDriver(Kernel):
    """Emits the kernel of a plan.

    Parameters
    ----------
    plan : bundles.Bundles
    order, width : int
        The order of the series, and the lanes of a vector.
    raises : bool
        True if the function may raise.
    fused, together
        See `Text` and `places.Places`.
    """

    def __init__(self, plan, order, width, raises, fused, together):
        self.plan, self.order, self.width, self.raises = plan, order, width, raises
        self.text, self.n = Text(fused), len(plan.places_of_states)
        self.wide = self.text.of(width)
        self.places = Places(plan, order, width, together)
        self.memory = Memory(self.text, plan, self.places, order, width)

    # -- memory

    def _begin(self):
        text = self.text
        read_words(text, WORDS)
        self.field = fields(text)
        f = self.field
        ahead = text.mul(f["direction"], text.sub(f["t"], f["t_end"]))
        text.put(f"br i1 {text.compare('oge', ahead, ZERO)}, label %over, label %first")
        text.label("over")
        text.put(f"ret i64 {FINISHED}")
        text.label("first")
        self.rows = Rows(self.plan, self.order, self.wide, "%space", self.places)
        self.memory.make_room()
        self.memory.read_factors()
        for name, row in ROWS.items():
            self.memory.read(row, name)
        self.var = {name: text.slot("double") for name in ("t", "t_old", "h", "scale")}
        for name in ("t", "t_old", "h"):
            text.store(f[name], self.var[name])
        text.store(ONE, self.var["scale"])
        tolerances = [text.load(self.memory.in_work(row, 0)) for row in (record.RTOL, record.ATOL)]
        self.tolerance = text.add(*tolerances)
        self.taken, self.tries = text.slot("i64"), text.slot("double")
        text.put(f"store i64 0, ptr {self.taken}")
        text.store(ZERO, self.tries)

    # -- one step

    def _step(self):
        text, wide, var, f = self.text, self.wide, self.var, self.field
        t, h = text.load(var["t"]), text.load(var["h"])
        scale = unit_of(text, h)
        text.store(scale, var["scale"])
        with self.memory.each_vector() as (row, here):
            wide.store(wide.load(here["y"]), row)
        self.rows.emit(wide.splat(t, self.width), wide.splat(scale, self.width))
        x, size = self._length()
        cap = longest(text, t, f["t_start"], f["h_first"], f["h_max"])
        tried = text.compare("ogt", text.load(self.tries), ZERO)
        cap = text.select(tried, text.smaller(h, cap), cap)
        clock = Clock(t, f["t_end"], f["direction"], cap)
        pace = chosen(text, clock, x, size, scale)
        text.store(ZERO, self.tries)
        text.put(f"br i1 {pace.wild}, label %wild, label %fine")
        text.label("wild")
        text.store(pace.shorter, var["h"])
        text.put(f"br i1 {pace.short}, label %lost, label %step")
        text.label("fine")
        text.put(f"br i1 {pace.stuck}, label %lost, label %go")
        text.label("go")
        x = text.div(pace.signed, scale)
        if some_must_not(self.rows):
            self._keep_from_roots(pace, x)
        self._end(x)
        self._prove(t, pace, x)
        self._accept(t, pace)

    def _length(self):
        """The `step.length`; stores the weights of the states."""
        wide, orders = self.wide, range(self.order, self.order - TERMS, -1)
        largest, total = {k: wide.slot(wide.kind) for k in orders}, wide.slot(wide.kind)
        for place in (*largest.values(), total):
            wide.store(ZERO, place)
        with self.memory.each_vector() as (row, here):
            y, r, a = (wide.load(here[name]) for name in ("y", "rtol", "atol"))
            w = weight(wide, y, wide.load(wide.at(row, self.width)), r, a)
            wide.store(w, here["weights"])
            for k, place in largest.items():
                c = wide.intrinsic("fabs", wide.load(wide.at(row, k * self.width)))
                c = wide.mul(c, w)
                wide.store(wide.larger(wide.load(place), c), place)
                wide.store(wide.add(c, wide.load(total)), total)
        norms = {k: self.across(wide.load(p), self.text.larger) for k, p in largest.items()}
        x = length(self.text, norms, ALLOWANCE[self.order], self.tolerance)
        return x, self.across(wide.load(total), self.text.add)

    def across(self, vector, join):
        """Reduce the lanes of a vector to one number by `join`, in pairs."""
        text, kind = self.text, self.wide.kind
        each = [text.new(f"extractelement {kind} {vector}, i64 {i}") for i in range(self.width)]
        while len(each) > 1:
            each = [join(a, b) for a, b in zip(each[::2], each[1::2], strict=True)]
        return each[0]

    def _end(self, x):
        """Store the state at x in `new`, its rounding error in `rest`, an inner one in `probe`."""
        wide = self.wide
        powers, nearer = (
            powers_of(wide, wide.splat(at, self.width), self.order)
            for at in (x, self.text.mul(x, hexadecimal(WITHIN)))
        )
        with self.memory.each_vector() as (row, here):
            terms = [wide.load(wide.at(row, k * self.width)) for k in range(self.order + 1)]
            low = wide.load(here["low"])
            value, rest = end(wide, terms, powers, low)
            wide.store(value, here["new"])
            wide.store(rest, here["rest"])
            wide.store(end(wide, terms, nearer, low)[0], here["probe"])

    def _prove(self, t, pace, x):
        """Shorten the step if the function raises, or has another slope than the series."""
        text = self.text
        between = text.fma(pace.signed, hexadecimal(WITHIN), t)
        for name, at, share in (("probe", between, WITHIN), ("new", pace.t, 1.0)):
            raised = self._raised(name, at)
            text.put(f"store i64 0, ptr {raised_word(text)}")
            self._shorter(raised, pace, RETRY, f"raises_{name}")
            self._shorter(off(self, x, share), pace, SHORTER, f"off_{name}")

    def _shorter(self, refused, pace, share, name):
        """Go back to a shorter step if the step is refused."""
        text = self.text
        text.put(f"br i1 {refused}, label %{name}, label %{name}_not")
        text.label(name)
        shorter = text.mul(pace.h, hexadecimal(share))
        text.store(shorter, self.var["h"])
        text.store(ONE, self.tries)
        least = text.mul(hexadecimal(LEAST), text.intrinsic("fabs", pace.t))
        short = text.compare("ule", shorter, least)
        text.put(f"br i1 {short}, label %lost, label %step")
        text.label(f"{name}_not")

    def _keep_from_roots(self, pace, x):
        """Shorten the step if the argument of a root may touch zero on the step."""
        text, wide = self.text, self.wide
        beyond = self.across(excess(self.rows, wide.splat(x, self.width)), text.larger)
        self._shorter(text.compare("uge", beyond, ZERO), pace, HALF, "rooted")

    def _raised(self, name, t):
        """A truth value: the function raises at a time and the state in array `name`."""
        self.memory.write(name, Y)
        y, out = (self.text.at("%work", row * self.n) for row in (Y, record.STAGE))
        return asked(self.text, t, y, self.n, out)

    def _accept(self, t, pace):
        wide = self.wide
        with self.memory.each_vector() as (_, here):
            for source, target in (("new", "y"), ("rest", "low")):
                wide.store(wide.load(here[source]), here[target])
        step_taken(self, t, pace)

    # -- the end

    def _leave(self):
        """Store the record and the rows before the kernel returns."""
        text, var, result = self.text, self.var, self.text.slot("i64")
        text.label("lost")
        raised = self._raised("y", text.load(var["t"])) if self.raises else "false"
        lost = text.new(f"select i1 {raised}, i64 {RAISED}, i64 {STEP_TOO_SMALL}")
        text.put(f"store i64 {lost}, ptr {result}")
        self.memory.write("y", Y_OLD)
        text.put("br label %leave")
        text.label("done")
        text.put(f"store i64 %status, ptr {result}")
        self.memory.write_series()
        text.put("br label %leave")
        text.label("leave")
        self.memory.write("y", Y)
        self.memory.write("low", LOW)
        text.store(text.load(var["scale"]), text.at("%work", SCALE * self.n))
        for name in ("t", "t_old", "h"):
            text.store(text.load(var[name]), text.at("%state", AT[name]))
        add(text, "n_accepted", self.taken)
        self.memory.release()
        text.put(f"ret i64 {text.new(f'load i64, ptr {result}')}")
