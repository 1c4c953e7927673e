"""Claims about events that have a series: none is missed, however many a step has."""

import math

import numpy as np
import pytest

import fastdyn
from tests.support.impacts import G, ball_after, impacts, last_impact
from tests.support.linear_series import NAME, ORDER, install, series_of

EPS = np.finfo(float).eps


@pytest.fixture(autouse=True)
def method(monkeypatch):
    install(monkeypatch)


def spring(t, y):
    return [y[1], -y[0]]


def linear(weights, constant=0.0, n_terms=ORDER + 1, **attributes):
    """The event function weights . y + constant, with so many terms of its series."""

    def event(t, y):
        return sum(w * c for w, c in zip(weights, y, strict=True)) + constant

    vars(event).update(attributes, series=series_of(tuple(weights), constant, n_terms))
    return event


def solve(fun, t_span, y0, step, events, **options):
    options = {"step": step, "events": events, "compile": "shared"} | options
    return fastdyn.solve_ivp(fun, t_span, y0, NAME, **options)


@pytest.mark.parametrize("step", [0.1, 1.0, 5.0])
def test_every_zero_of_a_cosine_is_found(step):
    run = solve(spring, (0.0, 40.0), [1.0, 0.0], step, linear((1.0, 0.0)))
    exact = np.pi * (np.arange(13) + 0.5)
    assert run.t_events[0] == pytest.approx(exact, abs=1e-12)


def exact(t, y0, w=(1.0, 1.7)):
    """Two springs of frequencies w, from rest."""
    return np.array([y0[0] * np.cos(w[0] * t), y0[2] * np.cos(w[1] * t)])


def springs(t, y):
    return [y[1], -y[0], y[3], -1.7 * 1.7 * y[2]]


def found_by_scan(g, t_end, n=400_001):
    """Where a function changes its sign, to the grid, and in which direction."""
    t = np.linspace(0.0, t_end, n)
    sign = np.sign(g(t))
    at = np.flatnonzero(sign[1:] != sign[:-1])
    return t[at], t[at + 1], sign[at + 1]


@pytest.mark.hunt
@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("seed", range(4))
def test_random_events_are_those_of_a_fine_scan(seed, direction):
    rng, t_end = np.random.default_rng(seed), 60.0
    y0 = [1.0, 0.0, rng.uniform(0.3, 1.5), 0.0]
    levels = rng.uniform(-1.2, 1.2, 5)
    events = [linear((1.0, 0.0, 1.0, 0.0), c, direction=direction) for c in levels]
    run = solve(springs, (0.0, t_end), y0, rng.uniform(0.5, 3.0), events)
    for c, t in zip(levels, run.t_events, strict=True):
        low, high, sign = found_by_scan(lambda s, c=c: exact(s, y0).sum(axis=0) + c, t_end)
        wanted = (direction == 0) | (sign == direction)
        assert len(t) == wanted.sum() > 5
        assert np.all(low[wanted] <= t + 1e-9) and np.all(t <= high[wanted] + 1e-9)


@pytest.mark.parametrize("step", [0.7, 2.0, 5.0])
def test_a_graze_is_found_and_has_no_direction(step):
    events = [linear((-1.0, 0.0), 1.0, direction=d) for d in (0, 1, -1)]
    run = solve(spring, (0.0, 30.0), [0.0, 1.0], step, events)
    tops = np.pi * (np.arange(5) * 2.0 + 0.5)
    # The value there is known to 1e-15, the place to the slope of the slope: sqrt only for noise.
    assert run.t_events[0] == pytest.approx(tops, abs=1e-7)
    assert [len(t) for t in run.t_events] == [5, 0, 0]


def even(t, y):
    return [y[1], 0.0]


@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("start", [-2.0, -1.5, 2.0])
@pytest.mark.parametrize("off", [0.0, 2 * EPS, -2 * EPS])
def test_a_zero_at_the_end_of_a_step_is_found_once(off, start, direction):
    """Also if it lies before or behind it by what cannot be told."""
    speed = -np.sign(start)
    event = linear((1.0, 0.0), off, direction=direction)
    run = solve(even, (0.0, 4.0), [start, speed], 0.5, event)
    expected = [abs(start)] if direction in (0, speed) else []
    assert run.t_events[0].tolist() == pytest.approx(expected, abs=4 * EPS)
    stopped = solve(even, (0.0, abs(start)), [start, speed], 0.5, event)
    assert stopped.t_events[0].tolist() == run.t_events[0].tolist()


@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("off", [0.0, 1e-12, -1e-12, 1e-8, -1e-8, 1e-6, -1e-6])
@pytest.mark.parametrize("n_terms", [9, 15])
def test_a_series_that_breaks_off_loses_nothing_between_steps(n_terms, off, direction):
    """Zeros lie near the ends of steps, by less than what the series lacks, and more."""
    event = linear((1.0, 0.0), 0.0, n_terms, direction=direction)
    step = np.pi / 8.0 * (1.0 + off)
    run = solve(spring, (0.0, 100.0), [1.0, 0.0], step, event)
    zeros = np.pi * (np.arange(32) + 0.5)
    expected = {0: zeros, 1: zeros[1::2], -1: zeros[::2]}[direction]
    assert len(run.t_events[0]) == len(expected[expected < 100.0])
    lacks = step**n_terms / math.factorial(n_terms)
    near = 1e-12 + lacks * n_terms * 300.0 * abs(off)  # to the end, where the rest is known
    assert run.t_events[0] == pytest.approx(expected[expected < 100.0], abs=near)


def test_a_series_that_does_not_converge_is_not_believed():
    run = solve(spring, (0.0, 40.0), [1.0, 0.0], 0.5, linear((1.0, 0.0), 0.0, 1))
    assert run.t_events[0] == pytest.approx(np.pi * (np.arange(13) + 0.5), abs=1e-12)


def test_a_zero_at_the_start_is_found_as_by_others():
    for direction in (0, 1, -1):
        event = linear((1.0, 0.0), 0.0, direction=direction)
        run = solve(even, (0.0, 4.0), [0.0, 1.0], 0.5, event)
        other = fastdyn.solve_ivp(even, (0.0, 4.0), [0.0, 1.0], events=event)
        assert run.t_events[0].tolist() == other.t_events[0].tolist()


def test_a_function_that_is_always_zero_never_occurs():
    run = solve(even, (0.0, 4.0), [1.0, 0.0], 0.5, linear((0.0, 1.0)))
    assert run.success and run.t_events[0].tolist() == []


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_run_ends_at_the_occurrence_that_is_asked_for(count):
    """Within a step of more than one period, and with nothing of what comes after it."""
    events = [linear((1.0, 0.0), terminal=count), linear((0.0, 1.0))]
    run = solve(spring, (0.0, 40.0), [1.0, 0.0], 7.0, events)
    assert run.status == 1 and len(run.t_events[0]) == count
    assert run.t[-1] == run.t_events[0][-1] == pytest.approx(np.pi * (count - 0.5), abs=1e-9)
    assert run.t_events[1] == pytest.approx(np.pi * np.arange(count), abs=1e-9)


def falling(t, y):
    return [y[1], y[2], 0.0]


def bounce(t, y):
    return [0.0, -0.9 * y[1], y[2]]


@pytest.mark.parametrize("direction", [-1, 0])
@pytest.mark.parametrize("step", [0.05, 1.0, 10.0])
def test_a_ball_bounces_within_a_step(step, direction):
    ground = linear((1.0, 0.0, 0.0), direction=direction)
    run = solve(falling, (0.0, 5.0), [1.0, 0.0, -G], step, ground, on_event=bounce)
    n = int((impacts(0.9, 60) < 5.0).sum())
    assert run.t_events[0] == pytest.approx(impacts(0.9, n), abs=1e-13 * n)
    assert run.y[:2, -1] == pytest.approx(ball_after(0.9, 5.0)[:, 0], abs=1e-11)
    low = linear((1.0, 0.0, 0.0), -0.1, direction=1)
    run = solve(falling, (0.0, 5.0), [1.0, 0.0, -G], step, [low, ground], on_event=[None, bounce])
    assert len(run.t_events[1]) == n and len(run.t_events[0]) in (n, n - 1)
    assert np.all(run.t_events[0] > run.t_events[1][: len(run.t_events[0])])


def two_falling(t, y):
    return [y[1], y[4], y[3], y[4], 0.0]


def first_bounces(t, y):
    return [0.0, -0.9 * y[1], y[2], y[3], y[4]]


def second_bounces(t, y):
    return [y[0], y[1], 0.0, -0.9 * y[3], y[4]]


def test_what_happens_at_once_acts_one_after_the_other():
    both = [linear((1.0, 0.0, 0.0, 0.0, 0.0), direction=-1)]
    both += [linear((0.0, 0.0, 1.0, 0.0, 0.0), direction=-1)]
    jumps = [first_bounces, second_bounces]
    run = solve(two_falling, (0.0, 5.0), [1.0, 0.0] * 2 + [-G], 0.8, both, on_event=jumps)
    n = int((impacts(0.9, 60) < 5.0).sum())
    for t in run.t_events:
        assert t == pytest.approx(impacts(0.9, n), abs=1e-13 * n)


def test_bounces_without_end_are_a_sentence():
    ground = linear((1.0, 0.0, 0.0), direction=-1)
    run = solve(falling, (0.0, 50.0), [1.0, 0.0, -G], 1.0, ground, on_event=bounce)
    assert run.status == -1 and "(Zeno)" in run.message
    assert run.t_events[0][-1] == pytest.approx(last_impact(0.9), abs=1e-6)


def test_events_with_and_without_a_series_keep_their_order():
    both = [linear((1.0, 0.0)), linear((0.0, 1.0), terminal=12)]
    run = solve(spring, (0.0, 60.0), [1.0, 0.1], 0.7, both)
    vars(both[0]).pop("series")
    mixed = solve(spring, (0.0, 60.0), [1.0, 0.1], 0.7, both)
    for one, other in zip(run.t_events, mixed.t_events, strict=True):
        assert one == pytest.approx(other, abs=1e-13 * 60.0)
    assert [len(t) for t in run.t_events] == [11, 12] and run.status == 1


def test_there_is_room_for_all():
    event = linear((1.0, 0.0))
    run = solve(spring, (0.0, 4000.0), [1.0, 0.0], 6.0, [event] * 5, max_steps=10_000)
    assert {len(t) for t in run.t_events} == {int(4000.0 / np.pi + 0.5)}
    assert np.all(np.diff(run.t_events[0]) > 3.0)
