"""Starts, Ctrl-C, progress, and functions that fail at some parameters."""

import math
import os
import signal

import numpy as np
import pytest

from fastdyn import Free, Record, fit
from support.fits import KNOWN, pendulum, tight

T = np.linspace(0, 20, 60)


def swinging(stiffness, **options):
    values = tight(pendulum, T, [1.0, 0.0], (9.0, 0.02))[:1]
    args = Free(stiffness, low=0.5, high=40.0), 0.02
    return fit(pendulum, Record(T, values, [1.0, 0.0], args, 0.01, 0), **options)


def test_starts_find_the_best_of_many_optima():
    """Where the phase is off by more than half a turn, there is a valley of its own."""
    lost, found = swinging(14.0), swinging(14.0, starts=60)
    assert lost.chi2 > 1e4 and found.chi2 < 1e-3
    assert "a better optimum" in str(lost) and "a better optimum" not in str(found)
    assert np.allclose(found.x, [9.0], rtol=1e-5)
    given = swinging(14.0, starts=[[20.0], [9.2]])
    assert np.allclose(given.x, found.x, rtol=1e-5)


def test_starts_do_without_an_ensemble():
    """Arguments that are arrays do not vary in an ensemble."""

    def spring(t, y, both):
        return [y[1], -both[0] * y[0] - both[1] * y[1]]

    values = tight(spring, T, [1.0, 0.0], (np.array([9.0, 0.02]),))[:1]
    free = Free([14.0, 0.1], low=[1.0, 0.0], high=[30.0, 0.2])
    found = fit(spring, Record(T, values, [1.0, 0.0], (free,), 0.01, 0), starts=40)
    assert np.allclose(found.x, [9.0, 0.02], rtol=1e-4)


def fails_above(t, y, rate):
    if rate > 1.0:
        raise ValueError("no rate is above 1")
    return [-rate * y[0]]


def roots(t, y, rate):
    return [-math.sqrt(1.0 - rate) * y[0]]


def bursts(t, y, rate):
    return [rate * y[0] ** 2]


@pytest.mark.parametrize(
    ("fun", "truth", "start"), [(fails_above, 0.9, 0.05), (roots, 0.99, 0.0), (bursts, 0.6, 0.1)]
)
def test_a_function_may_fail_at_some_parameters(fun, truth, start):
    """The search goes on with shorter steps: beyond 1, 1, and 0.625 there is no motion."""
    t = np.linspace(0, 1.6, 15)
    values = tight(fun, t, [1.0], (truth,))
    for starts in (1, [[truth + 0.5], [truth - 0.1]]):
        found = fit(fun, Record(t, values, [1.0], (Free(start),), 0.01), starts=starts)
        assert np.isclose(found.x[0], truth, rtol=1e-4) and found.success


def test_a_motion_that_fails_at_the_start_is_told():
    t = np.linspace(0, 2, 5)
    record = Record(t, np.ones(5), [1.0], (Free(5.0),), 0.01)
    with pytest.raises(ValueError, match=r"cannot start at rate = 5: ValueError: no rate is above"):
        fit(fails_above, record)
    with pytest.raises(ValueError, match=r"cannot start at rate = 5: .*t = 0.2"):
        fit(bursts, record)
    with pytest.raises(ValueError, match=r"fails at all 2 starts: .*no rate is above 1"):
        fit(fails_above, record, starts=[[4.0]])


def test_what_is_observed_may_be_undefined():
    def logarithm(t, y, rate):
        return np.log(y[0] - 0.1)

    t = np.linspace(0, 1, 10)
    values = np.log(np.exp(-0.8 * t) - 0.1)
    record = Record(t, values, [1.0], (Free(0.1),), 0.01, logarithm)
    assert np.isclose(fit(lambda t, y, rate: [-rate * y[0]], record).x[0], 0.8, rtol=1e-6)
    record = Record(t, values, [1.0], (Free(8.0),), 0.01, logarithm)
    with pytest.raises(ValueError, match="cannot start at rate = 8: what is observed"):
        fit(lambda t, y, rate: [-rate * y[0]], record)


def test_mistakes_of_the_user_are_raised():
    def wrong(t, y, rate):
        return [-rate * y[1]]

    with pytest.raises(IndexError):
        fit(wrong, Record(T, np.ones(60), [1.0], (Free(1.0),), 0.1))


@pytest.mark.parametrize("after", [2, 4])
def test_control_c_returns_the_best_so_far(monkeypatch, after):
    from fastdyn.fitting.motion import FittedMotion

    count, own = [0], FittedMotion.slopes

    def slopes(self, x, times):
        count[0] += 1
        if count[0] == after:
            os.kill(os.getpid(), signal.SIGINT)
        return own(self, x, times)

    known = KNOWN["pendulum"]()
    best = known.fitted(0).chi2
    monkeypatch.setattr(FittedMotion, "slopes", slopes)
    found = known.fitted(0)
    assert count[0] == after and not found.success and "Ctrl-C" in str(found)
    assert best < found.chi2 < np.inf and len(found.x) == 4


def test_control_c_before_the_first_trial_is_raised(monkeypatch):
    def slopes(self, x, times):
        raise KeyboardInterrupt

    monkeypatch.setattr("fastdyn.fitting.motion.FittedMotion.slopes", slopes)
    with pytest.raises(KeyboardInterrupt):
        KNOWN["pendulum"]().fitted(0)


def test_progress_is_shown_on_stderr_if_asked(capsys):
    KNOWN["pendulum"]().fitted(0)
    assert capsys.readouterr() == ("", "")
    KNOWN["pendulum"]().fitted(0, progress=True)
    out, err = capsys.readouterr()
    assert out == "" and "trials" in err and "chi2 = " in err


def test_the_search_ends_after_max_nfev():
    found = KNOWN["pendulum"]().fitted(0, max_nfev=2)
    assert not found.success and found.n_trials == 2 and "maximum number" in str(found)
    assert "smaller sum" not in str(found)
    found.profile("damping")  # fits the others, beyond where the search has ended
    assert "A profile met a smaller sum of squares" in str(found)


def test_values_from_outside_that_change_are_noticed():
    gravity = [9.0]

    def pulled(t, y, damping):
        return [y[1], -gravity[0] * np.sin(y[0]) - damping * y[1]]

    values = tight(pulled, T, [1.0, 0.0], (0.1,))[0]
    found = fit(pulled, Record(T, values, [1.0, 0.0], (Free(0.2),), 0.01, observed=0))
    gravity[0] = 9.5
    for ask in (lambda: found.intervals, lambda: found.profile("damping"), lambda: str(found)):
        with pytest.raises(ValueError, match="has changed"):
            ask()
    gravity[0] = 9.0
    assert np.isclose(found.x[0], 0.1, rtol=1e-6) and not found.curved
