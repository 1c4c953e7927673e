"""A prepared solver on runs that are ready: results and exceptions of the long way."""

import gc
import math
import pickle

import numpy as np
import pytest

import fastdyn
from fastdyn import prepare
from support.repeated import (
    METHODS,
    START,
    assert_same,
    both_ways,
    is_plain,
    oscillator,
    pendulum,
    warm,
    was_ready,
)  # fmt: skip


@pytest.mark.parametrize("t_eval", [None, [0.25, 1.0]], ids=["steps", "times"])
@pytest.mark.parametrize("method", METHODS)
def test_every_method_has_the_bits_of_python(method, t_eval):
    fun = oscillator if method == "VelocityVerlet" else pendulum
    mine, plain = both_ways(fun, method=method, t_eval=t_eval, **METHODS[method])
    for y0 in (None, START, [0.1, -0.5], (1.0, 0), [np.float64(0.3), 2.0], np.array([2.0, 0.0])):
        result = mine(y0)
        assert was_ready(result), y0
        assert_same(plain(y0), result)


BAD = [
    [1.0], np.zeros(3), np.zeros((1, 2)), [math.nan, 0.0], np.array([math.inf, 0.0]), ["a", "b"],
    [1j, 0.0], 5.0, [None, 1.0], [10**400, 0.0],
]  # fmt: skip


@pytest.mark.parametrize("y0", BAD, ids=map(repr, BAD))
def test_what_python_refuses_is_refused(y0):
    mine, plain = both_ways()
    said = []
    for solver in (plain, mine):
        with pytest.raises((TypeError, ValueError, OverflowError)) as raised:
            solver(y0)
        said.append((raised.type, str(raised.value)))
    assert said[0] == said[1]
    assert is_plain(mine, START)


UNUSUAL = [
    [1, 2], np.array([1, 2]), np.zeros(4)[::2], np.array([0.1, 0.2], "f4"), range(2),
    np.array([0.1, 0.2], ">f8"), np.frombuffer(bytearray(17), np.int8)[1:].view(float),
    [True, 2.0], np.array([0.1, 0.2], object), np.ma.array([0.1, 0.2]), iter([1.0, 2.0]),
]  # fmt: skip


@pytest.mark.parametrize("y0", UNUSUAL[:-1], ids=lambda y0: type(y0).__name__)
def test_any_form_of_a_state(y0):
    mine, plain = both_ways()
    assert_same(plain(y0), mine(y0))


def test_wrong_calls_raise_as_before():
    mine, _ = both_ways()
    for given, named in (((START, (), 1), {}), ((), {"y": START}), ((START,), {"y0": START})):
        with pytest.raises(TypeError):
            mine(*given, **named)
    assert_same(mine(START, ()), mine(y0=START, args=[]))


def test_a_function_that_raises():
    def fun(t, y):
        return [math.sqrt(y[0]) * math.log(y[0])]

    mine, plain = both_ways(fun, y0=[2.0])
    assert is_plain(mine, [2.5])
    for solver in (plain, mine):
        with pytest.raises(ValueError, match="math domain error"):
            solver([-1.0])
    assert_same(plain([2.5]), mine([2.5]))
    del fun


@pytest.mark.parametrize("method", ["RK45", "Taylor", "RK4"])
def test_long_solves_go_on(method):
    span, options = (0.0, 400.0), {"step": 0.01} if method == "RK4" else {"rtol": 1e-10}
    mine, plain = both_ways(span=span, method=method, t_eval=[1.0, 400.0], **options)
    for y0 in (START, [1.0, 0.0]):
        assert_same(plain(y0), mine(y0))
    mine, plain = both_ways(span=span, method=method, **options)
    for y0 in (START, [1.0, 0.0], [0.0, 0.0], [1.0, 0.5]):
        assert_same(plain(y0), mine(y0))
        gc.collect()


def test_results_do_not_share_memory():
    mine, plain = both_ways()
    results = [mine([0.1 * i, 0.0]) for i in range(1, 20)]
    for i, result in enumerate(results, 1):
        assert_same(plain([0.1 * i, 0.0]), result)
        result.y[:] = 0.0


def test_solves_that_fail():
    mine, plain = both_ways(lambda t, y: y * y, y0=[0.5])
    assert is_plain(mine, [0.25])
    failed = mine([2.0])
    assert failed.status == -1
    assert_same(plain([2.0]), failed)
    assert_same(plain([0.25]), mine([0.25]))


def test_solves_of_other_spans_that_fail():
    mine, plain = both_ways(max_steps=20, rtol=1e-9)
    assert is_plain(mine, t_span=(0.0, 0.1))
    for end in (50.0, 80.0, -50.0):
        failed = mine(t_span=(0.5, end))
        assert failed.status == -1 and "of the way" in failed.message
        assert_same(plain(t_span=(0.5, end)), failed)


def test_what_a_result_can_do():
    mine, _ = both_ways()
    result = mine()
    assert pickle.loads(pickle.dumps(result)).keys() == result.keys() and result.t is result["t"]
    assert "sol" in result and result.sol is None and result.get("none", 5) == 5
    result.note = 1
    del result.sol
    assert result["note"] == 1 and not hasattr(result, "sol") and not hasattr(result, "other")
    with pytest.raises(KeyError):
        result["other"]
    assert result.y.flags.writeable and "n_accepted" in repr(result)


def test_a_copy_has_runs_of_its_own():
    mine, _ = both_ways()
    copied = pickle.loads(pickle.dumps(mine))
    assert_same(mine(), warm(copied))
    assert is_plain(copied)


OWN = {  # an argument of `prepare`, others, and what the array or list has later
    "atol": (np.array([1e-6, 1e-8]), {}, 1e-2), "rtol": ([1e-6, 1e-8], {}, 1e-1),
    "t_eval": (np.array([0.25, 0.5, 1.0]), {}, 0.3), "y0": (START.copy(), {}, 2.0),
    "t_span": ([0.0, 1.0], {}, 0.5), "breakpoints": (np.array([0.5]), {"method": "Tsit5"}, 0.4),
    "mass": (np.array([[1.0, 0.0], [0.5, 2.0]]), {"method": "Radau"}, [3.0, 1.0]),
    "sensitivity": (["y0"], {}, "args"),
}  # fmt: skip


@pytest.mark.parametrize("name", OWN)
def test_arrays_and_lists_belong_to_the_solver(name):
    """Also where a solve goes the long way, has another span, or is that of a copy."""
    value, others, later = OWN[name]
    value = pickle.loads(pickle.dumps(value))
    given = {"t_span": (0.0, 1.0), "y0": START, "args": (0.1,), **others, name: value}
    solver = prepare(pendulum, compile="shared", **given)
    calls = [{}, {"y0": [np.float32(0.5), 0.25]}, {"args": (np.array(0.1),)}, {}]
    if name != "breakpoints":
        calls.append({"t_span": (0.0, 1.5)})
    before = [solver(**call) for call in calls]
    value[0] = later
    for mine in (solver, pickle.loads(pickle.dumps(solver))):
        for call, expected in zip(calls, before, strict=True):
            assert_same_outputs(mine(**call), expected)


def assert_same_outputs(found, expected):
    np.testing.assert_array_equal(found.t, expected.t)
    np.testing.assert_array_equal(found.y, expected.y)
    assert found.get("sensitivity", {}).keys() == expected.get("sensitivity", {}).keys()


def test_the_rules_of_events_belong_to_the_solver():
    """Also where a solve goes the long way: rules are those that events had at first."""

    def low(t, y, damping):
        return y[0] - 0.1

    low.terminal = True
    every = fastdyn.every(0.4)
    given = {"events": [low, every], "args": (0.1,)}
    solver = prepare(pendulum, (0.0, 2.0), START, compile="shared", **given)
    calls = [{}, {"t_span": (0.0, 1.5)}, {"args": (np.array(0.1),)}, {"t_span": (0.0, 1.0)}, {}]
    before = [solver(**call) for call in calls]
    assert before[0].status == 1
    low.terminal = False
    low.direction = 1
    every.terminal = True
    for call, expected in zip(calls, before, strict=True):
        found = solver(**call)
        assert_same_outputs(found, expected)
        assert found.status == expected.status
