"""Claims about event functions that switch with the time: each change of sign is an occurrence."""

import itertools
import types

import numba
import numpy as np
import pytest

from fastdyn import (
    SwitchingWarning,
    at,
    prepare,
    solve_dae,
    solve_dae_ensemble,
    solve_ensemble,
    solve_ivp,
)
from fastdyn.kernels.methods import METHODS

ADAPTIVE = [name for name, m in METHODS.items() if m.error_order and not m.series]
LINES = itertools.count(9000)
GRID = 0.01 * np.arange(1001)
TABLE = np.where((GRID > 5.005) & (GRID < 5.105), 1.0, -1.0)


def decay(t, y):
    return [-0.1 * y[0]]


def raised(t, y):
    return [y[0] + 1.0]


def pulse(t, y):
    return 1.0 if 5 < t < 5.1 else -1.0


def by_where(t, y):
    return np.where((t > 5) & (t < 5.1), 1.0, -1.0)


def by_level(t, y):
    return y[0] - (0.1 if 5 < t < 5.1 else 4.0)


def by_table(t, y):
    return TABLE[int(t / 0.01)]


def by_knots(t, y):
    return np.interp(t, GRID, TABLE)


EXPECTED = {pulse: [5.0, 5.1], by_where: [5.0, 5.1], by_level: [5.0, 5.1]}
EXPECTED |= {by_table: [5.01, 5.11], by_knots: [5.005, 5.105]}


@pytest.mark.few(12)
@pytest.mark.parametrize("event", EXPECTED)
@pytest.mark.parametrize("acts", [None, raised])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_adaptive_methods_lose_no_pulse(method, acts, event):
    """First, and again: the pulse is shorter than each step around it."""
    for _ in range(3):
        run = solve_ivp(decay, (0, 10), [1.0], method, events=event, on_event=acts)
        assert run.t_events[0] == pytest.approx(EXPECTED[event], abs=1e-9)
        assert run.status == 0
    if acts is not None:
        ends = np.exp(-1.0) + np.exp(-0.1 * (10.0 - run.t_events[0])).sum()
        assert run.y[0, -1] == pytest.approx(ends, rel=2e-2)


@pytest.mark.parametrize(("direction", "expected"), [(1, [5.0]), (-1, [5.1])])
@pytest.mark.parametrize("way", [1, -1])
def test_a_direction_takes_one_side(direction, expected, way):
    def one_sided(t, y):
        return 1.0 if 5 < way * t < 5.1 else -1.0

    one_sided.direction = direction
    run = solve_ivp(decay, (0, 10 * way), [1.0], "Tsit5", events=one_sided)
    assert way * run.t_events[0] == pytest.approx(expected, abs=1e-12)


def test_a_pulse_ends_a_run_at_its_edge():
    def stop(t, y):
        return 1.0 if 5 < t < 5.1 else -1.0

    stop.terminal = 2
    run = solve_ivp(decay, (0, 10), [1.0], "Vern9", events=stop, dense_output=True)
    assert run.status == 1 and run.t[-1] == run.t_events[0][1] == 5.1
    assert run.y_events[0][1, 0] == pytest.approx(np.exp(-0.51), rel=1e-3)


def test_a_smooth_zero_and_a_jump_back_in_one_step_are_two():
    """y falls below 0.65 at 4.31, and the level falls at 5."""

    def below(t, y):
        return (0.65 if t < 5 else 0.2) - y[0]

    for method in ("Tsit5", "Vern9", "RK45", "Radau"):
        run = solve_ivp(decay, (0, 10), [1.0], method, events=below, rtol=1e-6, first_step=4.0)
        assert run.t_events[0] == pytest.approx([-10 * np.log(0.65), 5.0], abs=1e-4)


def test_breakpoints_show_the_jumps_of_functions_without_a_trace():
    @numba.njit
    def compiled(t, y):
        return 1.0 if 5 < t < 5.1 else -1.0

    given = {"events": compiled, "breakpoints": [5.0, 5.1]}
    run = solve_ivp(decay, (0, 10), [1.0], "RK45", **given)
    assert run.t_events[0].tolist() == [5.0, 5.1]


def test_parameters_and_states_that_actions_change_move_the_pulse():
    def within(t, y, d):
        return 1.0 if d[0] < t < d[0] + 0.1 else -1.0

    given = {"discrete": [5.0], "events": [within, at([6.0])]}
    given["on_event"] = [None, lambda t, y, d: (y, [8.0])]
    run = solve_ivp(lambda t, y, d: [-0.1 * y[0]], (0, 10), [1.0], "Tsit5", **given)
    assert run.t_events[0] == pytest.approx([5.0, 5.1, 8.0, 8.1], abs=1e-9)
    shot = prepare(lambda t, y, a: decay(t, y), (0, 10), [1.0], "Vern7", events=late, args=(5.0,))
    for start in (5.0, 7.0, 3.0):
        found = shot(args=(start,)).t_events[0]
        assert found == pytest.approx([start, start + 0.1], abs=1e-9)


def late(t, y, start):
    return 1.0 if start < t < start + 0.1 else -1.0


@pytest.mark.few
@pytest.mark.parametrize("simd", [True, False])
@pytest.mark.parametrize("acts", [None, lambda t, y, start: [y[0] + 1.0]])
@pytest.mark.parametrize("method", ["Tsit5", "Rodas5P", "RK45"])
def test_each_member_of_an_ensemble_has_its_own(method, acts, simd):
    starts = np.array([5.0, 6.0, 3.0, 8.0, 1.0])
    many = solve_ensemble(
        lambda t, y, a: decay(t, y), (0, 10), [1.0], (starts,), method, events=late,
        on_event=acts, simd=simd,
    )  # fmt: skip
    for start, found in zip(starts, many.t_events[0], strict=True):
        assert found == pytest.approx([start, start + 0.1], abs=1e-9)


@pytest.mark.parametrize("method", ["Radau", "Rodas5P", "Tsit5"])
def test_an_implicit_equation_loses_none(method):
    run = solve_dae(lambda t, y, yp: [yp[0] + 0.1 * y[0]], (0, 10), [1.0], events=pulse,
                    method=method)  # fmt: skip
    assert run.t_events[0].tolist() == [5.0, 5.1]


def test_an_implicit_equation_by_bdf_tells():
    def within(t, y):
        return 1.0 if 5 < t < 5.1 else -1.0

    given = (lambda t, y, yp: [yp[0] + 0.1 * y[0]]), (0, 10), [1.0]
    with pytest.warns(SwitchingWarning, match="`within` changes at t = 5 and .* BDF do not end"):
        solve_dae(*given, events=within)
    solve_dae(*given, events=within)


@pytest.mark.parametrize("method", ["RK4", "VelocityVerlet", "Gauss8"])
def test_constant_steps_tell(method):
    code = pulse.__code__.replace(co_firstlineno=next(LINES))
    fresh = types.FunctionType(code, pulse.__globals__, "pulsed")
    given = (lambda t, y: [y[1], -y[0]]), (0, 10), [1.0, 0.0], method
    with pytest.warns(SwitchingWarning, match=f"`pulsed` changes at t = 5 and .* {method} looked"):
        solve_ivp(*given, events=fresh, step=0.5)
    assert not len(solve_ivp(*given, events=fresh, step=0.5).t_events[0])
    short = solve_ivp(*given, events=fresh, step=0.03)
    assert short.t_events[0] == pytest.approx([5.0, 5.1], abs=1e-9)


@pytest.mark.parametrize("method", ["Tsit5", "RK45", "Radau", "ode45"])
def test_a_span_that_begins_at_an_edge_has_the_edge_at_its_start(method):
    """The steps begin behind the edge, where the function falls with y[0]."""
    for direction, expected in ((1, [5.0]), (0, [5.0, 5.1]), (-1, [5.1])):

        def short(t, y):
            return (1.0 if 5.0 < t < 5.1 else 0.0) + 0.2 * y[0] - 0.6

        short.direction = direction
        run = solve_ivp(decay, (5.0, 10.0), [1.0], method, events=short)
        assert run.t_events[0] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("method", ["BDF", "Tsit5"])
def test_each_implicit_equation_of_many_has_its_own(method):
    """BDF's steps end at no switching times: one ends between any two."""
    starts = np.array([5.0, 6.0, 3.0, 8.0])
    many = solve_dae_ensemble(
        lambda t, y, yp, a: [yp[0] + 0.1 * y[0]], (0, 10), [1.0], args=(starts,), events=late,
        method=method,
    )  # fmt: skip
    for start, found in zip(starts, many.t_events[0], strict=True):
        assert found == pytest.approx([start, start + 0.1], abs=1e-9)
