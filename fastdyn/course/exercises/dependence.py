"""The numbers on which the difference of two functions depends, changed one at a time."""

from .call import Refused

OTHER = 2  # seed of the values that are exchanged


def dependence(exercise, name, off, call, same):
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
    same : callable
        Whether two arrays are equal but for rounding.
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
