"""A contact with friction: its coefficient and its direction of slip."""

from typing import Any, NamedTuple

import sympy as sp

from fastdyn.derive.notation import of_time


class Contact(NamedTuple):
    """
    A contact with friction.

    `sense` is the symbol of 1 where slip and reaction have one sign and of -1 where they do not,
    `held` the friction of unknown size while it rests, `slip` the velocity along `along`.
    """

    name: str
    body: Any
    reaction: Any
    friction: Any
    static: Any
    along: Any
    place: Any
    slip: Any
    held: Any
    sense: Any

    @classmethod
    def of(cls, body, reaction, coefficients, along, place, slip):
        """The contact of a body, called by the name of its reaction."""
        reaction = sp.sympify(reaction)
        name = str(reaction.func) if reaction.is_Function else body.model.free_name("contact")
        held = of_time(f"friction_{name}")
        sense = sp.Symbol(f"sense_{name}", real=True)
        friction, static = map(sp.sympify, coefficients)
        return cls(name, body, reaction, friction, static, along, place, slip, held, sense)

    def size(self, rests):
        """The friction along `along`."""
        return self.held if rests else -self.sense * self.friction * self.reaction

    @property
    def names(self):
        """Names of its friction, of its slip and of its sense."""
        return f"friction_{self.name}", f"slip_{self.name}", str(self.sense)
