"""Where a student's equations differ from the reference: component, term, sign, unit."""

import itertools
import math

import numpy as np

SAME = 1e-8  # relative
POWERS = (1, -1, 2, -2)


def compare(exercise, function):
    """
    Sentences about where a function differs from the reference of an exercise; none if nowhere.

    Parameters
    ----------
    exercise : Exercise
    function : callable
        ``function(t, y, *parameters)`` as for `solve_ivp`.

    Returns
    -------
    list of str
    """
    t, y, p = exercise.samples()
    names, rows = list(exercise.answer), []
    for n in range(len(t)):
        state, given = [one[n] for one in y.values()], [one[n] for one in p.values()]
        try:
            row = np.asarray(function(float(t[n]), np.array(state), *map(float, given)), float)
        except Exception as error:
            return [f"It raises {type(error).__name__}: {error}."]
        row = np.atleast_1d(row)
        if row.shape != (len(names),):
            listed = ", ".join(names)
            return [f"It returns {row.size} numbers; {len(names)} are asked for: {listed}."]
        rows.append(row)
    got = np.array(rows).T
    terms = exercise.values(t, y, p)
    right = {name: sum(one.values()) for name, one in terms.items()}
    found = []
    for name, values in zip(names, got, strict=True):
        if not np.isfinite(values).all():
            found.append(f"`{name}` is not finite at {np.sum(~np.isfinite(values))} states.")
        elif not _same(values, right[name]):
            found.append(_difference(exercise, name, values, terms[name], right, (t, y, p)))
    return found


def _same(a, b):
    return np.abs(a - b).max() <= SAME * max(np.abs(a).max(), np.abs(b).max(), 1e-300)


def _difference(exercise, name, values, terms, right, samples):
    """One sentence about a component that is wrong."""
    p = samples[2]
    if _same(values, -right[name]):
        return f"`{name}` has the wrong sign as a whole."
    if said := _of_terms(name, values, terms):
        return said
    for other, theirs in right.items():
        if other != name and _same(values, theirs):
            return f"`{name}` has the value of `{other}`: the order of what is returned?"
    if said := _of_degrees(exercise, name, values, samples):
        return said
    for parameter, power in itertools.product(p, POWERS):
        if _same(values, right[name] * p[parameter] ** power):
            return f"`{name}` as a whole {_unit(exercise, name, parameter, power)}"
    for about, term in terms.items():
        for parameter, power in itertools.product(p, POWERS):
            if _same(values, right[name] + term * (p[parameter] ** power - 1.0)):
                return f"The term of {about} in `{name}` {_unit(exercise, name, parameter, power)}"
    return _of_what_it_depends(exercise, name, values - right[name], samples)


def _of_terms(name, values, terms):
    """The defects of equations of which only factors of terms are wrong: signs, numbers, terms."""
    columns = np.column_stack(list(terms.values()))
    factors = np.linalg.lstsq(columns, values, rcond=1e-10)[0]
    if np.linalg.matrix_rank(columns) < len(terms) or not _same(columns @ factors, values):
        return ""
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
    return f"In `{name}` {' and '.join(said)}." if said else ""


def _of_degrees(exercise, name, values, samples):
    t, y, p = samples
    for factor, taken in ((math.pi / 180.0, "degrees"), (180.0 / math.pi, "radians")):
        turned = {
            key: one * factor if exercise.state[key] == "rad" else one for key, one in y.items()
        }
        theirs = sum(exercise.values(t, turned, p)[name].values())
        if any(unit == "rad" for unit in exercise.state.values()) and _same(values, theirs):
            return f"`{name}` takes an angle for one in {taken}: the state is in radians."
    return ""


def _unit(exercise, name, parameter, power):
    """The end of a sentence about a unit that is wrong."""
    unit = exercise.parameters[parameter]
    size = unit if abs(power) == 1 else f"({unit})²"
    extra = f"{size} too many" if power > 0 else f"1/({size}) too many"
    if unit in ("", "1"):
        return f"is off by a power of `{parameter}`."
    return f"has the wrong unit: {exercise.answer[name]} is due, and it has {extra}."


def _of_what_it_depends(exercise, name, off, samples):
    """Which of the names the difference depends on: what has to be looked at."""
    t, y, p = samples
    columns = {**y, **p, "t": t}
    where = int(np.argmax(np.abs(off)))
    size = np.corrcoef([np.abs(off), *(np.abs(one) for one in columns.values())])[0, 1:]
    likely = [key for key, one in zip(columns, np.abs(size), strict=True) if one > 0.25]
    state = ", ".join(f"{key} = {one[where]:.2g}" for key, one in y.items())
    about = f"; the difference grows or falls with {' and '.join(likely)}" if likely else ""
    return f"`{name}` differs, most of all at {state}{about}."
