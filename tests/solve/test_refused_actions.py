"""Claims about states that `on_event` returns: outside of the domain, negative, or not finite."""

import math

import numpy as np
import pytest

from fastdyn import every, solve_ensemble, solve_ivp

ADAPTIVE = ["RK45", "DOP853", "Radau", "BDF", "Rodas5P", "LSODA"]


def eliminated(t, y):
    return [-0.5 * y[0]]


def low(t, y):
    return y[0] - 0.5


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("scheduled", [False, True])
def test_a_state_outside_of_the_domain_ends_the_run_before_the_action(method, scheduled):
    events = [every(5.0, start=3.0), lambda t, y: y[0] - 1e9] if scheduled else [low, every(7.0)]
    run = solve_ivp(
        eliminated, (0.0, 6.0), [1.0], method, events=events,
        on_event=[lambda t, y: [-1.0], None], domain=lambda t, y: y[0],
        dense_output=True, rtol=1e-8,
    )  # fmt: skip
    assert run.status == -1 and run.y.min() > 0.0 and run.sol(run.t).min() > 0.0
    end = 3.0 if scheduled else 2.0 * math.log(2.0)
    assert run.t[-1] == pytest.approx(end, abs=1e-5) and len(run.t_events[0]) == 1
    said = "`on_event` of event 0, a schedule," if scheduled else "`on_event` of event 0, `low`,"
    assert run.message.startswith(f"{said} returned a state outside of `domain` at t = ")
    assert "nan" not in run.message


@pytest.mark.parametrize("method", ADAPTIVE)
def test_what_rounding_makes_negative_is_zero_as_at_a_step(method):
    """All is taken out at once, but for rounding."""
    given = {"at": [1.0], "nonnegative": True, "rtol": 1e-6, "atol": 1e-9}
    run = solve_ivp(eliminated, (0.0, 3.0), [1.0], method, on_event=lambda t, y: [-1e-12], **given)
    assert run.success and run.y.min() == 0.0 and run.y[0, -1] == 0.0
    twice = np.flatnonzero(np.diff(run.t) == 0.0)
    assert run.y[0, twice + 1] == 0.0
    run = solve_ivp(eliminated, (0.0, 3.0), [1.0], method, on_event=lambda t, y: [-1e-8], **given)
    assert run.status == -1 and run.y.min() > 0.0 and run.t[-1] == 1.0
    assert run.message.startswith("`on_event` of event 0, a schedule, returned a negative number")
    assert "component 0" in run.message


def test_components_that_may_be_negative_may_become_negative():
    run = solve_ivp(
        lambda t, y: [0.0, -y[1]], (0.0, 3.0), [1.0, 1.0], at=[1.0], nonnegative=[1],
        on_event=lambda t, y: [-1.0, y[1]],
    )  # fmt: skip
    assert run.success and run.y[0, -1] == -1.0


@pytest.mark.parametrize("simd", ["auto", False])
def test_in_ensembles_each_trajectory_ends_alone(simd):
    amounts = np.array([0.2, 0.9, 0.3, 0.8])
    run = solve_ensemble(
        lambda t, y, a: [-0.5 * y[0]], (0.0, 2.0), [1.0], (amounts,), at=[1.0],
        on_event=lambda t, y, a: [y[0] - a], nonnegative=True, simd=simd,
    )  # fmt: skip
    assert run.status.tolist() == [0, -1, 0, -1] and run.y_end.min() >= 0.0
    assert run.message(1).startswith("`on_event` returned a negative number at t = 1")
    run = solve_ensemble(
        lambda t, y, a: [-0.5 * y[0]], (0.0, 2.0), [1.0], (amounts,), at=[1.0],
        on_event=lambda t, y, a: [y[0] - a], domain=lambda t, y, a: y[0] > 0.0, simd=simd,
    )  # fmt: skip
    assert run.status.tolist() == [0, -1, 0, -1] and run.y_end.min() > 0.0
    assert "outside of `domain` at t = 1" in run.message(3)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_events_and_schedules_are_named_by_their_places():
    def high(t, y):
        return y[0] - 10.0

    for place, events in enumerate([[low, every(9.0), high], [every(9.0), low, high]]):
        jumps = [None, None, None]
        jumps[place] = lambda t, y: [math.nan]
        run = solve_ivp(eliminated, (0.0, 9.0), [1.0], events=events, on_event=jumps)
        assert f"`on_event` of event {place}, `low`, returned nan" in run.message
        assert run.t_events[place].size == 1 and np.isfinite(run.y).all()
