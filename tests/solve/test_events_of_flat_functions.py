"""Events that act, of functions that are exactly zero over intervals: the ends of these count."""

import numpy as np
import pytest
from scipy import integrate

from fastdyn import SwitchingWarning, solve_ensemble, solve_ivp

OWN = ("Tsit5", "Vern7", "Vern9", "Rodas5P", "RK4", "auto")
METHODS = ("Tsit5", "Vern9", "Rodas5P", "RK45", "DOP853", "Radau", "LSODA", "ode45")
TIGHT = {"rtol": 1e-8, "atol": 1e-8}
UP = np.pi * np.array([1 / 6, 13 / 6])  # where sin(t) passes 1/2
DOWN = np.pi * np.array([5 / 6, 17 / 6])
LOW = np.pi * np.array([7 / 6, 11 / 6, 19 / 6])  # where sin(t) passes -1/2
RESOLVED = 4 * np.finfo(float).eps * (1 + 10)  # of a root, as SciPy's; |y'| < 1
APART = 0.5  # less than half the least distance of two edges


def oscillates(t, y):
    return [np.cos(t), 0.0]


def count(t, y):
    return [y[0], y[1] + 1.0]


def above(t, y):
    return max(0.0, y[0] - 0.5)


def below(t, y):
    return np.clip(y[0], -0.5, 0.5) - 0.5 if y[0] > 0 else y[0] - 0.5


def outside(t, y):
    return y[0] - np.clip(y[0], -0.5, 0.5)


EDGES = {
    (above, 0): np.sort(np.r_[UP, DOWN]),
    (above, 1): UP,
    (above, -1): DOWN,
    (below, 0): np.sort(np.r_[UP, DOWN]),
    (below, 1): UP,
    (below, -1): DOWN,
    (outside, 0): np.sort(np.r_[UP, DOWN, LOW]),
    (outside, 1): np.sort(np.r_[UP, LOW[1]]),
    (outside, -1): np.sort(np.r_[DOWN, LOW[::2]]),
}


def directed(function, direction):
    def event(t, y):
        return function(t, y)

    event.direction = direction
    return event


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("function", "direction"), EDGES)
def test_an_event_acts_at_the_edges_of_an_interval_of_zeros(method, function, direction):
    for more in ({}, {"max_step": 0.3}):
        found = solve_ivp(
            oscillates, (0, 10), [0.0, 0.0], method, events=directed(function, direction),
            on_event=count, **TIGHT, **more,
        )  # fmt: skip
        edges = EDGES[function, direction]
        assert found.status == 0 and found.y[1, -1] == len(edges)
        assert found.t_events[0] == pytest.approx(edges, abs=APART)
        assert np.abs(np.abs(found.y_events[0][:, 0]) - 0.5).max() <= 2 * RESOLVED


@pytest.mark.parametrize("direction", [0, 1, -1])
def test_edges_inside_one_step_of_an_own_method_act(direction):
    edges = EDGES[outside, direction]
    found = solve_ivp(
        oscillates, (0, 10), [0.0, 0.0], "Vern9", events=directed(outside, direction),
        on_event=count, rtol=1e-4, atol=1e-4,
    )  # fmt: skip
    assert np.diff(found.t).max() > 1.2  # longer than the shortest interval of zeros
    assert found.t_events[0] == pytest.approx(edges, abs=APART)
    assert np.abs(np.abs(found.y_events[0][:, 0]) - 0.5).max() <= 2 * RESOLVED


def test_a_function_that_is_always_zero_never_acts():
    found = solve_ivp(
        oscillates, (0, 10), [0.0, 0.0], "Tsit5", events=lambda t, y: 0.0 * y[0], on_event=count
    )
    assert found.status == 0 and len(found.t_events[0]) == 0


@pytest.mark.parametrize("method", ["Tsit5", "RK45"])
def test_a_start_at_a_zero_by_itself_is_no_edge(method):
    found = solve_ivp(
        lambda t, y: [1.0, 0.0], (0, 1), [0.5, 0.0], method, events=lambda t, y: y[0] - 0.5,
        on_event=count,
    )  # fmt: skip
    assert len(found.t_events[0]) == 0


INSIDE = {
    (above, 0): np.sort(np.r_[UP, DOWN]),
    (above, 1): UP,
    (above, -1): DOWN,
}
PRECISE = 1e-6  # of the solution at the edges, at the tolerances of 1e-8


def steps_of(method):
    return {"step": 0.05} if method == "RK4" else TIGHT


@pytest.mark.parametrize("method", [*OWN, *METHODS[3:]])
@pytest.mark.parametrize(("function", "direction"), INSIDE)
def test_a_run_that_begins_inside_an_interval_of_zeros_acts_at_its_end(method, function, direction):
    """`above` is zero from the start to UP[0], also where no step ends before."""
    for more in ({}, {"first_step": 0.55}, {"first_step": 0.1}):
        given = {**steps_of(method), **({} if method == "RK4" else more)}
        found = solve_ivp(
            oscillates, (0, 10), [0.0, 0.0], method, events=directed(function, direction),
            on_event=count, **given,
        )  # fmt: skip
        edges = INSIDE[function, direction]
        assert found.status == 0 and found.y[1, -1] == len(edges)
        assert found.t_events[0] == pytest.approx(edges, abs=PRECISE)


@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize(("function", "direction"), EDGES)
def test_events_of_own_methods_that_do_not_act_occur_at_the_edges(method, function, direction):
    event = directed(function, direction)
    edges = EDGES[function, direction]
    given = oscillates, (0, 10), [0.0, 0.0], method
    for _ in range(3):
        found = solve_ivp(*given, events=event, **steps_of(method))
        assert found.t_events[0] == pytest.approx(edges, abs=PRECISE)
    event.terminal = True
    ended = solve_ivp(*given, events=event, **steps_of(method))
    assert ended.status == 1 and ended.t[-1] == pytest.approx(edges[0], abs=PRECISE)


def test_members_of_an_ensemble_occur_at_the_edges():
    starts = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    many = solve_ensemble(
        oscillates, (0, 10), starts, method="Tsit5", events=directed(above, 0), **TIGHT
    )
    for times in many.t_events[0]:
        assert times == pytest.approx(INSIDE[above, 0], abs=PRECISE)


def test_an_edge_at_a_point_that_is_looked_at_counts():
    """A constant step from 0 to 1 is looked at in eighths: the edges are 1/4 and 1/2."""

    def pulse(t, y):
        return max(0.0, 0.25 - y[0]) - max(0.0, y[0] - 0.5)

    found = solve_ivp(lambda t, y: [1.0], (0, 1), [0.0], "RK4", events=pulse, step=1.0)
    resolved = 4 * 2 * np.finfo(float).eps  # of a root, as SciPy's
    assert found.t_events[0] == pytest.approx([0.25, 0.5], abs=resolved, rel=0)


@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "LSODA"])
def test_scipys_methods_keep_scipys_occurrences_and_tell_it(method, terminal):
    def at_rest(t, y):
        return max(0.0, y[0] - 0.5)

    at_rest.terminal = terminal
    given = oscillates, (0, 10), [0.0, 0.0], method
    code = at_rest.__code__.replace(co_name=f"at_rest_of_{method}_{terminal}")
    at_rest.__code__ = code
    with pytest.warns(SwitchingWarning, match="exactly zero over an interval"):
        found = solve_ivp(*given, events=at_rest)
    expected = integrate.solve_ivp(*given, events=at_rest)
    assert found.status == expected.status and found.nfev <= expected.nfev
    # Steps of Radau with an exact Jacobian are SciPy's within the tolerance of 1e-3.
    assert found.t_events[0] == pytest.approx(expected.t_events[0], rel=1e-5)


def test_two_edges_within_a_step_of_a_method_of_scipys_act():
    """The steps are long: by SciPy's rule, one edge a step would act, and a warning tell others."""
    found = solve_ivp(
        oscillates, (0, 10), [0.0, 0.0], "RK45", events=directed(above, 1), on_event=count
    )
    assert found.y[1, -1] == len(UP)


@pytest.mark.parametrize(
    ("method", "acts"),
    [(m, acts) for m in ("Tsit5", "Vern9", "RK4", "Taylor") for acts in (True, False)]
    + [(m, True) for m in ("RK45", "DOP853", "Radau")],
)
@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize("kick", [-1.0, 1.0])
def test_a_body_at_rest_at_zero_occurs_when_an_action_moves_it(method, direction, kick, acts):
    """The position is exactly zero up to a kick at t = 1, and a smooth function at all times."""
    found = solve_ivp(
        lambda t, y: [y[1], 0.0 * y[1]], (0.0, 2.5), [0.0, 0.0], method, at=[1.0],
        events=directed(lambda t, y: y[0], direction), **{"step": 0.25} if method == "RK4" else {},
        on_event=[(lambda t, y: [y[0], -0.5 * y[1]]) if acts else None,
                  lambda t, y: [y[0], y[1] + kick]],
    )  # fmt: skip
    occurs = direction * kick >= 0.0
    assert found.t_events[0].tolist() == [1.0] * occurs
    assert found.y[1, -1] == (-0.5 * kick if occurs and acts else kick)


@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P", "Taylor", "RK4", "Gauss8"])
def test_a_zero_where_two_steps_meet_occurs_once(method):
    """By the signs at the ends of both steps, as SciPy's, the zero would occur in each."""
    options = {"step": 0.25} if method in ("RK4", "Gauss8") else {"max_step": 0.1}

    def run(events):
        return solve_ivp(
            lambda t, y: [y[1], -0.01], (0, 3), [0.0, 1.0], method, events=events, **options
        )

    at = run(None).t[3]
    second = directed(lambda t, y: t - at, 0)
    second.terminal = 2
    touching = directed(lambda t, y: (t - at) ** 2, 0)
    found = run([directed(lambda t, y: at - t, -1), second, touching])
    assert [times.tolist() for times in found.t_events] == [[at]] * 3
    assert found.t[-1] == 3.0


AT_SWITCHES = {
    "counts": (lambda t, y: np.floor(t) - 2.0, [2.0, 3.0]),
    "from zero": (lambda t, y: 1.0 if t > 2 else 0.0, [2.0]),
    "through zero": (lambda t, y: np.where(t < 2, -1.0, np.where(t < 3, 0.0, 1.0)), [2.0, 3.0]),
    "pulse": (lambda t, y: 1.0 if 2 < t < 3 else 0.0, [2.0, 3.0]),
    "kink": (lambda t, y: max(0.0, t - 2.0), [2.0]),
    "zero": (lambda t, y: 0.0 if 2 < t < 3 else -1.0, [2.0, 3.0]),
}


@pytest.mark.few(12)
@pytest.mark.parametrize("name", AT_SWITCHES)
@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize("acts", [None, count])
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P", "RK45"])
def test_edges_at_switching_times_occur(method, acts, direction, name):
    if method == "RK45" and acts is None:
        pytest.skip("SciPy's occurrences")
    function, edges = AT_SWITCHES[name]
    found = solve_ivp(
        lambda t, y: [1.0, 0.0], (0, 5.5), [0.0, 0.0], method, on_event=acts,
        events=directed(function, direction),
    )  # fmt: skip
    signs = {"pulse": [1, -1], "zero": [1, -1]}.get(name, [1] * len(edges))
    expected = [t for t, sign in zip(edges, signs, strict=True) if sign * direction >= 0]
    assert found.t_events[0].tolist() == expected
