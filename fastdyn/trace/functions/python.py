"""Python's builtins, and the functions of `math`, `cmath` and `bisect`, on symbols."""

import bisect
import builtins
import cmath
import functools
import math
import operator
from typing import Any

import numpy as np

from ..operations import NAMES, OPERATIONS
from ..operations.value import Value
from ..symbols.arithmetic import as_numbers, call, choose, to_whole
from ..symbols.constants import Constants
from ..symbols.formulas import hypotenuse
from ..symbols.lift import joint, number, symbol
from ..symbols.lookup import look_up
from ..symbols.masks import Masked
from ..symbols.symbol import PYTHON, Symbol, graph_of, is_symbolic, refuse
from .sequences import bisected
from .ufuncs import as_numpy

BY_CALL = {  # functions of `math`: names of operations
    "fabs": "absolute", "degrees": "rad2deg", "radians": "deg2rad",
    "isnan": "isnan", "isfinite": "isfinite", "isinf": "isinf", "copysign": "copysign",
}  # fmt: skip


def python_number(value, kind="f"):
    """A number under Python's rules."""
    if isinstance(value, np.generic):
        return PYTHON[kind](value)
    return Symbol(value.g, value.ids, value.kind, True) if type(value) is Symbol else value


class _PlainType(type):
    """The metaclass of types that replace float, int, ...; symbols count as their instances."""

    def __instancecheck__(cls, value):
        return isinstance(value, cls.plain)

    def __subclasscheck__(cls, other):
        return issubclass(getattr(other, "plain", other), cls.plain)

    def __eq__(cls, other):
        return other is cls or other is cls.plain

    def __hash__(cls):
        return hash(cls.plain)

    def __getattr__(cls, name):
        return getattr(cls.plain, name)


class Float(metaclass=_PlainType):
    plain = float

    def __new__(cls, value: Any = 0.0) -> Any:
        value = number(value)
        if type(value) is not Symbol:
            return float(value)
        if value.many or value.kind == "c":
            raise TypeError("only length-1 arrays can be converted to Python scalars")
        return Symbol(value.g, as_numbers(value.g, value), "f", True)


class Int(metaclass=_PlainType):
    plain = int

    def __new__(cls, value: Any = 0, *base) -> Any:
        value = number(value)
        if type(value) is not Symbol:
            return int(value, *base)
        if value.many or value.kind == "c":
            raise TypeError("only length-1 arrays can be converted to Python scalars")
        found = to_whole(value)
        return Symbol(found.g, found.ids, "i", True)


class Complex(metaclass=_PlainType):
    plain = complex

    def __new__(cls, real: Any = 0.0, imag: Any = 0.0) -> Any:
        real = number(real)
        imag = number(imag)
        g = graph_of(real, imag)
        if g is None:
            return complex(real, imag)
        a, b = (symbol(g, v) for v in (real, imag))
        if a.kind == b.kind == "c":
            found = joint(a.part(0) - b.part(1), a.part(1) + b.part(0))
        elif a.kind == "c":
            found = a if type(imag) is float and imag == 0.0 else joint(a.part(0), a.part(1) + b)
        else:
            found = joint(a - b.part(1), b.part(0)) if b.kind == "c" else joint(*map(Float, (a, b)))
        return Symbol(g, found.ids, "c", True)


class Type(metaclass=_PlainType):
    plain = type

    def __new__(cls, value, *more):
        if type(value) is Symbol and not value.many:
            refuse("it asks for the type of what depends on the state")
        return np.ndarray if type(value) in (Symbol, Masked, Constants) else type(value, *more)


def extreme(plain, first):
    """max or min: the first of equal items, as in Python."""

    def function(*args, **kwargs):
        items = list(map(number, args[0] if len(args) == 1 else args))
        if graph_of(items) is None:
            return plain(items, **kwargs)
        if kwargs:
            refuse(f"{plain.__name__} with a key")
        best = items[0]
        for item in items[1:]:
            best = choose(first(item, best), item, best)
        # a result of several kinds counts as Python's float: a division by zero then raises
        return (
            Symbol(best.g, best.ids, best.kind, True)
            if _mixed(items) and type(best) is Symbol
            else best
        )

    return function


def _mixed(items):
    return len({(s.kind, s.py) for s in map(functools.partial(symbol, graph_of(items)), items)}) > 1


def total(values, /, start=0):
    """The sum of an iterable."""
    values = [*values]
    found = start
    if len(values) > 8 and _are_reals(values) and type(start) in (int, float):
        return _sum_of_reals([start, *values])
    for value in values:
        found = found + value
    return found


def _are_reals(values):
    return all(type(v) in (int, float) or (type(v) is Symbol and not v.many and v.kind in "fi")
               for v in values) and is_symbolic(values)  # fmt: skip


def _sum_of_reals(values):
    g = graph_of(values)
    each = [symbol(g, v) for v in values]
    node = g.sum([s.node for s in each])
    kind = "f" if any(s.kind == "f" for s in each[1:]) else each[-1].kind
    return Symbol(g, node.key, kind, all(s.py for s in each))


def _exact_sum(values):
    """math.fsum of at most two numbers, whose plain sum is correctly rounded, too."""
    values = list(values)
    if not any(type(v) is Symbol and v.varies for v in values):
        return math.fsum(map(float, values))  # the values become constants of the code
    if len(values) > 2:
        refuse("math.fsum of what depends on the state")
    return Float(total(values))


class Bool(metaclass=_PlainType):
    plain = bool

    def __new__(cls, value: Any = False) -> Any:
        if type(value) is Symbol and not value.many:
            return python_truth(value if value.kind == "b" else value != 0)
        return bool(value)


def python_truth(truth):
    return Symbol(truth.g, truth.ids, "b", True) if type(truth) is Symbol else bool(truth)


def _folded(name, start):
    def function(values):
        found: Any = start
        for value in values:
            if type(value) is Symbol and (value.many or value.kind != "b"):
                value = Bool(value) if not value.many else bool(value)
            if type(value) is not Symbol and type(found) is not Symbol:
                if bool(value) != start:
                    return not start
            else:
                found = call(name, found, bool(value) if type(value) is not Symbol else value)
        return python_truth(found)

    return function


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


BUILTINS: dict[str, Any] = {
    "float": Float, "int": Int, "complex": Complex, "type": Type, "bool": Bool,
    "max": extreme(max, operator.gt), "min": extreme(min, operator.lt), "sum": total, "pow": _pow,
    "any": _folded("logical_or", False), "all": _folded("logical_and", True), "sorted": _sorted,
    **{
        name: impure(name)
        for name in "print open input exec eval globals setattr delattr vars id hash".split()
    },
}  # fmt: skip


class _Indexed:
    def __getitem__(self: Any, i) -> Any:
        if type(i) is Symbol:
            return look_up(list(self), i)
        found = super().__getitem__(i)  # pyright: ignore
        return type(self)(found) if isinstance(i, slice) else found


class List(_Indexed, list):
    """A list that accepts a symbol as an index."""


class Tuple(_Indexed, tuple):
    """A tuple that accepts a symbol as an index."""


# -- math


def _of_math(name, plain):
    """A function of `math` on symbols; like `math`, it returns Python floats and raises."""

    def function(*values):
        values = [number(v) for v in values]
        if not is_symbolic(values):
            return plain(*values)
        g = graph_of(values)
        given = [Float(symbol(g, v)) for v in values]
        if name in ("floor", "ceil", "trunc"):
            return (
                to_whole(Float(given[0]), name) if symbol(g, values[0]).kind != "i" else values[0]
            )
        if name in BY_CALL:
            found = call(BY_CALL[name], *given)
            return python_truth(found) if name[:2] == "is" else Float(found)
        operation: Any = OPERATIONS[NAMES.get(name, "")]
        if not operation.in_math:
            refuse(f"math.{name} of what depends on the state")
        if name == "log" and len(given) == 2:
            return function(given[0]) / function(given[1])
        nodes = [s.node for s in given]
        node = g.call(operation.name, *nodes)
        given = [Value(g, each) for each in (node, *nodes)]
        for condition, raising in operation.raises(operation.in_math, *given):
            g.raises_if(condition.of, raising)
        return Symbol(g, node.key, "f", True)

    return function


def _hypot(*values):
    if not is_symbolic(values):
        return math.hypot(*values)
    g = graph_of(*values)
    return Symbol(g, hypotenuse(g, *[Float(symbol(g, v)).ids for v in values]), "f", True)


def _distance(p, q):
    if not is_symbolic([p, q]):
        return math.dist(p, q)
    return _hypot(*[a - b for a, b in zip(p, q, strict=True)])


MATH: dict[str, Any] = {
    **{k: _of_math(k, v) for k, v in vars(math).items() if builtins.callable(v) and k[0] != "_"},
    "pow": lambda a, b: Float(a) ** Float(b) if is_symbolic([a, b]) else math.pow(a, b),
    "fsum": _exact_sum, "dist": _distance, "hypot": _hypot,
    "prod": lambda values, *, start=1: functools.reduce(operator.mul, values, start),
}  # fmt: skip


# -- cmath


def _of_cmath(name, plain):
    def function(*values):
        if not is_symbolic(values):
            return plain(*values)
        z = Complex(values[0])
        if name == "log" and len(values) == 2:
            return call("log", z) / call("log", Complex(values[1]))
        if name == "rect":
            size, turn = values
            return Complex(size * call("cos", turn), size * call("sin", turn))
        if name == "phase":
            return Float(call("phase", z))
        if name == "polar":
            return Float(abs(z)), Float(call("phase", z))
        if name in ("isclose",):
            refuse(f"cmath.{name} of what depends on the state")
        found = call({"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(name, name), z)
        return python_truth(found) if name[:2] == "is" else found

    return function


CMATH: dict[str, Any] = {
    name: _of_cmath(name, function)
    for name, function in vars(cmath).items()
    if callable(function) and name[0] != "_"
}
BISECT: dict[Any, Any] = {
    bisect.bisect_left: bisected(bisect.bisect_left, "left"),
    bisect.bisect_right: bisected(bisect.bisect_right, "right"),
}


def vectorized(function, *options, **more):
    """np.vectorize without options."""
    if options or any(v not in (None, False, "") for v in more.values()):
        refuse("np.vectorize with options")

    def of_arrays(*args):
        g = graph_of(*args)
        if g is None:
            return np.vectorize(function)(*args)
        given = [symbol(g, a) for a in args]
        if not any(s.many for s in given):
            return as_numpy(symbol(g, function(*given)))
        many = np.broadcast_arrays(*[s.ids for s in given])
        if many[0].size > g.few:
            return _at_once(function, args)
        each = zip(*[m.ravel().tolist() for m in many], strict=True)
        found = [function(*[Symbol(g, i, s.kind) for i, s in zip(ids, given, strict=True)])
                 for ids in each]  # fmt: skip
        kinds = {symbol(g, v).kind for v in found}
        if "i" in kinds and len(kinds) > 1:
            refuse("np.vectorize of a function that gives whole numbers, too")
        return symbol(g, found).reshape(many[0].shape)

    return of_arrays


def _at_once(function, args):
    """A function of numbers on long arrays, if the function does not decide."""
    g = graph_of(*args)
    decided = len(g.taken)
    found = function(*[as_numpy(symbol(g, a)) for a in args])
    if len(g.taken) != decided or type(found) is not Symbol:
        refuse("a function of numbers that decides, on a long array")
    return found
