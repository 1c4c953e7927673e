"""The modes of contacts with friction, and the functions of the motion in each of them."""

import functools
import itertools
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from fastdyn.derive.system import functions_of, metric
from fastdyn.derive.writing import Writer
from fastdyn.systems.base import event


class Way(NamedTuple):
    """How one contact moves: the sign of its slip, 0 at rest, and that of its reaction."""

    slip: int
    push: int

    def words(self):
        if not self.slip:
            return "rests"
        back = " back" * (self.slip < 0)
        pulled = " pulled" * (self.push < 0)
        return f"slips{back}{pulled}"


REST = Way(0, 0)
WAYS = (REST, *(Way(*signs) for signs in itertools.product((1, -1), repeat=2)))


class ContactFacts(NamedTuple):
    """Slip of a contact, its rate, reaction, friction, and the most that friction holds at rest."""

    slip: Any
    rate: Any
    reaction: Any
    size: Any
    most: Any


class ContactMode:
    """
    The motion while each contact keeps its way.

    The state has, beside its own components, the integral of the friction of each contact: a body
    at rest moves with nothing, and the steps have to follow the force that acts on it.

    Parameters
    ----------
    derivation : Derivation
        With the contacts at rest that are so.
    ways : tuple of Way
        One a contact; None for one without friction, which slips for ever.

    Attributes
    ----------
    rhs, project : callable
        Of the state with the integrals.
    ends : callable
        The event that ends the mode.
    facts : callable
        For each contact a `ContactFacts`.
    """

    def __init__(self, derivation, ways):
        model = derivation.model
        plain = derivation.plain
        self.derivation = derivation
        self.ways = ways
        senses = {
            str(contact.sense): float(way.slip * way.push)
            for contact, way in zip(model.contacts, ways, strict=True)
            if way and way.slip
        }
        self._own = Writer(derivation, senses)
        beside = [f"impulse_{contact.name}" for contact in model.contacts]
        writer = Writer(derivation, senses, beside)
        frictions = []
        facts = []
        for contact in model.contacts:
            rests = contact.name in derivation.at_rest
            slip = plain(contact.slip)
            size = plain(contact.size(rests))
            frictions.append(size)
            rate = derivation.motion.rate(slip)
            reaction = plain(contact.reaction)
            most = plain(contact.static) * reaction
            facts.append(ContactFacts(slip, rate, reaction, size, sp.Abs(most, evaluate=False)))
        self.rhs: Any = writer.rhs(frictions)
        self._facts = self._own.numbers("facts", [one for each in facts for one in each])
        texts = [self._watched(way, each) for way, each in zip(ways, facts, strict=True) if way]
        ends = [one for each in texts for one in each]
        write = "min({})".format if len(ends) > 1 else str
        watched = writer.numbers("ends", ends or [sp.S.One], write)
        self.ends: Any = event(direction=-1, terminal=True)(watched)
        self.project = writer.project(metric(derivation)) if derivation.held else None

    @staticmethod
    def _watched(way, facts):
        """The expressions that are greater than zero while a contact keeps its way."""
        if not way.slip:
            return [facts.most - sp.Abs(facts.size)]
        slip = way.slip * facts.slip
        rate = way.slip * facts.rate
        onwards = sp.Max(slip, rate, evaluate=False)  # one that is just setting off goes on
        return [onwards, way.push * facts.reaction]

    def facts(self, t, w, args):
        """`ContactFacts` in numbers."""
        found = np.array(self._facts(t, w, *args), float)
        return [ContactFacts(*each) for each in found.reshape(len(self.ways), -1).tolist()]

    @functools.cached_property
    def quantities(self):
        """Functions of the state by name."""
        return functions_of(self.derivation, self._own)
