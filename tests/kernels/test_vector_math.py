"""Elementary functions of vectors: exact to two units in the last place, lane by lane."""

import itertools
import math
import re

import mpmath
import numpy as np
import pytest
from numba import njit

from fastdyn.kernels.ensemble import lanes
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.vector import exponential, inverse, logarithm, trigonometric
from support.by_vectors import (
    ANY,
    RNG,
    SPECIAL,
    N,
    formula,
    joined,
    same,
    spread,
    uniform,
    vectors,
)


def near_multiples(unit, largest):
    """What is nearest to whole multiples, where a reduced argument has lost most digits."""
    return np.floor(10 ** RNG.uniform(0, math.log10(largest), N)) * unit


ANGLES = joined(
    uniform(-10, 10), spread(-320, 9), spread(9, 308),
    near_multiples(math.pi / 4, 1e9), near_multiples(math.pi / 4, 1e15),
)  # fmt: skip
EXPONENTS = joined(
    uniform(-2, 2), uniform(-750, 715), spread(-320, 0), near_multiples(math.log(2) / 2, 1000)
)
POSITIVE = joined(uniform(0, 3), abs(spread(-323, 308)), 1 + spread(-16, -1), uniform(0.6, 1.5))
UNIT = joined(uniform(-1, 1), spread(-320, 0), uniform(0.45, 0.55), 1 - abs(spread(-16, -1)))
FUNCTIONS = {  # mpmath's, NumPy's, arguments
    "sin": (mpmath.sin, np.sin, ANGLES),
    "cos": (mpmath.cos, np.cos, ANGLES),
    "tan": (mpmath.tan, np.tan, ANGLES),
    "exp": (mpmath.exp, np.exp, EXPONENTS),
    "expm1": (mpmath.expm1, np.expm1, EXPONENTS),
    "exp2": (
        lambda x: mpmath.power(2, x), np.exp2, joined(uniform(-1080, 1030), uniform(-2, 2))
    ),
    "sinh": (mpmath.sinh, np.sinh, EXPONENTS),
    "cosh": (mpmath.cosh, np.cosh, EXPONENTS),
    "tanh": (mpmath.tanh, np.tanh, EXPONENTS),
    "log": (mpmath.log, np.log, POSITIVE),
    "log1p": (mpmath.log1p, np.log1p, joined(POSITIVE - 1, -abs(spread(-300, 0)))),
    "log2": (lambda x: mpmath.log(x) / mpmath.log(2), np.log2, POSITIVE),
    "log10": (mpmath.log10, np.log10, POSITIVE),
    "cbrt": (lambda x: mpmath.sign(x) * mpmath.cbrt(abs(x)), np.cbrt, ANY),
    "asin": (mpmath.asin, np.arcsin, UNIT),
    "acos": (mpmath.acos, np.arccos, UNIT),
    "atan": (mpmath.atan, np.arctan, ANY),
}  # fmt: skip
for _y in (0.5, 1.5, 2.0, 2.5, -0.5, -1.5, -2.5, -3.0):
    FUNCTIONS[f"power {_y}"] = (
        lambda x, y=_y: mpmath.power(x, y),
        lambda x, y=_y: np.power(x, np.full_like(x, y)), POSITIVE,
    )  # fmt: skip

PAIRS = np.array([*itertools.product(SPECIAL, SPECIAL)]).T
BASES = np.concatenate([uniform(0, 10), abs(spread(-320, 308)), 1 + spread(-16, -1)])
PLANE = np.concatenate([uniform(-5, 5), spread(-323, 308), spread(-323, -300), spread(300, 308)])
OTHER = np.concatenate([uniform(-5, 5), spread(-323, 308), spread(-323, -300), spread(300, 308)])
FUNCTIONS_OF_TWO = {
    "pow": (
        mpmath.power, np.power,
        BASES, RNG.uniform(-745, 710, len(BASES)) / np.log(np.where(BASES == 1, 2, BASES)),
    ),
    "atan2": (mpmath.atan2, np.arctan2, PLANE, OTHER),
}  # fmt: skip


def of_one(name):
    exact, numpys, x = FUNCTIONS[name]
    if not name.startswith("power"):
        ours = formula(name)
        return lambda x: ours(x), exact, numpys, (x,)
    power, exponent = formula("pow", 2), float(name.split()[1])
    return lambda x: power(x, exponent), exact, numpys, (x,)


def of_two(name):
    exact, numpys, *columns = FUNCTIONS_OF_TWO[name]
    ours = formula(name, 2)
    return lambda x, y: ours(x, y), exact, numpys, columns


CASES = [of_one(name) for name in FUNCTIONS] + [of_two(name) for name in FUNCTIONS_OF_TWO]
over_functions = pytest.mark.parametrize(
    "function, exact, numpys, columns", CASES, ids=[*FUNCTIONS, *FUNCTIONS_OF_TWO]
)


def errors(found, exact, columns):
    """The errors in units in the last place, where the exact result is a number, and not zero."""
    with mpmath.workprec(200):
        for value, *row in zip(found, *columns, strict=True):
            try:
                truth = exact(*map(mpmath.mpf, row))
            except (ValueError, ZeroDivisionError):
                continue
            if isinstance(truth, mpmath.mpf) and 0 < abs(nearest := float(truth)) < math.inf:
                yield abs(mpmath.mpf(float(value)) - truth) / math.ulp(nearest)


def outstanding(x):
    """Zeros, infinities and NaN as they are, other numbers as their sign."""
    return np.where((x == 0) | ~np.isfinite(x), x, np.copysign(1.0, x))


@pytest.mark.few(5)
@over_functions
def test_a_function_is_exact_to_two_ulp(function, exact, numpys, columns):
    found = [*errors(vectors(function, *columns), exact, columns)]
    assert len(found) > N
    assert max(found) <= 2


@pytest.mark.few(8)
@over_functions
def test_zeros_infinities_and_nan_come_out_as_from_numpy(function, exact, numpys, columns):
    columns = [np.array(SPECIAL)] if len(columns) == 1 else PAIRS
    found = vectors(function, *columns)
    with np.errstate(all="ignore"):
        assert same(outstanding(found), outstanding(numpys(*columns)))


@pytest.mark.few(5)
@over_functions
def test_a_lane_depends_neither_on_the_others_nor_on_the_width(function, exact, numpys, columns):
    found = vectors(function, *columns)
    for width in (4, 8):
        order = RNG.permutation(len(found))
        again = vectors(function, *(c[order] for c in columns), width=width)
        assert same(again, found[order])


def test_sine_and_cosine_of_one_argument_are_one_call():
    form, sine, cosine = Form(1, 8), formula("sin"), formula("cos")

    @njit
    def product(a):
        x = lanes.field(form, a, 0)
        lanes.leave(form, a, 0, sine(x) * cosine(x) * sine(x + 1.0))

    product(np.ones((1, 8)))
    (code,) = product.inspect_llvm().values()
    assert len(re.findall("call .*@fastdyn.sine_cosine", code)) == 2


def series(coefficient, n=60):
    return lambda z: mpmath.fsum(coefficient(i) * z**i for i in range(n))


def sine_rest(z):
    return z if z == 0 else mpmath.sqrt(z) / mpmath.sin(mpmath.sqrt(z)) * z


FITS = {  # of what, with which weight, where, exponent of the error
    "SINE": (
        trigonometric.SINE, series(lambda i: (-1) ** (i + 1) / mpmath.factorial(2 * i + 3)),
        sine_rest, (0, 0.617), -57,
    ),
    "COSINE": (
        trigonometric.COSINE, series(lambda i: (-1) ** i / mpmath.factorial(2 * i + 4)),
        lambda z: z * z / mpmath.cos(mpmath.sqrt(z)), (0, 0.617), -59,
    ),
    "EXPONENTIAL": (
        exponential.EXPONENTIAL, series(lambda i: 1 / mpmath.factorial(i + 2)),
        lambda r: r * r / mpmath.exp(r), (-0.3466, 0.3466), -60,
    ),
    "LOGARITHM": (
        logarithm.LOGARITHM, series(lambda i: mpmath.mpf(2) / (2 * i + 3)),
        lambda z: z / 2, (0, 0.02944), -59,
    ),
    "TAIL": (
        logarithm.TAIL, series(lambda i: mpmath.mpf(2) / (2 * i + 7)),
        lambda z: z**3 / 2, (0, 0.02944), -72,
    ),
    "ARC_TANGENT": (
        inverse.ARC_TANGENT, series(lambda i: (-1) ** (i + 1) / mpmath.mpf(2 * i + 3)),
        lambda z: z * (1 + z / 2), (0, 0.17158), -58,
    ),
    "ARC_SINE": (
        inverse.ARC_SINE,
        series(lambda i: mpmath.binomial(2 * i + 2, i + 1) / mpmath.ldexp(2 * i + 3, 2 * i + 2)),
        lambda z: z, (0, 0.25), -58,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FITS)
def test_a_polynomial_has_the_error_that_is_stated(name):
    coefficients, exact, weight, interval, exponent = FITS[name]
    with mpmath.workprec(200):
        error = max(
            abs((series(coefficients.__getitem__, len(coefficients))(z) - exact(z)) * weight(z))
            for z in mpmath.linspace(*interval, 200)
        )
    assert error <= mpmath.mpf(2) ** exponent
