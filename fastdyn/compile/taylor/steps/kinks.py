"""Steps that end where a condition changes, so that each step has one series.

A condition compares two numbers.  Where their difference changes sign, the function may have a kink
or a jump.  The differences have Taylor series, too.  If a difference is zero at the start of a
step, the sign of its first coefficient that is not zero decides which side the step takes.
"""

import functools

from ..text.instructions import ZERO, hexadecimal
from .changes import (
    BEYOND,
    FIRST_CHANGE,
    FIRST_SIGN,
    NOT_FAR,
    TAIL,
    VANISHING,
    FirstChange,
    FirstSign,
    NotFar,
)
from .step import powers_of, sum_of

CLEAR = 1.0 - 2.0**-20  # share of the distance from zero that a difference may move


class Kinks:
    """Emits the treatment of the differences that a plan watches.

    Parameters
    ----------
    plan : Plan
    text : Text
    order : int
        The order of the series of the differences: one less than the states' order.
    """

    def __init__(self, plan, text, order):
        self.plan, self.text, self.order, self.raising = plan, text, order, None
        self.count = len(plan.watched)
        self._side = {key: text.slot("double") for key in plan.watched if key in plan.signed}
        self._rows = text.slot("double", max(self.count * (order + 1), 1))

    def forget(self):
        """Forget the sides at the start of a step."""
        for place in self._side.values():
            self.text.store(ZERO, place)

    def sides(self):
        """By key, the signs, just behind the start, of differences that are zero at the start."""
        return {key: self.text.load(place) for key, place in self._side.items()}

    def begin(self, start):
        """Take the truth of `raising` from order 0."""
        if self.plan.raises():
            self.raising = start.truth(self.plan.raising)

    def store(self, k, values):
        """Keep the coefficients of order k."""
        text = self.text
        if not self.count:
            return
        at = k * self.count if isinstance(k, int) else text.new(f"mul i64 {k}, {self.count}")
        row = text.at(self._rows, at)
        for i, key in enumerate(self.plan.watched):
            text.store(values[key], text.at(row, i))

    def decide(self):
        """Emit the truth value of "a side was wrong": the series must then be computed again."""
        text, again = self.text, "false"
        for i, key in enumerate(self.plan.watched):
            if key not in self._side:
                continue
            place = self._side[key]
            zero = text.compare("oeq", text.load(text.at(self._rows, i)), ZERO)
            unknown = text.compare("oeq", text.load(place), ZERO)
            first = text.truths("and", zero, unknown)
            sign = self._call(FIRST_SIGN, text.at(self._rows, i))
            known = text.compare("une", sign, ZERO)
            changed = text.truths("and", first, known)
            text.store(text.select(changed, sign, text.load(place)), place)
            again = text.truths("or", again, changed)
        return again

    def limited(self, x, t, scale):
        """The length x, or a shorter length that ends a little behind the first change.

        A node of `Plan.held` may shorten x, too.  A difference that moves by less than its distance
        from a change is not searched: the search is a call, and no value stays in a register
        around a call.
        """
        text = self.text
        size = text.intrinsic("fabs", x)
        t = text.div(text.intrinsic("fabs", t), scale)
        floor = text.mul(size, hexadecimal(BEYOND * BEYOND))
        least = text.fma(t, hexadecimal(2.0 * BEYOND), floor)
        powers, found = powers_of(text, size, self.order), text.slot("double")
        text.store(x, found)
        for i, key in enumerate(self.plan.watched):
            calm = self._calm(i, key, size, powers)
            text.put(f"br i1 {calm}, label %calm{i}, label %search{i}")
            text.label(f"search{i}")
            text.store(self._first(i, key, text.load(found), least), found)
            text.put(f"br label %calm{i}")
            text.label(f"calm{i}")
        return text.load(found)

    def _calm(self, i, key, size, powers):
        """The truth value of "up to the length `size`, the difference stays clear of a change".

        The bound of the motion is sum(|c[k]| x^k), k > 0.
        """
        text, plan = self.text, self.plan
        places = [text.at(self._rows, k * self.count + i) for k in range(self.order + 1)]
        first, *terms = [text.intrinsic("fabs", text.load(place)) for place in places]
        motion, conditions = sum_of(text, terms, powers, ZERO), []
        if key in plan.held:
            _, width, share = plan.held[key]
            allowed = text.larger(hexadecimal(width), text.mul(hexadecimal(share), first))
            conditions.append(text.compare("ole", motion, allowed))
        if key in plan.rooted:  # also clear of the value that counts as zero
            last = text.mul(text.power(size, self.order - 1), text.fma(terms[-1], size, terms[-2]))
            motion = text.fma(last, hexadecimal(2.0 * VANISHING * TAIL), motion)
        if key in plan.rooted or key in plan.signed:
            distance = text.mul(first, hexadecimal(CLEAR))
            conditions.append(text.compare("olt", motion, distance))
        return functools.reduce(functools.partial(text.truths, "and"), conditions)

    def _first(self, i, key, x, least):
        """The length x, or a shorter one, by a search for the first change of a difference."""
        place = self.text.at(self._rows, i)
        if key in self.plan.signed:
            x = self._call(FIRST_CHANGE, place, x, least, ZERO)
        if key in self.plan.rooted:
            x = self._call(FIRST_CHANGE, place, x, least, hexadecimal(VANISHING))
        if key in self.plan.held:
            _, width, share = self.plan.held[key]
            x = self._call(NOT_FAR, place, x, hexadecimal(width), hexadecimal(share))
        return x

    def _call(self, name, pointer, *numbers):
        given = "".join(f", double {x}" for x in numbers)
        head = f"call double @{name}(ptr {pointer}, i64 {self.count}, i64 {self.order}"
        return self.text.new(head + given + ")")

    def functions(self):
        """The LLVM text of the functions that a step calls."""
        if not self.count:
            return []
        given = self.text.fused, self.text.declarations
        found = [FirstSign(*given).body(), FirstChange(*given).body(self.order)]
        return [*found, NotFar(*given).body()] if self.plan.held else found
