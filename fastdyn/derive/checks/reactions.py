"""Sentences about drawn reactions that do work, or whose directions have not the length one."""

import numpy as np
import sympy as sp

from fastdyn.derive.algebra import shortened

WORK, LENGTH = 1e-7, 1e-6  # relative: above which there is work, another length than one


def of_wrong_reactions(derivation):
    """Sentences about drawn reactions that are no reactions."""
    if derivation.law != "newton":
        return
    name = derivation.model.name
    velocities = {*derivation.motion.v}
    for R in derivation.motion.reactions:
        drawn = _drawn(derivation, R)
        if not drawn:
            continue
        idle = [one for one in drawn if not _work(derivation, [one])]
        if not _work(derivation, drawn):
            yield from _of_length(R, name, drawn)
        elif idle or _without_a_coefficient(derivation, drawn):
            rubbing = [one for one in drawn if one not in idle]
            if not any(force.vector.free_symbols & velocities for _, force in rubbing):
                yield (
                    f"A force on {rubbing[0][0].name} of {name} with {R} as a factor does work "
                    "and knows no velocity: a friction that is drawn so drives the body backwards "
                    "after a stop. `slides(..., friction=, along=)` stops the body, and holds it."
                )
        else:
            names = list(dict.fromkeys(one.name for one, _ in drawn))
            alone = " alone" if len(names) == 1 else ""
            yield (
                f"The reaction {R} of {name}, drawn on {' and '.join(names)}{alone}, does work in "
                "motions that the constraints allow. Where bodies are joined their reaction acts "
                "on both, with opposite signs (Newton's third law)."
            )


def _drawn(derivation, R):
    """The factors of a reaction, as pairs (moving body, force for a reaction of 1)."""
    found = []
    for one in derivation.bodies:
        for force in one.forces[: len(one.body.forces)]:  # without the friction of contacts
            along = force.vector.diff(R)
            if any(along):
                found.append((one, force._replace(vector=along)))
    return found


def _work(derivation, drawn):
    """Whether forces do work in a motion that the constraints allow, at states without symmetry."""
    n = len(derivation.motion.q)
    total = sp.zeros(n, 1)
    sizes = []
    for one, force in drawn:
        total += one.work(force)
        sizes += [*force.vector, *one.partial()[0], *one.partial()[1]]
    entries = [*total, *(entry for held in derivation.held for entry in held.row), *sizes]
    for values in derivation.points.values(entries):
        work = values[:n]
        rows = values[n : n + n * len(derivation.held)].reshape(-1, n)
        left = work - (np.linalg.pinv(rows) @ rows @ work if len(rows) else 0.0)
        if np.abs(left).max() > WORK * max(np.abs(values[n + rows.size :]).max(), 1e-300):
            return True
    return False


def _without_a_coefficient(derivation, drawn):
    """Whether forces do no work if one of their parameters is zero."""
    known = {one.symbol for one in derivation.model.numbers}
    found = set().union(*(force.vector.free_symbols for _, force in drawn)) & known
    for symbol in sorted(found, key=str):
        rest = [
            (one, f._replace(vector=f.vector.xreplace({symbol: sp.S.Zero}))) for one, f in drawn
        ]
        finite = all(entry.is_finite is not False for _, f in rest for entry in f.vector)
        if finite and any(any(f.vector) for _, f in rest) and not _work(derivation, rest):
            return True
    return False


def _of_length(R, name, drawn):
    """A sentence about a reaction none of whose directions has length one."""
    derivation = drawn[0][0].derivation
    lengths = []
    known = {one.symbol for one in derivation.model.numbers}
    for _, force in drawn:
        square = shortened(force.vector.dot(force.vector))
        if force.at is None or (square.free_symbols and not square.free_symbols - known):
            return  # a torque, or the lengths of a lever
        found = [float(np.sqrt(one[0])) for one in derivation.points.values([square])]
        lengths.append(max(found, key=lambda one: abs(one - 1.0)))
    if all(abs(one - 1.0) > LENGTH for one in lengths):
        yield (
            f"{R} of {name} is drawn along a direction whose length is not 1 (but "
            f"{lengths[0]:.4g}), so that {R} is not the size of its force: divide the direction "
            "by its length."
        )
