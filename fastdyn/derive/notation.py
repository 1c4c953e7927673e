"""The signs on the blackboard: time, unit vectors, rates, turns."""

from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef, UndefinedFunction

t = sp.Symbol("t")  # what sp.symbols("t") and dynamicsymbols._t are, too
now = sp.Symbol("t", real=True)  # the time in plain symbols, see `kinematics.Motion`
ASSUMED = ({}, {"real": True}, {"positive": True}, {"nonnegative": True})
TIMES = frozenset(sp.Symbol("t", **one) for one in ASSUMED)
POINTS, ROUNDING = 3, 1e-12  # at which a length is looked at, and what is left of it


class Vector(sp.ImmutableDenseMatrix):
    """A column of three, which says what does not go with it."""

    __slots__ = ()

    def __add__(self, other):
        return self if _is_zero(other) else super().__add__(_column(self, other))

    def __radd__(self, other):
        return self if _is_zero(other) else super().__radd__(_column(self, other))

    def __sub__(self, other):
        return self if _is_zero(other) else super().__sub__(_column(self, other))

    def __rsub__(self, other):
        return -self if _is_zero(other) else super().__rsub__(_column(self, other))

    def __mul__(self, other):
        if isinstance(other, sp.MatrixBase) and self.shape == other.shape == (3, 1):
            raise TypeError(
                "Two vectors are multiplied by dot(a, b), a number, or by cross(a, b), a vector."
            )
        return super().__mul__(other)


def _is_zero(other):
    """Whether something is the number 0, from which `sum` begins."""
    return not isinstance(other, sp.MatrixBase) and other == 0


def _column(vector, other):
    """A term that is added to a vector; a number is refused."""
    if not isinstance(other, sp.MatrixBase):
        raise TypeError(
            f"A number is added to a vector: {other} and {list(vector)}. Each part of a vector "
            "has its direction, as in x*i + y*j."
        )
    return other


i: Any
j: Any
k: Any
i, j, k = (Vector([int(a == b) for b in range(3)]) for a in range(3))
ZERO: Any = Vector([0, 0, 0])


class OfTime(AppliedUndef):
    """
    A function of time, whatever assumptions the symbol t has by which a user differentiates it.

    SymPy takes the derivative with respect to a symbol that does not occur for zero, and a symbol
    t that is declared real is another one than that without assumptions.
    """

    @property
    def free_symbols(self):
        return super().free_symbols | TIMES

    def _eval_derivative(self, s):
        if is_time(s):
            return sp.Derivative(self, t, evaluate=False)
        return super()._eval_derivative(s)


def _refused(name):
    def refuse(self, *_):
        raise TypeError(
            f"{self.func.__name__} is a function of time and no number: in a derivation take "
            f"{name or 'the functions'} of SymPy, `from sympy import {name or 'sin, cos'}`, not of "
            "math or NumPy."
        )

    return refuse


for _name in ("sin", "cos", "tan", "exp", "log", "sqrt", "arctan", "arcsin", "arccos"):
    setattr(OfTime, _name, _refused(_name.replace("arc", "a")))  # what NumPy's functions call
OfTime.__float__ = _refused("")


def of_time(name) -> Any:
    """An unknown real function of time."""
    return UndefinedFunction(name, bases=(OfTime,), real=True)(t)


def is_time(symbol):
    """Whether a symbol is the time: any that is called t."""
    return isinstance(symbol, sp.Symbol) and symbol.name == "t"


def with_one_time(expression, time=t) -> Any:
    """An expression in which every symbol called t is the same."""
    expression = sp.sympify(expression)
    found = {s: time for s in expression.atoms(sp.Symbol) if s != time and is_time(s)}
    return expression.xreplace(found) if found else expression


def rate(expression, order=1) -> Any:
    """The derivative of a number or vector with respect to time, of a given order."""
    there = with_one_time(expression, now)  # |t| has a simple derivative where t is real
    return with_one_time(sp.diff(there, now, order))


def cross(a, b) -> Any:
    """Vector product."""
    return vector(a).cross(vector(b))


def dot(a, b) -> Any:
    """Scalar product."""
    return vector(a).dot(vector(b))


def length(a) -> Any:
    """Length of a vector."""
    return sp.sqrt(dot(a, a))


def vector(given, what="a vector") -> Any:
    """A vector as a column of three; 0 stands for the vector of zeros."""
    if isinstance(given, sp.MatrixBase) and given.shape == (3, 1):
        return Vector(given)
    if not isinstance(given, sp.MatrixBase) and given == 0:
        return ZERO
    raise TypeError(f"{what} must be a vector, a sum of multiples of i, j and k; got {given!r}.")


def expression(given, what) -> Any:
    """A number, or an expression of declared numbers and functions; no text, vector or None."""
    found = given if isinstance(given, str) else sp.sympify(given)
    if not isinstance(found, sp.Expr) or isinstance(found, sp.MatrixBase):
        raise TypeError(f"{what} must be a number or an expression; got {given!r}.")
    return found


def stays(expression) -> bool:
    """Whether an expression of functions of time is constant, looked at for some numbers."""
    change = rate(expression)
    random = np.random.default_rng(0)
    variables = change.atoms(AppliedUndef, sp.Derivative) | change.free_symbols
    for _ in range(POINTS):
        there = {one: sp.Float(random.uniform(0.1, 0.9)) for one in variables}
        found = sp.N(change.xreplace(there))
        if not (found.is_number and abs(found) <= ROUNDING):
            return False
    return True


def direction(given, what) -> Any:
    """The unit vector along a vector; a vector that has length one is returned unchanged."""
    along = vector(given, what)
    if along == ZERO:
        raise ValueError(f"{what} has no direction: it is 0.")
    square = dot(along, along)
    random = np.random.default_rng(0)
    variables = square.atoms(AppliedUndef, sp.Derivative) | square.free_symbols
    for _ in range(POINTS):
        there = {one: sp.Float(random.uniform(0.1, 0.9)) for one in variables}
        found = sp.N(square.xreplace(there))
        if not found.is_number or abs(found - 1.0) > ROUNDING:
            return (along / sp.sqrt(sp.simplify(square))).as_immutable()
    return along


class Rotation:
    """
    Rotations about body-fixed axes, one after the other: ``rotation(phi, k) * ...``.

    A Rotation times a vector of the turned frame is the vector in the fixed frame.  A Rotation
    times another Rotation is the composition of both.
    """

    def __init__(self, *turns):
        self.turns = turns  # (angle, axis in the frame after the turns before)

    def __mul__(self, other) -> Any:
        if isinstance(other, Rotation):
            return Rotation(*self.turns, *other.turns)
        turned: Any = vector(other, "what a rotation turns")
        for angle, axis in reversed(self.turns):
            turned = _turned(turned, angle, axis)
        return turned

    def inverse(self):
        """The rotation back, from the fixed to the turned frame."""
        return Rotation(*((-angle, axis) for angle, axis in reversed(self.turns)))

    def angular_velocity(self) -> Any:
        """Angular velocity in the fixed frame."""
        total: Any = ZERO
        for n, (angle, axis) in enumerate(self.turns):
            total += rate(angle) * (Rotation(*self.turns[:n]) * axis)
        return total


def rotation(angle, axis=k):
    """The Rotation by an angle about the vector `axis`, counterclockwise, by default about k."""
    angle = expression(angle, "the angle of a rotation")
    return Rotation((angle, direction(axis, "the axis of a rotation")))


def _turned(v, angle, axis):
    """Rodrigues' formula."""
    along = axis * axis.dot(v)
    return along + sp.cos(angle) * (v - along) + sp.sin(angle) * axis.cross(v)
