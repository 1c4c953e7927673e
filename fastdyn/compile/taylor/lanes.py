"""The loop over Taylor steps with a trajectory in each lane, as in `kernels/ensemble/lanes.py`.

The words of ``int64 kernel(int64 *words)`` are the arguments of ``loop(state, lanes, work, block,
n_steps)``.
"""

from fastdyn.kernels.state import lane_fields
from fastdyn.kernels.state.record import (
    ATOL,
    FINISHED,
    RTOL,
    STEP_TOO_SMALL,
    Y_OLD,
    K,
    Y,
)
from fastdyn.kernels.state.series import LOW, SCALE

from .coefficients.places import Places
from .coefficients.rows import Rows
from .steps.accuracy import ALLOWANCE
from .steps.pace import LEAST, Clock, chosen, longest, retry, unit_of
from .steps.proof import SHORTER
from .steps.proof_in_vectors import unproved
from .steps.step import TERMS, end, length, powers_of, weight
from .steps.vanishing_arguments import excess, some_held
from .text.frame import AT, HALF, RETRY, Kernel, counted, read_words
from .text.instructions import ONE, ZERO, Text, hexadecimal

WORDS = {"state": (0, "ptr"), "fields": (2, "ptr"), "work": (5, "ptr"), "block": (8, "ptr"),
         "n_steps": (10, "i64")}  # fmt: skip
READ = ("T", "T_END", "T_STOP", "H", "LIVE", "LIMIT", "ACCEPTED", "TRIES")


class LaneDriver(Kernel):
    """Emits the kernel of a plan on vectors.

    Parameters
    ----------
    plan : bundles.Single
    order, width : int
        The order of the series, and the lanes of a vector.
    raises : bool
        True if the function may raise.  ``fastdyn_raises(t, y, block)`` is 1 in lanes where the
        function raises.
    deceptive : bool
        True if series and function are compared inside each step: see `deceptive.py`.
    fused : str
        See `Text`.
    together : int
        See `places.Places`.
    """

    def __init__(self, plan, order, width, raises, deceptive, fused, together):
        self.plan, self.order, self.width = plan, order, width
        self.raises, self.deceptive = raises, deceptive
        self.text, self.n = Text(fused, width), len(plan.states)
        self.places = Places(plan, order, width, together)

    # -- memory

    def _row(self, row, i=0):
        """The address of a component in a row of `work`."""
        return self.text.at("%work", (row * self.n + i) * self.width)

    def _field(self, name):
        return self.text.at("%fields", getattr(lane_fields, name) * self.width)

    def _begin(self):
        text = self.text
        read_words(text, WORDS)
        self.space = text.slot("double", self.places.size)
        self.new = text.slot(text.kind, self.n)
        self.rest = text.slot(text.kind, self.n)
        self.weights = text.slot(text.kind, self.n)
        self.probe, self.slopes = text.slot(text.kind, self.n), text.slot(text.kind, self.n)
        text.put(f"call void @fastdyn_invariants(ptr %block, ptr {self.space})")
        names = ("direction", "h_max", "t_start", "h_first")
        self.common = {
            name: text.splat(text.load(text.at("%state", AT[name]), "double"), self.width)
            for name in names
        }
        self.field = {name: text.load(self._field(name)) for name in READ}
        self.live = text.compare("ogt", self.field["LIVE"], ZERO)
        self.var = {
            name: text.slot(text.kind) for name in ("T", "T_OLD", "H", "ACCEPTED", "TRIES", "scale")
        }
        for name in ("T", "H", "ACCEPTED", "TRIES"):
            text.store(self.field[name], self.var[name])
        self.tolerance = text.add(*[text.load(self._row(row, 0)) for row in (RTOL, ATOL)])
        self.taken = text.slot("i64")
        text.put(f"store i64 0, ptr {self.taken}")

    # -- one step

    def _step(self):
        text, var = self.text, self.var
        t, h, tries = (text.load(var[name]) for name in ("T", "H", "TRIES"))
        scale = unit_of(text, h)
        text.store(scale, var["scale"])
        rows = self.rows = Rows(self.plan, self.order, text, self.space, self.places)
        self.state_rows = [rows.pointer(y.key) for y in self.plan.states]
        for i, place in enumerate(self.state_rows):
            text.store(text.load(self._row(Y, i)), place)
        rows.begin(t, scale)
        rows.emit()
        for i, place in enumerate(self.state_rows):
            y, r, a = (text.load(self._row(row, i)) for row in (Y, RTOL, ATOL))
            slope = text.load(text.at(place, self.width))
            text.store(weight(text, y, slope, r, a), text.at(self.weights, i * self.width))
        x, size = self._length()
        f = self.common
        cap = longest(text, t, f["t_start"], f["h_first"], f["h_max"])
        cap = text.select(text.compare("ogt", tries, ZERO), text.smaller(h, cap), cap)
        clock = Clock(t, self.field["T_END"], f["direction"], cap)
        repeated = retry(text, t, x, size, scale)
        pace = chosen(text, clock, x, size, scale)
        self._ends(text.div(pace.signed, scale))
        self._accept(t, pace, repeated)

    def _length(self):
        """The `step.length` in each lane."""
        text, norms, total = self.text, {}, None
        for k in range(self.order, self.order - TERMS, -1):
            for i, place in enumerate(self.state_rows):
                c = text.load(text.at(place, k * self.width))
                c = text.intrinsic("fabs", c)
                c = text.mul(c, text.load(text.at(self.weights, i * self.width)))
                norms[k] = text.larger(c, norms[k]) if k in norms else c
                total = text.add(c, total)
        return length(text, norms, ALLOWANCE[self.order], self.tolerance), total

    def _ends(self, x):
        """Store the states at x in `new`, and their rounding errors in `rest`."""
        for i, (value, rest) in enumerate(self.states_at(x)):
            self.text.store(value, self.text.at(self.new, i * self.width))
            self.text.store(rest, self.text.at(self.rest, i * self.width))

    def states_at(self, x):
        """The states at x, and their rounding errors."""
        text, powers = self.text, powers_of(self.text, x, self.order)
        for i, place in enumerate(self.state_rows):
            terms = [text.load(text.at(place, k * self.width)) for k in range(self.order + 1)]
            yield end(text, terms, powers, text.load(self._row(LOW, i)))

    def _accept(self, t, pace, repeated):
        """Accept the step lane by lane; leave the kernel if a lane needs the scheduler."""
        text, var = self.text, self.var
        bad, failed, again = self._refused(pace, *repeated)
        good = text.truths("xor", bad, text.everywhere("true"))
        failed = text.truths("or", failed, text.truths("and", good, pace.stuck))
        good = text.truths("and", good, text.truths("xor", pace.stuck, text.everywhere("true")))
        for i in range(self.n):
            for source, row in ((self.new, Y), (self.rest, LOW)):
                new = text.load(text.at(source, i * self.width))
                text.store(text.select(good, new, text.load(self._row(row, i))), self._row(row, i))
        later = text.select(good, pace.t, t)
        accepted = text.add(text.load(var["ACCEPTED"]), text.select(good, ONE, ZERO))
        for name, value in (
            ("T_OLD", t), ("T", later), ("ACCEPTED", accepted),
            ("H", text.select(good, pace.h, again)),
        ):  # fmt: skip
            text.store(value, var[name])
        past = text.mul(self.common["direction"], text.sub(later, self.field["T_STOP"]))
        stop = text.compare("oge", past, ZERO)
        stop = text.truths("or", stop, text.compare("oge", accepted, self.field["LIMIT"]))
        stop = text.truths("or", text.truths("and", stop, good), failed)
        self._hand_back(text.truths("and", stop, self.live), failed, later)

    def _refused(self, pace, bad, again, short):
        """(bad, failed, again): lanes with a refused step, failed lanes, the retry's length."""
        text = self.text
        failed, tries = text.truths("and", bad, short), ZERO
        for refused, share in self._tests(pace):
            refused = text.truths("and", refused, text.truths("xor", bad, text.everywhere("true")))
            shorter = text.mul(pace.h, hexadecimal(share))
            least = text.mul(hexadecimal(LEAST), text.intrinsic("fabs", pace.t))
            short = text.compare("ule", shorter, least)
            failed = text.truths("or", failed, text.truths("and", refused, short))
            again, tries = text.select(refused, shorter, again), text.select(refused, ONE, tries)
            bad = text.truths("or", bad, refused)
        text.store(tries, self.var["TRIES"])
        return bad, failed, again

    def _tests(self, pace):
        """Yield (the lanes whose step must be shorter, the factor of the step's length)."""
        text = self.text
        if some_held(self.rows):
            beyond = excess(self.rows, text.div(pace.signed, text.load(self.var["scale"])))
            yield text.compare("uge", beyond, ZERO), HALF
        if self.raises:
            yield self._raised(pace), RETRY
        yield unproved(self, pace), SHORTER

    def _raised(self, pace):
        """The truth value of "the function raises at the end of the step", in each lane."""
        text, kind = self.text, self.text.kind
        call = f"call {kind} @fastdyn_raises({kind} {pace.t}, ptr {self.new}, ptr %block)"
        return text.compare("une", text.new(call), ZERO)

    def _hand_back(self, wanted, failed, t):
        text, width = self.text, self.width
        status = text.select(text.compare("oeq", t, self.field["T_END"]), _number(FINISHED), ZERO)
        status = text.select(failed, _number(STEP_TOO_SMALL), status)
        self.status = text.select(wanted, status, _number(lane_fields.NOTHING))
        count = counted(text, self.taken)
        enough = text.new(f"icmp sge i64 {count}, %n_steps")
        bits = text.new(f"bitcast {text.truth} {wanted} to i{width}")
        some = text.new(f"icmp ne i{width} {bits}, 0")
        leave = text.new(f"or i1 {some}, {enough}")
        text.put(f"br i1 {leave}, label %leave, label %step")

    def _leave(self):
        """Store all fields and rows before the kernel returns."""
        text, var = self.text, self.var
        text.label("leave")
        text.store(self.status, self._field("STATUS"))
        for name in ("T", "T_OLD", "H", "ACCEPTED", "TRIES"):
            text.store(text.load(var[name]), self._field(name))
        text.store(text.load(var["scale"]), self._row(SCALE))
        for i, place in enumerate(self.state_rows):
            text.store(text.load(place), self._row(Y_OLD, i))
            for k in range(self.order + 1):
                c = text.load(text.at(place, k * self.width))
                text.store(c, self._row(K + k, i))
        text.put(f"ret i64 {text.new(f'load i64, ptr {self.taken}')}")


def _number(status):
    return hexadecimal(float(status))
