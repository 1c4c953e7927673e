"""A drawn part of the hostile functions; `python -m tests.hostile` judges as many as asked for."""

import pytest

from .compare import verdict
from .compose import draw_case
from .selections import draw_selection
from .templates import all_idioms
from .workers import judged

SEED, COUNT = 27, 64
KNOWN = ("equal", "warned", "refused", "no reference")


@pytest.mark.few(6)
@pytest.mark.usefixtures("no_wrong_code")
@pytest.mark.parametrize("index", range(COUNT))
def test_a_hostile_function_is_what_python_says_it_is(index):
    case = draw_case(SEED, index, light=True)
    found, details = verdict(case.source)
    assert found in KNOWN, f"{case.number} {case.name}: {found}: {details}\n{case.source}"


SECOND_TIME = """
import os, sys, time
sys.drawn_loads = getattr(sys, "drawn_loads", -1) + 1
loads, left = int(sys.drawn_loads == 1), []
def fun(t, y): {line}; return [-y[0]]
def watched(): return left
HOW = {{"way": "once", "method": "RK45", "rtol": 1e-6, "atol": 1e-8, "span": (0, 2), "y0": [1.0]}}
"""


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("pass", "equal"),
        ("return [-y[0] * (1 + 1e-16 * loads)]", "equal"),
        ("return [-y[0] * (1 + 1e-10 * loads)]", "difference"),
        ("left[:] = [loads]", "difference"),
        ("return [-y[0] / (1 - loads * (t > 1.9))]", "difference"),
        ("assert loads < 1", "difference"),
        ("return [0.5 - (t > 0.7)]", "equal"),
    ],
)
def test_the_judge_sees_a_function_that_is_another_for_fastdyn(line, expected, monkeypatch):
    """The module is loaded first for SciPy: what depends on that differs as wrong code would."""
    monkeypatch.setattr("sys.drawn_loads", -1, raising=False)
    found, details = verdict(SECOND_TIME.format(line=line))
    assert found.replace("warned", "equal") == expected, details


@pytest.mark.hunt
def test_what_hangs_or_dies_is_named(monkeypatch):
    monkeypatch.setattr("hostile.workers.HANG", 2.0)
    seen = []
    lines = "time.sleep(60 * loads)", "loads and os._exit(3)", "pass"
    cases = [draw_case(0, 0)._replace(source=SECOND_TIME.format(line=line)) for line in lines]
    judged(cases, 1, lambda case, *found: seen.append(found[:2]), ("RK45",))
    assert [found for found, _ in seen] == ["hang", "crash", "equal"], seen


def test_a_draw_is_the_same_each_time_and_each_idiom_has_its_turn():
    n = len(all_idioms())
    names = [draw_case(3, index).name.split(" + ")[0] for index in range(n)]
    assert len(set(names)) == n > 400
    assert draw_case(3, 5) == draw_case(3, 5) != draw_case(3, 5 + n)


@pytest.mark.few(5)
@pytest.mark.parametrize("index", range(COUNT))
def test_a_selection_of_a_long_array_is_numpys(index):
    case = draw_selection(SEED, index)
    found, details = verdict(case.source)
    assert found in KNOWN, f"{case.number}: {found}: {details}\n{case.source}"
