"""Finds the difference of a student's equations from the reference: component, term, sign, unit."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from fastdyn.systems.base.units import product_of

from .call import ExerciseCall, Refused
from .mistakes import of_degrees, of_direction, of_sign, of_small_angles, same

ROUNDING = 1e-13  # relative to the largest component of the same unit
POWERS = (1, -1, 2, -2)
LARGE = 14.0  # logarithm of a number beyond which it stands for 0 or infinity
OTHER = 2  # seed of the values that are exchanged


def compare(exercise, function):
    """
    Sentences about the differences of a function from the reference of an exercise.

    Parameters
    ----------
    exercise : Exercise
    function : callable
        ``function(t, y, *parameters)`` as for `solve_ivp`; parameters are taken by name.

    Returns
    -------
    list of str
        Empty for a right function.
    """
    return compared(exercise, function)[0]


def compared(exercise, function):
    """The result of `compare`, and notes about deviations that are no errors."""
    try:
        call = ExerciseCall(exercise, function)
        samples = exercise.samples()
        got = call.values(*samples)
    except Refused as error:
        return [str(error)], []
    reference = exercise.values(*samples)
    right = {name: sum(one.values()) for name, one in reference.items()}
    sizes: dict[str, float] = {}  # the largest number of each unit
    for name, values in right.items():
        unit = exercise.answer[name]
        sizes[unit] = max(sizes.get(unit, 0.0), np.abs(values).max())
    said: dict[str | WrongUnit, list[str]] = {}  # defects, and the components they are found in
    for name, values in got.items():
        terms = exercise.following(name, samples, got) or reference[name]
        if not np.isfinite(values).all():
            sentence = f"{{names}} {{is}} not finite at {np.sum(~np.isfinite(values))} states."
        elif same(values, right[name]) or same(values, sum(terms.values())):
            continue
        elif np.abs(values - right[name]).max() <= ROUNDING * sizes[exercise.answer[name]]:
            continue
        else:
            sentence = _difference(exercise, name, values, terms, right, samples, call)
        said.setdefault(sentence, []).append(name)
    return [_of_names(*one) for one in _joined(said)], call.notes


class WrongUnit(NamedTuple):
    """Terms of a component that a number, such as a mass, multiplies once too often or too rarely.

    `about` and the verbs are the beginning of a sentence, `many` the unit that is too many.
    """

    about: str
    has: str
    it_has: str
    due: str
    many: str
    numbers: frozenset
    also: tuple

    def sentence(self):
        said = f"{self.about} {self.has} the wrong unit: {self.due} is due, and {self.it_has} "
        return f"{'; '.join([f'{said}{self.many} too many', *self.also])}."

    def part(self):
        said = f"{self.about} {self.has} {self.many} too many ({self.due} is due)"
        return "; ".join([said, *self.also])


def _joined(said):
    """(sentence, components) of each defect; one mistake in a number, in several places, is one."""
    alike: dict[frozenset, list] = {}
    for defect, names in said.items():
        if isinstance(defect, WrongUnit):
            alike.setdefault(defect.numbers, []).append((defect, names))
    for defect, names in said.items():
        if not isinstance(defect, WrongUnit):
            yield defect, names
            continue
        found = alike.pop(defect.numbers, [])
        if len(found) == 1:
            yield defect.sentence(), names
        elif found:
            yield _together(defect.numbers, found), [""]


def _together(numbers, found):
    """The sentence about wrong units of several terms, by powers of the same numbers."""
    first, *others = (_of_names(one.part(), names) for one, names in found)
    parts = [part[0].lower() + part[1:] for part in (first, *others)]
    several = " and ".join(f"`{name}`" for name in sorted(numbers))
    return f"A wrong power of {several}, in one place perhaps: {'; '.join(parts)}."


def _of_names(sentence, names):
    """A sentence about one component or more."""
    several = len(names) > 1
    verbs = {"is": "are", "has": "have", "takes": "take", "differs": "differ"}
    verbs = {one: many if several else one for one, many in verbs.items()}
    verbs["it_has"] = "they have" if several else "it has"
    *first, last = [f"`{name}`" for name in names]
    return sentence.format(names=f"{', '.join(first)} and {last}" if first else last, **verbs)


def _difference(exercise, name, values, terms, right, samples, call):
    """One defect of a component that is wrong, a sentence with {names} in the place of its name."""
    due = sum(terms.values())
    if same(values, -due):
        return "{names} {has} the wrong sign as a whole."
    if said := _of_terms(values, terms):
        return f"In {{names}} {' and '.join(said)}."
    for other, theirs in right.items():
        if other != name and same(values, theirs):
            return f"{{names}} {{has}} the value of `{other}`: the order of what is returned?"
    if said := of_degrees(exercise, name, values, samples):
        return said
    if said := of_sign(exercise, name, values, samples):
        return said
    if said := of_direction(exercise, values, terms, samples):
        return said
    if said := of_small_angles(exercise, name, samples, call):
        return said
    if said := _of_number(exercise, name, values, samples, call):
        return said
    if said := _of_units(exercise, name, values, terms, samples):
        return said
    about = _dependence(exercise, name, values - right[name], call)
    where = int(np.argmax(np.abs(values - due)))
    state = ", ".join(f"{key} = {one[where]:.2g}" for key, one in samples[1].items())
    return f"{{names}} {{differs}}, most of all at {state}{about}."


def _of_terms(values, terms):
    """The defects of equations whose terms have wrong factors: signs, numbers, missing terms."""
    columns = np.column_stack(list(terms.values()))
    factors = np.linalg.lstsq(columns, values, rcond=1e-10)[0]
    if np.linalg.matrix_rank(columns) < len(terms) or not same(columns @ factors, values):
        return []
    said = []
    for about, factor in zip(terms, factors, strict=True):
        if abs(factor - 1.0) < 1e-6:
            continue
        if abs(factor + 1.0) < 1e-6:
            said.append(f"the term of {about} has the wrong sign")
        elif abs(factor) < 1e-6:
            said.append(f"the term of {about} is missing")
        elif factor < 0.0:
            said.append(f"the term of {about} has the wrong sign and a wrong factor")
        else:
            more = "large" if factor > 1.0 else "small"
            said.append(f"the term of {about} is too {more}, by the same factor everywhere")
    return said


def _of_units(exercise, name, values, terms, samples):
    """The defect of terms with a wrong power of a number, such as a forgotten mass; "" if none."""
    parts, units = _parts(exercise, name, terms, samples)
    numbers = parts[0][2]
    single = [{key: power} for key, power in itertools.product(numbers, POWERS)]
    pairs = [
        {a: m, b: n} for a, b in itertools.combinations(exercise.parameters, 2)
        for m, n in itertools.product((1, -1), repeat=2)
    ]  # fmt: skip
    groups = [
        group for size in (len(terms), *range(1, len(terms)))
        for group in itertools.combinations(terms, size)
    ]  # fmt: skip
    matches = []
    for extra, group in itertools.product((*single, *pairs), groups):
        theirs = dict.fromkeys(terms, 0.0)
        for sign, each, there in parts:
            factor = math.prod(there[key] ** power for key, power in extra.items())
            for key, one in each.items():
                theirs[key] = theirs[key] + sign * one * (factor if key in group else 1.0)
        if same(values, sum(theirs.values())):
            matches.insert(0, (extra, group, []))
            break
        if also := _of_terms(values, theirs):
            matches.append((extra, group, also))
    if not matches:
        return ""
    extra, group, also = min(matches, key=lambda one: len(one[2]))
    about, has, it_has = _about(group, terms)
    powers = {units[key]: power for key, power in extra.items()}
    many = product_of(powers) if len(powers) == len(extra) else ""
    if many:
        due = exercise.answer[name]
        also = tuple(also)
        return WrongUnit(about, has, it_has, due, many, frozenset(extra), also)
    is_off = has.replace("has", "is").replace("have", "are")
    said = f"{about} {is_off} off by a power of `{'` and `'.join(extra)}`"
    return f"{'; '.join([said, *also])}."


def _parts(exercise, name, terms, samples):
    """(sign, terms, numbers) whose sum is a component, a change if its zero is free; and units."""
    numbers, units = _numbers(exercise, samples)
    if name not in exercise.free_zero:
        return [(1.0, terms, numbers)], units
    before = exercise.elsewhere(*samples)
    there, _ = _numbers(exercise, before)
    return [
        (1.0, exercise.at(*samples)[name], numbers), (-1.0, exercise.at(*before)[name], there)
    ], units  # fmt: skip


def _numbers(exercise, samples):
    """The numbers of which a term may have a wrong power, and the unit of each, by name.

    These are parameters, components of the state, and the sizes of vectors in the plane.
    """
    _, y, p = samples
    numbers = {**p, **y}
    units = {**exercise.parameters, **exercise.state}
    for a, b in itertools.combinations(y, 2):
        if units[a] == units[b]:
            name = f"sqrt({a}² + {b}²)"
            numbers[name], units[name] = np.hypot(y[a], y[b]), units[a]
    return numbers, {key: "" if unit == "1" else unit for key, unit in units.items()}


def _about(group, terms):
    """The beginning of a sentence about terms of a component, and its verbs."""
    if len(group) == len(terms):
        return "{names} as a whole", "{has}", "{it_has}"
    if len(group) == 1:
        return f"The term of {group[0]} in {{names}}", "has", "it has"
    return f"The terms of {' and '.join(group)} in {{names}}", "have", "they have"


def _of_number(exercise, name, values, samples, call):
    """A sentence about a component with a number in the place of a parameter."""
    t, y, p = samples
    for key in p if exercise.project is None else ():  # with constraints, none changes alone
        try:
            free = same(call.values(*_changed(exercise, key))[name], values)
        except Refused:
            return ""
        if not free:
            continue

        def off(logarithm, key=key):
            with_it = {**p, key: np.full(len(t), np.exp(logarithm[0]))}
            return sum(exercise.values(t, y, with_it)[name].values()) - values

        with np.errstate(all="ignore"):
            (found,) = least_squares(off, [1.0], xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        # A 1 is that of a forgotten factor, a 0 of a forgotten term.
        if 1e-6 < abs(found) < LARGE and same(off([found]) + values, values):
            return f"{{names}} {{has}} a number in the place of `{key}`."
    return ""


def _dependence(exercise, name, off, call):
    """
    The end of a sentence about a difference: the names of the numbers that change the difference.

    Parameters
    ----------
    exercise : Exercise
    name : str
        The name of the answer that differs.
    off : ndarray
        The difference at `Exercise.samples`.
    call : Call
        The function that differs.
    """
    if exercise.project is not None:
        return ""  # no component can be changed alone
    theirs = []
    due = []
    apart = []
    t, y, p = exercise.samples()
    base = sum(exercise.values(t, y, p)[name].values())
    for one in (*y, *p, "t"):
        changed = _changed(exercise, one)
        try:
            values = call.values(*changed)[name]
        except Refused:
            return ""
        right = sum(exercise.values(*changed)[name].values())
        if not same(values, base + off):
            theirs.append(one)
        if not same(right, base):
            due.append(one)
        if not same(values - right, off):
            apart.append(one)
    more = [one for one in theirs if one not in due]
    less = [one for one in due if one not in theirs]
    said = f"; it depends on {' and '.join(more)}, and should not" if more else ""
    said += f"; it should depend on {' and '.join(less)}, and does not" if less else ""
    if not said:
        said = f"; the difference depends on {' and '.join(apart)}" if apart else (
            "; the difference is the same number everywhere")  # fmt: skip
    return said


def _changed(exercise, one):
    """The samples, with other values for one name."""
    samples = exercise.samples()
    others = exercise.samples(OTHER)
    if one == "t":
        return others[0], *samples[1:]
    return samples[0], *(
        {key: (other if key == one else mine)[key] for key in mine}
        for mine, other in zip(samples[1:], others[1:], strict=True)
    )
