"""Arithmetic, roots, rounding, comparisons, logic and selection."""

import math
import operator

import numpy as np

from .domains import outside
from .record import Operation, add
from .value import select

add(
    Operation("add", operator.add, (1.0, 1.0), "fadd", "+", recurrence="linear"),
    Operation("sub", operator.sub, (1.0, -1.0), "fsub", "-", recurrence="linear"),
    Operation("neg", np.negative, (-1.0,), "fneg", recurrence="linear"),
    Operation("mul", operator.mul, (lambda o, a, b: b, lambda o, a, b: a), "fmul", "*",
              recurrence="product"),
    Operation("div", np.true_divide, (lambda o, a, b: 1 / b, lambda o, a, b: -(o * (1 / b))),
              "fdiv", "/", cost=4, recurrence="quotient"),
    Operation("sqrt", np.sqrt, (lambda o, a: 0.5 / o,), "llvm.sqrt", cost=4, in_math=math.sqrt,
              raises=outside(lambda a: a < 0, -2.0), recurrence="root", root=True),
    Operation("abs", np.abs, (lambda o, a: select(a < 0, -1.0, 1.0),), "llvm.fabs",
              recurrence="choice", kinked=True),
    *(Operation(name, getattr(np, name), (0.0,), f"llvm.{name}", whole=True,
                decision=lambda o, a: o, words="rounding to a whole number")
      for name in ("floor", "ceil", "rint", "trunc")),
    Operation("lt", np.less, (0.0, 0.0), sign="<", truth=True),
    Operation("le", np.less_equal, (0.0, 0.0), sign="<=", truth=True),
    Operation("eq", np.equal, (0.0, 0.0), sign="==", truth=True),
    Operation("and", np.logical_and, (0.0, 0.0), "and_", truth=True),
    Operation("or", np.logical_or, (0.0, 0.0), "or_", truth=True),
    Operation("not", np.logical_not, (0.0,), "not_", truth=True),
    Operation("select", lambda c, a, b: np.where(c, a, b)[()],
              (0.0, lambda o, c, a, b: select(c, 1.0, 0.0), lambda o, c, a, b: select(c, 0.0, 1.0)),
              "select", recurrence="choice", decision=lambda o, c, a, b: c),
)  # fmt: skip
