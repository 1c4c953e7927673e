"""Functions of one and of two numbers, smooth or with kinks and jumps, by name."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import erf, erfc

SPLINE = CubicSpline([-3.0, -1.0, 0.5, 4.0], [1.0, 0.2, 0.7, -0.4])
XP, FP = np.array([-4.0, -1.0, 0.3, 2.0, 5.0]), np.array([0.3, 1.0, -0.5, 0.2, 0.9])

ONE = {
    "sqrt": np.sqrt, "cbrt": np.cbrt, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh,
    "tanh": np.tanh, "asinh": np.arcsinh, "acosh": lambda x: np.arccosh(1 + x),
    "atanh": np.arctanh, "exp": np.exp, "exp2": np.exp2, "expm1": np.expm1, "log": np.log,
    "log2": np.log2, "log10": np.log10, "log1p": np.log1p, "erf": erf, "erfc": erfc,
    "abs": abs, "floor": np.floor, "rint": np.rint, "-5/2": lambda x: x**-2.5,
    "7/2": lambda x: x**3.5, "5": lambda x: x**5, "1.3": lambda x: x**1.3, "-1": lambda x: 1 / x,
    "spline": SPLINE, "interp": lambda x: np.interp(x, XP, FP), "mod": lambda x: x % 0.1,
    "sign": np.sign, "clip": lambda x: np.clip(x, 0.2, 0.5), "sinc": np.sinc,
}  # fmt: skip

TWO = {
    "product": lambda a, b: a * b, "quotient": lambda a, b: a / b, "atan2": np.arctan2,
    "power": lambda a, b: a**b, "fmod": np.fmod, "hypot": np.hypot, "max": np.maximum,
    "min": min, "mod": lambda a, b: a % b, "where": lambda a, b: np.where(a < b, a * b, b),
    "nested": lambda a, b: (a - b) - ((a + 2 * b) - (3 * a - b)),
    "floor division": lambda a, b: a // b, "copysign": np.copysign,
}  # fmt: skip
