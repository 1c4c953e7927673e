"""What solve_dde takes: histories, events, output, restarts, functions in Python, jumps."""

import pickle

import numpy as np
import pytest

from fastdyn import CompileWarning, solve_ivp
from fastdyn.delays import METHODS, solve_dde

TIGHT = {"rtol": 1e-10, "atol": 1e-12, "method": "Vern7"}


def lagging(t, y, past, tau=1.0):
    return [-past(t - tau)[0], y[0] - past(t - 2 * tau)[1]]


def test_without_a_past_it_is_solve_ivp():
    found = solve_dde(lambda t, y, past: [y[1], -y[0]], (0, 5), [1.0, 0.0], **TIGHT)
    other = solve_ivp(lambda t, y: [y[1], -y[0]], (0, 5), [1.0, 0.0], **TIGHT)
    np.testing.assert_array_equal(found.y, other.y)


def test_outputs_are_those_of_the_steps():
    whole = solve_dde(lagging, (0, 6), [1.0, 0.5], dense_output=True, **TIGHT)
    times = np.linspace(0, 6, 25)
    at = solve_dde(lagging, (0, 6), [1.0, 0.5], t_eval=times, **TIGHT)
    np.testing.assert_allclose(at.y, whole.sol(times), rtol=0, atol=1e-14)
    assert at.sol is None and at.t.tolist() == times.tolist()


def test_more_steps_than_a_first_piece_of_output_holds():
    long = solve_dde(lagging, (0, 60), [1.0, 0.5], args=(0.05,), **TIGHT)
    assert len(long.t) > 1000
    other = solve_dde(lagging, (0, 60), [1.0, 0.5], args=(0.05,), **{**TIGHT, "method": "Vern9"})
    np.testing.assert_allclose(long.y[:, -1], other.y[:, -1], rtol=0, atol=1e-8)


def test_a_solve_goes_on_from_an_earlier_one():
    whole = solve_dde(lagging, (0, 8), [1.0, 0.5], **TIGHT)
    first = solve_dde(lagging, (0, 1.5), [1.0, 0.5], dense_output=True, **TIGHT)
    rest = solve_dde(lagging, (1.5, 8), first, dense_output=True, **TIGHT)
    assert {2.0, 3.0, 4.0} <= set(rest.t.tolist()) and rest.jumps.tolist() == [0.0, 1.5]
    np.testing.assert_allclose(rest.y[:, -1], whole.y[:, -1], rtol=0, atol=1e-9)
    again = solve_dde(lagging, (3.5, 8), _until(rest, 3.5), **TIGHT)
    np.testing.assert_allclose(again.y[:, -1], whole.y[:, -1], rtol=0, atol=1e-9)


def _until(first, t):
    """The result of going on from 1.5 to t, whose history is another result."""
    start = first.history._earlier
    return solve_dde(lagging, (1.5, t), start, dense_output=True, **TIGHT)


def test_histories_are_numbers_functions_and_results():
    def fun(t, y, past):
        return [past(t - 1.0)[0]]

    constant = solve_dde(fun, (0, 0.5), 2.0, **TIGHT).y[0, -1]
    assert abs(constant - 3.0) < 1e-14
    moving = solve_dde(fun, (0, 0.5), lambda t: [np.cos(t)], **TIGHT).y[0, -1]
    assert abs(moving - (1 + np.sin(-0.5) - np.sin(-1.0))) < 1e-10
    ordinary = solve_ivp(lambda t, y: [-y[0]], (-2, 0), [np.exp(2)], dense_output=True, **TIGHT)
    follows = solve_dde(fun, (0, 0.5), ordinary, **TIGHT).y[0, -1]
    assert abs(follows - (1 + np.exp(1.0) - np.exp(0.5))) < 1e-8
    with pytest.raises(ValueError, match="before the start of the earlier result, -2"):
        solve_dde(lambda t, y, past: [past(t - 3.0)[0]], (0, 1), ordinary, **TIGHT)


def test_events_read_the_past():
    def meets(t, y, past):
        return y[0] - past(t - 1.0)[0] - 0.5

    meets.terminal = True
    found = solve_dde(lambda t, y, past: [1.0], (0, 5), [0.0], events=meets, **TIGHT)
    assert found.status == 1
    np.testing.assert_allclose(found.t_events[0], [0.5], rtol=1e-14)


def test_a_function_in_python_names_its_delays():
    seen = []

    def noted(t, y, past):
        seen.append(float(str(t)))
        return [-past(t - 1.0)[0]]

    with pytest.raises(ValueError, match=r"traced \(ValueError: could not .*give `delays=`"):
        solve_dde(noted, (0, 4), [1.0])
    # The reason is that of the trace: Numba knows nothing of the past.
    with pytest.warns(CompileWarning, match="many times slower: ValueError: could not convert"):
        found = solve_dde(noted, (0, 4), [1.0], delays=[1.0], **TIGHT)
    traced = solve_dde(lambda t, y, past: [-past(t - 1.0)[0]], (0, 4), [1.0], **TIGHT)
    np.testing.assert_allclose(found.y, traced.y, rtol=0, atol=1e-14)
    assert len(seen) > found.nfev


@pytest.mark.parametrize("method", ["auto", *METHODS])
def test_switching_times_are_carried_on_by_delays(method):
    """A pulse of 0.01 in the equations comes back after each delay; no step jumps over one.

    That holds for DOP853 and Radau, too, whose steps end nowhere in an ordinary equation.
    """

    def fun(t, y, past):
        return [1.0 if 5.0 < t < 5.01 else 0.0, past(t - 3.0)[0]]

    found = solve_dde(fun, (0, 12), [0.0, 0.0], method, rtol=1e-6, atol=1e-9)
    assert abs(found.y[0, -1] - 0.01) < 1e-12
    assert abs(found.y[1, -1] - 0.01 * (12 - 3 - 5.005)) < 1e-10
    assert {8.0, 8.01} <= set(found.t.round(12).tolist())


def test_a_jump_of_the_history_is_told():
    def before(t):
        return [1.0 if t > -0.5 else -1.0]

    found = solve_dde(
        lambda t, y, past: [past(t - 1.0)[0]], (0, 1), before, jumps=[-0.5], rtol=1e-3, atol=1e-6
    )
    assert abs(found.y[0, -1] - 1.0) < 1e-14  # 1 - 0.5 + 0.5


def test_exceptions_of_function_and_history_are_raised():
    def fails(t, y, past):
        if t > 1.0:
            raise RuntimeError("no more")
        return [-past(t - 0.5)[0]]

    with pytest.raises(RuntimeError, match="no more"):
        solve_dde(fails, (0, 2), [1.0])

    def lost(t):
        if t < -0.25:
            raise LookupError(f"nothing at {t}")
        return [1.0]

    with pytest.raises(LookupError, match="nothing"):
        solve_dde(lambda t, y, past: [-past(t - 0.5)[0]], (0, 2), lost)


def test_two_solves_do_not_share_their_past():
    ends = []
    for start in (1.0, 2.0, 1.0):
        ends.append(solve_dde(lagging, (0, 6), [start, 0.5], **TIGHT).y[0, -1])
    assert ends[0] == ends[2] != ends[1]


def test_the_past_at_an_array_of_times_has_the_shape_of_sol():
    """The times are behind the components, as in `sol`, and a derivative likewise."""
    taus = np.array([[0.5, 1.0], [1.5, 2.0]])

    def together(t, y, past):
        late = past(t - taus)
        assert late.shape == (2, 2, 2)
        return -late[:, 0, 1] - 0.5 * late[:, 1].sum(axis=-1)

    def singly(t, y, past):
        return -past(t - 1.0) - 0.5 * (past(t - 1.5) + past(t - 2.0))

    given = (0, 5), lambda t: [np.sin(t), np.cos(t)]
    one, other = (solve_dde(f, *given, **TIGHT) for f in (together, singly))
    assert one.delays.tolist() == [1.0, 1.5, 2.0]  # 0.5 is read, and not used
    np.testing.assert_allclose(one.y[:, -1], other.y[:, -1], rtol=0, atol=1e-12)

    def slopes(t, y, past):
        return -y + 0.1 * past.derivative([t - 1.0, t - 2.0]).sum(axis=-1)

    def slope_by_slope(t, y, past):
        return -y + 0.1 * past.derivative(t - 1.0) + 0.1 * past.derivative(t - 2.0)

    one, other = (solve_dde(f, *given, **TIGHT) for f in (slopes, slope_by_slope))
    np.testing.assert_allclose(one.y[:, -1], other.y[:, -1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("n", [1, 40])
def test_a_pulse_of_a_table_times_the_past_is_not_lost(n):
    """No formula knows the past: the times at which its factor bends are those of the factor."""
    knots = np.array([0.0, 5.0, 5.01, 5.02, 10.0])
    heights = np.array([0.0, 0.0, 300.0, 0.0, 0.0])

    def fun(t, y, past):
        return np.interp(t, knots, heights) * past(t - 1.0)

    first = solve_dde(fun, (0.0, 10.0), np.ones(n), "Tsit5")
    np.testing.assert_allclose(first.y[:, -1], 4.0, rtol=1e-12)  # a triangle of area 3
    for _ in range(4):  # another decision about the times is that of compiled code
        again = solve_dde(fun, (0.0, 10.0), np.ones(n), "Tsit5")
        assert again.t.tobytes() == first.t.tobytes() and again.y.tobytes() == first.y.tobytes()


def moving(t):
    return [np.cos(t), np.sin(t)]


@pytest.mark.parametrize("history", [[1.0, 0.5], moving])
def test_the_continuous_solution_has_its_history(history):
    """Before the start, an extrapolation of the first step would be another function."""
    found = solve_dde(lagging, (0, 2), history, dense_output=True, **TIGHT)
    times = [-1.5, -0.5, 0.0, 1.0]
    before = np.array([moving(t) if callable(history) else history for t in times[:2]]).T
    np.testing.assert_array_equal(found.sol(times)[:, :2], before)
    np.testing.assert_array_equal(found.sol(-0.5), before[:, 1])
    slopes = [[-np.sin(t), np.cos(t)] if callable(history) else [0.0, 0.0] for t in times[:2]]
    np.testing.assert_allclose(
        found.sol.derivative(times)[:, :2], np.array(slopes).T, rtol=0, atol=1e-15
    )
    assert np.abs(found.sol.derivative(1.0)[0] + found.sol(0.0)[0]) < 1e-8
    kept = pickle.loads(pickle.dumps(found))
    rest, other = (
        solve_dde(lagging, (2, 3), each, dense_output=True, **TIGHT) for each in (found, kept)
    )
    np.testing.assert_array_equal(rest.y, other.y)
    np.testing.assert_array_equal(rest.sol(-0.5), before[:, 1])


def test_each_solve_that_fails_has_its_message():
    def fun(t, y, past, k):
        return [-k * past(t - 0.3)[0]]

    first = solve_dde(fun, (0, 10), [1.0], "Tsit5", args=(1.0,), max_steps=5)
    assert first.status == -1
    for _ in range(5):
        again = solve_dde(fun, (0, 10), [1.0], "Tsit5", args=(1.0,), max_steps=5)
        assert again.status == -1 and again.message == first.message
        np.testing.assert_array_equal(again.y, first.y)
