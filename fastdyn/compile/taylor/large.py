"""The loop over Taylor steps of a large system, with nodes of equal formulas in vector lanes.

The kernel has the arguments of the kernel in `driver.py`.  State and coefficients are in memory of
the kernel, with the states in the order of their vectors.
"""

from fastdyn.kernels.state import record
from fastdyn.kernels.state.record import Y
from fastdyn.kernels.state.series import LOW

from .coefficients.memory import Memory
from .coefficients.places import Places
from .coefficients.rows import Rows
from .one_trajectory import OneTrajectory
from .steps import proof_in_vectors as proof
from .steps.accuracy import ALLOWANCE
from .steps.pace import LEAST, chosen, unit_of
from .steps.proof import allowed_share, slope_of
from .steps.step import TERMS, across, end, length, powers_of, weight
from .steps.vanishing_arguments import excess, some_held
from .text.frame import HALF, asked, step_taken
from .text.instructions import INFINITE, ONE, ZERO, Text, hexadecimal

ROWS = {"y": Y, "low": LOW, "rtol": record.RTOL, "atol": record.ATOL}


class LargeDriver(OneTrajectory):
    """Emits the kernel of a plan.

    Parameters
    ----------
    plan : bundles.Bundles
    order, width : int
        The order of the series, and the lanes of a vector.
    raises, deceptive : bool
        Whether the function may raise, and whether series and function are compared inside each
        step: see `deceptive.py`.
    fused, together
        See `Text` and `places.Places`.
    """

    def __init__(self, plan, order, width, raises, deceptive, fused, together):
        self.plan, self.order, self.width = plan, order, width
        self.raises, self.deceptive = raises, deceptive
        self.text, self.n = Text(fused), len(plan.places_of_states)
        self.wide = self.text.of(width)
        self.places = Places(plan, order, width, together)
        self.memory = memory = Memory(self.text, plan, self.places, order, width)
        self._write, self._write_series = memory.write, memory.write_series
        self._release = memory.release

    def _make_room(self):
        self.rows = Rows(self.plan, self.order, self.wide, "%space", self.places)
        self.memory.make_room()
        self.memory.read_factors()
        for name, row in ROWS.items():
            self.memory.read(row, name)

    # -- one step

    def _step(self):
        text, wide, var = self.text, self.wide, self.var
        t = text.load(var["t"])
        scale = unit_of(text, text.load(var["h"]))
        inverse = text.div(ONE, scale)
        with self.memory.each_vector() as (row, here):
            wide.store(wide.load(here["y"]), row)
        self.rows.begin(wide.splat(t, self.width), wide.splat(scale, self.width))
        per_time = wide.splat(inverse, self.width)

        def slopes(row, _):
            return wide.mul(wide.load(wide.at(row, self.width)), per_time)

        off = proof.differ(self, slopes, "predicted")
        text.put(f"br i1 {off}, label %doubtful, label %proved")
        text.label("proved")
        text.store(ZERO, var["pending"])
        text.store(scale, var["scale"])
        self.rows.emit()
        x, size = self._length()
        self._retry(t, x, size, scale)
        pace = chosen(text, self._clock(t), x, size, scale)
        text.put(f"br i1 {pace.stuck}, label %lost, label %go")
        text.label("go")
        x = text.mul(pace.signed, inverse)
        if some_held(self.rows):
            self._keep_from_roots(t, pace, x)
        self._take(t, pace, x, inverse)
        proof.take_back(self)

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
        norms = {k: across(wide, wide.load(p), self.text.larger) for k, p in largest.items()}
        x = length(self.text, norms, ALLOWANCE[self.order], self.tolerance)
        return x, across(wide, wide.load(total), self.text.add)

    def _take(self, t, pace, x, inverse):
        """Take the step of length x.

        Compare slopes after the last step of a call; if `raises`, after each step.
        """
        text, var = self.text, self.var
        stops = step_taken(self, t, pace)
        allowed = allowed_share(text, pace.h, self.order)
        for name, value in (("cap", INFINITE), ("pending", allowed)):
            text.store(value, var[name])
        self._end(x, inverse)
        if self.deceptive:
            proof.look(self, x, inverse)
            between = text.fma(pace.signed, hexadecimal(proof.WITHIN), t)
            proof.compare(self, "probe", between, "inner")
        if not self.raises:
            text.put(f"br i1 {stops}, label %asking, label %step")
            text.label("asking")
        proof.compare(self, "y", pace.t, "predicted")
        text.put(f"br i1 {stops}, label %done, label %step")

    def _end(self, x, inverse):
        """Store the state at x, its rounding error and its slope; keep the old state."""
        wide = self.wide
        powers, inverse = self.powers(x), wide.splat(inverse, self.width)
        with self.memory.each_vector() as (row, here):
            terms = [wide.load(wide.at(row, k * self.width)) for k in range(self.order + 1)]
            low = wide.load(here["low"])
            value, rest = end(wide, terms, powers, low)
            slope = wide.mul(slope_of(wide, terms[1:], powers), inverse)
            given = {"y": value, "low": rest, "y_old": terms[0], "low_old": low}
            for name, value in {**given, "predicted": slope}.items():
                wide.store(value, here[name])

    def powers(self, x):
        return powers_of(self.wide, self.wide.splat(x, self.width), self.order)

    def _keep_from_roots(self, t, pace, x):
        """Shorten the step if the argument of a root may touch zero on the step."""
        text, wide = self.text, self.wide
        beyond = across(wide, excess(self.rows, wide.splat(x, self.width)), text.larger)
        text.put(f"br i1 {text.compare('uge', beyond, ZERO)}, label %rooted, label %off_roots")
        text.label("rooted")
        shorter = text.mul(pace.h, hexadecimal(HALF))
        text.store(shorter, self.var["cap"])
        least = text.mul(hexadecimal(LEAST), text.intrinsic("fabs", t))
        text.put(f"br i1 {text.compare('ule', shorter, least)}, label %lost, label %step")
        text.label("off_roots")

    def raised(self, name, t):
        """The truth value of "the function raises" at a time and the state in array `name`."""
        self.memory.write(name, Y)
        y, out = (self.text.at("%work", row * self.n) for row in (Y, record.STAGE))
        return asked(self.text, t, y, self.n, out)

    # -- the end

    def _raised(self):
        return self.raised("y", self.text.load(self.var["t"])) if self.raises else "false"
