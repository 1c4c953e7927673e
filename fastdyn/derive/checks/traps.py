"""Warnings of declarations that a model permits, and that are most often mistakes."""

import itertools

import numpy as np
import sympy as sp

from fastdyn.compile.sentences import warn
from fastdyn.derive.notation import now

from .reactions import of_wrong_reactions
from .units import of_other_units

EXACT = 1e-9  # of its largest part, the rest of a condition of integrability


def warn_of_traps(derivation):
    """Warn of numbers that nothing uses, and of positions that the start alone decides."""
    for sentence in _sentences(derivation):
        warn(sentence)


def _sentences(derivation):
    yield from _unused(derivation.model)
    yield from of_other_units(derivation)
    yield from of_wrong_reactions(derivation)
    yield from _unplaced(derivation)
    yield from _unguided(derivation)


def _unused(model):
    """Sentences about numbers that are declared and occur nowhere."""
    used = set(model.field.free_symbols)
    for body in model.bodies:
        about = [body.mass, body.position, *(one.vector for one in body.forces)]
        about += [one.at for one in body.forces if one.at is not None]
        if body.rigid:
            about += [*body.inertia, *(angle for angle, _ in body.rotation.turns)]
        used |= set().union(*(one.free_symbols for one in about))
    rubbing = [each for one in model.contacts for each in (one.friction, one.static)]
    expressions = [one.expression for one in (*model.constraints, *model.functions)]
    expressions += [*model.energies, *model.given.values(), *model.guesses.values(), *rubbing]
    used |= set().union(*(sp.sympify(one).free_symbols for one in expressions))
    for one in model.numbers:
        if one.symbol not in used:
            yield (
                f"`{one.symbol}` of {model.name} is used nowhere: no force, position or start has "
                "it, and it changes nothing."
            )


def _unplaced(derivation):
    """Sentences about constraints of velocities that hold a position, wherever this begins."""
    motion = derivation.motion
    model = derivation.model
    start = dict(zip(derivation.start.names, derivation.start.default, strict=True))
    for one in derivation.held:
        rolling = next((c.rolling for c in model.constraints if c.name == one.name), None)
        if one.position is None and not _turns(one, rolling, derivation):
            if not _is_rate(derivation, one):
                continue
            names = [q for q, a in zip(motion.q, one.row, strict=True) if a != 0]
            places = ", ".join(f"{q} = {start[str(q)]:g}" for q in names)
            advice = "`slides` takes `through=`, a point of the surface; `constrain` the position"
            if rolling is not None:
                advice = "`constrain` the place of the wheel across the ground instead"
            yield (
                f"The constraint `{one.name}` of {model.name} is the rate of a position, which "
                f"it keeps as it starts, {places}, wherever that is. Give the position: {advice}."
            )


def _unguided(derivation):
    """Sentences about particles that are said to slide on a curve, and move more freely."""
    model = derivation.model
    q = {*derivation.motion.q}
    for one in model.drawn:
        if one.kind != "guide":
            continue
        ((body, place),) = one.points
        own = derivation.plain(place).free_symbols & q
        within = [c for c in derivation.held if c.position is not None]
        within = [c for c in within if c.position.free_symbols & q <= own]
        if len(own) - len(within) != 1:
            yield (
                f"{body.name} of {model.name} slides on no guide: its position follows from "
                f"{len(own)} coordinates with {len(within)} constraints, not from one."
            )


def _turns(held, rolling, derivation):
    """Whether a constraint ties the angle of what rolls, which may begin anywhere."""
    if rolling is None or not rolling.rigid:
        return False
    angles = [derivation.plain(angle) for angle, _ in rolling.rotation.turns]
    turning = set().union(*(one.free_symbols for one in angles))
    return any(q in turning and a != 0 for q, a in zip(derivation.motion.q, held.row, strict=True))


def _is_rate(derivation, held):
    """Whether a constraint of velocities is the rate of a function of coordinates and time."""
    motion = derivation.motion
    variables = [*derivation.motion.q, now]
    if held.velocity.free_symbols & {*motion.inputs} or held.row.free_symbols & {*motion.v}:
        return False
    moving = held.velocity.xreplace(dict.fromkeys(motion.v, sp.S.Zero))
    parts = [*held.row, moving]
    pairs = itertools.combinations(range(len(parts)), 2)
    both = [(sp.diff(parts[a], variables[b]), sp.diff(parts[b], variables[a])) for a, b in pairs]
    both = [pair for pair in both if pair[0] != pair[1]]
    if not both:
        return True
    for values in derivation.points.values(sp.Matrix(both)):
        off = np.abs(values[:, 0] - values[:, 1])
        size = np.abs(values).max()
        if off.max() > EXACT * size:
            return False
    return True
