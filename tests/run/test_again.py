"""The same call again: each door finds its runs in one store; one thread at a time has a run."""

import gc
import weakref

import numpy as np
import pytest

from fastdyn import solve_dde, solve_ivp
from fastdyn.integrate import few, odeint
from fastdyn.run import again
from support.repeated import in_threads

TIMES = np.linspace(0.0, 2.0, 5)
LONG = {"on_interrupt": "return"}  # with it, no run is made ready


def oscillator(k):
    return lambda t, y: [y[1], -k * y[0]]


def late(k):
    return lambda t, y, past: [-k * past(t - 0.5)[0]]


def falls(t, y):
    return y[0]


DOORS = {
    "solve_ivp": (oscillator, lambda fun: solve_ivp(fun, (0, 2), [1.0, 0.5]).y),
    "events": (oscillator, lambda fun: solve_ivp(fun, (0, 2), [1.0, 0.5], events=falls).y),
    "odeint": (oscillator, lambda fun: odeint(fun, [1.0, 0.5], TIMES, tfirst=True)),
    "solve_dde": (late, lambda fun: solve_dde(fun, (0, 2), [1.0]).y),
    "the long way": (oscillator, lambda fun: solve_ivp(fun, (0, 2), [1.0, 0.5], **LONG).y),
}  # fmt: skip


@pytest.fixture(params=DOORS)
def door(request, nothing_known, monkeypatch):
    """How functions of one code are made, and how one of them is solved; nothing is known yet."""
    monkeypatch.setattr(few, "solved", lambda *given: None)  # SciPy's odeint has other bits
    return DOORS[request.param]


def kinds():
    return [(entry.key, entry.value) for entry in again.calls.entries.values()]


def test_a_run_in_use_is_not_given_twice(door):
    made, solve = door
    functions = {k: made(k) for k in (0.5, 1.0, 2.0, 4.0)}
    expected = {k: solve(fun).tobytes() for k, fun in functions.items()}
    wrong = []

    def work(k):
        for _ in range(60):
            if solve(functions[k]).tobytes() != expected[k]:
                wrong.append(k)

    in_threads(work, functions)
    assert not wrong
    waiting = [run for _, kind in kinds() for run in kind.idle]
    assert waiting and len({*map(id, waiting)}) == len(waiting)


def test_a_closure_that_changes_is_seen_and_no_function_is_held(door):
    made, solve = door
    found = [(0.5, solve(made(0.5)).tobytes())]  # whose trace may hold the function
    for k in (2.0, 2.0, 0.5, 2.0, 3.0, 0.5):
        fun = made(k)
        found.append((k, solve(fun).tobytes()))
        held = weakref.ref(fun)
        del fun
        gc.collect()
        assert held() is None
    assert len({*found}) == len({k for k, _ in found})  # one answer for each value


def test_the_ids_of_a_key_are_those_of_code_that_lives(door):
    made, solve = door
    for _ in range(4):
        solve(made(1.0))
    codes = {id(code) for _, kind in kinds() for code in kind.codes}
    assert id(made(1.0).__code__) in codes
    for key, kind in kinds():
        assert kind.codes
        assert {id(code) for code in kind.codes} <= {*_flat(key)}


def _flat(key):
    for each in key:
        if isinstance(each, tuple):
            yield from _flat(each)
        else:
            yield each
