"""A drawn part of the hostile functions; `python -m tests.hostile` judges as many as asked for."""

import pytest

from .compare import verdict
from .compose import draw_case

SEED, COUNT = 27, 64
KNOWN = ("equal", "warned", "refused", "no reference")


@pytest.mark.parametrize("index", range(COUNT))
def test_a_hostile_function_is_what_python_says_it_is(index):
    case = draw_case(SEED, index, light=True)
    found, details = verdict(case.source)
    assert found in KNOWN, f"{case.number} {case.name}: {found}: {details}\n{case.source}"
