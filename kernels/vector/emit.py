"""Formulas that write code: operators on `Lanes` emit LLVM instructions on vectors.

Each operator is one operation with one rounding.  Only `fma` fuses two operations, so that the
error of an operation can be computed.

LLVM, because Numba takes several times as long to compile an equal formula, and has no `fma`.
"""

import functools
import struct

from llvmlite import ir

from .instructions import INDEX, REAL, constant, declared, intrinsic_of, pack, splat

WHOLE = ir.IntType(64)
SIGN = 1 << 63
SHIFT = 1.5 * 2.0**52  # x + SHIFT ends in the bits of the whole number nearest to x


def _operation(real, whole, swapped=False):
    def method(self, other):
        pair = self.value, self.like(other)
        name = real if self.element == REAL else whole
        return Lanes(self.builder, getattr(self.builder, name)(*(pair[::-1] if swapped else pair)))

    return method


def _comparison(sign):
    def method(self, other):
        real = "fcmp_unordered" if sign == "!=" else "fcmp_ordered"
        name = real if self.element == REAL else "icmp_signed"
        return Lanes(self.builder, getattr(self.builder, name)(sign, self.value, self.like(other)))

    return method


class Lanes:
    """A value in each lane: doubles, whole numbers of 64 bits, or truth values.

    Arithmetic, comparisons, `where` and `bits` also take a single number instead of a vector.
    """

    __hash__ = None

    def __init__(self, builder, value):
        self.builder = builder
        self.value = value
        self.element = getattr(value.type, "element", value.type)

    def like(self, other):
        """The LLVM value of Lanes, or of a number for each lane."""
        if isinstance(other, Lanes):
            return other.value
        number = self.element(other)
        return splat(self.builder, number, self.count) if self.count else number

    @property
    def count(self):
        """The number of lanes; 0 for a single number."""
        return getattr(self.value.type, "count", 0)

    def of(self, element):
        """The LLVM type with `element` in each lane."""
        return ir.VectorType(element, self.count) if self.count else element

    __add__ = _operation("fadd", "add")
    __radd__ = _operation("fadd", "add", True)
    __sub__ = _operation("fsub", "sub")
    __rsub__ = _operation("fsub", "sub", True)
    __mul__ = _operation("fmul", "mul")
    __rmul__ = _operation("fmul", "mul", True)
    __truediv__ = _operation("fdiv", None)
    __rtruediv__ = _operation("fdiv", None, True)
    __mod__ = _operation("frem", None)
    __lshift__ = _operation(None, "shl")
    __rshift__ = _operation(None, "lshr")
    __and__ = _operation(None, "and_")
    __or__ = _operation(None, "or_")
    __xor__ = _operation(None, "xor")
    __lt__ = _comparison("<")
    __le__ = _comparison("<=")
    __gt__ = _comparison(">")
    __ge__ = _comparison(">=")
    __eq__ = _comparison("==")  # type: ignore
    __ne__ = _comparison("!=")  # type: ignore

    def __neg__(self):
        return Lanes(self.builder, self.builder.fneg(self.value))

    def __invert__(self):
        return Lanes(self.builder, self.builder.not_(self.value))

    def __abs__(self):
        return named("fabs", self)

    def choose(self, a, b):
        """a in the lanes where `self` is true, b in the others."""
        return where(self, a, b)


def named(name, x, *others):
    """Call the LLVM intrinsic `name`."""
    values = [x.value, *map(x.like, others)]
    function = intrinsic_of(x.builder, name, x.value.type, len(values))
    return Lanes(x.builder, x.builder.call(function, values))


def fma(a, b, c):
    """a b + c, rounded once; at least `a` is Lanes."""
    return named("fma", a, b, c)


def sqrt(x):
    return named("sqrt", x)


def signed(x, sign):
    """The magnitude of x with the sign of `sign`."""
    return named("copysign", x, sign)


def where(mask, a, b):
    """a in the lanes where the mask is true, b in the others: Lanes, or numbers for each lane."""
    pair = (x.value if isinstance(x, Lanes) else constant(mask.of(REAL), x) for x in (a, b))
    return Lanes(mask.builder, mask.builder.select(mask.value, *pair))


def bits(x):
    """The bits of doubles, as whole numbers."""
    return Lanes(x.builder, x.builder.bitcast(x.value, x.of(WHOLE)))


def real(x):
    """The doubles with the bits of whole numbers: the inverse of `bits`."""
    return Lanes(x.builder, x.builder.bitcast(x.value, x.of(REAL)))


def word(number):
    """The bits of a constant double, as a Python int."""
    return struct.unpack("<q", struct.pack("<d", number))[0]


def two_sum(a, b):
    """a + b exactly, as the rounded sum and its error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def fast_two_sum(a, b):
    """`two_sum` for |a| >= |b| or a = 0."""
    total = a + b
    return total, b - (total - a)


def two_product(a, b):
    """a b exactly, as the rounded product and its error."""
    product = a * b
    return product, fma(a, b, -product)


def quotient(a, a_low, b, b_low):
    """(a + a_low) / (b + b_low) as a double and a correction."""
    inverse = 1.0 / b
    ratio = a * inverse
    rest = fma(-ratio, b, a) + fma(-ratio, b_low, a_low)
    return ratio, rest * inverse


def polynomial(x, coefficients):
    """c[0] + c[1] x + ..., in pairs of terms that the processor computes in parallel."""
    while len(coefficients) > 1:
        pairs = zip(coefficients[::2], coefficients[1::2], strict=False)
        odd = coefficients[-1:] if len(coefficients) % 2 else ()
        coefficients = [*(fma(x, b, a) for a, b in pairs), *odd]
        x = x * x
    return coefficients[0]


def each_lane(builder, vectors, function):
    """The vector of ``function(numbers)``, called with the numbers of each lane."""
    result = ir.Constant(vectors[0].type, ir.Undefined)
    for i in map(INDEX, range(vectors[0].type.count)):
        found = function([builder.extract_element(x, i) for x in vectors])
        result = builder.insert_element(result, found, i)
    return result


def by_library(name, x):
    """The function `name` of the C library, called for each lane."""
    form = ir.FunctionType(REAL, [REAL])
    function = declared(x.builder.module, form, name)
    call = functools.partial(x.builder.call, function)
    return Lanes(x.builder, each_lane(x.builder, [x.value], call))


def where_any(mask, body, given):
    """body() where the mask is true, else `given`; computes body() if any lane needs the value."""
    builder = mask.builder
    word = ir.IntType(mask.value.type.count)
    some = builder.icmp_unsigned("!=", builder.bitcast(mask.value, word), word(0))
    before = builder.block
    with builder.if_then(some, likely=False):
        replaced = [where(mask, a, b) for a, b in zip(body(), given, strict=True)]
        inside = builder.block
    results = []
    for a, b in zip(replaced, given, strict=True):
        result = builder.phi(b.value.type)
        result.add_incoming(a.value, inside)
        result.add_incoming(b.value, before)
        results.append(Lanes(builder, result))
    return results


def outlined(formula, n_results=1):
    """The formula as a function of the module: inlined code runs no faster and compiles longer.

    LLVM merges calls with equal arguments.
    """

    @functools.wraps(formula)
    def call(x, *others):
        builder = x.builder
        kind = x.value.type
        name = f"fastdyn.{formula.__name__}.{kind.count}"
        function = builder.module.globals.get(name)
        if function is None:
            result = kind if n_results == 1 else ir.LiteralStructType([kind] * n_results)
            form = ir.FunctionType(result, [kind] * (1 + len(others)))
            function = _written(builder.module, name, form, formula)
        found = builder.call(function, [x.value, *map(x.like, others)])
        if n_results == 1:
            return Lanes(builder, found)
        return [Lanes(builder, builder.extract_value(found, i)) for i in range(n_results)]

    return call


def _written(module, name, form, formula):
    function = ir.Function(module, form, name)
    function.linkage = "linkonce_odr"
    for attribute in ("noinline", "nounwind", "readnone"):
        function.attributes.add(attribute)
    builder = ir.IRBuilder(function.append_basic_block())
    found = formula(*(Lanes(builder, x) for x in function.args))
    if isinstance(found, Lanes):
        builder.ret(found.value)
    else:
        builder.ret(pack(builder, [x.value for x in found]))
    return function
