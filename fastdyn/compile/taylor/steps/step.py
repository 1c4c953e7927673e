"""A step from its coefficients: its length, and the state at its end.

The length keeps the last two terms of the series below the tolerance (A. Jorba and M. Zou, see
`rewrite.py`, section 3.2.1), of each component below its own tolerance.  A second bound limits the
terms of lower orders, which may be larger by the same ratios as the terms of exp.  The second bound
detects a series with gaps, for example a series in powers of t^5.
"""

import math

from ..text.instructions import ONE, ZERO, hexadecimal
from .accuracy import SMALLEST

LAST, TERMS = 2, 8
IRREGULAR = 64.0  # ratio of earlier terms to those of exp, above which a series has gaps
# log2(1.5 + u / 2) for |u| < 1 and 2**u for |u| < 1 / 2, to 1e-4: least squares at Chebyshev's
# points.
LOGARITHM = (
    0.5849504981408199, 0.48048162364576458, -0.079937273772185555,
    0.01943073188493305, -0.0050006798066754132,
)  # fmt: skip
EXPONENTIAL = 0.9999244814555224, 0.6931210339915466, 0.24264008283277344, 0.055922035647262516


class Step:
    """Emits the part of a step that follows the series.

    Parameters
    ----------
    text : Text
    n, order : int
        Number of components, and the order of the series.
    rows, row : str, int
        The place of the coefficients: see `online.Online`.
    """

    def __init__(self, text, n, order, rows, row):
        self.text, self.n, self.order, self.rows, self.row = text, n, order, rows, row
        self.wide = text.of(4 if n <= 4 else 8)

    def length(self, weights, allowance, tolerance):
        """The `length`, and the sum of all examined terms: finite if the series is finite.

        Parameters
        ----------
        weights : str
            The address of 1 / (atol + rtol |y|) of each component.
        allowance : float
            The largest term, in units of the tolerance.
        tolerance : str
            The relative tolerance.
        """
        text, orders = self.text, range(self.order, self.order - LAST, -1)
        length_at, size_at = text.slot("double"), text.slot("double")
        norms, size = self._norms(orders, weights)
        x = length(text, norms, allowance, tolerance)
        text.store(x, length_at)
        text.store(size, size_at)
        regular = text.compare("ole", self._earlier(x, weights, allowance), ONE)
        regular = text.truths("and", regular, text.compare("ogt", size, ZERO))
        text.put(f"br i1 {regular}, label %regular, label %gaps")
        text.label("gaps")
        norms, size = self._norms(range(self.order, self.order - TERMS, -1), weights)
        text.store(length(text, norms, allowance, tolerance), length_at)
        text.store(size, size_at)
        text.put("br label %regular")
        text.label("regular")
        return text.load(length_at), text.load(size_at)

    def _earlier(self, x, weights, allowance):
        """The terms before the last terms, at x, in units of the largest terms of a regular series.

        A regular series has geometric terms, with the last terms at the bound of `length` for the
        smallest tolerance of the order.
        """
        text, wide, least = self.text, self.wide, self.order - LAST + 1
        ratio = math.e * SMALLEST[self.order] ** (-1.0 / least)
        orders = range(least - 1, self.order - TERMS, -1)
        x = text.mul(x, hexadecimal(ratio))
        share = text.mul(
            text.power(x, orders[-1]), hexadecimal(ratio**-least / allowance / IRREGULAR)
        )
        at, found = wide.splat(x, wide.lanes), []
        for first in range(0, self.row, wide.lanes):
            total = None
            for k in orders:
                c = wide.load(wide.at(self.rows, k * self.row + first))
                c = wide.intrinsic("fabs", c)
                total = c if total is None else wide.fma(total, at, c)
            found.append(wide.mul(total, wide.load(wide.at(weights, first))))
        return text.mul(across(wide, joined(found, wide.add), text.add), share)

    def _norms(self, orders, weights):
        """The largest terms of some orders, and the sum of all terms, in units of the tolerance."""
        found = {k: self._terms(k, weights) for k in orders}
        norms = {k: joined(terms, self.text.larger) for k, terms in found.items()}
        return norms, joined([term for terms in found.values() for term in terms], self.text.add)

    def _terms(self, k, weights):
        """The sizes of the coefficients of an order, in units of the tolerance."""
        text = self.text
        sizes = [
            text.intrinsic("fabs", text.load(text.at(self.rows, k * self.row + i)))
            for i in range(self.n)
        ]
        return [text.mul(c, text.load(text.at(weights, i))) for i, c in enumerate(sizes)]

    def end(self, x, state, low, each=()):
        """Store the state at x at the address `state`, and its rounding error at `low`.

        `each` has further addresses, one for each component.
        """
        wide = self.wide
        powers = powers_of(wide, wide.splat(x, wide.lanes), self.order)
        for first in range(0, self.row, wide.lanes):
            places = [wide.at(self.rows, k * self.row + first) for k in range(self.order + 1)]
            low_at, state_at = wide.at(low, first), wide.at(state, first)
            value, rest = end(wide, [wide.load(p) for p in places], powers, wide.load(low_at))
            wide.store(rest, low_at)
            wide.store(value, state_at)
            for i, place in enumerate(each[first : first + wide.lanes]):
                one = self.text.new(f"extractelement {wide.kind} {value}, i64 {i}")
                self.text.store(one, place)

    def copy(self, source, target):
        """Copy a row."""
        for first in range(0, self.row, self.wide.lanes):
            value = self.wide.load(self.wide.at(source, first))
            self.wide.store(value, self.wide.at(target, first))

    def weights(self, state, rtol, atol, weights):
        """Store the `weight` of each component at the address `weights`."""
        wide = self.wide
        for first in range(0, self.row, wide.lanes):
            y, r, a = (wide.load(wide.at(p, first)) for p in (state, rtol, atol))
            slope = wide.load(wide.at(self.rows, self.row + first))
            wide.store(weight(wide, y, slope, r, a), wide.at(weights, first))


def joined(terms, join):
    """All terms, joined in pairs."""
    while len(terms) > 1:
        pairs = zip(terms[::2], terms[1::2], strict=False)
        terms = [join(a, b) for a, b in pairs] + terms[len(terms) & ~1 :]
    return terms[0]


def across(wide, vector, join):
    """The lanes of a vector joined to one number."""
    lanes = range(wide.lanes)
    return joined([wide.new(f"extractelement {wide.kind} {vector}, i64 {i}") for i in lanes], join)


def length(text, norms, allowance, tolerance):
    """The length of a step in the unit of the series.

    `norms` are, by order, the largest terms at x = 1, in units of the tolerance.
    """
    found, least, digits = None, max(norms) - LAST + 1, _logarithm(text, tolerance)
    for k, m in norms.items():
        constant = math.log2(allowance) / k
        if k < least:
            constant += math.log2(least / k)
        z = text.fma(_logarithm(text, m), hexadecimal(-1.0 / k), hexadecimal(constant))
        if k < least:
            z = text.fma(digits, hexadecimal(1.0 / least - 1.0 / k), z)
        found = z if found is None else text.smaller(z, found)
    return _exponential(text, found)


def _polynomial(text, coefficients, u):
    first, *rest = map(hexadecimal, coefficients)
    return sum_of(text, rest, powers_of(text, u, len(coefficients)), first)


def _logarithm(text, x):
    """log2(x) to 1e-4, which suffices for a length, in a dozen cycles."""
    bits = text.bits(x)
    exponent = text.of_bits("add", text.of_bits("lshr", bits, 52), -1023)
    exponent = text.new(f"sitofp {text.whole} {exponent} to {text.kind}")
    mantissa = text.of_bits("or", text.of_bits("and", bits, 2**52 - 1), 1023 << 52)
    u = text.fma(text.real(mantissa), hexadecimal(2.0), hexadecimal(-3.0))
    return text.add(exponent, _polynomial(text, LOGARITHM, u))


def _exponential(text, z):
    """2**z, |z| < 1000, to 1e-4; the last bits of z + 1.5 2**52 are z rounded to an integer."""
    shifted = text.add(z, hexadecimal(1.5 * 2.0**52))
    u = text.sub(z, text.sub(shifted, hexadecimal(1.5 * 2.0**52)))
    exponent = text.of_bits("shl", text.bits(shifted), 52)
    result = text.bits(_polynomial(text, EXPONENTIAL, u))
    return text.real(text.new(f"add {text.whole} {result}, {exponent}"))


def powers_of(text, x, order):
    """The powers x, x^2, x^4, ... that `end` needs, by their exponents."""
    powers, e = {1: x}, 2
    while e < order:
        powers[e] = text.mul(powers[e // 2], powers[e // 2])
        e *= 2
    return powers


def sum_of(text, terms, powers, low):
    """low + terms[0] x + terms[1] x^2 + ..., by Estrin's scheme."""
    e = 1
    while len(terms) > 1:
        pairs = zip(terms[::2], terms[1::2], strict=False)
        terms = [text.fma(b, powers[e], a) for a, b in pairs] + terms[len(terms) & ~1 :]
        e *= 2
    return text.fma(terms[0], powers[1], low)


def end(text, coefficients, powers, low):
    """The value of a polynomial plus `low`, and its rounding error."""
    y, *terms = coefficients
    rise = sum_of(text, terms, powers, low)
    value = text.add(y, rise)
    return value, text.sub(rise, text.sub(value, y))


def weight(text, y, slope, rtol, atol):
    """1 / (atol + rtol max(|y|, |y_1|)); 0 for a component without tolerance.

    The slope y_1 is the change in one unit of time, for components that are zero now and grow in
    the step.  The unit is at most 1 / COARSE of the step: see `pace.py`.
    """
    y, slope = (text.intrinsic("fabs", v) for v in (y, slope))
    size = text.select(text.compare("ole", slope, y), y, slope)  # NaN if the slope is
    size = text.fma(rtol, size, atol)
    inverse = text.div(ONE, size)
    return text.select(text.compare("oeq", size, ZERO), ZERO, inverse)
