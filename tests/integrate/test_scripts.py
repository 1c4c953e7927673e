"""Scripts with odeint, as people write them, run by one changed import."""

import numpy as np
import pytest
import scipy.integrate

from bench.corpus import odeint as scripts
from fastdyn import odeint

SCRIPTS = scripts.load()
TOLERANCE = 1.49012e-8  # the default
MANY_STEPS = 50_000


def nearly_exact(func, y0, t, args=(), **given):
    """SciPy's solution with tolerances far below those of the script."""
    tight = {"rtol": 1e-10, "atol": 1e-10, "mxstep": MANY_STEPS}
    return scipy.integrate.odeint(func, y0, t, args, **{**given, **tight})


def check(title):
    """The script's answers differ from SciPy's by no more than these from nearly exact ones.

    Both take LSODA's steps: what rounding does to them is far less than their errors.
    """
    script = SCRIPTS[title]
    solvers = odeint, scipy.integrate.odeint, nearly_exact
    for ours, theirs, exact in zip(*[scripts.run(script, one) for one in solvers], strict=True):
        assert ours.shape == theirs.shape
        size = 1 + np.abs(theirs).max(axis=0)
        errors = np.abs(theirs - exact).max(axis=0)
        assert (np.abs(ours - theirs) <= errors + 10 * TOLERANCE * size).all()


@pytest.mark.few(8)
@pytest.mark.parametrize("title", SCRIPTS)
def test_a_compiled_script_has_scipys_answers(title):
    check(title)


@pytest.mark.few(4)
@pytest.mark.parametrize("title", SCRIPTS)
def test_a_script_has_scipys_answers(patience, title):
    check(title)


def test_the_corpus_has_scripts_of_all_forms():
    text = "".join(SCRIPTS.values())
    assert len(SCRIPTS) > 70
    for form in (
        "tfirst",
        "Dfun",
        "full_output",
        "ml=",
        "hmax",
        "tcrit",
        "rtol",
        "mxstep",
        "lambda",
    ):
        assert form in text
