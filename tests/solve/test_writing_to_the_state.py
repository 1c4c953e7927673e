"""Functions that write to the state that they are given: what they do under SciPy."""

import gc
import weakref

import numpy as np
import pytest
import scipy.integrate

from fastdyn import prepare, solve_ensemble, solve_ivp


def clipped(t, y):
    y[y < 0] = 0
    return np.array([-1.0 - 0.1 * y[0], 0.3 * y[0] - y[1]])


def bounce(t, y):
    if y[0] < 0:
        y[0] = -y[0]
        y[1] = -0.8 * y[1]
    return [y[1], -9.81]


def normalised(t, q):
    q[:] = q / np.linalg.norm(q)
    return 0.5 * np.array([-q[1] - q[2], q[0] - q[3], q[0] + q[3], q[1] - q[2]])


seen: list = []


def in_python(t, y):
    seen.append(t)
    return bounce(t, y)


STARTS = {clipped: [1.0, 2.0], bounce: [1.0, 0.0], normalised: [1.0, 0, 0, 0.2], in_python: [1, 0]}
BETWEEN = (
    {},
    {"t_eval": np.linspace(0, 3, 9)},
    {"events": lambda t, y: y[0] - 0.5},
    {"dense_output": True},
)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("method", ["RK45", "RK23", "DOP853"])
@pytest.mark.parametrize("fun", STARTS, ids=lambda f: f.__name__)
def test_the_solution_changes_as_under_scipy(fun, method):
    for more in BETWEEN:
        given = (fun, (0, 3), STARTS[fun], method)
        ours = solve_ivp(*given, rtol=1e-6, **more)
        scipys = scipy.integrate.solve_ivp(*given, rtol=1e-6, **more)
        assert ours.nfev == scipys.nfev, more
        np.testing.assert_allclose(ours.y, scipys.y, rtol=1e-9, atol=1e-12)
        if more.get("dense_output"):
            t = np.linspace(0, 3, 40)
            np.testing.assert_allclose(ours.sol(t), scipys.sol(t), rtol=1e-9, atol=1e-12)


def test_the_inlined_kernel_is_not_taken_and_the_start_is_not_written_to():
    y0 = np.array([1.0, 0.0])
    shared, inlined = (
        solve_ivp(bounce, (0, 3), y0, compile=kernel) for kernel in ("shared", "inlined")
    )
    assert np.array_equal(shared.y, inlined.y) and y0.tolist() == [1.0, 0.0]
    many = solve_ensemble(bounce, (0, 3), np.array([y0, y0 + 0.5]))
    assert np.array_equal(many.y[0], shared.y[:, -1]) and many.width == 1


def test_a_prepared_solver_says_that_it_cannot():
    with pytest.raises(ValueError, match="writes to the state"):
        prepare(bounce, (0, 3), [1.0, 0.0], t_eval=[1.0, 2.0])
    assert np.array_equal(
        prepare(bounce, (0, 3), [1.0, 0.0])().y, solve_ivp(bounce, (0, 3), [1.0, 0.0]).y
    )


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning", "ignore:The following arguments")
def test_the_shortest_step_is_refused_where_scipys_lsoda_would_drop_it():
    def writes(t, y):
        y[0] *= 0.5
        return [y[1], -y[0]]

    with pytest.raises(ValueError, match="`min_step` is for compiled methods"):
        solve_ivp(writes, (0, 5), [1.0, 0.0], "LSODA", min_step=0.5)
    for method, shortest in (("LSODA", 0.0), ("RK45", 0.5)):  # that warns, as SciPy does
        assert solve_ivp(writes, (0, 1), [1.0, 0.0], method, min_step=shortest).success


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_what_a_function_that_begins_to_write_was_given_is_freed():
    class Held:
        writes = False

    def fun(t, y, held):
        calls.append(t)
        if held.writes and t > 2.5:  # behind the steps that are taken at once
            y[0] += 1e-9
        return [-y[0]]

    def solved(held):
        return solve_ivp(fun, (0, 3), [1.0], dense_output=True, max_step=1e-3, args=(held,))

    calls = []
    for _ in range(6):
        solved(Held())
    held = Held()
    held.writes = True
    assert solved(held).success
    gone = weakref.ref(held)
    del held
    gc.collect()
    assert gone() is None
