"""Each way to solve a delay equation again gives the bits of a first solve.

A table of problems and a table of ways, as `tests/solve/test_ways_of_a_solve.py` has them.
"""

import copy
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest

from fastdyn import solve_dde, solve_dde_ensemble
from fastdyn.compile import memory
from fastdyn.compile.traced import code, known, past
from fastdyn.delays import prepare_dde
from fastdyn.delays.equation import Equation, Given
from fastdyn.run import loop
from fastdyn.run.ready import ReadyRun
from support.delayed import late

SPAN = (0.0, 9.0)
TIGHT = {"rtol": 1e-6, "atol": 1e-8}
TIMES = np.linspace(*SPAN, 6)
NAMES = (
    "t", "y", "nfev", "n_accepted", "n_rejected", "status", "message", "success", "delays", "jumps",
    "t_events", "y_events",
)  # fmt: skip


class Case(NamedTuple):
    """A problem, what calls after the first give in place of its own values, and whether plain.

    A plain one is solved by a ReadyRun.
    """

    fun: Any
    given: dict
    calls: list
    plain: bool = True
    methods: tuple = ("Tsit5", "Vern7", "DOP853")


def weighted(t, y, past, weights):
    return [-weights[0] * past(t - weights[1])[1], y[0] - weights[2] * y[1]]


def pulsed(t, y, past, start, tau):
    push = 1.0 if start < t < start + 0.5 else 0.0
    return [push - past(t - tau)[0]]


def neighbours(t, y, past, gain, tau):
    p = past(t - tau)
    return [gain * (p[i - 1] - y[i]) for i in range(12)]


def again_and_again(t, y, past, gain, tau):
    return [gain * past.derivative(t - tau)[0] - y[0]]


def of_state(t, y, past, gain, share):
    return [-gain * past(t - 0.3 - share * y[0] ** 2)[0]]


def moving(t, gain, tau):
    return [np.cos(gain * t), t]


def wave(t):
    return [np.cos(t), 0.3 * t]


def falls(t, y, past, gain, tau):
    return y[0] - 0.3 * past(t - 1.7 * tau)[0]


def ends(t, y, past, gain, tau):
    return y[0] + 0.5


ends.terminal = True


def kicks(t, y, past, gain, tau):
    return [y[0] + 0.1, y[1]]


LATE = {"history": [1.0, 0.0], "args": (1.1, 0.4), **TIGHT}
CALLS = [{"args": (0.7, 0.4)}, {"args": (0.7, 1.3)}, {"history": [0.3, -1.0]}, {"args": (1, 2)},
         {"history": [2, 0], "args": (1.1, 0.4)}, {"history": np.array([0.1, 0.2])}]  # fmt: skip
FUNCTIONS = [{"args": (0.7, 0.4)}, {"args": (0.9, 1.3)}, {"args": (1.1, 0.4)}]
OTHERS = [{"args": (0.5, 0.4)}, {"args": (0.5, 0.9)}]


def of_late(plain=True, **options):
    return Case(late, LATE | options, CALLS, plain)


CASES = {
    "steps": of_late(),
    "times": of_late(t_eval=TIMES),
    "dense": of_late(dense_output=True),
    "events": of_late(events=falls),
    "an event that ends the run": of_late(events=[ends, falls], dense_output=True),
    "events that act": of_late(False, events=falls, on_event=kicks),
    "longest step": of_late(max_step=0.07),
    "breakpoints": of_late(breakpoints=[0.5, 4.4]),
    "jumps": of_late(jumps=[-0.3]),
    "a function as history": Case(late, LATE | {"history": moving}, FUNCTIONS),
    "a function of time": Case(late, LATE | {"history": wave}, FUNCTIONS),
    "a mixture of histories": Case(late, LATE, [{"history": moving}, {"history": wave}, {}]),
    "arrays": Case(
        weighted,
        {"history": [1.0, 0.0], "args": (np.array([1.0, 0.4, 0.1]),), **TIGHT},
        [{"args": (np.array([1.0, 0.9, 0.1]),)}, {"args": (np.array([0.4, 0.4, 0.3]),)}],
    ),
    "many components": Case(
        neighbours, {"history": np.linspace(0, 1, 12), "args": (0.9, 0.4), **TIGHT}, OTHERS
    ),
    "short delays": of_late()._replace(calls=[{"args": (0.7, tau)} for tau in (1e-4, 0.4, 2e-4)]),
    "a pulse": Case(
        pulsed, {"history": [1.0], "args": (2.0, 0.4), **TIGHT},
        [{"args": (3.3, 0.4)}, {"args": (3.3, 0.9)}], False,
    ),
    "neutral": Case(
        again_and_again, {"history": [1.0], "args": (0.4, 0.5), **TIGHT}, OTHERS,
        methods=("Vern7", "Vern9"),
    ),
    "of the state": Case(of_state, {"history": [1.0], "args": (1.1, 0.1), **TIGHT},
                         [{"args": (0.7, 0.1)}, {"history": [0.2]}], False),
    "stiff": of_late(False)._replace(methods=("Rodas5P", "Radau")),
}  # fmt: skip


def of(case, method, call=None):
    return {"t_span": SPAN, "method": method} | case.given | (call or {})


def first(case, method, call):
    """The solve of an Equation that nothing knows."""
    given = of(case, method, call)
    names = Given._fields[1:-1]
    own = {name: given.pop(name, None) for name in names}
    own["dense_output"] = bool(own["dense_output"])
    return Equation(Given(case.fun, **own, options=given)).solve()


def assert_same(found, wanted):
    """Whether two results are equal, to the bit."""
    assert found.keys() == wanted.keys()
    for name in NAMES:
        one = found[name]
        other = wanted[name]
        if name.endswith("events") and other is not None:
            assert len(one) == len(other)
            for a, b in zip(one, other, strict=True):
                np.testing.assert_array_equal(a, b, err_msg=name)
        else:
            np.testing.assert_array_equal(one, other, err_msg=name)
    if wanted["sol"] is not None:
        times = np.linspace(wanted.t[0], wanted.t[-1], 50)
        np.testing.assert_array_equal(found.sol(times), wanted.sol(times))
        assert found.history.before(-0.3).tolist() == wanted.history.before(-0.3).tolist()


def again(case, method):
    for call in (*[{}] * 4, *case.calls, {}, *case.calls):
        yield solve_dde(case.fun, **of(case, method, call)), call


def prepared(case, method, tier):
    return prepare_dde(case.fun, compile=tier, **of(case, method))


def called(solver, case):
    for call in (*[{}] * 4, *case.calls, {}, *case.calls, {}, {}, *case.calls):
        yield solver(**call), call


def in_place(case, method):
    """Arrays of the arguments and of the history change between calls."""
    solver = prepared(case, method, "inlined")
    given = of(case, method)
    own = copy.deepcopy({name: given[name] for name in ("history", "args")})
    for call in (*[{}] * 4, *case.calls, {}, *case.calls):
        wanted = copy.deepcopy({"args": given["args"], "history": given["history"]} | call)
        for name, value in wanted.items():
            old = own[name]
            if name == "args":
                for k, each in enumerate(value):
                    if isinstance(each, np.ndarray):
                        old[k][:] = each
                        value = (*value[:k], old[k], *value[k + 1 :])
                wanted[name] = value
            elif isinstance(old, list | np.ndarray) and not callable(value):
                old[:] = list(value)
                wanted[name] = old
        yield solver(**wanted), call


def copied(case, method):
    original = prepared(case, method, "shared")
    yield from called(original, case)
    yield from called(pickle.loads(pickle.dumps(original)), case)


WAYS = {
    "again": again,
    "prepared": lambda case, method: called(prepared(case, method, "inlined"), case),
    "shared": lambda case, method: called(prepared(case, method, "shared"), case),
    "in place": in_place,
}
PRODUCT = [
    pytest.param(CASES[name], method, WAYS[way], id=f"{name}-{way}-{method}")
    for name in CASES
    for way in WAYS
    for method in CASES[name].methods
]


@pytest.mark.few(48)
@pytest.mark.parametrize(("case", "method", "way"), PRODUCT)
def test_the_bits_are_those_of_a_first_solve(case, method, way):
    known = {}
    for found, call in way(case, method):
        if repr(call) not in known:
            known[repr(call)] = first(case, method, call)
        assert_same(found, known[repr(call)])


@pytest.mark.parametrize("name", ["steps", "dense", "events", "many components", "arrays"])
def test_copies_solve_alike(name):
    case = CASES[name]
    for found, call in copied(case, "Tsit5"):
        assert_same(found, first(case, "Tsit5", call))


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name].plain])
def test_plain_problems_are_solved_by_a_ready_run(name, monkeypatch):
    solves = []
    solve = loop.Run.solve
    monkeypatch.setattr(loop.Run, "solve", lambda *given: solves.append(1) or solve(*given))
    case = CASES[name]
    solver = prepared(case, case.methods[0], "inlined")
    for _ in range(4):
        solver()
    assert isinstance(solver._equation._ready, ReadyRun)
    for _ in range(8):  # solves 1, 2, 4, 8, ... are compared with the function
        solver()
    assert len(solves) <= 6
    if not {"events", "jumps", "breakpoints"} & {*case.given}:  # else the long way
        solves.clear()
        for _ in range(24):
            solve_dde(case.fun, **of(case, case.methods[0]))
        assert len(solves) <= 12


def test_a_trajectory_of_an_ensemble_is_that_of_a_first_solve():
    taus = np.array([0.4, 0.4, 0.7, 0.7, 0.3, 0.4])
    found = solve_dde_ensemble(late, SPAN, [1.0, 0.0], (1.1, taus), method="Tsit5", **TIGHT)
    for i, tau in enumerate(taus):
        wanted = first(CASES["steps"], "Tsit5", {"args": (1.1, float(tau))})
        np.testing.assert_array_equal(found.y_end[i], wanted.y[:, -1])
        np.testing.assert_array_equal(found.t_end[i], wanted.t[-1])
        assert found.delays[i].tolist() == [tau]


def ahead(t, y, past, gain, tau):
    """Two reads of few components, one of which goes back and forth over many steps."""
    far = past(t - 1.0 - 0.9 * tau * np.sin(40.0 * t))[0]
    return [-gain * past(t - tau)[0] - 0.1 * far, y[0] - y[1]]


def test_reads_within_a_function_have_the_bits_of_the_kernel(monkeypatch):
    found = {}
    key = code.Traced.key
    for most in (3, -1):  # components that are read within the function; none
        monkeypatch.setattr(past, "FEW_COMPONENTS", most)
        monkeypatch.setattr(known, "TABLE", memory.Table())
        monkeypatch.setattr(code.Traced, "key", lambda self, most=most: f"{key(self)} {most}")
        given = Given(ahead, SPAN, [1.0, 0.2], "Tsit5", None, False, None, (1.1, 0.4), None, None,
                      {**TIGHT, "compile": "shared"})  # fmt: skip
        equation = Equation(given)
        found[most] = equation.solve()
        assert (past.NEAR in equation.run.bounds[0].function.traced.text("f")) == (most > 0)
    assert_same(found[3], found[-1])
