"""Which mode a motion with friction is in: at the start, and after each event."""

from typing import Any

import numpy as np

from fastdyn.solve.phases import Phase

from .modes import REST, WAYS, Way

AT_REST = 1e-12  # of the terms of a slip, below which a start is at rest
MOMENT = 1e-9  # of a phase
STOPPED = 1e-6  # of the slip that a phase has lost
BEYOND = 1e-9  # of the greatest friction: what rests is freed where more is needed


class Transitions(dict):
    """
    The phases of a motion by name, each made when it is first asked for.

    Parameters
    ----------
    system : RubbingSystem
    phase : callable
        Gives right-hand side, event and options of a `Mode`.
    """

    def __init__(self, system, phase):
        super().__init__()
        self.system = system
        self._phase = phase
        contacts = system.derivation.model.contacts
        self.contacts = [one.name for one in contacts]
        self.smooth = {n for n, one in enumerate(contacts) if not system.rough(one)}
        self.ways: dict[str, tuple[Way | None, ...]] = {}
        self._begun: Any = None  # time and facts at the start of the phase

    def __contains__(self, name):
        return name in self.ways

    def __missing__(self, name):
        mode = self.system.mode(self.ways[name])
        rhs, ends, options = self._phase(mode)

        def after(t, w, *args):
            own = w[: len(w) - len(self.contacts)]
            return self._entered(t, own, self._changed(mode, t, own)), w

        self[name] = Phase(rhs, ends, after, options)
        return self[name]

    def begin(self, t, w):
        """The phase of a start: what does not slip rests, if its friction suffices."""
        self._begun = t, None
        slipping = self.system.mode((Way(1, 1),) * len(self.contacts))
        facts = slipping.facts(t, w, self.system.args)
        still = slipping.facts(t, self._standing(w), self.system.args)
        ways = []
        for one, there in zip(facts, still, strict=True):
            terms = abs(one.slip - there.slip) + abs(there.slip)
            rests = abs(one.slip) <= AT_REST * terms
            ways.append(REST if rests else Way(_sign(one.slip), _sign(one.reaction)))
        ways = [None if one in self.smooth else way for one, way in enumerate(ways)]
        return self._entered(t, w, tuple(ways))

    @staticmethod
    def _standing(w):
        """The state without its velocities."""
        return np.concatenate([w[: len(w) // 2], np.zeros(len(w) // 2)])

    def _entered(self, t, w, ways):
        """The name of the phase that agrees with itself, nearest to the ways that are given."""
        for _ in range(len(WAYS) ** len(ways)):
            mode = self.system.mode(ways)
            facts = mode.facts(t, w, self.system.args)
            soon = mode.facts(*self._soon(mode, t, w), self.system.args)
            changed = [_agreeing(*each) for each in zip(ways, facts, soon, strict=True)]
            wrong = [n for n, way in enumerate(ways) if way != changed[n]]
            if not wrong:
                break
            ways = (*ways[: wrong[0]], changed[wrong[0]], *ways[wrong[0] + 1 :])
        else:
            raise ValueError(
                f"At t = {t:.6g} no slip or rest of the {self.system.name} agrees with the signs "
                "of its reactions (Painlevé's paradox): rigid bodies with so much friction have "
                "no motion there."
            )
        words = [way.words() if way else "slips" for way in ways]
        several = [f"{name} {word}" for name, word in zip(self.contacts, words, strict=True)]
        name = words[0] if len(words) == 1 else ", ".join(several)
        self.ways[name] = ways
        self._begun = (t, facts)
        return name

    def _soon(self, mode, t, w):
        """Time and state a moment later, where a reaction that begins with zero has its sign."""
        moment = MOMENT * (abs(t - self._begun[0]) or 1.0)
        rates = mode.rhs(t, np.append(w, np.zeros(len(self.contacts))), *self.system.args)
        return t + moment, w + moment * np.array(rates[: len(w)])

    def _changed(self, mode, t, w):
        """The ways after the event that ends a mode: of the contact whose function is zero."""
        begun, before = self._begun
        facts = mode.facts(t, w, self.system.args)
        nearest = []
        for n, way in enumerate(mode.ways):
            one = facts[n]
            if way == REST:
                nearest.append(((one.most - abs(one.size)) / (one.most or 1.0), n, _freed(one)))
            elif way:
                path = abs(one.rate * (t - begun)) or 1.0
                off = max(abs(one.slip) / path - STOPPED, 0.0)  # it stops, whatever else is zero
                nearest.append((off, n, REST))
                usual = max(abs(one.reaction), abs(before[n].reaction)) or 1.0
                nearest.append((abs(one.reaction) / usual, n, _pulled(way)))
        _, n, way = min(nearest, key=lambda one: one[0])
        return (*mode.ways[:n], way, *mode.ways[n + 1 :])


def _agreeing(way, facts, soon):
    """The way of a contact, or another one where it cannot go on in that."""
    if way is None:
        return way
    if way == REST:
        return way if abs(facts.size) <= (1.0 + BEYOND) * facts.most else _freed(facts)
    return _pulled(way) if way.push * soon.reaction < 0.0 else way


def _freed(facts):
    """The way of a contact that does not rest any more: against the friction that held it."""
    return Way(-_sign(facts.size), _sign(facts.reaction))


def _pulled(way):
    """The way with a reaction of the other sign."""
    return Way(way.slip, -way.push)


def _sign(number):
    return -1 if number < 0.0 else 1
