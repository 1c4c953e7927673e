"""Numbers where arithmetic is delicate: zeros of both signs, infinite ones, NaN, ties.

Where the function raises, its graph must say so; it may say so where Python does not raise, and
then Python decides.  Else both give the same, of the same sign.
"""

import cmath
import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastdyn
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace

DELICATE = (
    0.0, -0.0, 1.0, -1.0, 0.5, 2.675, -2.675, 1.005, 1e-310, -1e-310, 1e300, math.inf, -math.inf,
    math.nan, 3.0, -4.0, 7.25, 1e16,
)  # fmt: skip
OF_TWO = {
    "a // b": lambda a, b: a // b,
    "float(a) // float(b)": lambda a, b: float(a) // float(b),
    "a % b": lambda a, b: a % b,
    "float(a) % float(b)": lambda a, b: float(a) % float(b),
    "np.copysign": np.copysign,
    "math.copysign": math.copysign,
    "math.fmod": math.fmod,
    "1 / max(0.0, a)": lambda a, b: 1 / max(0.0, a),
    "1 / min(b, 0.0)": lambda a, b: 1 / min(b, 0.0),
}
OF_ONE = {
    **{f"math.{name}": getattr(math, name) for name in (
        "sin", "cos", "tan", "asin", "acos", "atan", "log", "log2", "log10", "log1p", "sqrt",
        "acosh", "atanh", "exp", "expm1", "sinh", "cosh", "tanh", "gamma", "lgamma",
    )},
    "np.signbit": lambda a: np.where(np.signbit(a), 1.0, 2.0),
    "round(float(a), 2)": lambda a: round(float(a), 2),
    **{f"cmath.phase of {name}": lambda a, of=of: cmath.phase(of(a)) for name, of in {
        "complex(a, -0.0)": lambda a: complex(a, -0.0),
        "complex(-0.0, a)": lambda a: complex(-0.0, a),
        "complex(a, -1.0 - 0j)": lambda a: complex(a, -1.0 - 0j),
        "complex(1j, a)": lambda a: complex(1j, a),
    }.items()},
    "a.round(2)": lambda a: a.round(2),
    "a.round()": lambda a: a.round(),
    "round(a, 2)": lambda a: round(a, 2),
    "round(float(a), -1)": lambda a: round(float(a), -1),
}  # fmt: skip
ULPS = 8  # between libraries, of elementary functions


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", [*OF_TWO, *OF_ONE])
def test_delicate_numbers(name):
    n = 2 if name in OF_TWO else 1
    of = OF_TWO.get(name) or OF_ONE[name]
    found = trace(lambda t, y: [of(*y)], (), n, (1,))
    for values in itertools.product(DELICATE, repeat=n):
        y = np.array(values)
        nodes = [*found.outputs, found.raising]
        value, raised = evaluate(found.graph, nodes, np.zeros(1), y[:, None], [])[0].ravel()
        try:
            expected = float(of(*y))
        except (ValueError, ZeroDivisionError, OverflowError):
            assert raised, values
            continue
        if not raised:
            np.testing.assert_allclose(value, expected, rtol=ULPS * np.finfo(float).eps)
            assert expected != 0 or np.signbit(value) == np.signbit(expected), values


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_fractions_from_outside():
    given = {"k": Fraction(1, 3)}

    def fun(t, y):
        return [(given["k"] * Fraction(2, 7) + 1) * y[0] ** given["k"] - float(given["k"])]

    for k in Fraction(1, 3), Fraction(5, 4), 0.4:
        given["k"] = k
        mine, theirs = (solve(fun, (0.0, 1.0), [1.0]) for solve in (fastdyn.solve_ivp, solve_ivp))
        np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-12)


LIGHT = 299792458  # m/s; its square is no float


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("c", [LIGHT, -LIGHT, 2**62 + 1])
def test_large_whole_numbers_are_floats_beside_floats(c):
    def fun(t, y, c):
        x, v = y
        return [v * c**2 / LIGHT**2 / c, (c**2 + 1) / c**2 - x / c**2 + (v + c**2) / (c**2 - v)]

    mine, theirs = (
        solve(fun, (0.0, 1.0), [1.0, 2.0], args=(c,)) for solve in (fastdyn.solve_ivp, solve_ivp)
    )
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-14)


def test_large_whole_numbers_beside_whole_numbers_are_left_to_python():
    with pytest.raises(Untraceable, match=r"beyond 2\*\*53"):
        trace(lambda t, y: [int(t) + LIGHT**2 + y[0]], (), 1, (1,))
