"""Functions of numbers evaluated by vectors, and numbers to try them on."""

import functools
import math

import numpy as np
from numba import njit
from numba.extending import intrinsic

from fastdyn.kernels.ensemble import lanes
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.vector.emit import Lanes
from fastdyn.kernels.vector.formulas import BY_NAME

RNG = np.random.default_rng(1)
N = 400
SPECIAL = [
    0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 0.5, -0.5, 1.5, -2.5, 5e-324, -5e-324,
    2.0**-1022, -1e-310, 1e-17, -1e-17, 1 + 2**-52, 1 - 2**-53, 1e17, -1e17, 2.0**53 - 1, 709.0,
    -745.0, 800.0, -800.0, 1.7976931348623157e308, -1.7976931348623157e308, math.inf, -math.inf,
    math.nan,
]  # fmt: skip


@functools.cache
def formula(name, n=1):
    """The formula of that name, of n vectors, for functions that Numba compiles."""

    def body(builder, args):
        return BY_NAME[name](*(Lanes(builder, v) for v in args)).value

    @intrinsic
    def of_one(typingctx, x):
        return x(x), lambda c, b, s, args: body(b, args)

    @intrinsic
    def of_two(typingctx, x, y):
        return x(x, x), lambda c, b, s, args: body(b, args)

    return (of_one, of_two)[n - 1]


def vectors(function, *columns, width=8):
    """The function of one or two arrays, computed by vectors."""
    n = len(columns[0])
    tables = [np.pad(c, (0, -n % width), "edge").reshape(-1, width) for c in columns]
    found = np.empty_like(tables[0])
    _over_tables(function, width)[len(columns) - 1](*tables, found)
    return found.ravel()[:n]


@functools.cache
def _over_tables(function, width):
    form = Form(1, width)
    function = njit(function)

    @njit
    def of_one(a, found):
        for i in range(len(found)):
            lanes.leave(form, found, i, function(lanes.field(form, a, i)))

    @njit
    def of_two(a, b, found):
        for i in range(len(found)):
            x, y = lanes.field(form, a, i), lanes.field(form, b, i)
            lanes.leave(form, found, i, function(x, y))

    return of_one, of_two


def numbers(function, *columns):
    """The same, one number at a time."""
    function = njit(error_model="numpy")(function)
    rows = zip(*(c.tolist() for c in columns), strict=True)
    return np.array([function(*row) for row in rows], float)


def same(a, b):
    """Whether two arrays are equal to the last bit; one NaN is as good as another."""
    bits = [np.where(np.isnan(x), 0, x.view(np.int64)) for x in (a, b)]
    return np.array_equal(*bits)


def spread(low, high):
    """Numbers of both signs with magnitudes between two powers of ten."""
    return 10 ** RNG.uniform(low, high, N) * RNG.choice([-1, 1], N)


def uniform(low, high):
    return RNG.uniform(low, high, N)


def joined(*parts):
    """The arrays and the special numbers as one array."""
    return np.concatenate([*parts, SPECIAL])


ANY = joined(uniform(-5, 5), spread(-323, 308))
