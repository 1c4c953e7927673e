"""Solvers that are copied, pickled, and sent to another process."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
import scipy.integrate

from fastdyn import Stepper, prepare, solve_ivp

METHODS = ("RK45", "Vern9", "Taylor", "Radau", "BDF", "LSODA", "Rodas5P", "VelocityVerlet")


def pendulum(t, y, k=9.81):
    return [y[1], -k * np.sin(y[0])]


def chain(t, y):
    return -2.0 * y + np.append(y[1:], 0.0) + np.append(0.0, y[:-1])


def at_bottom(t, y, k=9.81):
    return y[0]


def rest_of(stepper):
    found = []
    while stepper.status == "running":
        stepper.step()
        found.append((stepper.t, *stepper.y, stepper.nfev, stepper.n_accepted, stepper.njev))
    return found


def elsewhere(function, *args):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, args)


def begun(method, n_steps, fun=pendulum, y0=(0.5, 0.0)):
    options = {"step": 0.03} if method == "VelocityVerlet" else {"rtol": 1e-7}
    stepper = Stepper(fun, 0.0, np.array(y0), 5.0, method=method, **options)
    for _ in range(n_steps):
        stepper.step()
    return stepper


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n_steps", [0, 1, 6])
def test_a_copy_of_a_stepper_goes_on_to_the_bit(method, n_steps):
    stepper = begun(method, n_steps)
    copies = pickle.loads(pickle.dumps(stepper)), copy.deepcopy(stepper), copy.copy(stepper)
    for each in copies:
        assert (each.t, each.t_old, each.step_size, each.n) == (
            stepper.t, stepper.t_old, stepper.step_size, stepper.n,
        )  # fmt: skip
        if n_steps:
            middle = (stepper.t + stepper.t_old) / 2
            assert np.array_equal(each.dense_output()(middle), stepper.dense_output()(middle))
        else:
            assert each.y is not stepper.y
    rest = rest_of(stepper)
    assert rest and all(rest_of(each) == rest for each in copies)


@pytest.mark.parametrize("method", ["Radau", "BDF"])
def test_sparse_matrices_are_made_again(method):
    stepper = begun(method, 5, chain, np.linspace(0.0, 1.0, 300))
    twin = pickle.loads(pickle.dumps(stepper))
    assert rest_of(stepper) == rest_of(twin)


def test_a_stepper_in_another_process():
    stepper = begun("Radau", 6)
    assert elsewhere(rest_of, stepper) == rest_of(stepper)


def test_a_prepared_solver():
    shot = prepare(pendulum, (0, 2), [0.5, 0.0], events=at_bottom, args=(4.0,), rtol=1e-8)
    expected = shot([0.3, 0.1], (5.0,))
    for twin in (pickle.loads(pickle.dumps(shot)), copy.deepcopy(shot)):
        found = twin([0.3, 0.1], (5.0,))
        assert np.array_equal(found.y, expected.y)
        assert np.array_equal(found.t_events[0], expected.t_events[0])
    assert np.array_equal(elsewhere(shot, [0.3, 0.1], (5.0,)).y, expected.y)


def test_functions_without_a_name_are_refused_as_pickle_does():
    local = lambda t, y: -y  # noqa: E731
    for made in (prepare(local, (0, 1), [1.0]), Stepper(local, 0, [1.0], 1)):
        with pytest.raises(
            (AttributeError, pickle.PicklingError), match=r"[Cc]an't (.*pickle|get local) .*lambda"
        ):
            pickle.dumps(made)
        assert copy.deepcopy(made) is not made


def test_what_a_callback_is_given_stays():
    seen = []

    def look(solver):
        with pytest.raises(TypeError, match="a Stepper can"):
            pickle.dumps(solver)
        seen.append(solver.t)

    solve_ivp(pendulum, (0, 1), [0.5, 0.0], callback=look)
    assert seen


@pytest.mark.parametrize("method", ["Radau", scipy.integrate.DOP853])
def test_the_method_in_the_fifth_place(method):
    mine = Stepper(pendulum, 0, [0.5, 0.0], 5, method)
    same = Stepper(pendulum, 0, [0.5, 0.0], 5, method=method)
    assert rest_of(mine) == rest_of(same)
    with pytest.raises(TypeError, match="given twice"):
        Stepper(pendulum, 0, [0.5, 0.0], 5, method, method="BDF")
    with pytest.raises(TypeError, match=r"max_step=0\.1"):
        Stepper(pendulum, 0, [0.5, 0.0], 5, np.inf)
