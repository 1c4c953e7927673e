"""Arithmetic, roots, rounding, comparisons, logic and selection."""

import math
import operator

import numpy as np

from .domains import LARGEST, outside
from .record import Operation, add
from .value import select


def _below_zero(a):
    """Whether the sign of a number is set, also that of a zero."""
    return (a < 0.0) | ((a == 0.0) & (1.0 / a < 0.0))


def _by_sign(a, below, above, at):
    """`below`, `above` or `at` by the sign of a; NaN stays."""
    return select(a < 0.0, below, select(a > 0.0, above, select(a == 0.0, at, a)))


add(
    Operation("add", operator.add, (1.0, 1.0), "fadd", "+", recurrence="linear"),
    Operation("sub", operator.sub, (1.0, -1.0), "fsub", "-", recurrence="linear",
              aliases=("subtract",)),
    Operation("neg", np.negative, (-1.0,), "fneg", c="-{0}", js="-{0}", recurrence="linear"),
    Operation("mul", operator.mul, (lambda o, a, b: b, lambda o, a, b: a), "fmul", "*",
              recurrence="product", aliases=("multiply",)),
    Operation("div", np.true_divide, (lambda o, a, b: 1 / b, lambda o, a, b: -(o * (1 / b))),
              "fdiv", "/", cost=4, recurrence="quotient"),
    Operation("sqrt", np.sqrt, (lambda o, a: 0.5 / o,), "llvm.sqrt", c="sqrt({0})",
              js="Math.sqrt({0})", cost=4, in_math=math.sqrt,
              raises=outside(lambda a: a < 0, -2.0), recurrence="root", root=True),
    Operation("abs", np.abs, (lambda o, a: select(a < 0, -1.0, 1.0),), "llvm.fabs",
              c="fabs({0})", js="Math.abs({0})", recurrence="choice", kinked=True),
    *(Operation(name, getattr(np, name), (0.0,), f"llvm.{name}", c=f"{name}({{0}})", js=js,
                whole=True, decision=lambda o, a: o, words="rounding to a whole number")
      for name, js in (("floor", "Math.floor({0})"), ("ceil", "Math.ceil({0})"),
                       ("rint", "rint({0})"), ("trunc", "Math.trunc({0})"))),
    Operation("lt", np.less, (0.0, 0.0), sign="<", truth=True),
    Operation("le", np.less_equal, (0.0, 0.0), sign="<=", truth=True),
    Operation("eq", np.equal, (0.0, 0.0), sign="==", truth=True),
    Operation("and", np.logical_and, (0.0, 0.0), "and_", c="{0} && {1}", js="{0} && {1}",
              truth=True),
    Operation("or", np.logical_or, (0.0, 0.0), "or_", c="{0} || {1}", js="{0} || {1}", truth=True),
    Operation("not", np.logical_not, (0.0,), "not_", c="!{0}", js="!{0}", truth=True),
    Operation("select", lambda c, a, b: np.where(c, a, b)[()],
              (0.0, lambda o, c, a, b: select(c, 1.0, 0.0), lambda o, c, a, b: select(c, 0.0, 1.0)),
              "select", c="{0} ? {1} : {2}", js="{0} ? {1} : {2}", recurrence="choice",
              decision=lambda o, c, a, b: c),
    # functions of NumPy by these operations
    Operation("positive", formula=lambda a: a, aliases=("conjugate",)),
    Operation("square", formula=lambda a: a * a),
    Operation("reciprocal", formula=lambda a: 1.0 / a),
    Operation("greater", formula=lambda a, b: a > b),
    Operation("greater_equal", formula=lambda a, b: a >= b),
    Operation("not_equal", formula=lambda a, b: a != b),
    Operation("maximum", formula=lambda a, b: select((b <= a) | (a != a), a, b)),
    Operation("minimum", formula=lambda a, b: select((a <= b) | (a != a), a, b)),
    Operation("fmax", formula=lambda a, b: select((b <= a) | (b != b), a, b)),
    Operation("fmin", formula=lambda a, b: select((a <= b) | (b != b), a, b)),
    Operation("sign", formula=lambda a: _by_sign(a, -1.0, 1.0, 0.0)),
    Operation("heaviside", formula=lambda a, at: _by_sign(a, 0.0, 1.0, at)),
    Operation("signbit", formula=_below_zero),
    Operation("copysign", formula=lambda a, b: select(_below_zero(b), -abs(a), abs(a))),
    Operation("isnan", formula=lambda a: a != a),
    Operation("isinf", formula=lambda a: abs(a) == math.inf),
    Operation("isfinite", formula=lambda a: abs(a) <= LARGEST),
    Operation("deg2rad", formula=lambda a: a * (math.pi / 180.0)),
    Operation("rad2deg", formula=lambda a: a * (180.0 / math.pi)),
)  # fmt: skip
