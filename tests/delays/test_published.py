"""Published test sets of delay equations, each within ten tolerances of its exact solution."""

import numpy as np
import pytest

from fastdyn.delays import solve_dde
from fastdyn.delays.equation import EXPLICIT, METHODS, NEUTRAL
from support.published_delays import DDETST, OF_THE_STATE, PAUL
from support.shifted_copies import end_of

TENFOLD = 10.0
# The delay of G1 touches the jump of y' at the end of the span, so that a rounding 2e-16 moves the
# place where the jump is passed by its root, 3e-8: no tolerance below is reached.
TOUCHING = {"G1": 1e-8}


def error_of(published, method, rtol):
    """The largest error at the end, in tolerances."""
    p = published
    history = p.solution if p.history is None else p.history
    found = solve_dde(p.fun, (p.t0, p.tf), history, method, rtol=rtol, atol=rtol)
    assert found.success, found.message
    exact = np.array(p.solution(p.tf))
    return np.abs((found.y[:, -1] - exact) / (1 + np.abs(exact))).max() / rtol


@pytest.mark.parametrize("published", [*DDETST, *OF_THE_STATE], ids=lambda p: p.name)
def test_exact_solutions(published):
    """Delays of the time and the state, that vanish, neutral ones, and a switch on the past."""
    for rtol in 10.0 ** -np.arange(3, 11):
        if rtol >= TOUCHING.get(published.name, 0.0):
            assert error_of(published, "auto", rtol) < TENFOLD, rtol


def growth_of(published):
    """By how much a change of the history grows up to the end; 1 at least."""
    p = published
    history = p.solution if p.history is None else p.history
    ends = []
    for more in (0.0, 1e-6):

        def moved(t, more=more):
            before = np.array(history(t) if callable(history) else history)
            return before + more * np.cos(np.arange(before.size))

        found = solve_dde(p.fun, (p.t0, p.tf), moved, "Vern9", rtol=1e-11, atol=1e-11)
        ends.append(found.y[:, -1])
    return max(1.0, np.abs((ends[1] - ends[0]) / (1 + np.abs(ends[0]))).max() / 1e-6)


OF_PAUL = [
    pytest.param(p, method, marks=() if method in ("Tsit5", "Vern7", "Radau") else pytest.mark.hunt,
                 id=f"{p.name} {method}")
    for p in PAUL for method in METHODS
]  # fmt: skip


@pytest.mark.parametrize(("published", "method"), OF_PAUL)
def test_equations_of_paul(published, method):
    """Whether or not the jumps of a history are given: they cost up to 55 tolerances in silence."""
    p = published
    history = p.solution if p.history is None else p.history
    exact = np.array(p.solution(p.tf))
    most = TENFOLD * growth_of(p)
    for rtol in 10.0 ** -np.arange(3, 11):
        for jumps in {p.jumps or None, None}:
            found = solve_dde(
                p.fun, (p.t0, p.tf), history, method, rtol=rtol, atol=rtol, jumps=jumps
            )
            error = np.abs((found.y[:, -1] - exact) / (1 + np.abs(exact))).max()
            assert error < most * rtol, (rtol, jumps, error / rtol)


OTHERS = [
    pytest.param(p, method, marks=pytest.mark.hunt, id=f"{p.name} {method}")
    for p in (*DDETST, *OF_THE_STATE)
    for method in (NEUTRAL if p.neutral else METHODS)
]


@pytest.mark.parametrize(("published", "method"), OTHERS)
def test_exact_solutions_by_all_methods(published, method):
    for rtol in 10.0 ** -np.arange(3, 11):
        if rtol >= TOUCHING.get(published.name, 0.0):
            assert error_of(published, method, rtol) < TENFOLD, rtol


@pytest.mark.parametrize("published", OF_THE_STATE, ids=lambda p: p.name)
def test_a_rosenbrock_method_sees_jumps_at_unknown_times(published):
    """Its error estimate does not: errors were up to 39 tolerances."""
    for rtol in 10.0 ** -np.arange(3, 11):
        assert error_of(published, "Rodas5P", rtol) < TENFOLD, rtol


@pytest.mark.parametrize("method", EXPLICIT)
def test_wille_and_baker(method):
    """Example 3 of D. R. Wille and C. T. H. Baker (1992), and of dde23: piecewise polynomials."""

    def fun(t, y, past):
        return [past(t - 1.0)[0], past(t - 1.0)[0] + past(t - 0.2)[1], y[1]]

    def chained(t, y, shifted):
        return [shifted[0][0], shifted[0][0] + shifted[1][1], y[1]]

    exact = end_of(chained, lambda t: np.ones(3), 0.2, (5, 1), 25)
    for rtol in (1e-3, 1e-6, 1e-9):
        found = solve_dde(fun, (0, 5), np.ones(3), method, rtol=rtol, atol=rtol)
        assert np.abs(found.y[:, -1] / exact - 1).max() < TENFOLD * rtol
