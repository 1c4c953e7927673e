"""Arithmetic, roots, rounding, comparisons, logic and selection."""

import math
import operator

import numpy as np

from .domains import outside
from .record import Operation, add


def _one(g, o, *_):
    return g.const(1.0)


def _minus_one(g, o, *_):
    return g.const(-1.0)


def _itself(g, o, *_):
    return o


def _sign(g, o, a):
    return g.select(g.compare(a, g.const(0.0), "lt"), g.const(-1.0), g.const(1.0))


def _inverse(g, o, a, b):
    return g.div(g.const(1.0), b)


add(
    Operation("add", operator.add, (_one, _one), "fadd", "+", recurrence="linear"),
    Operation("sub", operator.sub, (_one, _minus_one), "fsub", "-", recurrence="linear"),
    Operation("neg", np.negative, (_minus_one,), "fneg", recurrence="linear"),
    Operation(
        "mul", operator.mul, (lambda g, o, a, b: b, lambda g, o, a, b: a), "fmul", "*",
        recurrence="product",
    ),
    Operation(
        "div", np.true_divide, (_inverse, lambda g, o, a, b: g.neg(g.mul(o, _inverse(g, o, a, b)))),
        "fdiv", "/", cost=4, recurrence="quotient",
    ),
    Operation(
        "sqrt", np.sqrt, (lambda g, o, a: g.div(g.const(0.5), o),), "llvm.sqrt", cost=4,
        in_math=math.sqrt, raises=outside("lt", 0.0), recurrence="root", root=True,
    ),
    Operation("abs", np.abs, (_sign,), "llvm.fabs", recurrence="choice", kinked=True),
    *[
        Operation(
            name, getattr(np, name), (None,), f"llvm.{name}", whole=True, decision=_itself,
            words="rounding to a whole number",
        ) for name in ("floor", "ceil", "rint", "trunc")
    ],
    *[
        Operation(name, value, (None, None), sign=sign, truth=True)
        for name, value, sign in (
            ("lt", np.less, "<"), ("le", np.less_equal, "<="), ("eq", np.equal, "=="),
        )
    ],
    Operation("and", np.logical_and, (None, None), "and_", truth=True),
    Operation("or", np.logical_or, (None, None), "or_", truth=True),
    Operation("not", np.logical_not, (None,), "not_", truth=True),
    Operation(
        "select", lambda c, a, b: np.where(c, a, b)[()],
        (
            None,
            lambda g, o, c, a, b: g.select(c, g.const(1.0), g.const(0.0)),
            lambda g, o, c, a, b: g.select(c, g.const(0.0), g.const(1.0)),
        ),
        "select", recurrence="choice", decision=lambda g, o, c, a, b: c,
    ),
)  # fmt: skip
