"""Events of which a step has several: what each rule lets count, and what ends the step between."""

import warnings

import numpy as np
import pytest

from fastdyn import SwitchingWarning, solve_ensemble, solve_ivp
from fastdyn.compile import budget

END, W, LEVEL = 10.0, 50.0, 0.9
TIGHT = {"rtol": 1e-7, "atol": 1e-9}
RESOLVED = 4 * np.finfo(float).eps * (1 + END) + 1e-12  # of a root, and of the sine of 500
OWN = ("Tsit5", "Vern9", "Rodas5P", "Taylor")
ALL = (*OWN, "RK45", "DOP853", "Radau", "LSODA", "ode45")


def decays(t, y):
    return [-0.1 * y[0]]


def rises(t, y):
    return [1.0]


def same(t, y):
    return y


def with_rules(function, **rules):
    """A copy of an event function with attributes."""

    def event(t, y):
        return function(t, y)

    for name, value in rules.items():
        setattr(event, name, value)
    return event


def wave(t, y):
    return np.sin(W * t) - LEVEL


def zeros(direction, w=W, level=LEVEL):
    """The zeros of sin(w t) - level up to END."""
    turns = 2 * np.pi * np.arange(int(w * END / (2 * np.pi)) + 1)
    rising = (np.arcsin(level) + turns) / w
    falling = (np.pi - np.arcsin(level) + turns) / w
    found = np.sort({0: np.r_[rising, falling], 1: rising, -1: falling}[direction])
    return found[found < END]


def thinned(times, wait):
    found = []
    for t in times:
        if not found or t - found[-1] >= wait:
            found.append(t)
    return np.array(found)


@pytest.mark.few(9)
@pytest.mark.parametrize(("wait", "direction"), [(0.05, 0), (0.2, 1), (0.7, -1)])
@pytest.mark.parametrize("method", ALL)
def test_an_event_that_acts_waits_within_a_step(method, wait, direction):
    """The first crossing of a step comes too early, and others of the same step do not."""
    event = with_rules(wave, wait=wait, direction=direction)
    run = solve_ivp(decays, (0, END), [1.0], method, events=event, on_event=same, **TIGHT)
    assert run.t_events[0] == pytest.approx(thinned(zeros(direction), wait), rel=0, abs=RESOLVED)


@pytest.mark.parametrize("simd", [True, False])
def test_members_of_an_ensemble_wait_within_a_step(simd):
    event = with_rules(wave, wait=0.2)
    starts = np.ones((5, 1))
    many = solve_ensemble(
        decays, (0, END), starts, method="Tsit5", events=event, on_event=same, simd=simd, **TIGHT
    )
    for times in many.t_events[0]:
        assert times == pytest.approx(thinned(zeros(0), 0.2), rel=0, abs=RESOLVED)


def product(*places):
    """The product of the distances of y = t from some places."""
    a, b = places
    return lambda t, y: (y[0] - a) * (y[0] - b)


@pytest.mark.parametrize(("direction", "expected"), [(0, [0, 1]), (-1, [0]), (1, [1])])
@pytest.mark.parametrize("acts", [None, same])
@pytest.mark.parametrize("method", ["RK4", "Tsit5", "Vern9", "Rodas5P", "Taylor"])
@pytest.mark.parametrize("places", [(0.0, 1.0), (1.0, 4.0)])
def test_a_zero_at_an_end_of_a_step_hides_none_within(method, places, acts, direction, expected):
    """The first step is from 0 to 4: a zero at its start, or at its end, and one at 1."""
    run = solve_ivp(
        rises, (0, 10), [0.0], method, events=with_rules(product(*places), direction=direction),
        on_event=acts, **{"step" if method == "RK4" else "first_step": 4.0},
    )  # fmt: skip
    found = [places[i] for i in expected]
    if acts and direction == 0:  # a contact at the start acts with a direction only
        found = [t for t in found if t > 0.0]
    assert run.t_events[0] == pytest.approx(found, rel=0, abs=1e-12)


@pytest.mark.few(8)
@pytest.mark.parametrize("wait", [0.0, 0.1])
@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("acts", [None, same])
@pytest.mark.parametrize("method", [*OWN, "RK45", "DOP853"])
def test_an_action_moves_no_other_event_of_its_step(method, acts, direction, wait):
    """The other event crosses zero before the action, where it does not count, and behind."""
    slow = with_rules(lambda t, y: np.sin(3 * t) - 0.5)
    fast = with_rules(lambda t, y: np.sin(W * t) - 0.3, direction=direction, wait=wait)
    if acts is None and method not in OWN:
        acts = same  # else SciPy's occurrences, one a step
    run = solve_ivp(decays, (0, END), [1.0], method, events=[slow, fast], on_event=[same, acts],
                    **TIGHT)  # fmt: skip
    assert run.t_events[0] == pytest.approx(zeros(0, 3.0, 0.5), rel=0, abs=RESOLVED)
    expected = thinned(zeros(direction, W, 0.3), wait)
    assert run.t_events[1] == pytest.approx(expected, rel=0, abs=RESOLVED)


@pytest.mark.parametrize("method", OWN)
def test_what_is_behind_the_end_of_a_run_is_not_lost(method):
    """A step has more occurrences than there is room for, and the run ends at the third."""
    event = with_rules(lambda t, y: np.sin(5000.0 * t + 0.1), terminal=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error", SwitchingWarning)
        run = solve_ivp(lambda t, y: [-1e-6 * y[0]], (0, 10), [1.0], method, events=event)
    expected = (np.pi * np.arange(1, 4) - 0.1) / 5000.0
    assert run.t_events[0] == pytest.approx(expected, rel=0, abs=RESOLVED)


@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("first", [0, 1])
def test_an_event_at_the_end_of_a_run_counts_in_any_order(method, first):
    ends = with_rules(lambda t, y: y[0] - 0.7, terminal=True)
    looks = with_rules(lambda t, y: 3.0 * y[0] - 2.1)
    events = [ends, looks] if first == 0 else [looks, ends]
    run = solve_ivp(decays, (0, END), [1.0], method, events=events, **TIGHT)
    assert run.status == 1
    for times in run.t_events:
        assert times == pytest.approx([run.t[-1]], rel=0, abs=RESOLVED)


def test_an_event_waits_longer_for_its_code_than_the_equations(monkeypatch):
    """A first solve has used its time for the equations, and the values show no fast turns."""
    within = budget.within
    asked = set()

    def late(place, *given):
        if place in asked:
            return within(place, *given)
        asked.add(place)
        return None, budget.Account("late")

    monkeypatch.setattr(budget, "within", late)
    event = with_rules(lambda t, y: np.sin(5000.0 * t + 0.1), terminal=3)
    run = solve_ivp(lambda t, y: [-1e-6 * y[0] + 0.0], (0, 10), [1.0], "Tsit5", events=event)
    assert len(asked) == 2
    assert run.t[-1] == pytest.approx((3 * np.pi - 0.1) / 5000.0, rel=0, abs=RESOLVED)
