"""Claims about switching times by every method, way and solver: each is right, or tells."""

import copy
import warnings

import numpy as np
import pytest

from fastdyn import (
    Free,
    Phase,
    Record,
    Stepper,
    SwitchingWarning,
    at,
    every,
    fit,
    prepare,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)
from fastdyn.solve import solve_second_order
from support.pulsed import fresh, pulse
from support.steppers import ended

OWN = ["Tsit5", "Vern7", "Vern9", "Rodas5P", "auto", "Taylor"]
NOT_OWN = ["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"]


def test_each_method_tells_once():
    """Whoever was told of RK45 was not told of DOP853."""
    fun = fresh(lambda t, y: [pulse(t)])
    for method in NOT_OWN:
        with pytest.warns(SwitchingWarning, match=f"`pulsed` .* no step of {method} looked"):
            solve_ivp(fun, (0, 10), [0.0], method)
        solve_ivp(fun, (0, 10), [0.0], method)


@pytest.mark.parametrize(
    "method", ["VelocityVerlet", "Yoshida8", "KahanLi8", "Gauss8", "GaussNystrom8", "RK4"]
)
def test_constant_steps_tell(method):
    """A step may be longer than a pulse, wherever the method evaluates the function in between."""

    def fun(t, y):
        return [y[1], pulse(t)]

    fun, ends = fresh(fun), {"step": 0.5} if method != "RK4" else {"step": 1.5}
    with pytest.warns(SwitchingWarning, match=f"no step of {method} .*give `step=0.2`"):
        solve_ivp(fun, (0, 10), [0.0, 0.0], method, **ends)
    solve_ivp(fresh(lambda t, y: [y[1], pulse(t)]), (0, 10), [0.0, 0.0], method, step=0.01)


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "ode45", "Radau"])
def test_a_stage_without_weight_looks_at_nothing(method):
    """Wherever a short pulse lies within a step, its area is found, or the user is told."""
    step, width = 0.5, 0.03  # longest step; a stage sees a pulse as hundreds of tolerances
    for share in np.linspace(0.01, 0.9, 24):
        start = 4.0 + step * share
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", SwitchingWarning)
            fun = fresh(lambda t, y, start: [pulse(t, start, width)])
            run = solve_ivp(fun, (0, 6), [0.0], method, args=(start,), max_step=step)
        assert caught or run.y[0, -1] == pytest.approx(width, rel=0.05), share


def test_a_force_tells():
    force = fresh(lambda t, q: [pulse(t)])
    with pytest.warns(SwitchingWarning, match="no step of VelocityVerlet looked"):
        solve_second_order(force, (0, 10), [0.0], [0.0], step=0.5)


# -- times kept in components that do not change, and in discrete states


@pytest.mark.parametrize("method", OWN)
def test_times_in_a_component_that_stays(method):
    def fun(t, y):
        return [pulse(t, y[1], 0.1), 0.0]

    for start in (5.0, 2.0, 8.5, 5.0):
        for _ in range(3):
            run = solve_ivp(fun, (0, 10), [0.0, start], method)
            assert run.y[0, -1] == pytest.approx(0.1, rel=1e-9)
    if method not in ("auto", "Taylor"):
        solver = prepare(fun, (0, 10), [0.0, 5.0], method)
        assert [solver([0.0, s]).y[0, -1] for s in (1.0, 7.0)] == pytest.approx([0.1, 0.1])
        starts = np.array([[0.0, 3.0], [0.0, 6.0], [0.0, 9.0]])
        for simd in (True, False):
            whole = solve_ensemble(fun, (0, 10), starts, method=method, simd=simd)
            assert whole.y_end[:, 0] == pytest.approx(0.1, rel=1e-9)


def test_times_in_a_component_that_stays_are_told():
    fun = fresh(lambda t, y: [pulse(t, y[1], 0.1), 0.0])
    with pytest.warns(SwitchingWarning, match="changes at t = 5 and t = 5.1"):
        solve_ivp(fun, (0, 10), [0.0, 5.0], "RK45")


@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
@pytest.mark.parametrize("own", [{}, {"breakpoints": [4.0, 6.0], "max_step": 3.0}])
def test_times_in_discrete_states(method, span, own):
    """An infusion that begins half a second after an event, another after each schedule."""
    way = np.sign(span[1] - span[0])

    def fun(t, y, d):
        return [pulse(way * t, d[0], 0.1), 1.0]

    def crossed(t, y, d):
        return y[1] - (1.0 if way > 0 else -1.0)

    def start(t, y, d):
        return y, [way * t + 0.5]

    given = {"discrete": [way * 1e3], "events": crossed, "on_event": start, **own}
    run = solve_ivp(fun, span, [0.0, 0.0], method, **given)
    assert run.success and way * run.y[0, -1] == pytest.approx(0.1, rel=1e-6)
    given |= {"events": [at([3.0, 7.0])], "on_event": [start]}
    run = solve_ivp(fun, span, [0.0, 0.0], method, **given)
    assert way * run.y[0, -1] == pytest.approx(0.2, rel=1e-6)
    given |= {"events": [every(2.0)], "on_event": [start]}
    run = solve_ivp(fun, span, [0.0, 0.0], method, **given)
    assert way * run.y[0, -1] == pytest.approx(0.1 * len(run.t_events[0]), rel=1e-6)


@pytest.mark.parametrize("method", NOT_OWN)
def test_times_in_discrete_states_are_told(method):
    fun = fresh(lambda t, y, d: [pulse(t, d[0], 0.1)])
    given = {"discrete": [-5.0], "events": at([1.0]), "on_event": lambda t, y, d: (y, [5.0])}
    with pytest.warns(SwitchingWarning, match="changes at t = 5 and t = 5.1"):
        solve_ivp(fun, (0, 10), [0.0], method, **given)


# -- other solvers


def test_a_fit_of_a_pulsed_input():
    times = np.linspace(0.5, 10.0, 20)
    true = 1.5 * np.clip(times - 5.0, 0.0, 0.2)
    record = Record(times, true, [0.0], (Free(1.0, name="k"),), t0=0.0)
    found = fit(lambda t, y, k: [k * pulse(t)], record)
    assert found.x == pytest.approx([1.5], rel=1e-6)


@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "RK45"])
def test_phases(method):
    fun = fresh(lambda t, y: [pulse(t)])

    def early(t, y):
        return t - 2.0

    def late(t, y):
        return t - 9.0

    early.terminal = late.terminal = True
    phases = {"one": Phase(fun, early, lambda t, y: ("two", y)),
              "two": Phase(fun, late, lambda t, y: ("one", y))}  # fmt: skip
    if method == "RK45":
        with pytest.warns(SwitchingWarning) as caught:
            solve_phases(phases, "one", (0, 10), [0.0], method)
        assert not any("'auto'" in str(each.message) for each in caught)  # phases refuse it
    else:
        run = solve_phases(phases, "one", (0, 10), [0.0], method)
        assert run.y[0, -1] == pytest.approx(0.2, rel=1e-9)


@pytest.mark.parametrize("method", ["DOP853", "RK45", "Gauss8"])
def test_steppers_tell(method):
    ends = {"step": 0.5} if method == "Gauss8" else {}
    stepper = Stepper(fresh(lambda t, y: [pulse(t)]), 0.0, [0.0], 10.0, method=method, **ends)
    with pytest.warns(SwitchingWarning, match=f"no step of {method}"):
        ended(stepper)


def end_of(stepper):
    return ended(stepper).y


@pytest.mark.parametrize("method", ["Tsit5", "Vern7", "Vern9", "Rodas5P", "Taylor"])
@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
def test_own_steps_of_steppers_end_there(method, span):
    def fun(t, y):
        return [pulse(t)]

    stepper = Stepper(fun, span[0], [0.0], span[1], method=method)
    expected = solve_ivp(fun, span, [0.0], method)
    times = [stepper.t]
    while stepper.status == "running":
        stepper.step()
        times.append(stepper.t)
        assert stepper.interpolate(stepper.t) == pytest.approx(stepper.y, abs=1e-14)
    assert {5.0, 5.2} <= set(times) and times == expected.t.tolist()
    assert stepper.y[0] == expected.y[0, -1] == pytest.approx(0.2 * (span[1] - span[0]) / 10)


def test_values_that_change_between_steps_give_other_times():
    """Outside values, the arguments, and a value that needs other code: a list of pulses."""
    outside = {"start": 9.0, "more": [3.0]}

    def fun(t, y, width):
        force = pulse(t, outside["start"], width)
        for start in outside["more"]:
            force += pulse(t, start, width)
        return [force]

    stepper = Stepper(fun, 0.0, [0.0], 10.0, method="Vern9", args=(0.2,))
    while stepper.t < 1.0:
        stepper.step()
    outside["start"] = 5.0
    while stepper.t < 3.5:
        stepper.step()
    assert stepper.y[0] == pytest.approx(0.2)
    outside["more"] = [3.0, 7.0]
    while stepper.t < 6.0:
        stepper.step()
    stepper.args = (0.1,)
    assert end_of(stepper)[0] == pytest.approx(0.5)


@pytest.mark.parametrize("method", ["Vern9", "RK45"])
def test_copies_of_steppers_go_on(method):
    def fun(t, y, d):
        return [pulse(t, d[0], 0.1)]

    given = {"discrete": [-5.0], "events": at([1.0]), "on_event": lambda t, y, d: (y, [5.0])}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SwitchingWarning)
        stepper = Stepper(fun, 0.0, [0.0], 10.0, method=method, **given)
        while stepper.t < 1.0:
            stepper.step()
        for _ in range(2):
            stepper.step()
            copied = copy.deepcopy(stepper)
            assert end_of(copied) == end_of(copy.deepcopy(stepper))
        end = end_of(stepper)
    assert end == end_of(copied) and (method == "RK45" or end[0] == pytest.approx(0.1))


@pytest.mark.filterwarnings("ignore:.*runs in Python")
@pytest.mark.parametrize("method", ["Tsit5", "Vern9"])
def test_python_code_within_a_solve_gives_other_times(method):
    outside = {"start": 100.0}

    def fun(t, y):
        return [pulse(t, outside["start"])]

    def watch(solver):
        outside["start"] = 5.0

    run = solve_ivp(fun, (0, 10), [0.0], method, callback=watch, max_step=2.0)
    assert run.y[0, -1] == pytest.approx(0.2)
    outside["start"] = 100.0

    def crossed(t, y):
        outside["start"] = 5.0
        return t - 2.0

    run = solve_ivp(fun, (0, 10), [0.0], method, events=crossed)
    assert run.y[0, -1] == pytest.approx(0.2)


def test_a_function_in_python_has_no_times():
    """The function acts besides giving a value, which compiled code does not."""
    seen = []

    def fun(t, y, a):
        seen.append(t)
        return [a * pulse(t)]

    with pytest.warns(match="runs in Python"):
        whole = solve_ensemble(fun, (0, 10), [0.0], (np.ones(3),), method="RK45", max_step=0.1)
    assert whole.y_end[:, 0] == pytest.approx(0.2, rel=0.1)


@pytest.mark.filterwarnings("ignore:.*runs in Python")
def test_events_that_switch_beside_equations_in_python():
    seen = []

    def fun(t, y):
        seen.append(t)
        return [1.0]

    def crossed(t, y):
        return np.where(t >= 5.0, 1.0, -1.0)

    run = solve_ivp(fun, (0, 10), [0.0], "RK45", events=crossed)
    assert run.t_events[0] == pytest.approx([5.0])


@pytest.mark.parametrize(
    "rest",
    [lambda t, y: 0 * y[1], lambda t, y: -(0.0 * t), lambda t, y: y[1] - y[1],
     lambda t, y: np.sin(0 * y[1]), lambda t, y: 0 * y[1] / 3.0 + y[0] * 0.0,
     lambda t, y: np.where(y[0] > 5.0, 0.0 * t, 0 * y[1])],
)  # fmt: skip
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P"])
def test_a_component_at_rest_may_be_spelled_in_many_ways(method, rest):
    """Its value is the start of a pulse."""
    run = solve_ivp(lambda t, y: [pulse(t, y[1]), rest(t, y)], (0, 10), [0.0, 5.0], method)
    assert run.y[0, -1] == pytest.approx(0.2, rel=1e-9)
