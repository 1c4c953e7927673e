"""A Stepper takes the steps of solve_ivp, in SciPy's shape; a callback sees each of them."""

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import Stepper, solve_ivp

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
