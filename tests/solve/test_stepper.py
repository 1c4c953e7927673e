"""A Stepper takes the steps of solve_ivp, in SciPy's shape; a callback sees each of them."""

import copy

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import Stepper, every, solve_ivp
from support.steppers import ended

START = [0.5, 0.0]
EPS = np.finfo(float).eps
TIGHT = {"rtol": 1e-6, "atol": 1e-9}
CONSTANT = {"step": 0.03}  # no divisor of the span: the last step is cut by interpolation
METHODS = ("RK45", "DOP853", "Tsit5", "ode45", "VelocityVerlet", "Gauss4", "Radau", "BDF", "LSODA")


def pendulum(t, y, k=9.81):
    return [y[1], -k * np.sin(y[0])]


def options_of(method):
    return CONSTANT if method in ("VelocityVerlet", "Gauss4") else TIGHT


def steps_of(stepper):
    t, y = [stepper.t], [stepper.y]
    while stepper.status == "running":
        assert stepper.step() is None
        t.append(stepper.t)
        y.append(stepper.y)
    return np.array(t), np.array(y).T


@pytest.mark.parametrize("end", [2.0, -1.0])
@pytest.mark.parametrize("method", METHODS)
def test_steps_are_those_of_solve_ivp(method, end):
    given = options_of(method)
    stepper = Stepper(pendulum, 0.0, START, end, method=method, args=(4.0,), **given)
    expected = solve_ivp(pendulum, (0.0, end), START, method, args=(4.0,), **given)
    assert (stepper.t, stepper.t_old, stepper.step_size) == (0.0, None, None)
    t, y = steps_of(stepper)
    assert stepper.status == "finished" and stepper.t == end
    assert np.array_equal(t, expected.t) and np.array_equal(y, expected.y)
    assert stepper.nstep == stepper.n_accepted == expected.n_accepted
    assert stepper.n_rejected == expected.n_rejected
    with pytest.raises(RuntimeError):
        stepper.step()


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853"])
def test_counts_are_scipys(method):
    mine = Stepper(pendulum, 0.0, START, 2.0, method=method, **TIGHT)
    scipys = getattr(scipy.integrate, method)(pendulum, 0.0, np.array(START), 2.0, **TIGHT)
    while scipys.status == "running":
        mine.step()
        scipys.step()
        assert mine.nfev == scipys.nfev
        # the rounding of a step, as a part of its error estimate, which decides on the next
        assert np.isclose(mine.step_size, scipys.step_size, rtol=100 * EPS / TIGHT["atol"], atol=0)
        assert np.isclose(mine.t, scipys.t, rtol=100 * EPS / TIGHT["atol"], atol=0)
    assert mine.status == "finished"


@pytest.mark.parametrize("method", METHODS)
def test_between_the_steps(method):
    given = options_of(method)
    sol = solve_ivp(pendulum, (0.0, 1.0), START, method, dense_output=True, **given).sol
    stepper = Stepper(pendulum, 0.0, START, 1.0, method=method, **given)
    while stepper.status == "running":
        stepper.step()
        times = np.linspace(stepper.t_old, stepper.t, 5)[1:]
        assert np.array_equal(stepper.interpolate(times), sol(times))
        dense = stepper.dense_output()
        assert (dense.t_old, dense.t) == (stepper.t_old, stepper.t)
        assert dense(times[0]).shape == (2,)


def test_inside_scipys_and_our_solve_ivp():
    def landed(t, y):
        return y[0]

    given = {"events": landed, "dense_output": True, **TIGHT}
    expected = solve_ivp(pendulum, (0, 2), START, **given)
    mine = type("Mine", (Stepper,), {})
    for solve, cls in ((scipy.integrate.solve_ivp, Stepper), (solve_ivp, mine)):
        found = solve(pendulum, (0, 2), START, cls, **given)
        assert np.array_equal(found.t, expected.t) and np.array_equal(found.y, expected.y)
        assert np.allclose(found.t_events[0], expected.t_events[0], rtol=1e-12, atol=0)
        assert np.array_equal(found.sol(0.7), expected.sol(0.7))


def test_an_end_that_never_comes():
    stepper = Stepper(pendulum, 0.0, START, np.inf)
    for _ in range(1000):
        stepper.step()
    assert stepper.status == "running" and stepper.nstep == 1000


def test_failures():
    stepper = Stepper(lambda t, y: y**2, 0.0, [1.0], 2.0)  # blows up at 1
    message = None
    while stepper.status == "running":
        message = stepper.step()
    assert stepper.status == "failed" and "blows up" in message

    def refuse(t, y):
        if t > 0.5:
            raise KeyError("late")
        return -y

    stepper = Stepper(refuse, 0.0, [1.0], 2.0)
    with pytest.raises(KeyError, match="late"):
        while True:
            stepper.step()


def test_goes_on_in_python_where_compiled_code_gives_up():
    def spun(t, y):
        # the eigenvalues are complex from t = 0.5 on
        values = np.linalg.eigvals(np.array([[1.0, 0.5 - t], [1.0, 1.0]]))
        return [-y[0] * abs(values[0] + values[1])]

    expected = scipy.integrate.solve_ivp(spun, (0, 1), [1.0], max_step=0.05)
    stepper = Stepper(spun, 0.0, [1.0], 1.0, max_step=0.05)
    assert stepper._run.bounds[0].function is not None
    with pytest.warns(fastdyn.CompileWarning):
        t, y = steps_of(stepper)
    assert stepper._run.bounds[0].function is None
    assert np.allclose(t, expected.t, rtol=1e-6, atol=0)
    assert np.allclose(y, expected.y, rtol=1e-6, atol=0)
    assert stepper.nfev == expected.nfev


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"method": scipy.integrate.OdeSolver}, ValueError),
        ({"y0": [1j]}, ValueError),
        ({"t_bound": 0.0}, ValueError),
        ({"method": "RK4"}, ValueError),
        ({"checkpoint": "x"}, TypeError),
        ({"fun": lambda t, y: np.nan * y}, ValueError),
    ],
)
def test_refused(given, error):
    with pytest.raises(error):
        Stepper(**{"fun": lambda t, y: -y, "t0": 0.0, "y0": [1.0], "t_bound": 1.0} | given)


class OfSciPy(scipy.integrate.LSODA):
    """A solver that is not ours."""


OUTPUTS = [{}, {"t_eval": np.linspace(0, 2, 7)}, {"dense_output": True}]


@pytest.mark.parametrize("output", OUTPUTS, ids=["steps", "times", "dense"])
@pytest.mark.parametrize("method", METHODS)
def test_a_callback_sees_each_step(method, output):
    seen, given = [], options_of(method) | output
    plain = solve_ivp(pendulum, (0, 2), START, method, **given)
    called = solve_ivp(
        pendulum, (0, 2), START, method, **given,
        callback=lambda s: seen.append((s.nstep, s.t_old, s.t, *s.y, s.status)),
    )  # fmt: skip
    assert np.array_equal(called.t, plain.t) and np.array_equal(called.y, plain.y)
    assert called.message == plain.message
    expected = Stepper(pendulum, 0.0, START, 2.0, method=method, **options_of(method))
    for row in seen:
        expected.step()
        t_old, status = expected.t_old, expected.status
        assert row == (expected.nstep, t_old, expected.t, *expected.y, status)
    assert expected.status == "finished"


@pytest.mark.parametrize(
    "method", ["RK45", "VelocityVerlet", "Radau", "LSODA", scipy.integrate.RK45, OfSciPy]
)
@pytest.mark.parametrize("how", ["StopIteration", "True"])
def test_a_callback_ends_the_run(method, how):
    def callback(solver):
        if how == "True":
            return np.float64(solver.t) > 1.0
        if solver.t > 1.0:
            raise StopIteration
        return None

    given = CONSTANT if method == "VelocityVerlet" else {}
    whole = solve_ivp(pendulum, (0, 2), START, method, **given)
    run = solve_ivp(pendulum, (0, 2), START, method, callback=callback, **given)
    n = np.searchsorted(whole.t, 1.0, side="right") + 1
    assert run.status == 1 and run.success and "`callback` stopped" in run.message
    assert np.array_equal(run.t, whole.t[:n])


def test_what_a_callback_raises():
    def callback(solver):
        raise ZeroDivisionError(solver.nstep)

    with pytest.raises(ZeroDivisionError, match="1"):
        solve_ivp(pendulum, (0, 2), START, callback=callback)
    with pytest.raises(TypeError, match="callback"):
        solve_ivp(pendulum, (0, 2), START, callback=3)


def ball(t, y, g):
    return [y[1], -g]


def ground(t, y, g):
    return y[0]


def top(t, y, g):
    return y[1]


def bounce(t, y, g):
    return [0.0, -0.9 * y[1]]


def kick(t, y, g):
    return [y[0], y[1] + 0.1]


def lands(t, y, g):
    return y[0]


ground.direction = top.direction = -1
lands.terminal = True
ACTING = {
    "events": {"events": [ground, top], "on_event": [bounce, None]},
    "schedules": {"events": ground, "on_event": [bounce, kick, None], "every": 0.3, "at": [0.31]},
    "schedule at the start": {"events": every(0.5), "on_event": kick},
    "terminal": {"events": lands},
}


@pytest.mark.parametrize("copied", [False, True])
@pytest.mark.parametrize("method", ["RK45", "Radau", "RK4"])
@pytest.mark.parametrize("name", ACTING)
def test_events_and_schedules_act_between_the_steps(name, method, copied):
    """Where solve_ivp has a time twice, the state is the later; copied, the steps are the same."""
    given = {**ACTING[name], "args": (9.81,), **({"step": 0.03} if method == "RK4" else TIGHT)}
    expected = solve_ivp(ball, (0, 2), [1.0, 0.0], method, dense_output=True, **given)
    stepper = Stepper(ball, 0, [1.0, 0.0], 2, method=method, **given)
    t, y = [stepper.t], [stepper.y]
    while stepper.status == "running":
        assert stepper.step() is None
        if copied:
            stepper = copy.deepcopy(stepper)
        t.append(stepper.t)
        y.append(stepper.y.copy())
        if not copied and t[-1] > t[-2]:
            times = np.linspace(t[-2], t[-1], 5)[1:-1]
            assert np.array_equal(stepper.interpolate(times), expected.sol(times))
    last = np.r_[np.diff(expected.t) != 0, True]
    assert np.array_equal(t, expected.t[last])
    assert np.array_equal(np.transpose(y), expected.y[:, last])
    for mine, whole in (
        (stepper.t_events, expected.t_events),
        (stepper.y_events, expected.y_events),
    ):
        assert all(map(np.array_equal, mine, whole))
    assert stepper.n_accepted == expected.n_accepted


def test_discrete_states_and_breakpoints():
    def held(t, y, d):
        return [d[0] - y[0]]

    def sample(t, y, d):
        return y, [float(y[0] < 0.5)]

    given = {"discrete": [1.0], "every": 0.25, "on_event": sample}
    expected, stepper = solve_ivp(held, (0, 3), [0.0], **given), Stepper(held, 0, [0.0], 3, **given)
    t, y = steps_of(stepper)
    last = np.r_[np.diff(expected.t) != 0, True]
    assert np.array_equal(t, expected.t[last]) and np.array_equal(y, expected.y[:, last])
    assert stepper.discrete.shape == stepper.y.shape == (1,) and stepper.n == 1
    assert stepper.discrete == expected.discrete[:, -1]

    def doubled(t, y):
        return [1.0 if t < 1 else 2.0]

    t, y = steps_of(Stepper(doubled, 0, [0.0], 3, breakpoints=[1.0]))
    assert 1.0 in t and np.abs(y[0, t >= 1] - 2 * t[t >= 1] + 1).max() <= 1e-13


def test_outside_values_change_while_events_act():
    """The code is made anew for another whole number; events and their counts go on."""
    power = [1]

    def fun(t, y, g):
        return [y[1], -g * power[0]]

    def fifth(t, y, g):
        return y[0]

    fifth.direction, fifth.terminal = -1, 5
    given = {"events": [fifth, top], "on_event": [bounce, None], "args": (9.81,), **TIGHT}
    stepper = Stepper(fun, 0, [1.0, 0.0], 3, **given)
    while stepper.t < 1:
        stepper.step()
    power[0], fifth.terminal = 2, False
    after = solve_ivp(fun, (stepper.t, 3), stepper.y, **given)
    known = [len(each) for each in stepper.t_events]
    ended(stepper)
    assert known[0] > 0 and len(stepper.t_events[0]) == 5 and stepper.t < 3
    for mine, whole, n in zip(stepper.t_events, after.t_events, known, strict=True):
        found = mine[n:]  # the first step still begins with the slope of before
        assert len(found) > 1 and np.abs(found - whole[: len(found)]).max() <= 1e-3


@pytest.mark.parametrize("end", [0.9, 1.0, 1.05])
@pytest.mark.parametrize("method", ["RK4", "Gauss4"])
def test_the_discrete_states_stay_where_a_constant_step_leads_beyond_the_end(method, end):
    def fun(t, y, d):
        return [d[0] - y[0]]

    given = {
        "step": 0.3, "discrete": [0.5], "every": 0.5, "on_event": lambda t, y, d: (y, [d[0] + 1]),
    }  # fmt: skip
    steps = ended(Stepper(fun, 0.0, [1.0], end, method=method, **given))
    run = solve_ivp(fun, (0.0, end), [1.0], method, **given)
    assert np.array_equal(steps.discrete, run.discrete[:, -1])
    assert np.array_equal(steps.y, run.y[:, -1])


def test_tolerances_belong_to_the_stepper():
    atol, start = np.array([1e-6, 1e-9]), np.array(START)
    one = Stepper(pendulum, 0.0, start, 5.0, atol=atol)
    other = Stepper(pendulum, 0.0, START, 5.0, atol=[1e-6, 1e-9])
    atol[:] = 0.1
    start[:] = 9.0
    one = copy.deepcopy(one)
    for stepper in (one, other):
        stepper.args = (9.0,)  # which checks the tolerances anew
    assert np.array_equal(steps_of(one)[1], steps_of(other)[1])
