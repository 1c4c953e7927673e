"""Cases of the corpus have SciPy's answer over their whole span.

Eight are in each run, the others are hunts.
"""

import pytest
import scipy.integrate

import fastdyn
from bench.corpus import agreement, load

CASES = load()
LOOSEST = 0.01  # where rounding alone does more, the case tells nothing


@pytest.mark.few(8)
@pytest.mark.parametrize("name", [name for name, case in CASES.items() if not case.random])
@pytest.mark.usefixtures("no_wrong_code")
def test_answer(name):
    """State and status at the end, and for explicit methods the evaluations."""
    case = CASES[name]
    ours = agreement.run(fastdyn.solve_ivp, case).result
    theirs = agreement.run(scipy.integrate.solve_ivp, case).result
    verdict = agreement.compare(case, ours, theirs)
    assert verdict.allowed < LOOSEST
    assert verdict.equal, (verdict, ours.nfev, theirs.nfev, ours.message)


def test_random_right_hand_sides_run():
    """Two solves differ, in SciPy, too; both reach the end."""
    drawn = [case for case in CASES.values() if case.random]
    assert drawn
    assert all(agreement.run(fastdyn.solve_ivp, case).result.success for case in drawn)


def test_a_wrong_answer_is_seen():
    """A relative error of 1e-9 in the derivative is one, under a tight tolerance."""
    case = CASES["courses.bessel"]
    theirs = agreement.run(scipy.integrate.solve_ivp, case).result
    fun = case.fun
    wrong = agreement.run(scipy.integrate.solve_ivp, case, lambda t, y: fun(t, y) * (1 + 1e-9))
    assert not agreement.compare(case, wrong.result, theirs).equal
