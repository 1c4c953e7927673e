"""Operations on complex numbers and arrays, as formulas of real symbols; principal values."""

import math
from typing import Any

from .arithmetic import call, where
from .lift import joint
from .symbol import HANDLERS, Symbol, constant, refuse


def _parts(z):
    return z.part(0), z.part(1)


def _is_zero(s):
    """Whether a real symbol is the constant 0."""
    if s.many:
        i = s.ids.flat[0] if s.ids.size else 0
        return bool(s.ids.size) and bool((s.ids == i).all()) and _is_zero(Symbol(s.g, int(i)))
    node = s.node
    return node.op == "const" and node.data == 0


def product(a, b) -> Any:
    """a times b; None if a factor is the constant 0."""
    return None if _is_zero(a) or _is_zero(b) else a * b


def _sum(a, b, like, minus=False):
    if b is None:
        return constant(like.g, 0.0, like.part(0).ids) if a is None else a
    if a is None:
        return -b if minus else b
    return a - b if minus else a + b


def _mul(x, y):
    a, b = _parts(x)
    c, d = _parts(y)
    like = x if x.many else y
    real = _sum(product(a, c), product(b, d), like, True)
    imag = _sum(product(a, d), product(b, c), like)
    return joint(real, imag)


def _div(x, y):
    if y.kind != "c" or _is_zero(y.part(1)):
        return joint(x.part(0) / y.part(0), x.part(1) / y.part(0))
    c, d = _parts(y)
    size = c * c + d * d
    top = _mul(x, _conj(y))
    return joint(top.part(0) / size, top.part(1) / size)


def _conj(z):
    return joint(z.part(0), -z.part(1)) if z.kind == "c" else z


def _phase(z):
    return call("arctan2", z.part(1), z.part(0))


def _abs(z):
    return call("hypot", *_parts(z))


def _exp(z):
    size = call("exp", z.part(0))
    return joint(size * call("cos", z.part(1)), size * call("sin", z.part(1)))


def _log(z):
    return joint(call("log", _abs(z)), _phase(z))


def _sqrt(z):
    """The root with real part u >= 0, computed without cancellation."""
    a, b = _parts(z)
    u = call("sqrt", (_abs(z) + abs(a)) * 0.5)
    v = where(call("equal", u, 0.0), 0.0, call("divide", b, 2.0 * u))
    right = call("greater_equal", a, 0.0)
    root = call("copysign", u, b)
    return joint(where(right, u, abs(v)), where(right, v, root))


def _by_angles(f, g, h, k, minus=False):
    """(f(a) g(b), h(a) k(b)) for a + i b; the second part with the sign turned, if `minus`."""

    def function(z):
        a, b = _parts(z)
        imag = call(h, a) * call(k, b)
        return joint(call(f, a) * call(g, b), -imag if minus else imag)

    return function


def power(base, exponent):
    """base ** exponent; products for a small whole exponent."""
    known = not exponent.many and not exponent.varies
    if known and (exponent.kind != "c" or _is_zero(exponent.part(1))):
        value = exponent.part(0).node.value
        if value == int(value) and abs(value) <= 16:
            exponent.g.assume(exponent.part(0).node)
            one = joint(
                constant(base.g, 1.0, base.part(0).ids), constant(base.g, 0.0, base.part(0).ids)
            )
            result = one
            for _ in range(abs(int(value))):
                result = _mul(result, base)
            return result if value >= 0 else _div(one, result)
    found = _exp(_mul(_log(base), exponent))
    zero = call("logical_and", call("equal", base.part(0), 0.0), call("equal", base.part(1), 0.0))
    at_zero = where(call("greater", exponent.part(0), 0.0), 0.0, math.nan)
    return joint(*[where(zero, at_zero, part) for part in _parts(found)])


def _real_pair(op):
    return lambda x, y: joint(call(op, x.part(0), y.part(0)), call(op, x.part(1), y.part(1)))


def _equal(x, y):
    same = [call("equal", *both) for both in zip(_parts(x), _parts(y), strict=True)]
    return call("logical_and", *same)


_sin = _by_angles("sin", "cosh", "cos", "sinh")
_cos = _by_angles("cos", "cosh", "sin", "sinh", True)
_sinh = _by_angles("sinh", "cos", "cosh", "sin")
_cosh = _by_angles("cosh", "cos", "sinh", "sin")
FUNCTIONS: dict[str, Any] = {
    "add": _real_pair("add"), "subtract": _real_pair("subtract"), "multiply": _mul, "divide": _div,
    "power": power, "equal": _equal, "not_equal": lambda x, y: call("logical_not", _equal(x, y)),
    "negative": lambda z: joint(-z.part(0), -z.part(1)), "positive": lambda z: z,
    "absolute": _abs, "conjugate": _conj, "square": lambda z: _mul(z, z),
    "reciprocal": lambda z: call("divide", 1.0, z), "exp": _exp, "log": _log, "sqrt": _sqrt,
    "sin": _sin, "cos": _cos, "sinh": _sinh, "cosh": _cosh, "tan": lambda z: _sin(z) / _cos(z),
    "tanh": lambda z: _sinh(z) / _cosh(z), "log10": lambda z: _log(z) / math.log(10.0),
    "log2": lambda z: _log(z) / math.log(2.0), "exp2": lambda z: _exp(z * math.log(2.0)),
    "expm1": lambda z: _exp(z) - 1.0,
    "isnan": lambda z: call("logical_or", *[call("isnan", part) for part in _parts(z)]),
    "isfinite": lambda z: call("logical_and", *[call("isfinite", part) for part in _parts(z)]),
    "phase": _phase,
}  # fmt: skip


def of_complex(name: str, given) -> Any:
    """An operation on numbers and arrays, some of which are complex."""
    function = FUNCTIONS.get(name)
    if function is None:
        refuse(f"{name} of complex numbers")
    given = [s if s.kind != "b" else s + 0.0 for s in given]
    found = function(*given)
    if type(found) is Symbol and not found.many:
        found.py = all(s.py for s in given)
    return found


HANDLERS["complex"] = of_complex
