"""Python's builtins and the functions of `math`, on symbols."""

import builtins
import functools
import math
import operator
from typing import Any

import numpy as np

from ...operations import NAMES
from ..graph.kinds import FLOAT, INT
from ..symbols.arrays import Array, elementwise
from ..symbols.complex_functions import made
from ..symbols.complex_pair import Pair, total
from ..symbols.conditions import Condition, both, either, select
from ..symbols.instances import of_type
from ..symbols.masks import Masked
from ..symbols.real import Symbol, symbol
from ..symbols.symbolic import Batched, Symbolic, graph_of, is_symbolic, refuse
from .constants import Constants
from .of_numbers import BY_FORMULA, hypotenuse
from .plain_arrays import number


class _PlainType(type):
    """The metaclass of types that replace float, int, ...; symbols count as their instances."""

    def __instancecheck__(cls, value):
        if isinstance(value, Symbol) and cls.plain is not type:
            return cls.plain is (int if value.kind == INT else float)
        if isinstance(value, Pair):
            return cls.plain is complex
        return isinstance(value, cls.plain)

    def __subclasscheck__(cls, other):
        return issubclass(other, cls.plain)

    def __eq__(cls, other):
        return other is cls or other is cls.plain

    def __hash__(cls):
        return hash(cls.plain)

    def __getattr__(cls, name):
        return getattr(cls.plain, name)


class Float(metaclass=_PlainType):
    plain = float

    def __new__(cls, value: Any = 0.0):
        value = number(value)
        if not isinstance(value, Symbolic):
            return float(value)
        found = symbol(value.g, value)
        return Symbol(found.g, found.node, FLOAT)


class Int(metaclass=_PlainType):
    plain = int

    def __new__(cls, value: Any = 0, *base):
        value = number(value)
        if not isinstance(value, Symbolic):
            return int(value, *base)
        found = symbol(value.g, value)
        return found if found.kind == INT else found.__trunc__()


class Complex(metaclass=_PlainType):
    plain = complex

    def __new__(cls, *given, **named):
        return made(*map(number, given), **named)


class Type(metaclass=_PlainType):
    plain = type

    def __new__(cls, value, *more):
        if isinstance(value, Symbolic):
            refuse("it asks for the type of what depends on the state")
        ours = isinstance(value, Batched | Masked | Array | Constants)
        return np.ndarray if ours else type(value, *more)


def _extreme(plain, sign):
    def function(*args, **kwargs):
        items = list(map(number, args[0] if len(args) == 1 else args))
        g = graph_of(items)
        if g is None:
            return plain(items, **kwargs)
        if kwargs:
            refuse(f"{plain.__name__} with a key")
        best = items[0]
        for item in items[1:]:  # the first of equal items, as in Python
            best = select(sign(symbol(g, item), best), item, best)
        kinds = {symbol(g, item).kind for item in items}
        # a result of several kinds counts as Python's float: a division by zero then raises
        return Float(best) if len(kinds) > 1 and isinstance(best, Symbol) else best

    return function


def _sum(values, /, start=0):
    values = [start, *values]
    plain = (int, float, np.number, Symbol, Condition)
    if is_symbolic(values) and all(isinstance(v, plain) for v in values):
        return total(values)
    return functools.reduce(operator.add, values)


def varies(value):
    """Whether a symbolic value depends on t, y or a parameter that varies."""
    found = value.number()
    return found is None or found.node.varies


def _exact_sum(values):
    """math.fsum of at most two numbers, whose plain sum is correctly rounded, too."""
    values = list(values)
    if not any(isinstance(v, Symbolic) and varies(v) for v in values):
        return math.fsum(map(float, values))  # the values become constants of the code
    if len(values) > 2:
        refuse("math.fsum of what depends on the state")
    return Float(_sum(values))


def bool_of(value=False):
    if isinstance(value, Symbol):
        value = value != 0
    return _of_python(value) if isinstance(value, Condition) else bool(value)


def _of_python(truth):
    """A truth value as a bool of Python."""
    return truth.g.condition(truth.node, True) if isinstance(truth, Condition) else truth


vars(bool_of)["plain"] = bool  # so that `dtype=bool` works


def _sorted(values, **kwargs):
    values = list(values)
    if is_symbolic(values):
        refuse("sorted() of what depends on the state")
    return sorted(values, **kwargs)


def _pow(a, b, *modulo):
    if modulo and is_symbolic([a, b, *modulo]):
        refuse("a power modulo a number")
    return a**b if is_symbolic([a, b]) else pow(a, b, *modulo)


def impure(name):
    """A function that refuses: it replaces a function with a side effect."""
    return lambda *_, **__: refuse(f"it calls {name}", effect=True)


BUILTINS = {
    "float": Float, "int": Int, "complex": Complex, "type": Type, "max": _extreme(max, operator.gt),
    "min": _extreme(min, operator.lt), "sum": _sum, "bool": bool_of, "pow": _pow,
    "any": lambda values: _of_python(functools.reduce(either, values, False)),
    "all": lambda values: _of_python(functools.reduce(both, values, True)),
    "sorted": _sorted, "isinstance": of_type,
    **{
        name: impure(name)
        for name in "print open input exec eval globals setattr delattr vars id hash".split()
    },
}  # fmt: skip


def _of_math(name, plain):
    """A function of `math` on symbols; like `math`, it returns Python floats and raises."""
    formula = {
        "fabs": abs, "floor": math.floor, "ceil": math.ceil, "trunc": math.trunc, "fmod": None,
        "degrees": BY_FORMULA["degrees"], "radians": BY_FORMULA["radians"],
        "isnan": Symbol.nan, "isfinite": Symbol.finite, "isinf": BY_FORMULA["isinf"],
        "copysign": BY_FORMULA["copysign"],
    }.get(name)  # fmt: skip

    def function(*values):
        values = [number(v) for v in values]
        if not is_symbolic(values):
            return plain(*values)
        g = graph_of(values)
        first, *others = [symbol(g, v) for v in values]
        if formula is not None:
            result = formula(first, *others)
        elif name not in NAMES:
            refuse(f"math.{name} of what depends on the state")
        elif name == "log" and others:
            result = function(first) / function(others[0])
        else:
            result = first.call(NAMES[name], *others, python=True)
        whole = name in ("floor", "ceil", "trunc")
        return _of_python(result) if whole or isinstance(result, Condition) else Float(result)

    return function


def _distance(p, q):
    return Float(hypotenuse(*(a - b for a, b in zip(p, q, strict=True))))


def _math_power(a, b):
    return Float(a) ** Float(b) if is_symbolic([a, b]) else math.pow(a, b)


MATH = {
    **{k: _of_math(k, v) for k, v in vars(math).items() if builtins.callable(v) and k[0] != "_"},
    "pow": _math_power,
    "fsum": _exact_sum,
    "dist": lambda p, q: _distance(p, q) if is_symbolic([p, q]) else math.dist(p, q),
    "hypot": lambda *v: Float(hypotenuse(*v)) if is_symbolic(v) else math.hypot(*v),
    "prod": lambda values, start=1: functools.reduce(operator.mul, values, start),
}


def vectorized(function, *options, **more):
    """np.vectorize without options."""
    if options or any(v not in (None, False, "") for v in more.values()):
        refuse("np.vectorize with options")

    def of_arrays(*args):
        result = elementwise(function, *args)
        whole = [_is_whole(v) for v in np.asarray(result, dtype=object).flat]
        if any(whole) and not all(whole):
            refuse("np.vectorize of a function that gives whole numbers, too")
        return result

    return of_arrays


def _is_whole(value):
    if isinstance(value, Symbol):
        return value.kind == INT
    return isinstance(value, bool | int | np.integer | np.bool_ | Condition)
