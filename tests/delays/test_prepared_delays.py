"""prepare_dde: solves with other histories and arguments equal those of solve_dde, to the bit."""

import copy
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest

from fastdyn.delays import prepare_dde, repeated, solve_dde
from fastdyn.delays.again import RepeatedEquation
from fastdyn.delays.equation import Equation, Given
from fastdyn.problem.options.table import OPTIONS as OPTIONS_OF_ALL
from fastdyn.run import again
from support.delayed import late

OPTIONS = {"rtol": 1e-7, "atol": 1e-8, "compile": "shared"}


def moving(t, gain, tau):
    return [np.cos(gain * t), t]


def same(found, wanted):
    """Whether two results are equal, to the bit."""
    names = {"t", "y", "nfev", "n_accepted", "status", "message", "delays", "jumps", "t_events"}
    for name in names:
        one, other = found.get(name), wanted.get(name)
        if name == "t_events" and one is not None:
            one, other = np.concatenate(one), np.concatenate(other)
        np.testing.assert_array_equal(one, other, err_msg=name)


@pytest.mark.parametrize("more", [{}, {"t_eval": [1.0, 2.5, 20.0]}, {"dense_output": True}])
@pytest.mark.parametrize("history", [[1.0, 0.0], moving])
def test_solves_again_equal_first_solves(history, more):
    solver = prepare_dde(late, (0, 20), history, args=(1.1, 0.4), **more, **OPTIONS)
    cases = [(None, None), (None, (0.7, 0.4)), (None, (0.7, 0.013)), (None, (1.1, 0.4)),
             ([0.3, -1.0], (1.1, 0.4)), (moving, (0.9, 0.5)), ([0.3, -1.0], None)]  # fmt: skip
    for given, args in [*cases, *cases]:
        found = solver(given, args)
        wanted = solve_dde(
            late, (0, 20), history if given is None else given, args=args or (1.1, 0.4), **more,
            **OPTIONS,
        )  # fmt: skip
        same(found, wanted)
        if more.get("dense_output"):
            times = np.linspace(0, 20, 50)
            np.testing.assert_array_equal(found.sol(times), wanted.sol(times))
            assert found.history.before(-0.3).tolist() == wanted.history.before(-0.3).tolist()


def test_results_of_several_solves_share_nothing():
    solver = prepare_dde(late, (0, 5), [1.0, 0.0], args=(1.1, 0.4), **OPTIONS)
    first = solver()
    kept = first.y.copy()
    second = solver([5.0, 1.0], (0.3, 0.9))
    np.testing.assert_array_equal(first.y, kept)
    assert first.delays.tolist() == [0.4] and second.delays.tolist() == [0.9]


def test_what_a_function_uses_from_outside_is_read_again():
    scale = {"tau": 0.5}

    def fun(t, y, past):
        return -past(t - scale["tau"])

    solver = prepare_dde(fun, (0, 3), [1.0], **OPTIONS)
    for tau in (0.5, 1.5, 0.5):
        scale["tau"] = tau
        same(solver(), solve_dde(fun, (0, 3), [1.0], **OPTIONS))
        assert solver().delays.tolist() == [tau]


def test_a_delay_that_is_not_positive_is_refused_each_time():
    solver = prepare_dde(late, (0, 5), [1.0, 0.0], args=(1.1, 0.4), **OPTIONS)
    for _ in range(2):
        with pytest.raises(ValueError, match=r"a delay is -0\.2"):
            solver(args=(1.1, -0.2))
        assert solver().success


def high(t, y, past, gain, tau):
    return y[0] - 0.5


def test_events_and_actions():
    wanted = solve_dde(late, (0, 20), [1.0, 0.0], args=(0.9, 0.4), events=high, **OPTIONS)
    solver = prepare_dde(late, (0, 20), [1.0, 0.0], args=(1.1, 0.4), events=high, **OPTIONS)
    same(solver(args=(0.9, 0.4)), wanted)
    acting = {"events": high, "on_event": lambda t, y, past, *args: [y[0] + 0.1, y[1]]}
    wanted = solve_dde(late, (0, 5), [1.0, 0.0], args=(0.9, 0.4), **acting, **OPTIONS)
    solver = prepare_dde(late, (0, 5), [1.0, 0.0], args=(1.1, 0.4), **acting, **OPTIONS)
    for _ in range(2):
        same(solver(args=(0.9, 0.4)), wanted)
    assert len(wanted.jumps) > 1


def test_many_solves_with_a_delay_each():
    taus = np.linspace(0.2, 1.2, 7)
    solver = prepare_dde(late, (0, 8), [1.0, 0.0], t_eval=[4.0, 8.0], args=(1.1, 0.4), **OPTIONS)
    found = solver.many(args=(1.1, taus))
    assert found.y.shape == (7, 2, 2) and found.success.all()
    for row, tau in zip(found.y, taus, strict=True):
        np.testing.assert_array_equal(row, solver(args=(1.1, tau)).y)
    starts = np.array([[1.0, 0.0], [0.5, 0.2]])
    found = solver.many(starts)
    np.testing.assert_array_equal(found.y[1], solver(starts[1]).y)
    assert solver.many(moving, (1.1, taus)).y.shape == (7, 2, 2)


def test_copies_and_sensitivities():
    solver = prepare_dde(
        late, (0, 4), [1.0, 0.0], args=(1.1, 0.4), sensitivity="tau", rtol=1e-7, atol=1e-8
    )
    wanted = solve_dde(
        late, (0, 4), [1.0, 0.0], args=(1.1, 0.6), sensitivity="tau", rtol=1e-7, atol=1e-8
    )
    for each in (solver, copy.copy(solver), pickle.loads(pickle.dumps(solver))):
        found = each(args=(1.1, 0.6))
        np.testing.assert_allclose(found.sensitivity["tau"], wanted.sensitivity["tau"], atol=1e-13)
    assert "Vern7, t = 0 to 4, 2 components" in repr(solver)


def again_and_anew(fun, history, args, **more):
    """A call, again, and the same call the long way."""
    found = solve_dde(fun, (0, 6), history, args=args, rtol=1e-7, atol=1e-8, **more)
    anew = Equation(Given(
        fun, (0, 6), history, "auto", more.get("t_eval"), False, None, args, None, None,
        {"rtol": 1e-7, "atol": 1e-8},
    )).solve()  # fmt: skip
    same(found, anew)
    return found


def made(tau):
    """A function with the code of other ones."""

    def fun(t, y, past, gain):
        return -gain * past(t - tau)

    return fun


def test_calls_again_take_the_run_of_an_earlier_call(monkeypatch):
    """Other closures, histories and arguments; times of whole numbers stay whole."""
    solved = []
    own = RepeatedEquation.again

    def noted(self, *given):
        result = own(self, *given)
        solved.append(result is not None)
        return result

    monkeypatch.setattr(RepeatedEquation, "again", noted)
    for tau in (0.5, 0.5, 1.25, 0.5):
        for history in ([1.0], [2.0], lambda t: [np.cos(t)]):
            again_and_anew(made(tau), history, (0.7,))
            again_and_anew(made(tau), history, (1.7,))
    assert len(solved) > 15 and all(solved)
    for times in ([1, 3, 6], [1.0, 3.0, 6.0]):
        for _ in range(2):
            found = again_and_anew(made(0.5), [1.0], (0.7,), t_eval=times)
            assert found.t.dtype == np.asarray(times).dtype


def test_between_calls_nothing_of_the_user_is_held():
    def history(t):
        return [np.cos(t)]

    for _ in range(3):
        solve_dde(made(0.5), (0, 2), history, args=(0.7,))
    waiting = [e for entry in again.calls.entries.values() for e in entry.value.idle]
    held = [e for e in waiting if isinstance(e, Equation)]
    assert held
    for e in held:
        assert e.fun is e.problem.fun is e.run.problem.fun is e.run.memory is None
        assert e.history._function is not history
        assert all(bound.held.fun is None for bound in e.run.bounds)


def test_arrays_and_lists_belong_to_the_solver():
    history, times, atol = [1.0, 0.0], np.array([1.0, 2.5, 4.0]), np.array([1e-7, 1e-8])
    given = {"args": (1.1, 0.4), "t_eval": times, "rtol": 1e-7, "atol": atol}
    solver = prepare_dde(late, (0, 5), history, **given)
    calls = {}, {"history": moving}, {"history": [0.3, -1.0]}, {}
    before = [solver(**call) for call in calls]
    history[0] = 7.0
    times[1] = 2.0
    atol[:] = 0.1
    for mine in (solver, pickle.loads(pickle.dumps(solver))):
        for call, expected in zip(calls, before, strict=True):
            same(mine(**call), expected)


def test_several_threads_call_one_solver():
    """A solver lies in one memory: without one for each thread, few of 400 solves were wrong."""

    def fun(t, y, past, gain):
        return -gain * past(t - 1.0)

    solver = prepare_dde(fun, (0, 20), [1.0], args=(1.0,), **OPTIONS)
    gains = np.linspace(0.5, 1.5, 20)
    wanted = [solver(args=(gain,)).y[0, -1] for gain in gains]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(4) as pool:
            each = lambda _: [solver(args=(gain,)).y[0, -1] for gain in gains]  # noqa: E731
            found = list(pool.map(each, range(20)))
    finally:
        sys.setswitchinterval(interval)
    assert all(one == wanted for one in found)


def test_the_rules_of_events_belong_to_the_solver():
    """A history of another kind goes the long way."""

    def low(t, y, past, gain, tau):
        return y[0] - 0.5

    low.terminal = True
    solver = prepare_dde(late, (0, 20), [1.0, 0.0], args=(1.1, 0.4), events=low, **OPTIONS)
    calls = {}, {"history": moving}, {}
    before = [solver(**call) for call in calls]
    assert before[0].status == 1
    low.terminal = False
    for call, expected in zip(calls, before, strict=True):
        same(solver(**call), expected)


def test_an_option_that_no_key_knows_goes_the_long_way():
    assert repeated.IN_KEY.keys() <= {name for name, one in OPTIONS_OF_ALL.items() if one.in_key}
    given = Given(late, (0, 5), [1.0, 0.0], "Tsit5", None, False, None, (), None, None, {})
    assert repeated.key_of(given) is not None
    others = {
        "checkpoint": None, "progress": False, "on_interrupt": "raise", "callback": None,
        "sensitivity": "tau", "on_event": [], "at": [1.0], "every": 1.0, "breakpoints": [1.0],
        "new": 1, "atol": Fraction(1, 10**6),
    }  # fmt: skip
    for name, value in others.items():
        assert repeated.key_of(given._replace(options={name: value})) is None, name


def test_keys_tell_bits_apart():
    """0.0 equals -0.0, and 1.0 the text "1" as a number; an array changes in place."""
    atol = np.array([1e-6, 1e-8])
    given = Given(
        late, (0.0, 5.0), [1.0, 0.0], "Tsit5", None, False, None, (), None, None, {"atol": atol}
    )
    key = repeated.key_of(given)
    assert key == repeated.key_of(given._replace(options={"atol": atol.copy()}))
    assert key != repeated.key_of(given._replace(t_span=(-0.0, 5.0)))
    assert repeated.key_of(given._replace(t_span=("0", "5"))) is None
    atol[1] = 1e-3
    assert key != repeated.key_of(given)


def test_times_of_an_earlier_call_change_in_place():
    """A run that is kept has times of its own."""
    times = np.array([1.0, 3.0, 6.0])
    made_before = made(0.5)
    for _ in range(2):
        again_and_anew(made_before, [1.0], (0.7,), t_eval=times)
    times[1] = 2.0
    for tau in (0.5, 1.25):
        again_and_anew(made(tau), [1.0], (0.7,), t_eval=np.array([1.0, 3.0, 6.0]))
