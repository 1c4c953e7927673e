"""NumPy's ufuncs on numbers, some of which are symbols."""

import functools
import operator

import numpy as np

from ..graph.kinds import INT, NUMPY
from ..symbols.complex_functions import of_complex, power
from ..symbols.complex_pair import is_complex, total
from ..symbols.conditions import Condition, both, either, negated, select
from ..symbols.real import Symbol, by_name, symbol
from ..symbols.symbolic import Symbolic, graph_of, refuse

LARGE, SMALL = 1e300, 1e-280  # the square root of a sum of squares in this range is accurate


def _not(a):
    a = a != 0 if isinstance(a, Symbol) else a
    return negated(a)


def _inverted(a):
    return negated(a) if isinstance(a, Condition) else ~a


def _of_symbol(function):
    """A function of numbers that first converts its first argument to a Symbol."""
    return lambda a, *rest: function(symbol(graph_of((a, *rest)), a), *rest)


def maximum(a, b):
    """The larger number; NaN if either is NaN."""
    return select((a >= b) | a.nan(), a, b)


def minimum(a, b):
    return select((a <= b) | a.nan(), a, b)


def _fmax(a, b):
    b = symbol(a.g, b)
    return select((a >= b) | b.nan(), a, b)


def _fmin(a, b):
    b = symbol(a.g, b)
    return select((a <= b) | b.nan(), a, b)


def _sign(a):
    return select(a > 0, 1.0, select(a < 0, -1.0, select(a.nan(), a, 0.0)))


def _heaviside(a, at):
    return select(a < 0, 0.0, select(a > 0, 1.0, select(a.nan(), a, at)))


def _fmod(a, b):
    return a.call("fmod", symbol(a.g, b))


def _copysign(a, b):
    return select(_signbit(symbol(a.g, b)), -abs(a), abs(a))


def _signbit(a):
    return (a < 0) | ((a == 0) & (1.0 / a.as_numpy() < 0))


def hypotenuse(a, *others):
    """The square root of a sum of squares, valid if no square overflows or underflows."""
    squares = total([v * v for v in (a, *others)])
    g, node = squares.g, squares.node
    g.stays_below(g.compare(node, g.const(LARGE), "gt"))
    nonzero = g.false
    for v in (a, *others):
        zero = g.compare(symbol(g, v).node, g.const(0.0), "eq")
        nonzero = g.both(nonzero, g.negation(zero), "or")
    g.stays_below(g.both(g.compare(node, g.const(SMALL), "lt"), nonzero))
    return squares.call("sqrt")


BY_OPERATOR = {
    "add": operator.add, "subtract": operator.sub, "multiply": operator.mul,
    "divide": operator.truediv, "true_divide": operator.truediv, "power": operator.pow,
    "float_power": operator.pow, "pow": operator.pow, "remainder": operator.mod,
    "mod": operator.mod, "floor_divide": operator.floordiv, "greater": operator.gt,
    "greater_equal": operator.ge, "less": operator.lt, "less_equal": operator.le,
    "equal": operator.eq, "not_equal": operator.ne, "logical_and": both, "logical_or": either,
    "bitwise_and": operator.and_, "bitwise_or": operator.or_, "bitwise_xor": operator.xor,
    "logical_xor": operator.xor, "logical_not": _not, "invert": _inverted,
    "bitwise_not": _inverted, "negative": operator.neg, "positive": operator.pos,
    "absolute": abs, "abs": abs, "divmod": divmod,
}  # fmt: skip
BY_FORMULA = {
    "fabs": abs, "square": lambda a: a * a, "reciprocal": lambda a: 1.0 / a, "sign": _sign,
    "floor": lambda a: a.to_whole("floor"), "ceil": lambda a: a.to_whole("ceil"),
    "trunc": lambda a: a.to_whole("trunc"), "rint": lambda a: a.to_whole("rint"),
    "fix": lambda a: a.to_whole("trunc"), "heaviside": _heaviside, "maximum": maximum,
    "minimum": minimum, "fmax": _fmax, "fmin": _fmin, "fmod": _fmod, "copysign": _copysign,
    "signbit": _signbit,
    "hypot": hypotenuse, "isnan": Symbol.nan, "isfinite": Symbol.finite,
    "isinf": lambda a: abs(a) == np.inf, "conjugate": Symbol.conjugate, "conj": Symbol.conjugate,
    "deg2rad": lambda a: a * (np.pi / 180.0), "radians": lambda a: a * (np.pi / 180.0),
    "rad2deg": lambda a: a * (180.0 / np.pi), "degrees": lambda a: a * (180.0 / np.pi),
}  # fmt: skip


def is_known(name):
    """Whether a ufunc has a formula in this file, or is an operation of the graph."""
    return name in BY_OPERATOR or name in BY_FORMULA or by_name(name) is not None


def _is_whole(value):
    return isinstance(value, Symbol) and value.kind == INT


def _is_exact(value):
    return _is_whole(value) or (isinstance(value, int) and not isinstance(value, bool))


@functools.lru_cache(256)
def of_numbers(ufunc):
    """A ufunc as a function of numbers, some of which may be symbols."""
    name = ufunc.__name__
    by_operator = BY_OPERATOR.get(name)
    by_formula = BY_FORMULA.get(name)
    known = _of_symbol(by_formula) if by_formula else by_name(name)

    def function(*values):
        if not any(isinstance(v, Symbolic) for v in values):
            return ufunc(*values)
        if any(isinstance(v, np.integer) for v in values) and any(map(_is_whole, values)):
            refuse("whole numbers of NumPy, which have a width")
        # a NumPy number beside a symbol would call the ufunc again
        values = [v.item() if isinstance(v, np.generic) else v for v in values]
        values = [v.as_numpy() if isinstance(v, Condition) else v for v in values]
        of_complexes = any(map(is_complex, values))
        if of_complexes and by_operator is operator.pow:
            result = power(*values)
        elif by_operator is not None:
            result = by_operator(*values)
        elif of_complexes:
            result = of_complex(name)(*values)
        elif known is None:
            refuse(f"{name} of what depends on the state")
        else:
            result = known(*values)
        if isinstance(result, Symbol) and all(isinstance(v, Condition | bool) for v in values):
            if name in ("maximum", "minimum", "fmax", "fmin"):
                refuse(f"{name} of truth values")  # NumPy returns a truth value, not a number
        if not isinstance(result, Symbol) or (result.kind == INT and all(map(_is_exact, values))):
            return result
        return Symbol(result.g, result.node, NUMPY)

    return function
