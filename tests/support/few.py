"""Which parameters of a test are in each run: the marker `few`."""

import random

import pytest


def left_out(items, n=None):
    """The items of a test that are hunts: all but n, the same ones each time.

    Without n, an item is left out if each value of its parameters is that of an item before, so
    that each method and each problem of a product is in one pair.
    """
    drawn = random.Random(0).sample(items, len(items))
    if n is not None:
        return drawn[n:]
    known, found = set(), []
    for item in drawn:
        values = item.callspec.params.items()
        of_item = {(name, v if isinstance(v, (str, int, float)) else id(v)) for name, v in values}
        found += [item] if of_item <= known else []
        known |= of_item
    return found


def hunts(values, *each_run):
    """The parameters of a test: `each_run` of them are in each run, the others are hunts."""
    return [v if v in each_run else pytest.param(v, marks=pytest.mark.hunt) for v in values]
