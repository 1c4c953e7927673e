"""Finds the difference of a student's equations from the reference: component, term, sign, unit."""

import itertools
import math

import numpy as np

from .call import Call, Refused

SAME = 1e-8  # relative
POWERS = (1, -1, 2, -2)
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
        call = Call(exercise, function)
        samples = exercise.samples()
        got = call.values(*samples)
    except Refused as error:
        return [str(error)], []
    terms = exercise.values(*samples)
    right = {name: sum(one.values()) for name, one in terms.items()}
    found = []
    for name, values in got.items():
        if not np.isfinite(values).all():
            found.append(f"`{name}` is not finite at {np.sum(~np.isfinite(values))} states.")
        elif not same(values, right[name]):
            found.append(_difference(exercise, name, values, terms[name], right, samples, call))
    return found, call.notes


def same(a, b):
    """Whether values are equal but for rounding."""
    return np.abs(a - b).max() <= SAME * max(np.abs(a).max(), np.abs(b).max(), 1e-300)


def _difference(exercise, name, values, terms, right, samples, call):
    """One sentence about a component that is wrong."""
    if same(values, -right[name]):
        return f"`{name}` has the wrong sign as a whole."
    if said := _of_terms(values, terms):
        return f"In `{name}` {' and '.join(said)}."
    for other, theirs in right.items():
        if other != name and same(values, theirs):
            return f"`{name}` has the value of `{other}`: the order of what is returned?"
    if said := _of_degrees(exercise, name, values, samples):
        return said
    if said := _of_units(exercise, name, values, terms, samples[2]):
        return said
    about = _dependence(exercise, name, values - right[name], call)
    where = int(np.argmax(np.abs(values - right[name])))
    state = ", ".join(f"{key} = {one[where]:.2g}" for key, one in samples[1].items())
    return f"`{name}` differs, most of all at {state}{about}."


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


def _of_degrees(exercise, name, values, samples):
    t, y, p = samples
    for factor, taken in ((math.pi / 180.0, "degrees"), (180.0 / math.pi, "radians")):
        turned = {
            key: one * factor if exercise.state[key] == "rad" else one for key, one in y.items()
        }
        theirs = sum(exercise.values(t, turned, p)[name].values())
        if any(unit == "rad" for unit in exercise.state.values()) and same(values, theirs):
            return f"`{name}` takes an angle for one in {taken}: the state is in radians."
    return ""


def _of_units(exercise, name, values, terms, p):
    """A sentence about terms with a wrong power of a parameter, such as a forgotten mass."""
    single = [{key: power} for key, power in itertools.product(p, POWERS)]
    pairs = [
        {a: m, b: n} for a, b in itertools.combinations(p, 2)
        for m, n in itertools.product((1, -1), repeat=2)
    ]  # fmt: skip
    groups = [
        group for size in (len(terms), *range(1, len(terms)))
        for group in itertools.combinations(terms, size)
    ]  # fmt: skip
    matches = []
    for extra, group in itertools.product((*single, *pairs), groups):
        factor = math.prod(p[key] ** power for key, power in extra.items())
        theirs = {key: one * factor if key in group else one for key, one in terms.items()}
        if same(values, sum(theirs.values())):
            matches.insert(0, (extra, group, []))
            break
        if also := _of_terms(values, theirs):
            matches.append((extra, group, also))
    if not matches:
        return ""
    extra, group, also = min(matches, key=lambda one: len(one[2]))
    about, verbs = _about(name, group, terms)
    if all(exercise.parameters[key] in ("", "1") for key in extra):
        said = f"{about} {verbs[0]} off by a power of `{'` and `'.join(extra)}`"
    else:
        many = " and ".join(_size(exercise, *one) for one in extra.items())
        due = exercise.answer[name]
        said = f"{about} {verbs[1]} the wrong unit: {due} is due, and {verbs[2]} {many} too many"
    return f"{'; '.join([said, *also])}."


def _about(name, group, terms):
    """The beginning of a sentence about terms of a component, and its verbs."""
    if len(group) == len(terms):
        return f"`{name}` as a whole", ("is", "has", "it has")
    if len(group) == 1:
        return f"The term of {group[0]} in `{name}`", ("is", "has", "it has")
    return f"The terms of {' and '.join(group)} in `{name}`", ("are", "have", "they have")


def _size(exercise, parameter, power):
    """The unit of a power of a parameter; the name of the parameter if it has no unit."""
    unit = exercise.parameters[parameter]
    unit = f"`{parameter}`" if unit in ("", "1") else unit
    size = unit if abs(power) == 1 else f"({unit})²"
    return size if power > 0 else f"1/({size})"


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
    theirs, due, apart = [], [], []
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
    samples, others = exercise.samples(), exercise.samples(OTHER)
    if one == "t":
        return others[0], *samples[1:]
    return samples[0], *(
        {key: (other if key == one else mine)[key] for key in mine}
        for mine, other in zip(samples[1:], others[1:], strict=True)
    )
