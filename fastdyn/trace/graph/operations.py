"""The operations of a graph, computed by NumPy on numbers or arrays."""

import math
from typing import Any

import numpy as np


def _piecewise(data, x):
    knots, *coefficients = data
    i = np.clip(np.searchsorted(knots, x, "right") - 1, 0, len(knots) - 2)
    at, result = np.asarray(x) - knots[i], coefficients[0][i]
    for c in coefficients[1:]:
        result = result * at + c[i]
    return result


def _interpolate(data, x):
    """np.interp for x between the first and the last knot."""
    knots, heights = data
    x = np.asarray(x, float)
    i = np.clip(np.searchsorted(knots, x, "right") - 1, 0, len(knots) - 2)
    left, right, low, high = knots[i], knots[i + 1], heights[i], heights[i + 1]
    slope = (high - low) / (right - left)
    result = slope * (x - left) + low
    result = np.where(np.isnan(result), slope * (x - right) + high, result)
    result = np.where(np.isnan(result) & (low == high), low, result)
    return np.where(np.isnan(x), x, np.where(x == left, low, result))[()]


def _entry(table, x):
    i = np.nan_to_num(np.asarray(x, float), nan=0.0, posinf=0.0, neginf=0.0).astype(np.int64)
    return table[np.clip(np.where(i < 0, i + len(table), i), 0, len(table) - 1)]


def _scalar_function(name):
    function = np.vectorize(getattr(math, name), otypes=[float])

    def compute(x):
        try:
            return function(x)[()]
        except (ValueError, OverflowError):
            return np.nan * np.asarray(x)

    return compute


FUNCTIONS: dict[str, Any] = {  # by their names in C
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "asinh": np.arcsinh,
    "acosh": np.arccosh, "atanh": np.arctanh, "exp": np.exp, "exp2": np.exp2, "expm1": np.expm1,
    "log": np.log, "log2": np.log2, "log10": np.log10, "log1p": np.log1p, "cbrt": np.cbrt,
    "atan2": np.arctan2, "pow": np.power, "fmod": np.fmod, "erf": _scalar_function("erf"),
    "erfc": _scalar_function("erfc"), "tgamma": _scalar_function("gamma"),
    "lgamma": _scalar_function("lgamma"),
}  # fmt: skip
COMPUTE: dict[str, Any] = {
    "neg": lambda _, a: -a,
    "add": lambda _, a, b: a + b,
    "sub": lambda _, a, b: a - b,
    "mul": lambda _, a, b: a * b,
    "div": lambda _, a, b: np.true_divide(a, b),
    "sqrt": lambda _, a: np.sqrt(a),
    "abs": lambda _, a: np.abs(a),
    "round": lambda how, a: getattr(np, how)(a),
    "call": lambda name, *a: FUNCTIONS[name](*a),
    "lt": lambda _, a, b: np.less(a, b),
    "le": lambda _, a, b: np.less_equal(a, b),
    "eq": lambda _, a, b: np.equal(a, b),
    "and": lambda _, a, b: np.logical_and(a, b),
    "or": lambda _, a, b: np.logical_or(a, b),
    "not": lambda _, a: np.logical_not(a),
    "select": lambda _, c, a, b: np.where(c, a, b)[()],
    "entry": lambda i, found: found[i],
    "table": _entry,
    "search": lambda data, x: np.searchsorted(data[0], x, data[1]) * 1.0,
    "piecewise": _piecewise,
    "interpolate": _interpolate,
}
