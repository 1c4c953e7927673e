"""Mistakes that many make: degrees, a wrong sign, no direction, small angles."""

import itertools
import math

import numpy as np

from .call import Refused

SAME = 1e-8  # relative
SMALL, ABOUT = (0.1, 0.01), 0.2  # sizes of small angles; slack of an order found from these


def same(a, b):
    """Whether values are equal but for rounding."""
    return np.abs(a - b).max() <= SAME * max(np.abs(a).max(), np.abs(b).max(), 1e-300)


def of_degrees(exercise, name, values, samples):
    """A sentence about a component with an angle in degrees."""
    t, y, p = samples
    for factor, taken in ((math.pi / 180.0, "degrees"), (180.0 / math.pi, "radians")):
        turned = {
            key: one * factor if exercise.state[key] == "rad" else one for key, one in y.items()
        }
        theirs = sum(exercise.values(t, turned, p)[name].values())
        if any(unit == "rad" for unit in exercise.state.values()) and same(values, theirs):
            return f"{{names}} {{takes}} an angle for one in {taken}: the state is in radians."
    return ""


def of_sign(exercise, name, values, samples):
    """A sentence about a component in which one name has the wrong sign wherever it stands."""
    t, y, p = samples
    if exercise.project is not None:
        return ""  # the reference holds on the constraints alone
    for key in (*p, *y):
        turned = [{k: -one if k == key else one for k, one in each.items()} for each in (y, p)]
        with np.errstate(all="ignore"):
            theirs = sum(exercise.values(t, *turned)[name].values())
        if same(values, theirs):
            return f"{{names}} {{takes}} `{key}` with the wrong sign."
    return ""


def of_direction(exercise, values, terms, samples):
    """A sentence about a term with the square of a size in place of the size times a component."""
    _, y, _ = samples
    sizes = [(a, b) for a, b in itertools.combinations(y, 2) if _alike(exercise, a, b)]
    for (a, b), about, sign in itertools.product(sizes, terms, (1.0, -1.0)):
        size = np.hypot(y[a], y[b])
        for component in (a, b):
            squared = terms[about] * sign * size / y[component]
            if same(values, sum({**terms, about: squared}.values())):
                return (
                    f"In {{names}} the term of {about} has the square of the size, "
                    f"{a}² + {b}², in the place of sqrt({a}² + {b}²) {component}: it has no "
                    f"direction, and does not turn round with {component}."
                )
    return ""


def _alike(exercise, a, b):
    return exercise.state[a] == exercise.state[b]


def of_small_angles(exercise, name, samples, call):
    """A sentence about a component that differs by the third order of small angles only."""
    t, y, p = samples
    angles = [key for key, unit in exercise.state.items() if unit == "rad"]
    if not angles or exercise.project is not None:
        return ""
    off = []
    size = []
    found = []
    for small in SMALL:
        near = {key: small * one if key in angles else one for key, one in y.items()}
        try:
            theirs = call.values(t, near, p)[name]
        except Refused:
            return ""
        right = sum(exercise.values(t, near, p)[name].values())
        found.append(theirs)
        off.append(np.abs(theirs - right).max())
        size.append(np.abs(right).max())
    order = math.log(off[0] / off[1]) / math.log(SMALL[0] / SMALL[1]) if min(off) > 0 else 0.0
    if order < 2 - ABOUT or off[1] > SMALL[1] * size[1]:
        return ""
    said = "{names} {is} right for small angles only"
    if same(found[0] / SMALL[0], found[1] / SMALL[1]):
        return f"{said}: {angles[0]} for sin({angles[0]})?"
    return f"{said}: 1 for cos({angles[0]})?" if same(*found) else f"{said}."
