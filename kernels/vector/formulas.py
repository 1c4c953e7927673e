"""Formulas of elementary functions on vectors, by their names in C."""

from . import exponential, inverse, logarithm, trigonometric
from .emit import outlined


@outlined
def _remainder(a, b):
    return a % b


BY_NAME = {
    "sin": trigonometric.sine, "cos": trigonometric.cosine, "tan": trigonometric.tangent,
    "asin": inverse.arc_sine, "acos": inverse.arc_cosine, "atan": inverse.arc_tangent,
    "atan2": inverse.arc_tangent_of_two, "exp": exponential.exponential,
    "expm1": exponential.exponential_less_one, "exp2": exponential.power_of_two,
    "sinh": exponential.hyperbolic_sine, "cosh": exponential.hyperbolic_cosine,
    "tanh": exponential.hyperbolic_tangent, "log": logarithm.logarithm,
    "log1p": logarithm.logarithm_of_one_plus, "log2": logarithm.logarithm_2,
    "log10": logarithm.logarithm_10, "cbrt": logarithm.cube_root, "pow": logarithm.power,
    "fmod": _remainder,
}  # fmt: skip
