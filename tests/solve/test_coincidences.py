"""Claims about events at the time of a schedule: which acts first does not depend on rounding."""

import itertools
import math

import numpy as np
import pytest

from fastdyn import METHODS, at, every, solve_ensemble, solve_ivp
from tests.support.impacts import marked

TIGHT = {"rtol": 1e-10, "atol": 1e-12}
OFF = [0.0, *np.array([1e-16, 5e-16, 2e-15, 8e-15]), *-np.array([1e-16, 5e-16, 2e-15, 8e-15])]
SOLVED = [name for name, method in METHODS.items() if not method.second_order]


def options_of(method):
    return TIGHT if METHODS[method].error_order else {"step": 0.013}


def rising(t, y):
    return [1.0]


def level(t, y):
    return y[0] - 1.0


def doubled(t, y):
    return [2.0 * y[0]]


def lowered(t, y):
    return [y[0] - 0.5]


@pytest.mark.parametrize("method", SOLVED)
@pytest.mark.parametrize("listed", [0, 1])
def test_an_event_acts_before_a_schedule_of_its_time(method, listed):
    """The zero lies some units in the last place before or behind the time."""
    for off in OFF:
        events, jumps = [level, every(1.0)], [lowered, doubled]
        if listed:
            events, jumps = events[::-1], jumps[::-1]
        run = solve_ivp(
            rising, (0.0, 1.4), [off], method, events=events, on_event=jumps, max_steps=1000,
            t_eval=[1.0, 1.4], **options_of(method),
        )  # fmt: skip
        assert np.array_equal(run.t_events[listed], [1.0])
        assert np.array_equal(run.t_events[1 - listed], [0.0, 1.0])
        assert run.y_events[1 - listed][1] == pytest.approx(0.5)  # which the event has left
        assert run.y[0, -1] == pytest.approx(1.4)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Taylor", "Radau", "BDF", "LSODA", "RK4"])
@pytest.mark.parametrize(("acts", "ticks"), [*itertools.product([None, lowered], [None, doubled])])
def test_an_event_occurs_once_at_the_time_of_a_schedule(method, acts, ticks):
    for off, direction in itertools.product(OFF, [0, 1]):
        watched = marked(level, direction=direction)
        run = solve_ivp(
            rising, (0.0, 1.4), [off], method, events=[watched, at([1.0])],
            on_event=[acts, ticks], **options_of(method),
        )  # fmt: skip
        assert np.array_equal(run.t_events[0], [1.0])
        assert np.array_equal(run.t_events[1], [1.0])
        end = (1.0 if acts is None else 0.5) * (1.0 if ticks is None else 2.0) + 0.4
        assert run.y[0, -1] == pytest.approx(end)


def test_a_crossing_in_the_other_direction_is_no_event():
    for off in OFF:
        run = solve_ivp(
            rising, (0.0, 1.4), [off], events=[marked(level, direction=-1), at([1.0])], **TIGHT
        )
        assert len(run.t_events[0]) == 0


@pytest.mark.parametrize("method", ["RK45", "Taylor", "RK4"])
def test_a_schedule_that_turns_the_motion_leaves_one_event(method):
    """The schedule sends the state back, which then rises again."""

    def moved(t, y):
        return [y[1], 0.0]

    for off in OFF:
        run = solve_ivp(
            moved, (0.0, 3.4), [off, 1.0], method, events=[level, at([1.0, 1.5])],
            on_event=[None, lambda t, y: [y[0], -y[1]]], **options_of(method),
        )  # fmt: skip
        assert len(run.t_events[0]) == 2 and run.t_events[0][0] == 1.0
        assert run.t_events[0][1] == pytest.approx(2.0)


def test_a_terminal_event_ends_the_run_before_the_schedule():
    for off in OFF:
        run = solve_ivp(
            rising, (0.0, 3.0), [off], events=[at([1.0]), marked(level, terminal=True)],
            on_event=[doubled, None], **TIGHT,
        )  # fmt: skip
        assert run.status == 1 and run.t[-1] == 1.0 and run.y[0, -1] == pytest.approx(1.0)
        assert len(run.t_events[0]) == 0


def test_bounces_at_the_times_of_a_comb():
    """A ball that comes down at each second whole, where a comb counts: nobody is second."""

    def thrown(t, y):
        return [y[1], -2.0]

    for events in ([level_zero, every(1.0)], [every(1.0), level_zero]):
        jumps = [lambda t, y: [0.0, -y[1]], lambda t, y: [y[0], y[1]]]
        jumps = jumps if events[0] is level_zero else jumps[::-1]
        run = solve_ivp(thrown, (0.0, 20.5), [0.0, 1.0], events=events, on_event=jumps, **TIGHT)
        bounces = run.t_events[events.index(level_zero)]
        assert run.success and np.allclose(bounces, np.arange(1, 21), atol=1e-9)
        assert run.y[:, -1] == pytest.approx([0.25, 0.0], abs=1e-8)


def level_zero(t, y):
    return y[0]


vars(level_zero)["direction"] = -1


@pytest.mark.parametrize("method", ["RK45", "Taylor"])
def test_backwards_and_far_from_zero(method):
    for start in (0.0, 1e6, -1e6):
        for off in (0.0, 2.0 * math.ulp(start), -2.0 * math.ulp(start)):
            run = solve_ivp(
                rising, (start + 2.0, start), [2.0 + off], method,
                events=[level, at([start + 1.0])], on_event=[lambda t, y: [y[0] + 1.0], doubled],
                t_eval=[start], **TIGHT,
            )  # fmt: skip
            assert np.array_equal(run.t_events[0], [start + 1.0])
            assert run.y[0, -1] == pytest.approx(3.0, abs=1e-8)


@pytest.mark.parametrize("simd", ["auto", False])
def test_ensembles_have_the_order_of_single_solves(simd):
    starts = np.array(OFF)[:, None]
    run = solve_ensemble(
        rising, (0.0, 1.4), starts, events=[level, every(1.0)], on_event=[lowered, doubled],
        simd=simd, **TIGHT,
    )  # fmt: skip
    assert all(np.array_equal(times, [1.0]) for times in run.t_events[0])
    assert np.allclose(run.y_end, 1.4)
