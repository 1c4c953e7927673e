"""What the doors have in common, with arrays of NumPy in the place of another library's."""

import importlib
import sys

import numpy as np
import pytest

import fastdyn
from fastdyn.solve.differentiable import Axis, Library, call_of, pulled, pushed, solved
from fastdyn.solve.differentiable import call as calls
from tests.doors import problems
from tests.doors.problems import TIGHT, TIMES


class Varying(np.ndarray):
    """An array of the library of these tests."""


def varying(value):
    return np.asarray(value, float).view(Varying)


OWN = Library(
    "own",
    lambda value: isinstance(value, Varying),
    lambda value: True,
    lambda value: value.dtype.name,
    lambda values: np.array(values).view(Varying),
    lambda value: value.shape,
    "write a point.",
)


def called(fun, y0, *args, method="Tsit5", t_eval=TIMES, events=None, occurrences=1, **options):
    given = fun, (0, 3), y0, method, t_eval, events, args, occurrences, {**TIGHT, **options}
    return call_of(OWN, *given)


def bounced(t, y, k):
    return [0.0, -0.8 * y[1]]


def floor(t, y, k):
    return y[0]


floor.direction = -1


def level(t, y, k):
    return y[0] - 0.3


CHAIN = varying(np.append(np.sin(np.arange(1, 6)), np.zeros(5))), varying(np.linspace(0.5, 2, 6))
CASES = {
    "few": lambda method: called(
        problems.pendulum, varying([1.0, 0.0]), varying(9.81), 0.2, method=method
    ),
    "many": lambda method: called(problems.chain, *CHAIN, method=method),
    "many, and events": lambda method: called(
        problems.chain, *CHAIN, method=method, events=[level, problems.first_up], occurrences=3
    ),
    "times of events": lambda method: called(
        problems.fall, varying([10.0, 0.0]), varying(0.1), method=method, events=problems.ground
    ),
    "events that act": lambda method: called(
        problems.fall, varying([4.0, 0.0]), varying(0.1), method=method, events=floor,
        on_event=bounced, occurrences=2,
    ),
}  # fmt: skip


@pytest.mark.few(6)
@pytest.mark.parametrize("method", ["Tsit5", "Rodas5P"])
@pytest.mark.parametrize("case", CASES)
def test_both_directions_agree(case, method):
    """g (J v) = (g J) v, for random g and v; outputs without a part in g may be nan."""
    call, values = CASES[case](method)
    rng = np.random.default_rng(3)
    wanted = tuple(range(len(values)))
    tangents = [rng.normal(size=value.shape) for value in values]
    arrays, status = call.solve(values)
    g = [np.where(np.isnan(a), 0.0, rng.normal(size=a.shape)) for a in arrays]
    none = Axis(None, (False,) * (len(values) + len(g)))
    moved = pushed(call, wanted, [*values, *tangents], none)
    back = pulled(call, wanted, [*values, *g], none)
    forth = sum(np.sum(a * np.where(np.isnan(b), 0.0, b)) for a, b in zip(g, moved, strict=True))
    assert np.isclose(sum(np.sum(a * b) for a, b in zip(back, tangents, strict=True)), forth,
                      rtol=1e-6)  # fmt: skip
    step = 1e-5  # of differences, whose error is of its square, and that of solves over it
    ends = [
        call.solve([v + s * d for v, d in zip(values, tangents, strict=True)])[0]
        for s in (step, -step)
    ]
    for one, other, found in zip(*ends, moved, strict=True):
        there = np.isfinite(one) & np.isfinite(other)
        assert np.allclose(((one - other) / (2 * step))[there], found[there], rtol=1e-5, atol=1e-5)
    assert status == (1 if case == "times of events" else 0)


def test_the_rule(monkeypatch):
    """Sensitivities for few numbers, and wherever `adjoint` does not go; a sweep for many."""
    asked, own = [], calls.solve_ivp

    def noted(*given, **options):
        asked.append(" ".join({"adjoint", "sensitivity"} & {*options}))
        return own(*given, **options)

    monkeypatch.setattr(calls, "solve_ivp", noted)

    def of(call, values, n=None):
        asked.clear()
        call.backward(values, tuple(range(len(values)))[:n])
        return asked

    assert of(*CASES["few"]("Tsit5")) == ["sensitivity"]
    assert of(*CASES["many"]("Tsit5")) == ["adjoint"]
    call, values = called(problems.chain, CHAIN[0], 1.0 + 0 * CHAIN[1], method="BDF")
    assert of(call, values) == ["adjoint", "sensitivity"]
    assert of(call, values) == ["sensitivity"]  # what was refused once is not asked for again


def test_mistakes_of_the_function_are_its_own():
    def bad(t, y, k):
        raise KeyError("mine")

    call, values = called(bad, varying(np.ones(9)), varying(1.0))
    for solve in (call.solve, lambda v: call.backward(v, (0, 1)), lambda v: call.forward(v, (0,))):
        with pytest.raises(KeyError, match="mine") as caught:
            solve(values)
        assert any("written with NumPy" in note for note in caught.value.__notes__)


def test_nothing_varies_or_is_empty():
    call, values = called(problems.pendulum, [1.0, 0.0], 9.81, 0.2)
    assert values == [] and np.isfinite(call.solve([])[0][0]).all()

    def scaled(t, y, k, none):
        return [-k * y[0]]

    call, values = called(scaled, [1.0], varying(2.0), varying(np.zeros(0)))
    alone = call.forward(values, (1,))
    assert alone.status == 0 and np.array_equal(alone.outputs[0], call.solve(values)[0][0])
    by_k, by_none = call.backward(values, (0, 1)).pull([np.ones((1, len(TIMES)))])
    assert np.isclose(by_k, np.sum(-TIMES * np.exp(-2 * TIMES)), rtol=1e-8)
    assert by_none.shape == (0,)


def test_members_with_rows_of_their_own_are_solved_one_by_one():
    springs = np.linspace(0.5, 2, 6) * np.array([[1.0], [2.0]])
    call, values = called(problems.chain, *CHAIN)
    found = solved(call, [values[0], springs], Axis(2, (False, True)), fastdyn.solve_ensemble)
    for i in range(2):
        assert np.array_equal(found[0][i], call.solve([values[0], springs[i]])[0][0])


def spring(t, y, m):
    return [y[1], -m["k"] * y[0]]


def test_an_event_beside_a_container_has_the_rules_of_each_call():
    """The event of the numbers side by side was kept with its first rules, and without `wait`."""

    def passes(t, y, m):
        return y[0] - 0.3

    rules = {"wait": 1.0}, {"wait": 0.0}, {"direction": 1.0}, {"terminal": 2}, {"terminal": False}
    for rule in rules:
        vars(passes).update(rule)
        call, values = called(
            spring, [1.0, 0.0], {"k": varying(40.0)}, events=[passes, fastdyn.every(0.5)],
            occurrences=6,
        )  # fmt: skip
        wanted = fastdyn.solve_ivp(
            spring, (0, 3), [1.0, 0.0], "Tsit5", TIMES, events=[passes, fastdyn.every(0.5)],
            args=({"k": 40.0},), **TIGHT,
        )  # fmt: skip
        outputs, status = call.solve(values)
        assert status == wanted.status, rule
        for found, times in zip(outputs[1::2], wanted.t_events, strict=True):
            np.testing.assert_allclose(found[np.isfinite(found)], times[:6], rtol=1e-9)


@pytest.mark.parametrize("library", ["jax", "torch", "pytensor"])
def test_a_library_that_is_missing_gets_a_sentence(library, monkeypatch):
    for name in list(sys.modules):
        if name.partition(".")[0] == library or name == f"fastdyn.{library}":
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ModuleNotFoundError, match=f"pip install {library}"):
        importlib.import_module(f"fastdyn.{library}")
