"""Actions of events and schedules in delay equations: each jump comes back after each delay."""

import numpy as np
import pytest

from fastdyn.delays import solve_dde
from fastdyn.delays.equation import EXPLICIT

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def rising(t, y, past):
    """y' = 1, and z' is y a unit before."""
    return [1.0, past(t - 1.0)[0]]


def before(t):
    return [t, 0.0]


def area(a, b):
    """The integral of t from a to b."""
    return (b * b - a * a) / 2


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_jump_of_an_event_comes_back_after_the_delay(method):
    """y falls by 2 at 0.55 and 2.55: steps end a unit later, and z is exact."""

    def high(t, y, past):
        return y[0] - 0.55

    def fall(t, y, past):
        return [y[0] - 2.0, y[1]]

    found = solve_dde(rising, (0, 3), before, method, events=high, on_event=fall, **TIGHT)
    np.testing.assert_allclose(found.t_events[0], [0.55, 2.55], rtol=1e-14)
    np.testing.assert_allclose(found.jumps, [0.0, 0.55, 2.55], rtol=1e-14)
    assert np.abs(found.t - 1.55).min() < 1e-14
    assert abs(found.y[1, -1] - area(-1, 0.55) - area(-1.45, 0)) < 1e-13


@pytest.mark.parametrize("given", [{"at": [0.7, 1.1]}, {"every": 0.4}])
def test_schedules_act_and_come_back(given):
    """y rises by the past half a unit before: from t on by c - 0.5, where y is t + c."""

    def add(t, y, past):
        return [y[0] + past(t - 0.5)[0], y[1]]

    found = solve_dde(rising, (0, 1.3), before, on_event=add, **given, **TIGHT)
    times = given.get("at") or (0.4 * np.arange(4)).tolist()
    assert found.jumps.tolist() == sorted({0.0, *times})
    height = exact = 0.0
    pieces = [(-1.0, 0.0)]  # the start of a piece of y, and y - t there
    for t in times:
        before_half = t - 0.5
        late = [c for start, c in pieces if start <= before_half + 1e-12][-1]
        height += before_half + late
        pieces.append((t, height))
    ends = [*[start for start, _ in pieces[1:]], np.inf]
    for (start, c), end in zip(pieces, ends, strict=True):
        end = min(end, 0.3)
        if end > start:
            exact += area(start, end) + c * (end - start)
    assert abs(found.y[0, -1] - 1.3 - height) < 1e-13
    assert abs(found.y[1, -1] - exact) < 1e-12
    assert all(np.abs(found.t - t - 1.0).min() < 1e-13 for t in times if t < 0.3)


def test_behind_an_action_the_polynomial_of_the_last_step_is_over():
    """The event ends the step from 0.5 to 0.6.  The step behind asks for times up to 0.6, where
    that polynomial goes on as if nothing had acted."""

    def fun(t, y, past):
        return [1.0, past(2 * t - 0.7)[0]]  # a delay of 0.7 - t

    def high(t, y, past):
        return y[0] - 0.55

    def fall(t, y, past):
        return [y[0] - 2.0, y[1]]

    found = solve_dde(
        fun, (0, 0.68), before, "Vern7", events=high, on_event=fall, rtol=1e-9, atol=1e-11,
        first_step=0.1, max_step=0.1,
    )  # fmt: skip
    exact = 0.5 * (area(-0.7, 0.66) - 2.0 * (0.66 - 0.55))
    assert abs(found.y[1, -1] - exact) < 10 * 1e-9


def test_a_number_ends_the_run_and_breakpoints_are_carried_on():
    def high(t, y, past):
        return y[0] - 0.25

    high.terminal = 3

    def fall(t, y, past):
        return [y[0] - 0.5, y[1]]

    found = solve_dde(
        rising, (0, 9), before, events=high, on_event=fall, breakpoints=[0.125], **TIGHT
    )
    assert found.status == 1
    np.testing.assert_allclose(found.t_events[0], [0.25, 0.75, 1.25], rtol=1e-13)
    assert 1.125 in found.t.tolist()


def test_other_options_are_refused_by_name():
    for name in ("project", "adjoint", "callback", "discrete"):
        with pytest.raises(TypeError, match=f"takes no `{name}`"):
            solve_dde(rising, (0, 1), before, **{name: 1})


def test_actions_of_neutral_equations_are_refused():
    def neutral(t, y, past):
        return [0.5 * past.derivative(t - 1.0)[0], 0.0]

    with pytest.raises(ValueError, match="derivative is an impulse"):
        solve_dde(neutral, (0, 2), before, at=[0.5], on_event=lambda t, y, past: 2 * y)
