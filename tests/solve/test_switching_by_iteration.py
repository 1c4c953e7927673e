"""Functions that iterate to a tolerance at each time: their switching times in bounded work."""

import math
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.trace.switching import divisions

SPAN = 0.0, 300.0


def moving(tolerance, pulse):
    """A forced oscillator under a moon whose anomaly is found by Newton's method."""

    def anomaly(M, e):
        E = M
        for _ in range(20):
            step = (E - e * np.sin(E) - M) / (1.0 - e * np.cos(E))
            E = E - step
            if abs(step) < tolerance:
                break
        return E

    def moon(t, y):
        kick = pulse if 150.0 < t < 150.2 else 0.0
        return [y[1], kick - y[0] + 0.1 * np.cos(anomaly(2.0 * math.pi * t / 27.3, 0.05))]

    return moon


@pytest.fixture
def work(monkeypatch):
    """The numbers that searches computed, one item a search."""
    spent = []
    found = divisions.Divisions.found

    def counted(self, end):
        result = found(self, end)
        spent.append(self._work)
        return result

    monkeypatch.setattr(divisions.Divisions, "found", counted)
    return spent


@pytest.fixture
def operations(monkeypatch):
    """The operations of searches, one item a search."""
    spent = []
    found = divisions.Divisions.found

    def counted(self, end):
        result = found(self, end)
        spent.append(self._operations)
        return result

    monkeypatch.setattr(divisions.Divisions, "found", counted)
    return spent


def test_decisions_by_long_formulas_are_searched_in_few_operations(operations):
    """The least distance to 150 times takes formulas of 150 terms, at which 150 decisions look."""
    times = np.linspace(0.0, 20.0, 150)
    heights = np.sin(3.0 * times)

    def held(t, y):
        distance = np.abs(times - t)
        return [heights @ (distance == distance.min()) - y[0]]

    with pytest.warns(fastdyn.SwitchingWarning, match="too long to search"):
        found = fastdyn.prepare(held, (0, 20), [0.0], method="RK45", max_step=0.02)([0.0])
    theirs = scipy.integrate.solve_ivp(held, (0, 20), [0.0], max_step=0.02)
    assert found.nfev == theirs.nfev and np.allclose(found.y, theirs.y, rtol=0, atol=1e-12)
    assert max(operations) < 2 * divisions.MOST_OPERATIONS


def test_an_iteration_that_converges_is_searched_in_few_numbers(work):
    """Samples are evaluated once, and residuals that are rounding divide nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", fastdyn.SwitchingWarning)
        solver = fastdyn.prepare(moving(1e-12, 0.0), SPAN, [1.0, 0.0], method="Tsit5", rtol=1e-6)
        solver([1.0, 0.0])
    assert 0 < sum(work) < divisions.MOST_WORK / 4


def test_an_iteration_that_ends_in_rounding_is_told_of(work):
    """The search is given up, and the pulse between exact times is found."""
    rtol = 1e-8
    options = {"method": "Tsit5", "rtol": rtol, "atol": rtol}
    noisy = moving(1e-15, 5.0)
    with pytest.warns(fastdyn.SwitchingWarning, match="too long to search") as said:
        solver = fastdyn.prepare(noisy, SPAN, [1.0, 0.0], **options)
        found = solver([1.0, 0.0])
    assert len(said) == 1
    assert len(work) == 2
    assert 4 * divisions.MOST_WORK > work[0] > divisions.MOST_WORK > 10 * work[1]
    plain = fastdyn.solve_ivp(
        moving(1e-12, 5.0), SPAN, [1.0, 0.0], breakpoints=[150.0, 150.2], **options
    )
    assert found.nfev < 1.1 * plain.nfev  # no step ends at noise
    assert np.abs(found.y[:, -1] - plain.y[:, -1]).max() < 100 * rtol
