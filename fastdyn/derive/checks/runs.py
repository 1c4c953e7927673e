"""Checks of a system with its numbers, before its run and after it."""

import numpy as np
import sympy as sp

from fastdyn.compile.sentences import warn
from fastdyn.derive.notation import k

ROUNDING = 1e-9  # relative
MOST = 200  # most points of a run at which normal forces are checked


def refuse_impossible_bodies(derivation, numbers):
    """
    Refuse masses and moments of inertia that no body has.

    Parameters
    ----------
    derivation : Derivation
    numbers : dict
        Values of the symbols of the model's numbers.
    """
    for body in derivation.model.bodies:
        own = [body.mass, *(body.inertia if body.rigid else ())]
        own = [sp.sympify(derivation.plain(one)).xreplace(numbers) for one in own]
        mass, *inertia = own
        known = [float(one) for one in inertia if one.is_number]
        if (mass.is_number and mass < 0) or any(one < 0.0 for one in known):
            raise ValueError(f"{body.name} has a mass or a moment of inertia below zero.")
        in_space = body.rigid and any(axis != k for _, axis in body.rotation.turns)
        if in_space and len(known) == 3 and 2.0 * max(known) > sum(known) * (1.0 + ROUNDING):
            said = ", ".join(f"{one:g}" for one in known)
            raise ValueError(
                f"{body.name} has the moments of inertia {said}: no body has one that is "
                "greater than the sum of the other two."
            )


def refuse_coincidence(system, t, w):
    """Refuse a start at which the ends of a spring coincide: its force has no direction."""
    derivation = system.derivation
    lengths, singular = (system.lengths, False)
    if lengths is None or min(lengths(t, w, *system.args)) > 0.0:
        return
    try:
        with np.errstate(all="ignore"):
            singular = not np.isfinite(system.rhs(t, w, *system.args)).all()
    except ZeroDivisionError:
        singular = True
    if singular:
        raise ValueError(
            f"At the start of the {derivation.model.name} the two ends of a spring, a damper or a "
            "force are at one place, where that force has no direction: start elsewhere (`start`, "
            "`guess`), or say its direction by `along=`."
        )


def warn_of_pull(result, values):
    """
    Warn of contacts that pull.

    Parameters
    ----------
    result : SystemResult
    values : callable
        ``values(names, points)`` returns quantities at some points of the run.
    """
    system = result.system
    pushing = result.system.derivation.model.pushing
    names = {name: body for name, body in pushing.items() if name in system.quantities}
    if not names or not len(result.t):
        return
    points = np.unique(np.linspace(0, len(result.t) - 1, MOST).astype(int))
    for name, found in values(list(names), points).items():
        below = np.flatnonzero(found < -ROUNDING * np.abs(found).max())
        if len(below):
            warn(
                f"The normal force {name} of the {system.name} is negative from about "
                f"t = {result.t[points[below[0]]]:.4g} (down to {found.min():.4g} N): the contact "
                f"pulls. {names[name]} would leave a surface there; if the surface guides the body "
                "on both sides, write `slides(..., guided=True)`."
            )
