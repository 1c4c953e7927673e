"""Numbers and units as a user gives them: finite, angles in radians, with a unit or without."""

import math
import numbers
from typing import Any

import sympy as sp

from fastdyn.derive.notation import expression as expression_of
from fastdyn.systems.base.dimensions import dimension_of, near_unit
from fastdyn.systems.base.units import (
    is_number,
    magnitude,
    other_unit_of,
    said_in_unit,
    warn_of_degrees,
)

UNSAID = ("", "1")  # units of numbers without one


def refuse_degrees(name, unit):
    """Refuse a unit of angles other than radians, which sines and cosines take."""
    if own := other_unit_of(unit):
        raise ValueError(
            f"`{name}` is declared in {unit}, but angles are in radians here: declare `{name}` in "
            f"{own}; its values may then be given as '45 {unit}'."
        )


def refuse_unknown_unit(name, unit):
    """Refuse a unit that is written wrongly; those of other systems, lbf/ft, are not compared."""
    if not isinstance(unit, str):
        raise TypeError(f"The unit of `{name}` must be a text; got {unit!r}.")
    if unit in UNSAID or dimension_of(unit) is not None or other_unit_of(unit):
        return
    near = near_unit(unit)
    if near and dimension_of(near) is not None:
        raise ValueError(
            f"`{name}` is declared in {unit!r}, which is no unit known here; did you mean {near!r}?"
        )


def default_of(name, given, unit):
    """The default of a number; TypeError or ValueError for another object."""
    refuse_degrees(name, unit)
    given = magnitude(given, unit)
    if isinstance(given, str) and is_number(given):
        return said_in_unit(f"The default of `{name}`", given, unit)
    if isinstance(given, numbers.Real) and math.isfinite(given):
        warn_of_degrees(f"The default of `{name}`", float(given), unit)
        return float(given)
    return None


def component_of(name, given, unit):
    """The start of a component of the state: an expression of numbers."""
    given = magnitude(given, unit)
    if isinstance(given, str):
        if not is_number(given):
            raise ValueError(
                f"The start of `{name}` is a number, with its unit if you like ('60 deg'), or an "
                f"expression of declared numbers; got {given!r}."
            )
        return sp.sympify(said_in_unit(f"The start of `{name}`", given, unit))
    value = expression_of(given, f"the start of `{name}`")
    if value.is_number:
        if value.is_finite is False or not value.is_real:
            raise ValueError(f"The start of `{name}` must be a finite number; got {given!r}.")
        warn_of_degrees(f"The start of `{name}`", float(value), unit)
    return value


def refuse_negative(whose, *coefficients):
    """Refuse negative coefficients of friction, because such a friction would drive."""
    for one in map(sp.sympify, filter(None, coefficients)):
        if one.is_number and one < 0:
            raise ValueError(
                f"A coefficient of friction {whose} is {float(one):g}; below zero the friction "
                "would drive the body."
            )


def residual_of(constraint):
    """The residual of a constraint: an expression, or the difference of an equation's sides."""
    expression: Any = constraint if isinstance(constraint, str) else sp.sympify(constraint)
    if isinstance(expression, sp.Equality):
        left, right = (side for side in expression.args)
        return residual_of(left) - residual_of(right)
    if not isinstance(expression, sp.Expr):
        raise ValueError(
            f"A constraint is an expression that is zero, or an equation Eq(a, b); got "
            f"{constraint!r}."
        )
    return expression
