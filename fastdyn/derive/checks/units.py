"""Whether what is added, and what is drawn, has the units that it must have."""

from fractions import Fraction
from typing import Any

import sympy as sp

from fastdyn.systems.base.dimensions import NONE, dimension_of

PURE = (
    sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.asinh,
    sp.acosh, sp.atanh, sp.exp, sp.log,
)  # fmt: skip
GRAVITY = ", an acceleration: fastdyn multiplies gravity by the masses"


class OtherUnitError(Exception):
    """Units that cannot be added, or of which there is no sine."""


def of_other_units(derivation):
    """Sentences about expressions whose units do not agree; numbers alone agree with any unit."""
    known = _known(derivation)
    seen = set()
    for what, given, unit, more in _drawn(derivation.model):
        entries = given.flat() if isinstance(given, sp.MatrixBase) else [sp.sympify(given)]
        for entry in entries:
            sentence = _wrong(derivation.motion.symbols(entry).doit(), unit, known)
            if sentence and what not in seen:
                seen.add(what)
                yield f"{what} of {derivation.model.name} {sentence}{more}."


def _wrong(expression, unit, known):
    """The sentence about a wrong unit of an expression, or None."""
    expected = dimension_of(unit)
    try:
        found = _dimension(expression, known)
    except OtherUnitError as error:
        return str(error)
    if found is None or expected is None or _is_number(found) or found.agrees(expected):
        return None
    return f"is in {found} where {unit if unit != '1' else 'a number without unit'} is needed"


def _known(derivation) -> dict[Any, Any]:
    """The dimensions of all symbols whose units are declared."""
    model = derivation.model
    motion = derivation.motion
    second = dimension_of("s")
    found: dict[Any, Any] = {one.symbol: dimension_of(one.unit) for one in model.numbers}
    for n, one in enumerate(model.coordinate_list):
        own = dimension_of(one.unit) if one.said else None
        for order, symbol in enumerate((motion.q[n], motion.v[n], motion.a[n])):
            found[symbol] = own and own.times(second, -order)
    for one in model.reaction_list:
        found[sp.Symbol(one.name, real=True)] = dimension_of(one.unit) if one.said else None
    return found


def _drawn(model):
    """The declarations, as (what, expression, unit, what to say more)."""
    yield "The gravity", model.field, "m/s²", GRAVITY
    for body in model.bodies:
        yield f"The mass of {body.name}", body.mass, "kg", ""
        yield f"The position of {body.name}", body.position, "m", ""
        if body.rigid:
            for one in body.inertia:
                yield f"A moment of inertia of {body.name}", one, "kg m²", ""
            for angle, _ in body.rotation.turns:
                yield f"The angle of {body.name}", angle, "rad", ""
        for one in body.forces:
            if not one.potential:  # its energy is looked at
                what, unit = ("torque", "N m") if one.at is None else ("force", "N")
                yield f"A {what} on {body.name}", one.vector, unit, ""
    for energy in model.energies:
        for same in (energy, 2 * energy):  # without the half of a spring's
            yield "The energy of a spring, or of a force between two points,", same, "J", ""
    for one in model.constraints:
        yield f"The constraint `{one.name}`", one.expression, "", ""
    for one in model.contacts:
        yield f"The friction at {one.name}", one.friction, "1", ""
    for one in model.functions:
        yield f"The {one.kind} `{one.name}`", one.expression, one.unit, ""
    for one in model.coordinate_list:
        for name, unit in ((one.name, one.unit), (one.rate, f"{one.unit or 1}/s")):
            if one.said and name in model.given:
                yield f"The start of `{name}`", model.given[name], unit, ""


def _dimension(expression, known):
    """The dimension of an expression, None where it is not known."""
    if expression.is_Symbol:
        return known.get(expression)
    parts = [_dimension(one, known) for one in expression.args if isinstance(one, sp.Expr)]
    if expression.is_Add or isinstance(expression, sp.Max | sp.Min):
        return _common(expression.args, parts)
    if expression.is_Mul:
        return _product(expression.args, parts)
    if expression.is_Pow:
        power = expression.exp
        if parts[0] is None or not power.is_Rational:
            return None
        return NONE.times(parts[0], Fraction(int(power.p), int(power.q)))
    if isinstance(expression, PURE):
        if parts[0] is not None and parts[0].powers != NONE.powers:
            raise OtherUnitError(
                f"has {expression.func.__name__} of {expression.args[0]}, which is in {parts[0]} "
                "and no number without unit"
            )
        return NONE
    if isinstance(expression, sp.sign):
        return NONE
    return parts[0] if isinstance(expression, sp.Abs) else None


def _common(terms, parts):
    """The dimension that all terms of a sum have."""
    first = None
    pure = [one for one in parts if one is not None]
    for term, one in zip(terms, parts, strict=True):
        if one is None or _is_number(one):
            continue
        if first is None:
            first = term, one
        elif not first[1].agrees(one):
            raise OtherUnitError(f"adds {term}, in {one}, to {first[0]}, in {first[1]}")
    return first[1] if first else pure[0] if len(pure) == len(parts) else None


def _is_number(dimension):
    """Whether something has no unit, as a sine: a number, that may stand for anything."""
    return dimension.powers == NONE.powers


def _product(factors, parts):
    """The dimension of a product; a number in it, but for a sign, may stand for anything."""
    total = NONE
    for factor, one in zip(factors, parts, strict=True):
        if factor == -1:
            continue
        if one is None:
            return None
        total = total.times(one)
    return total
