"""The nodes of a recurrence as a list, and a recurrence with other nodes."""

from typing import Any, NamedTuple

from .operations import Integral

NO_OPERANDS = frozenset(("node", "exponent", "name", "condition"))


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


def nodes(step):
    """The operands and invariants of a step."""
    found: list = []
    for name, value in zip(step._fields, step, strict=True):
        if name not in NO_OPERANDS:
            _flatten(value, found)
    return found


def _flatten(value, found):
    if type(value) in (list, tuple):
        for x in value:
            _flatten(x, found)
    elif value is not None:
        found.append(value)


def items(step, invariant):
    """The operands and invariants of a step as (whether the node is invariant, node)."""
    return [(invariant(node), node) for node in nodes(step)]


def timed(plan):
    """The keys of functions whose argument is linear in time: such functions need no sum."""
    found = [step for step in plan.steps if isinstance(step, Integral) and len(step.parts) == 1]
    return {
        step.node.key
        for step in found
        for _, a, g in step.parts if g is not None and plan.degree.get(a.key) == 1
    }  # fmt: skip


def rebuilt(step, node, given):
    """A step with the formula of another step, for a new node and new operands."""
    left = iter(given)
    return _replaced(step, lambda _: next(left))._replace(node=node)


def shape(step, invariant):
    """The formula of a step without its nodes, as a key."""
    squares = tuple([a is b for _, a, b in getattr(step, "products", ())])
    return squares, repr(_replaced(step, invariant)._replace(node=None))


def _replaced(step, new):
    """A copy of a step with ``new(x)`` in place of each operand and invariant x."""

    def of(value):
        if type(value) in (list, tuple):
            return type(value)([of(x) for x in value])
        return None if value is None else new(value)

    fields = [name for name in step._fields if name not in NO_OPERANDS]
    return step._replace(**{name: of(getattr(step, name)) for name in fields})
