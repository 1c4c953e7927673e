"""Repeated calls of `solve_ivp`: the results of the first call, to the last bit."""

import functools
import gc
import math
import warnings

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.kernels.methods.taylor.accuracy import order_for
from fastdyn.run import again, stiffness
from fastdyn.solve import ivp, repeated
from support.repeated import (
    CALLS,
    assert_first,
    assert_same,
    closure,
    is_plain,
    plain,
    warm,
    was_ready,
)

g = 9.81
START = np.array([0.5, 0.25])
METHODS = ["RK23", "RK45", "DOP853", "Tsit5", "Vern9", "ode45", "Taylor", "Radau", "BDF", "LSODA"]


def pendulum(t, y):
    return [y[1], -g * math.sin(y[0]) + 0.01 * t]


pytestmark = pytest.mark.usefixtures("nothing_known")


SPANS = [
    ((0.0, 1.0), None), ((0.0, 2.0), None), ((1.0, -1.0), None), ((2, 3), None), ((0, 0.001), None),
    ((np.float64(0.5), 1.0), None), ((0.0, 1.0), None), ((-0.0, 1.0), None), ((1, 0), None),
    ((1.0, -0.0), None), ((5.0, 5.0 + 1e-9), None),
    ((0.0, 1.0), [0.5, 1.0]), ((0.0, 2.0), np.array([0.0, 2.0])), ((1.0, 0.0), [0.5, 0.25]),
    ((0.0, 1.0), (0.5, 0.75)), ((0.0, 1.0), [0.125, np.float64(1.0)]), ((0.0, 1.0), [0, 1]),
    ((0.0, 1.0), [0.5]), ([0.0, 1.0], [0.5, 0.75]), (np.array([0.0, 1.0]), None),
    ([0, 1], None), (np.array([0, 1]), None), ([0.0, 1.0, 2.0][:2], None), ([1.0, -1.0], [0.5]),
]  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_spans_times_states_and_methods(method):
    for times in (None, [0.25, 0.5]):
        warm(solve_ivp, pendulum, (0.0, 1.0), START, method, times)
        assert is_plain(solve_ivp, pendulum, (0.0, 1.0), START, method, times)
    n_plain = 0
    for span, times in SPANS:
        for y0 in (START, [0.1, -0.3], (1.0, 0), [1e3, 0.0], np.array([1, 0]), START.astype("f4")):
            mine = solve_ivp(pendulum, span, y0, method, times)
            n_plain += was_ready(mine)
            assert_same(plain(pendulum, span, y0, method, times), mine)
    assert n_plain > 30


def test_the_size_of_a_state_chooses_the_order_of_a_series():
    options = {"rtol": 1e-12, "atol": 1e-9}
    for start in ([1.0, 0.0], [1e-6, 0.0]):
        assert is_plain(solve_ivp, pendulum, (0, 1), start, "Taylor", **options)
        orders = set()
        for size in (0.0, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6):
            mine = solve_ivp(pendulum, (0, 1), [0.0, -size], "Taylor", **options)
            expected = plain(pendulum, (0, 1), [0.0, -size], "Taylor", **options)
            orders.add(order_for(1e-12, 1e-9, np.array([size])))
            assert_same(expected, mine)
        assert len(orders) > 1


def spring(t, y, stiffness=9.0, friction=0.1):
    return [y[1], -stiffness * y[0] - friction * y[1]]


@pytest.mark.parametrize("first", [None, (4.0,), (4.0, 0.5), ()])
def test_arguments_of_one_call_are_not_those_of_the_next(first):
    warm(solve_ivp, spring, (0.0, 1.0), START, args=first)
    for args in (None, (4.0,), None, (), (4.0, 0.5), (9.0,), None):
        for _ in range(CALLS):
            mine = solve_ivp(spring, (0.0, 1.0), START, args=args)
            assert_same(plain(spring, (0.0, 1.0), START, args=args), mine)


def test_lists_and_arrays_are_read_at_each_call():
    span, ends, args, y0 = [0.0, 1.0], np.array([0.0, 1.0]), [4.0], np.array([1, 0])
    for given in (span, ends):
        warm(solve_ivp, spring, given, y0, args=args)
    for change in range(4):
        for given in (span, ends):
            mine = solve_ivp(spring, given, y0, args=args)
            assert was_ready(mine)
            assert_same(plain(spring, tuple(given), y0.tolist(), args=tuple(args)), mine)
        span[change % 2] += 0.25
        ends[1] += 0.5
        args[0] += 1.0
        y0[0] += 1


class Spring:
    def __init__(self, stiffness):
        self.stiffness = stiffness

    def __call__(self, t, y):
        return [y[1], -self.stiffness * y[0]]


class Passage:
    direction = 0

    def __init__(self, level, terminal):
        self.level, self.terminal = level, terminal

    def __call__(self, t, y):
        return y[0] - self.level


def test_objects_and_partials():
    spans = (0.0, 1.0)
    assert is_plain(solve_ivp, Spring(2.0), spans, START)
    assert is_plain(solve_ivp, functools.partial(spring, stiffness=2.0), spans, START)
    assert is_plain(solve_ivp, Spring(2.0), spans, START, events=Passage(0.1, True))
    changed = Spring(3.0)
    for fun in (
        Spring(3.0), Spring(4), changed, changed, functools.partial(spring),
        functools.partial(spring, stiffness=4.0), functools.partial(spring, friction=4.0),
        functools.partial(spring, stiffness=5), functools.partial(Spring(6.0)),
    ):  # fmt: skip
        changed.stiffness += 1.0
        for _ in range(3):
            assert_same(plain(fun, spans, START), solve_ivp(fun, spans, START))
    for event in (Passage(0.2, True), Passage(0.2, False), Passage(0.3, True)):
        mine = solve_ivp(Spring(2.0), spans, START, events=event)
        theirs = plain(Spring(2.0), spans, START, events=event)
        assert mine.t_events[0].tolist() == theirs.t_events[0].tolist()
        assert mine.y.tolist() == theirs.y.tolist()


@pytest.mark.parametrize("method", ["RK45", "Radau", "Taylor"])
def test_times_that_are_whole_numbers(method):
    for times in (range(6), [0, 1, 2], np.arange(4), np.arange(5, dtype=np.float32)):
        assert is_plain(solve_ivp, pendulum, (0, 5), START, method, times)
        for t_eval in (times, np.arange(len(times)), [0.5 * k for k in range(len(times))]):
            mine = solve_ivp(pendulum, (0, 5), START, method, t_eval)
            assert_same(plain(pendulum, (0, 5), START, method, t_eval), mine)
    long = plain(pendulum, (0, 900), START, method, range(901))  # beyond the first chunk
    assert_same(long, warm(solve_ivp, pendulum, (0, 900), START, method, range(901)))


def test_without_arguments_solves_are_plain_after_calls_with_some():
    warm(solve_ivp, spring, (0.0, 1.0), START, args=(4.0,))
    assert is_plain(solve_ivp, spring, (0.0, 1.0), START)


@pytest.mark.parametrize("method", ["RK45", "Taylor"])
def test_tolerances_and_closures(method):
    for options in ({}, {"rtol": 1e-8}, {"rtol": 1e-6, "atol": 1e-9}, {"atol": 1e-3}):
        warm(solve_ivp, closure(1.0), (0, 1), START, method, **options)
        for q in (2.0, 9.81, np.float64(3.0), 4):
            if type(q) is float:
                assert is_plain(solve_ivp, closure(q), (0, 1), START, method, **options)
            mine = solve_ivp(closure(q), (0, 1), START, method, **options)
            assert_same(plain(closure(q), (0, 1), START, method, **options), mine)
    for options in ({"rtol": 1}, {"rtol": np.array([1e-3, 1e-4])}, {"max_step": 0.1}):
        for _ in range(CALLS):
            mine = solve_ivp(closure(1.0), (0, 1), START, method, **options)
        assert_same(plain(closure(1.0), (0, 1), START, method, **options), mine)


@pytest.mark.parametrize("method", ["RK45", "Radau", "Taylor", "LSODA"])
def test_a_tolerance_for_each_component(method):
    for atol in ([1e-6, 1e-8], np.array([1e-7, 1e-5]), (1e-7, 1e-6), [1e-6, 1]):
        assert is_plain(solve_ivp, pendulum, (0, 1), START, method, atol=atol)
        for other in (atol, np.array(atol)[::-1], 1e-6, np.array(1e-6)):
            for y0 in (START, 2e3 * START):
                mine = solve_ivp(pendulum, (0, 1), y0, method, atol=other)
                assert_same(plain(pendulum, (0, 1), y0, method, atol=other), mine)
    for wrong in ([1e-6], [[1e-6, 1e-6]], [1e-6, -1.0], [1e-6, "a"], [1e-6, math.nan]):
        with pytest.raises((ValueError, TypeError)):
            solve_ivp(pendulum, (0, 1), START, method, atol=wrong)
    changed = np.array([1e-6, 1e-6])
    warm(solve_ivp, pendulum, (0, 1), START, method, atol=changed)
    changed[0] = 1e-9
    mine = solve_ivp(pendulum, (0, 1), START, method, atol=changed)
    assert_same(plain(pendulum, (0, 1), START, method, atol=changed), mine)


def test_a_number_that_changes_in_place_is_read_at_each_call():
    class Longest:
        value = 0.1

        def __float__(self):
            return self.value

        __lt__ = lambda self, other: self.value < other  # noqa: E731
        __gt__ = lambda self, other: self.value > other  # noqa: E731
        __le__ = lambda self, other: self.value <= other  # noqa: E731
        __ge__ = lambda self, other: self.value >= other  # noqa: E731

    longest = Longest()
    for value in (0.1, 0.1, 0.1, 0.02, 0.02, 0.1):
        longest.value = value
        steps = np.diff(solve_ivp(lambda t, y: [-y[0]], (0, 5), [1.0], max_step=longest).t)
        assert steps.max() == pytest.approx(value)


@pytest.mark.parametrize("option", ["sensitivity", "adjoint"])
def test_names_in_a_list_are_read_at_each_call(option, monkeypatch):
    names, times = ["stiffness"], [0.5, 1.0]

    def found():
        given = {"args": (9.0, 0.1), option: names, "rtol": 1e-8, "t_eval": times}
        result = solve_ivp(spring, (0, 1), START, **given)
        return result.sensitivity if option == "sensitivity" else result.vjp(np.ones((2, 2)))

    warm(found)
    noted = []
    monkeypatch.setattr(repeated, "note", lambda *given: noted.append(given))
    assert "stiffness" in found() and "friction" not in found()
    assert not noted  # the call took a run that was ready
    names[0] = "friction"
    assert "friction" in found() and "stiffness" not in found()


def test_results_with_events_share_no_memory():
    def crossing(t, y):
        return y[0] - 0.3

    call = functools.partial(solve_ivp, spring, (0, 3), events=crossing)
    assert is_plain(call, START)
    one, other = call(START), call(2.0 * START)
    mine = plain(spring, (0, 3), START, events=crossing)
    assert one.t_events[0].size > 1
    for name in ("t", "y", "t_events", "y_events"):
        mine_there, there, later = (np.array(each[name]) for each in (mine, one, other))
        assert there.tobytes() == mine_there.tobytes() != later.tobytes(), name
        for a, b in zip(one[name], other[name], strict=False):
            assert not np.shares_memory(a, b), name


WRONG = [
    {"t_span": (0.0, math.nan)}, {"t_span": (0.0,)}, {"t_span": (0.0, 1.0, 2.0)},
    {"t_span": (0.0, "b")}, {"t_span": 1.0}, {"t_eval": [0.5, 2.0]}, {"t_eval": [0.75, 0.5]},
    {"t_eval": [-0.5, 0.5]}, {"t_eval": [0.5, 0.5]}, {"t_eval": [0.5, math.nan]},
    {"t_eval": [math.nan, 0.5]}, {"t_eval": np.array([[0.25, 0.5]])}, {"y0": [math.nan, 1.0]},
    {"y0": [[1.0, 2.0]]}, {"y0": "ab"}, {"y0": None}, {"args": (1.0,)}, {"args": 5},
    {"rtol": math.nan}, {"atol": -1.0}, {"method": "RK54"}, {"method": ["RK45"]},
    {"t_span": (0.0, 10**400)},
]  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG, ids=map(repr, WRONG))
def test_what_python_refuses_is_refused(wrong):
    given = {"t_span": (0.0, 1.0), "y0": START, "t_eval": [0.25, 0.5]}
    warm(solve_ivp, pendulum, **given)
    said = []
    for solve in (plain, solve_ivp):
        with pytest.raises((TypeError, ValueError, OverflowError)) as raised:
            solve(pendulum, **(given | wrong))
        said.append((raised.type, str(raised.value)))
    assert said[0] == said[1]
    assert is_plain(solve_ivp, pendulum, **given)


def test_spans_that_go_the_long_way():
    warm(solve_ivp, pendulum, (0.0, 1.0), START)
    for span in ((0.0, 0.0), (0.0, 1e300), (-1e308, 1e308)):
        for solve in (plain, solve_ivp):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                result = solve(pendulum, span, START) if span[1] == 0.0 else None
        assert result is None or result.t.tolist() == [0.0, 0.0]


def test_outside_values_arguments_and_numbers_of_components():
    def decay(t, y, k):
        return [-k * v for v in y]

    warm(solve_ivp, decay, (0, 1), [1.0, 2.0], args=(2.0,))
    for y0 in ([1.0, 2.0], [1.0, 2.0, 3.0], [1.0]):
        for args in ((2.0,), (3.0,), (3,), [2.5], (np.float64(2.0),)):
            for _ in range(CALLS):
                mine = solve_ivp(decay, (0, 1), y0, args=args)
            assert_same(plain(decay, (0, 1), y0, args=args), mine)


def test_too_low_a_tolerance_warns_each_time():
    for _ in range(CALLS):
        with pytest.warns(UserWarning, match="rtol"):
            solve_ivp(pendulum, (0, 1), START, rtol=1e-20)


@pytest.mark.hunt
def test_long_solves_and_failures():
    for method in ("RK45", "Taylor"):
        warm(solve_ivp, pendulum, (0.0, 1.0), START, method)
        for end in (1.0, 300.0, 1.0, 20.0, 3000.0, 2.0):
            mine = solve_ivp(pendulum, (0.0, end), START, method)
            assert_same(plain(pendulum, (0.0, end), START, method), mine)
            del mine
            gc.collect()
    blow_up = lambda t, y: y * y  # noqa: E731
    warm(solve_ivp, blow_up, (0.0, 1.0), [0.5])
    for y0, end in (([0.5], 1.0), ([2.0], 1.0), ([0.5], 3.0), ([0.25], 1.0)):
        assert_same(plain(blow_up, (0.0, end), y0), solve_ivp(blow_up, (0.0, end), y0))


def swings(t, y):
    return y[0]


OUTPUTS = {
    "the end": {"t_eval": [300.0]},
    "steps": {},
    "dense": {"dense_output": True},
    "events": {"events": [swings, lambda t, y: y[1] - 9.0], "t_eval": [1.0, 300.0]},
    "dense and times": {"dense_output": True, "t_eval": [1.0, 300.0], "events": swings},
}


@pytest.mark.parametrize("method", ["RK45", "Taylor", "Rodas5P"])
@pytest.mark.parametrize("outputs", OUTPUTS)
def test_long_solves_share_no_memory_and_lay_out_nothing_anew(method, outputs):
    given = {"method": method, "rtol": 1e-8, "atol": 1e-8, "compile": "shared"}
    given |= {"max_step": 0.1, **OUTPUTS[outputs]}

    def call(by, i):
        return by(pendulum, (0.0, 300.0), [0.1 + 0.01 * i, 0.0], **given)

    for i in range(40):  # behind the solves that are examined, and the comparison after 32
        call(solve_ivp, i)
    (kind,) = [e.value for e in again.calls.entries.values() if isinstance(e.value, again.Solver)]
    go = kind.idle[0].go
    n_plain = 0
    results = []
    for i in range(12):
        results.append(call(solve_ivp, i))
        n_plain += kind.idle[0].go is go
    assert n_plain == 12 and min(run.n_accepted for run in results) > stiffness.MANY
    for i, run in enumerate(results):
        assert_first(run, call(plain, i))


def test_an_array_of_start_and_end_with_sensitivities_and_events():
    """From the third equal call on, a ready run takes the span, and the events their times."""

    def decay(t, y, k):
        return [-k * y[0]]

    def half(t, y, k):
        return y[0] - 0.5

    span = np.array([0.0, 3.0])
    for _ in range(5):
        given = {"args": (0.5,), "sensitivity": "args[0]", "events": half, "rtol": 1e-8}
        run = solve_ivp(decay, span, [1.0], **given)
        moved = run.event_sensitivity[0].t["k"]
        assert np.isclose(moved[0], -np.log(2) / 0.25, rtol=1e-5)


@pytest.mark.parametrize("option", ["sensitivity", "adjoint"])
def test_the_place_of_an_option_among_others_does_not_matter(option, monkeypatch):
    def never(*given):
        raise AssertionError

    times = [0.0, 0.5, 1.0]
    before = {option: "y0", "rtol": 1e-7, "t_eval": times}
    behind = {"rtol": 1e-7, "t_eval": times, option: "y0"}
    warm(solve_ivp, pendulum, (0.0, 1.0), START, **before)
    monkeypatch.setattr(ivp, "checked", never)
    for given in (before, behind):
        assert solve_ivp(pendulum, (0.0, 1.0), START, **given).success
