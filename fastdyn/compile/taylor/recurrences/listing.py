"""Recurrences as lists of nodes, and back."""

from typing import Any, NamedTuple

from .operations import Integral, Power, Quotient, Root, Sum


class Gather(NamedTuple):
    """A vector whose lanes are copied from (node, lane) of other vectors."""

    node: Any
    lanes: list


class Rate(NamedTuple):
    """The derivative of the state `node`, factor core + constant; None stands for zero."""

    node: Any
    factor: Any
    core: Any
    constant: Any


def items(step, invariant=lambda node: False):
    """The operands of a step as (whether the operand is a factor, node)."""
    if isinstance(step, Sum):
        found = [] if step.constant is None else [(True, step.constant)]
        found += [each for f, a in step.terms for each in ((True, f), (False, a))]
        for f, a, b in step.products:
            found += [(True, f), (False, a), (False, b)]
        return found
    if isinstance(step, Quotient):
        found = [(True, step.factor), (False, step.b)]
        return found if step.a is None else [*found, (False, step.a)]
    if isinstance(step, Power):
        return [(True, step.factor), (False, step.a)]
    if isinstance(step, Root):
        return [(False, step.a)]
    if isinstance(step, Rate):
        given = (True, step.factor), (False, step.core), (True, step.constant)
        return [each for each in given if each[1] is not None]
    found = [(invariant(a), a) for a in step.arguments]
    for f, a, g in step.parts:
        found += [(True, f), (False, a)] + ([] if g is None else [(False, g)])
    return found


def rebuilt(step, node, given):
    """A step with the formula of another step, for a new node and new operands."""
    left = iter(given)
    if isinstance(step, Sum):
        constant = None if step.constant is None else next(left)
        terms = [(next(left), next(left)) for _ in step.terms]
        products = [(next(left), next(left), next(left)) for _ in step.products]
        return Sum(node, constant, terms, products)
    if isinstance(step, Quotient):
        factor, b = next(left), next(left)
        return Quotient(node, factor, None if step.a is None else next(left), b)
    if isinstance(step, Power):
        return Power(node, next(left), next(left), step.exponent)
    if isinstance(step, Root):
        return Root(node, next(left))
    if isinstance(step, Rate):
        fields = step.factor, step.core, step.constant
        return Rate(node, *[None if x is None else next(left) for x in fields])
    arguments = [next(left) for _ in step.arguments]
    parts = [(next(left), next(left), None if g is None else next(left)) for _, _, g in step.parts]
    return Integral(node, step.name, arguments, parts)


def shape(step, invariant=lambda node: False):
    """The formula of a step without its nodes, as a key."""
    kind = type(step).__name__
    if isinstance(step, Sum):
        squares = tuple([a is b for _, a, b in step.products])
        return kind, step.constant is None, len(step.terms), squares
    if isinstance(step, Quotient):
        return kind, step.a is None
    if isinstance(step, Power):
        return kind, step.exponent
    if isinstance(step, Rate):
        return kind, step.factor is None, step.core is None, step.constant is None
    if isinstance(step, Integral):
        fixed = tuple([invariant(a) for a in step.arguments])
        return kind, step.name, fixed, tuple([g is None for _, _, g in step.parts])
    return (kind,)
