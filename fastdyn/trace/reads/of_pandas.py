"""The steps that lead to the parts of a pandas table."""

from typing import Any


def labels_of(value, which):
    """The labels of a table, in a form that is cheap to compare."""
    labels = getattr(value, which)
    if hasattr(labels, "start"):  # a range
        return labels.start, labels.stop, labels.step
    return tuple(labels)


STEPS: dict[str, Any] = {
    "labels": labels_of,
    "numbers of": lambda value, _: value.to_numpy(),
    "column": lambda value, name: value[name],
    "line": lambda value, label: value.loc[label],
    "place": lambda value, i: value.iloc[i],
}
