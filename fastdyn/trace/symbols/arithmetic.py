"""Elementwise operations on numbers and arrays: Python's and NumPy's rules, written once.

`call` applies an operation by its name in NumPy.  Python's rules hold if all operands are numbers
of Python; then what Python would raise becomes a condition of the trace.
"""

import functools
import math
import operator
from typing import Any

import numpy as np

from ..operations import NAMES
from ..operations.domains import LARGEST
from .formulas import OnIds, divided, hypotenuse
from .lift import joint, symbol
from .symbol import HANDLERS, PYTHON, Symbol, graph_of, refuse

EXACT = float(2**53)  # floats represent all whole numbers up to this absolute value
MOST = 2**1023  # whole numbers below it have floats
IN_FLOATS = frozenset(("add", "subtract", "multiply", "divide"))  # beside a float, of floats
INDEX = float(2**31)  # limit of whole numbers that are made of real ones
SMALL_TYPES = frozenset(map(np.dtype, ("f2", "f4", "i1", "i2", "i4", "u1", "u2", "u4")))
DECIMALS = 2.0**50  # below this size, the rounding error of x 10^k is less than 1/2
SAME: dict[str, str] = {  # other names of operations
    "true_divide": "divide", "mod": "remainder", "abs": "absolute", "fabs": "absolute",
    "conj": "conjugate", "bitwise_not": "invert", "pow": "power", "float_power": "power",
    "radians": "deg2rad", "degrees": "rad2deg", "fix": "trunc",
}  # fmt: skip
LOGICAL = frozenset(("logical_and", "logical_or", "logical_xor", "logical_not"))
BITS = {"bitwise_and": "logical_and", "bitwise_or": "logical_or", "bitwise_xor": "logical_xor"}
TRUE_OR_FALSE = frozenset(
    "isnan isinf isfinite signbit less less_equal greater greater_equal equal not_equal".split()
)
ON_WHOLE: dict[str, Any] = {  # operations that whole numbers of Python compute exactly
    "add": operator.add, "subtract": operator.sub, "multiply": operator.mul,
    "divide": operator.truediv, "floor_divide": operator.floordiv, "remainder": operator.mod,
    "power": operator.pow, "negative": operator.neg, "positive": operator.pos,
    "absolute": operator.abs, "less": operator.lt, "less_equal": operator.le,
    "greater": operator.gt, "greater_equal": operator.ge, "equal": operator.eq,
    "not_equal": operator.ne, "bitwise_and": operator.and_, "bitwise_or": operator.or_,
    "bitwise_xor": operator.xor, "invert": operator.invert, "divmod": divmod,
    "left_shift": operator.lshift, "right_shift": operator.rshift,
}  # fmt: skip
KEEP_WHOLE = {*ON_WHOLE, "conjugate", "square", "maximum", "minimum", "sign"} - {"divide"}


def call(name: str, *values) -> Any:
    """An operation on numbers and arrays, by its name in NumPy."""
    name = SAME.get(name, name)
    if name in ON_WHOLE and all(map(_is_known_whole, values)):
        return ON_WHOLE[name](*[v.plain() if type(v) is Symbol else v for v in values])
    g = graph_of(*values)
    if g is None:
        return getattr(np, name)(*values)
    if any(type(v) is Symbol and not v.py and v.kind in "fc" for v in values):
        values = [_in_full(v) for v in values]
    if name in IN_FLOATS and any(type(v) is Symbol and v.kind in "fc" for v in values):
        values = [_as_float(v) for v in values]
    given = [symbol(g, v) for v in values]
    if any(s.kind == "c" for s in given):
        return HANDLERS["complex"](name, given)
    return _real(g, name, given)


def _in_full(value):
    """Numbers of 32 bits as NumPy takes them beside numbers of 64 bits; any other value as is."""
    small = isinstance(value, np.ndarray | np.generic) and type(value) is not Symbol
    return value.astype(float) if small and value.dtype in SMALL_TYPES else value


def _as_float(value):
    """A large whole number as it counts beside a real number, such as c**2 of light; others as are.

    The whole numbers that floats represent stay whole.
    """
    whole = issubclass(type(value), int | np.integer)  # isinstance asks a Symbol, which assumes
    return float(value) if whole and EXACT < abs(int(value)) < MOST else value


def _is_known_whole(value):
    """Whether a number is one of Python's whole numbers, which no state determines."""
    if type(value) is Symbol:
        return value.kind == "i" and value.py and not value.many and not value.varies
    return type(value) is int


def _real(g, name, given) -> Any:
    if name in BITS:
        if not all(s.kind == "b" for s in given):
            refuse("bits of a whole number")
        name = BITS[name]
    python = all(s.py for s in given)
    if name in LOGICAL:
        return _logical(g, name, given, python)
    if name == "invert":
        if given[0].kind != "b":
            refuse("bits of a whole number")
        return -1 - given[0] if python else call("logical_not", *given)
    kind = _python_kind(name, given) if python else numpy_kind(name, given)
    if kind == "b" and name in ("add", "maximum", "fmax"):
        return _logical(g, "logical_or", given, False)
    if kind == "b" and name in ("multiply", "minimum", "fmin"):
        return _logical(g, "logical_and", given, False)
    if name in ("equal", "not_equal") and all(s.kind == "b" for s in given):
        differ = _logical(g, "logical_xor", given, python)
        return differ if name == "not_equal" else _logical(g, "logical_not", [differ], python)
    ids = [as_numbers(g, s) for s in given]
    if name in ON_SYMBOLS:
        return ON_SYMBOLS[name](
            kind, python, *[_number(g, i, s) for i, s in zip(ids, given, strict=True)]
        )
    elif name == "hypot":
        found = hypotenuse(g, *ids)
    elif name in NAMES:
        found = OnIds(g).call(NAMES[name], *ids)
    else:
        refuse(f"{name} of what depends on the state")
    if python and name == "divide":
        _not_caught(g, given)
        g.raises_if(g.map("eq", ids[1], g.const(0.0).key), _divided_by_zero)
    if kind == "b":
        return truth(g, found, python)
    if kind == "i":
        found = _kept_whole(g, name, found)
    return Symbol(g, found, kind, python and not isinstance(found, np.ndarray))


def _number(g, ids, s):
    return s if s.kind != "b" else Symbol(g, ids, "i", s.py)


def as_numbers(g, s):
    """The ids of a symbol, truth values as 1.0 and 0.0."""
    if s.kind != "b":
        return s.ids
    return g.map("select", s.ids, g.const(1.0).key, g.const(0.0).key)


def as_truth(g, s):
    """The ids of truth values: which numbers are not 0."""
    if s.kind == "b":
        return s.ids
    if s.kind == "c":
        return (s != 0).ids
    return g.map("not", g.map("eq", s.ids, g.const(0.0).key))


def _logical(g, name, given, python):
    ids = [as_truth(g, s) for s in given]
    if name == "logical_not":
        found = g.map("not", *ids)
    elif name == "logical_xor":
        a, b = ids
        found = g.map("or", g.map("and", a, g.map("not", b)), g.map("and", g.map("not", a), b))
    else:
        found = g.map("and" if name == "logical_and" else "or", *ids)
    return truth(g, found, python)


def truth(g, ids, python=False):
    """The truth values of ids; a plain one if parameters alone determine a single value."""
    if isinstance(ids, np.ndarray):
        return Symbol(g, ids, "b")
    node = g.node(ids)
    if node.varies:
        g.conditions = True
        return Symbol(g, ids, "b", python)
    g.assume(node)
    return bool(node.value) if python else np.bool_(node.value)


# -- kinds of numbers


def _python_kind(name, given):
    if name in TRUE_OR_FALSE:
        return "b"
    return "i" if name in KEEP_WHOLE and "f" not in {s.kind for s in given} else "f"


def numpy_kind(name, given):
    """The kind of the result of a ufunc of NumPy."""
    return _kind_of_ufunc(name, tuple([(s.kind, s.py) for s in given]))


@functools.lru_cache(4096)
def _kind_of_ufunc(name, kinds):
    ufunc = getattr(np, name, None)
    if not isinstance(ufunc, np.ufunc):
        return "f"
    dtypes = [np.dtype(bool) if k == "b" else PYTHON[k] if py else np.dtype(PYTHON[k])
              for k, py in kinds]  # fmt: skip
    found = ufunc.resolve_dtypes((*dtypes, *[None] * ufunc.nout))[-1]
    if found == np.float16:  # of truth values
        found = np.dtype(float)
    if found.kind not in "bifc" or found.itemsize < (8 if found.kind != "b" else 1):
        refuse(f"np.{name} of small whole numbers, or of truth values")
    return found.kind


# -- rules of whole numbers, and of what Python raises


def _not_caught(g, given):
    """Refuse a division of whole numbers in a handler: Python's raise for zero, NumPy's do not."""
    unsure = given[1].varies or np.any(given[1].ids == g.const(0.0).key)
    if unsure and any(s.kind == "i" and s.varies for s in given) and g.in_handler():
        refuse("a division of whole numbers where an exception may be caught")


def _kept_whole(g, name, ids):
    """A result as whole numbers: no -0.0, and left to Python where a float is not exact."""
    if name in ("negative", "multiply", "remainder"):
        ids = g.map("add", ids, g.const(0.0).key)
    if name in ("multiply", "power"):
        too_large = g.map("lt", g.const(EXACT).key, g.map("abs", ids))
        g.leaves_to_python_if(g.anywhere(too_large))
    return ids


def to_whole(s, how="trunc"):
    """A number, or an array, as whole numbers; beyond 2**31 the call is left to Python."""
    g = s.g
    if s.kind in "bi":
        return Symbol(g, as_numbers(g, s), "i", s.py)
    ids = g.map(how, s.ids)
    size = g.map("abs", ids)
    if not s.many and g.in_handler():
        g.raises_if(g.map("not", g.map("eq", ids, ids)), lambda: int(math.nan))
        g.raises_if(g.map("eq", size, g.const(math.inf).key), lambda: int(math.inf))
    within = g.map("le", size, g.const(INDEX).key)
    g.leaves_to_python_if(g.anywhere(g.map("not", within)))
    return Symbol(g, g.map("add", ids, g.const(0.0).key), "i", not s.many)


def _divmod(kind, python, a, b):
    g = a.g
    if python:
        _not_caught(g, [a, b])
        g.raises_if(g.map("eq", b.ids, g.const(0.0).key), _divided_by_zero)
    found = divided(g, a.ids, b.ids)
    if kind == "i" and not python:  # NumPy's whole numbers give 0 for a division by zero
        zero = g.const(0.0).key
        found = [g.map("select", g.map("eq", b.ids, zero), zero, ids) for ids in found]
    return tuple([Symbol(g, ids, kind, python) for ids in found])


def _power(kind, python, a, e):
    g, known = a.g, not e.many and not e.varies
    whole = a.kind == e.kind == "i"
    value = e.node.value if known else 0.0
    if whole and not a.varies and not known:
        refuse("a power of whole numbers")
    if whole and known and value < 0:
        refuse("a negative power of a whole number")  # NumPy raises, Python gives a float
    if whole and not known:
        g.leaves_to_python_if(g.anywhere(g.map("lt", e.ids, g.const(0.0).key)))
    if known and 2 * value == np.rint(2 * value):
        g.assume(e.node)
        ids = power(g, a.ids, value)
    else:
        ids = g.map("pow", a.ids, e.ids)
    if whole:
        ids = _kept_whole(g, "power", ids)
    elif python:
        _note_power(g, a.ids, e, ids, known, value)
    return Symbol(g, ids, kind if not python else "i" if whole else "f", python)


def power(g, ids, e):
    """The ids of a number, or an array, to a plain power: products and roots if e is small."""
    if not isinstance(ids, np.ndarray):
        return g.power(g.node(ids), e).key
    if ids.size <= g.few:
        flat = [g.power(g.node(i), e).key for i in ids.ravel().tolist()]
        return g.map("add", np.array(flat, ids.dtype).reshape(ids.shape), g.const(0.0).key)
    return _long_power(g, ids, float(e))


def _long_power(g, ids, e):
    if e != e or abs(e) > 16 or 2 * e != int(2 * e):
        return g.map("pow", ids, g.const(e).key)
    if e < 0:
        return g.map("div", g.const(1.0).key, _long_power(g, ids, -e))
    result: Any = g.map("sqrt", ids) if e != int(e) else None
    square, k = ids, int(e)
    while k:
        if k & 1:
            result = square if result is None else g.map("mul", square, result)
        k >>= 1
        square = g.map("mul", square, square) if k else None
    return np.full_like(ids, g.const(1.0).key) if result is None else result


def _note_power(g, a, e, result, known, value):
    """The conditions under which a power of Python raises, or is left to Python."""
    zero, m = g.const(0.0).key, g.map
    negative = m("lt", a, zero)
    if not known or value != np.rint(value):
        if not known:
            whole = m("eq", m("floor", e.ids), e.ids)
            negative = m("and", negative, m("not", whole))
        g.leaves_to_python_if(g.node(negative))  # Python gives a complex number
    if not known or value < 0:
        at_zero = m("eq", a, zero)
        if not known:
            at_zero = m("and", at_zero, m("lt", e.ids, zero))
        g.raises_if(at_zero, _zero_to_a_negative_power)
    if g.node(result).op in ("pow", "sqrt", "mul", "div"):
        finite = m("and", *[m("le", m("abs", i), g.const(LARGEST).key) for i in (a, e.ids)])
        much = m("not", m("le", m("abs", result), g.const(LARGEST).key))
        g.raises_if(m("and", much, finite), _too_large_a_power)


ON_SYMBOLS: dict[str, Any] = {  # formulas (kind of the result, Python's rules?, *symbols)
    "divmod": _divmod,
    "floor_divide": lambda *given: _divmod(*given)[0],
    "remainder": lambda *given: _divmod(*given)[1],
    "power": _power,
}


def to_decimals(a, digits):
    """round(a, digits); near a tie, and for large values, a Python float is left to Python."""
    digits = operator.index(digits)
    factor = 10.0 ** abs(digits)
    scaled = a * factor if digits > 0 else a / factor
    whole = call("rint", scaled)
    if a.py:
        g = a.g
        away, size = abs(scaled - whole), abs(scaled)
        certain = (away < 0.5 - size * (2 * np.finfo(float).eps)) & (size < DECIMALS)
        if type(certain) is Symbol:
            g.leaves_to_python_if(g.negation(certain.node))
    return whole / factor if digits > 0 else whole * factor


# -- selections and conversions


def where(condition, a, b) -> Any:
    """`a` where the condition holds, else `b`."""
    g = graph_of(condition, a, b)
    if g is None:
        return np.where(condition, a, b)
    condition, a, b = (symbol(g, v) for v in (condition, a, b))
    ids = as_truth(g, condition)
    python = condition.py and a.py and b.py
    if a.kind == b.kind == "b":
        return truth(g, g.map("select", ids, a.ids, b.ids), python)
    if "c" in (a.kind, b.kind):
        parts = [where(condition, a.part(i), b.part(i)) for i in (0, 1)]
        return joint(*parts)
    kind = "f" if "f" in (a.kind, b.kind) else "i"
    found = g.map("select", ids, as_numbers(g, a), as_numbers(g, b))
    return Symbol(g, found, kind, python)


def choose(condition, a, b):
    """`a` if a condition of Python holds, else `b`: numbers, whose kinds stay if they are equal."""
    if type(condition) is not Symbol:
        return a if condition else b
    return where(condition, a, b)


def cast(g, value, kind, casting) -> Any:
    """The ids of a value, converted to a kind of numbers."""
    s = symbol(g, value)
    if s.kind == kind:
        return s.ids
    if casting != "unsafe" and not np.can_cast(np.dtype(s.kind + "8" if s.kind != "b" else bool),
                                               np.dtype(PYTHON[kind]), casting):  # fmt: skip
        raise TypeError(f"Cannot cast array data from {s.kind} to {kind} by '{casting}'")
    if s.kind == "c":
        refuse("complex numbers where real ones are needed")
    if kind == "c":
        return joint(Symbol(g, as_numbers(g, s)), symbol(g, 0.0)).ids
    if kind == "b":
        return as_truth(g, s)
    return as_numbers(g, s) if (kind == "f" or s.kind == "b") else to_whole(s).ids


def stored(result, out) -> Any:
    """Store a result in `out`, if `out` is given, and return it."""
    if isinstance(out, tuple):
        (out,) = out
    if out is None:
        return result
    if type(out) is not Symbol:
        refuse("a result that depends on the state is stored in an array from outside")
    found = symbol(out.g, result)
    shape = found.ids.shape if found.many else ()
    if found.many and shape != out.ids.shape:
        if np.broadcast_shapes(shape, out.ids.shape) != out.ids.shape:
            raise ValueError("non-broadcastable output operand")
    out.put(..., cast(out.g, found, out.kind, "same_kind"))
    return out


HANDLERS["cast"] = cast


def _divided_by_zero():
    """Raise ZeroDivisionError with Python's message."""
    return 1.0 / 0.0


def _zero_to_a_negative_power():
    """Raise ZeroDivisionError with Python's message."""
    return 0.0**-1.0


def _too_large_a_power():
    """Raise OverflowError with Python's message."""
    return 10.0**400.0
