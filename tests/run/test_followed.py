"""What functions use is read again whenever Python code of the user has run within a solve."""

import itertools
import random
import types

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.run.loop import Run

pytestmark = pytest.mark.filterwarnings("ignore")
HOLDERS = (
    "dict",
    "nested",
    "attribute",
    "list",
    "array",
    "whole array",
    "cell",
    "default",
    "class",
)
VALUES = ((10.0, 0.0), (10, 0), (True, False), (np.float64(10.0), 0.0), ((10.0,), (0.0,)))


def switch(holder, high, low):
    """``read()`` and ``write(on)`` of one place of the user's program."""
    if holder == "dict":
        at = {"value": high}
        return lambda: at["value"], lambda on: at.update(value=high if on else low)
    if holder == "nested":
        at = {"a": {"value": high}}
        return lambda: at["a"]["value"], lambda on: at["a"].update(value=high if on else low)
    if holder == "attribute":
        thing = types.SimpleNamespace(value=high)
        return lambda: thing.value, lambda on: setattr(thing, "value", high if on else low)
    if holder == "list":
        found = [high]
        return lambda: found[0], lambda on: found.__setitem__(0, high if on else low)
    if holder in ("array", "whole array"):
        numbers = np.array([10.0, 3.0]).astype(float if holder == "array" else int)
        return lambda: numbers[0], lambda on: numbers.__setitem__(0, 10 if on else 0)
    if holder == "default":

        def read(kept=[high]):  # noqa: B006
            return kept[0]

        return read, lambda on: read.__defaults__[0].__setitem__(0, high if on else low)
    if holder == "class":
        cls = type("Settings", (), {"value": high})
        return lambda: cls.value, lambda on: setattr(cls, "value", high if on else low)
    value = high

    def write(on):
        nonlocal value
        value = high if on else low

    return lambda: value, write


def thermostat(holder, high, low):
    read, write = switch(holder, high, low)

    def heat(t, T):
        value = read()
        power = value[0] if isinstance(value, tuple) else 10.0 * value if value is True else value
        return [power - 0.3 * (T[0] - 5.0)]

    def event(t, T):
        if T[0] > 22.0:
            write(False)
        elif T[0] < 18.0:
            write(True)
        return T[0] - 20.0

    return heat, event


def drawn(n):
    every = list(itertools.product(HOLDERS, VALUES))
    return random.Random(4).sample(every, n)


@pytest.mark.parametrize(("holder", "values"), drawn(16), ids=str)
def test_an_event_that_switches_what_fun_reads(holder, values):
    results = []
    for solve in scipy.integrate.solve_ivp, fastdyn.solve_ivp:
        heat, event = thermostat(holder, *values)
        results.append(solve(heat, (0, 20), [10.0], "RK45", events=event))
    theirs, ours = results
    assert ours.nfev == theirs.nfev and len(ours.t_events[0]) == len(theirs.t_events[0])
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


@pytest.mark.parametrize("method", ["RK23", "DOP853", "BDF", "LSODA"])
def test_by_every_kind_of_method(method):
    results = []
    for solve in scipy.integrate.solve_ivp, fastdyn.solve_ivp:
        heat, event = thermostat("dict", True, False)
        results.append(solve(heat, (0, 20), [10.0], method, events=event))
    theirs, ours = results
    assert abs(ours.y[0, -1] - theirs.y[0, -1]) < 1e-6 * theirs.y[0, -1]


@pytest.mark.parametrize("holder", HOLDERS)
def test_values_changed_between_the_steps_of_a_stepper(holder):
    ends = []
    for cls in scipy.integrate.RK45, fastdyn.Stepper:
        read, write = switch(holder, 10.0, 0.0)
        stepper = cls(lambda t, y, read=read: [-0.1 * read() * y[0]], 0.0, [1.0], 4.0, max_step=0.1)
        for i in range(30):
            write(i % 7 < 4)
            stepper.step()
        ends.append(stepper.y[0])
    assert abs(ends[0] - ends[1]) < 1e-12


def test_a_callback_changes_what_fun_reads():
    read, write = switch("dict", True, False)

    def fun(t, y):
        return [-1.0 if read() else -2.0 * y[0]]

    ours = fastdyn.solve_ivp(
        fun, (0, 3), [1.0], max_step=0.1, callback=lambda solver: write(solver.t < 1.0)
    )
    write(True)
    theirs = scipy.integrate.RK45(fun, 0.0, [1.0], 3.0, max_step=0.1)
    while theirs.status == "running":
        theirs.step()
        write(theirs.t < 1.0)
    assert abs(ours.y[0, -1] - theirs.y[0]) < 1e-12


def test_taylor_says_that_it_keeps_to_its_formulas():
    heat, event = thermostat("dict", True, False)
    with pytest.raises(ValueError, match="keeps to the formulas"):
        fastdyn.solve_ivp(heat, (0, 20), [10.0], "Taylor", events=event)


def test_functions_are_followed_where_python_runs_and_only_there(monkeypatch):
    followed = []
    monkeypatch.setattr(Run, "follow_again", lambda run: followed.append(run))
    fastdyn.solve_ivp(lambda t, y: -y, (0, 1), [1.0], events=lambda t, y: y[0] - 0.5)
    assert not followed
    seen = []
    fastdyn.solve_ivp(
        lambda t, y: -y, (0, 1), [1.0], events=lambda t, y: seen.append(t) or y[0] - 0.5
    )
    assert len(followed) == len(seen)


def test_a_global_variable_that_an_event_makes():
    def fun(t, y):
        return [-made_late(t) * y[0] if t > 1 else -0.5 * y[0]]  # noqa: F821

    def event(t, y):
        globals()["made_late"] = lambda v: 2.5
        return y[0] - 0.6

    given = fun, (0.0, 3.0), [1.0]
    solves = scipy.integrate.solve_ivp, fastdyn.solve_ivp
    theirs, ours = (
        solve(*given, events=event) for solve in solves if globals().pop("made_late", 1)
    )
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_an_event_that_makes_another_object_the_chosen_one():
    """Equal lists are told apart by identity, back and forth within one solve."""
    one, two = [1.98], [1.98]
    chosen = one

    def fun(t, y):
        return [-y[0] + (0.1 if chosen is one else 0.4)]

    def hook(t, y):
        nonlocal chosen
        chosen = two if t < 1.2 else one
        return t - 1.2

    mine = fastdyn.solve_ivp(fun, (0, 2), [2.0], "RK23", events=hook)
    chosen = one
    theirs = scipy.integrate.solve_ivp(fun, (0, 2), [2.0], "RK23", events=hook)
    np.testing.assert_allclose(mine.y, theirs.y, 1e-9)


@pytest.mark.parametrize("given", [False, True], ids=["differences", "jac"])
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "BDF", "LSODA"])
def test_what_precedes_the_first_call_of_an_event(method, given):
    """SciPy asks the events behind the first Jacobian, LSODA before the first derivative."""
    st = {"k": 0.3}

    def fun(t, y):
        return [st["k"] - 0.9 * y[0] ** 2, y[0] - 0.6 * y[1]]

    def jac(t, y):
        return [[-0.9 * st["k"] * y[0], 0.0], [1.0, -0.6]]

    def event(t, y):
        st["k"] = 2.0 if y[0] > 1.3 else 4.0
        return y[0] - 1.3

    found, options = [], {"rtol": 1e-8, "atol": 1e-10}
    if given and method in ("Radau", "BDF", "LSODA"):
        options["jac"] = jac
    for solve in (scipy.integrate.solve_ivp, fastdyn.solve_ivp):
        st["k"] = 0.3
        found.append(solve(fun, (0, 2), [1.7, 1.1], method, events=event, **options))
    theirs, ours = found
    assert (ours.nfev, ours.njev) == (theirs.nfev, theirs.njev)
    np.testing.assert_allclose(ours.t, theirs.t, rtol=1e-5)  # the Jacobian is exact
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-5)
