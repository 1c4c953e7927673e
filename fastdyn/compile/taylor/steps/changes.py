"""LLVM functions that find the first change of sign of a polynomial; a step calls them."""

import contextlib

from ..text.instructions import MINUS, ONE, ZERO, Text, hexadecimal
from .accuracy import SMALLEST
from .step import powers_of, sum_of

ROUNDS = 100  # most rounds of a search; a step then ends before the change
BEYOND = 2.0**-50  # distance from a change to the step's end, as a share of step and time
TAIL = 2.0**50  # weight of the last two terms in the size of a polynomial: see VANISHING
VANISHING = 2.0**-48  # below this share of its size, the argument of a root counts as zero
# Largest remainder of a difference at its change, as a share of its motion, in units of the order's
# smallest tolerance.
REMAINDER = 0.1
CHAINS, FIRST_TERMS = 4, 3
LEAST_BOUND = 1e-300  # least bound of a second derivative
FIRST_SIGN, FIRST_CHANGE = "fastdyn_first_sign", "fastdyn_first_change"
NOT_FAR = "fastdyn_not_far"


class _Function(Text):
    """A function of the coefficients c[0], c[stride], ..., c[order stride]."""

    def __init__(self, fused, declarations):
        super().__init__(fused)
        self.declarations, self.k = declarations, self.slot("i64")

    def coefficient(self, k):
        return self.load(self.at("%c", self.new(f"mul i64 {k}, %stride")))

    def jump(self, condition, yes, no):
        self.put(f"br i1 {condition}, label %{yes}, label %{no}")
        self.label(no)

    @contextlib.contextmanager
    def down(self, label, least):
        """A context whose lines become a loop over k, from the order down to `least`."""
        self.put(f"store i64 %order, ptr {self.k}")
        self.put(f"br label %{label}")
        self.label(label)
        yield self.load(self.k, "i64")
        k = self.new(f"add i64 {self.load(self.k, 'i64')}, -1")
        self.put(f"store i64 {k}, ptr {self.k}")
        self.jump(self.new(f"icmp sge i64 {k}, {least}"), label, f"{label}_done")


class FirstSign(_Function):
    """The sign of the first coefficient that is not zero; 0 if all are zero."""

    def body(self):
        sign = self.slot("double")
        self.store(ZERO, sign)
        with self.down("each", 0) as k:
            c = self.coefficient(k)
            negative = self.select(self.compare("olt", c, ZERO), MINUS, self.load(sign))
            self.store(self.select(self.compare("ogt", c, ZERO), ONE, negative), sign)
        self.put(f"ret double {self.load(sign)}")
        return self.function(f"internal double @{FIRST_SIGN}(ptr %c, i64 %stride, i64 %order)")


class NotFar(_Function):
    """Emits the largest x = 2^-i end up to which the polynomial stays near its value at 0.

    The bound sum(|c[k]| |x|^k), k > 0, is at most the larger of `width` and `share` |c[0]|.
    """

    def body(self):
        at, left, total = self.slot("double"), self.slot("i64"), self.slot("double")
        self.store("%end", at)
        self.put(f"store i64 {ROUNDS}, ptr {left}")
        first = self.mul("%share", self.intrinsic("fabs", self.coefficient(0)))
        allowed = self.select(self.compare("ogt", first, "%width"), first, "%width")
        self.put("br label %round")
        self.label("round")
        self.store(ZERO, total)
        x = self.intrinsic("fabs", self.load(at))
        with self.down("sum", 1) as k:
            before = self.load(total)
            self.store(self.fma(before, x, self.intrinsic("fabs", self.coefficient(k))), total)
        near = self.compare("ole", self.mul(self.load(total), x), allowed)
        self.jump(near, "found", "far")
        self.store(self.mul(self.load(at), hexadecimal(0.5)), at)
        rounds = self.new(f"add i64 {self.load(left, 'i64')}, -1")
        self.put(f"store i64 {rounds}, ptr {left}")
        self.jump(self.new(f"icmp sgt i64 {rounds}, 0"), "round", "found")
        self.put(f"ret double {self.load(at)}")
        head = "(ptr %c, i64 %stride, i64 %order, double %end, double %width, double %share)"
        return self.function(f"internal double @{NOT_FAR}{head}")


class FirstChange(_Function):
    """The first x in (0, end] behind a change of sign, `end` if there is none.

    With a `share`, the polynomial counts as zero below this share of its size.  The change is then
    the point where the polynomial begins to vanish, or ceases to vanish.

    From a point where the value is q and the slope p (with signs such that q > 0), the polynomial
    stays positive for lengths s with q + p s - m s^2 / 2 > 0, where m bounds the second derivative.
    Steps of such lengths approach a simple zero quadratically, a double zero linearly.
    """

    def body(self, order):
        x = self.intrinsic("fabs", "%end")
        direction = self.select(self.compare("olt", "%end", ZERO), MINUS, ONE)
        c, slope, bend = (self.coefficient(k) for k in range(3))
        rest, sizes = self._rest(x, order), [self.intrinsic("fabs", v) for v in (bend, slope, c)]
        total = self.fma(self.fma(sizes[0], x, sizes[1]), x, self.add(sizes[2], rest))
        tiny = self.mul("%share", self.fma(hexadecimal(TAIL), self._tail(x, order), total))
        inside = self.compare("olt", c, tiny)
        shift = self.select(inside, self.mul(hexadecimal(4.0), tiny), tiny)
        q = self.sub(c, shift)
        side = self.select(self.compare("olt", q, ZERO), MINUS, ONE)
        least = self._least(x, *[self.mul(side, v) for v in (q, self.mul(direction, slope), bend)])
        none = self.compare("oeq", total, ZERO)  # the polynomial is zero
        far = self.new(f"or i1 {none}, {self.compare('ogt', least, rest)}")
        self.jump(far, "none", "near")
        bound = self._bound(x)
        sign = self.new(f"call double @{FIRST_SIGN}(ptr %c, i64 %stride, i64 %order)")
        negative = self.compare("olt", q, ZERO)
        sign = self.select(negative, MINUS, self.select(self.compare("ogt", q, ZERO), ONE, sign))
        self._march(x, shift, sign, direction, bound, order)
        self.label("none")
        self.put("ret double %end")
        head = "(ptr %c, i64 %stride, i64 %order, double %end, double %least, double %share)"
        return self.function(f"internal double @{FIRST_CHANGE}{head}")

    def _rest(self, x, order):
        """A bound of the sum of all terms but three, in CHAINS independent sums."""
        powers = [None, x]
        while len(powers) < CHAINS + FIRST_TERMS:
            powers.append(self.mul(powers[-1], x))
        total = None
        for first in range(FIRST_TERMS, FIRST_TERMS + CHAINS):
            part = None
            for k in range(order - (order - first) % CHAINS, FIRST_TERMS - 1, -CHAINS):
                c = self.intrinsic("fabs", self.coefficient(k))
                part = c if part is None else self.fma(part, powers[CHAINS], c)
            total = self.fma(part, powers[first], total)
        return total

    def _tail(self, x, order):
        """The size of the last two terms, an estimate of the remainder."""
        power = self.power(x, order - 1)
        last = [self.intrinsic("fabs", self.coefficient(k)) for k in (order, order - 1)]
        return self.mul(power, self.fma(last[0], x, last[1]))

    def _least(self, x, q, p, m):
        """The least value of q + p s + m s^2 for 0 <= s <= x."""
        end = self.fma(self.fma(m, x, p), x, q)
        square = self.mul(hexadecimal(4.0), m)
        vertex = self.sub(q, self.div(self.mul(p, p), square))
        falls = self.compare("olt", p, ZERO)
        rises = self.compare("ogt", self.fma(self.mul(hexadecimal(2.0), m), x, p), ZERO)
        least = self.select(self.new(f"and i1 {falls}, {rises}"), vertex, q)
        return self.select(self.compare("olt", end, least), end, least)

    def _bound(self, x):
        """A bound of the second derivative."""
        bound = self.slot("double")
        self.store(ZERO, bound)
        with self.down("sum", 2) as k:
            c = self.intrinsic("fabs", self.coefficient(k))
            n = self.new(f"sitofp i64 {k} to double")
            second = self.mul(self.mul(n, self.sub(n, ONE)), c)
            self.store(self.fma(self.load(bound), x, second), bound)
        bound, least = self.load(bound), hexadecimal(LEAST_BOUND)
        return self.select(self.compare("ogt", bound, least), bound, least)

    def _march(self, x, shift, sign, direction, bound, order):
        at, left = self.slot("double"), self.slot("i64")
        self.store(ZERO, at)
        self.put(f"store i64 {ROUNDS}, ptr {left}")
        self.put("br label %round")
        self.label("round")
        begun = self.load(at)
        q, p = self._value_and_slope(self.mul(begun, direction))
        q, p = self.mul(sign, self.sub(q, shift)), self.mul(self.mul(sign, direction), p)
        changed = self.new(
            f"and i1 {self.compare('olt', q, ZERO)}, {self.compare('ogt', begun, ZERO)}"
        )
        self.jump(changed, "found", "goes_on")
        q = self.select(self.compare("olt", q, ZERO), ZERO, q)
        twice = hexadecimal(2.0)
        root = self.fma(p, p, self.mul(self.mul(twice, bound), q))
        root = self.intrinsic("sqrt", root)
        s = self.select(
            self.compare("olt", p, ZERO),
            self.div(self.mul(twice, q), self.sub(root, p)),
            self.div(self.add(root, p), bound),
        )
        least = self.fma(begun, hexadecimal(BEYOND), "%least")
        later = self.add(begun, self.select(self.compare("ogt", s, least), s, least))
        self.store(later, at)
        self.jump(self.compare("oge", later, x), "none", "inside")
        rounds = self.new(f"add i64 {self.load(left, 'i64')}, -1")
        self.put(f"store i64 {rounds}, ptr {left}")
        self.jump(self.new(f"icmp sgt i64 {rounds}, 0"), "round", "found")
        self.put(f"ret double {self.mul(self._exact(begun, order), direction)}")

    def _exact(self, x, order):
        """A change's place x, or half of x if the remainder could have moved the change.

        The steps end where the states are accurate, and the difference may be less accurate: one
        with y^3, at rtol = 1e-6 and 0.04 % of the step away from its change.  From half of x, the
        next step finds the change by a series whose remainder is smaller by 2^order.
        """
        sizes = [self.intrinsic("fabs", self.coefficient(k)) for k in range(1, order + 1)]
        motion = sum_of(self, sizes, powers_of(self, x, order), ZERO)
        allowed = self.mul(hexadecimal(REMAINDER * SMALLEST[order + 1]), motion)
        vague = self.compare("ogt", self._tail(x, order), allowed)
        vague = self.truths("and", vague, self.compare("oeq", "%share", ZERO))
        return self.select(vague, self.mul(x, hexadecimal(0.5)), x)

    def _value_and_slope(self, x):
        value, slope = self.slot("double"), self.slot("double")
        for place in (value, slope):
            self.store(ZERO, place)
        with self.down("horner", 0) as k:
            self.store(self.fma(self.load(slope), x, self.load(value)), slope)
            self.store(self.fma(self.load(value), x, self.coefficient(k)), value)
        return self.load(value), self.load(slope)
