"""Arguments of a Stepper that change between steps: inputs of a controller."""

import pickle

import numpy as np
import pytest
from scipy.linalg import expm

from fastdyn import Stepper
from fastdyn.kernels.methods import METHODS
from support.steppers import ended

TIMES = np.linspace(0.0, 3.0, 13)
INPUTS = np.random.default_rng(0).normal(size=12) * 3
STEPS = 16  # of a method of constant steps, in a period
MATRIX = np.array([[0.0, 1.0, 0.0], [-2.0, -0.1, 1.0], [0.0, 0.0, 0.0]])  # with the held input


def oscillator(t, y, u, k):
    return [y[1], -k * y[0] - 0.1 * y[1] + u]


def exact():
    """The state at the end: a matrix exponential for each period."""
    y = np.array([1.0, 0.0])
    for u, length in zip(INPUTS, np.diff(TIMES), strict=True):
        y = (expm(MATRIX * length) @ np.r_[y, u])[:2]
    return y


ADAPTIVE = [name for name, m in METHODS.items() if m.error_order and not m.second_order]


@pytest.mark.parametrize("method", [*ADAPTIVE, "RK4"])
def test_a_held_input_is_followed_exactly(method):
    """No method keeps slopes of the input before: the error is that of the tolerance."""
    rtol = 1e-7
    how = {"rtol": rtol, "atol": rtol, "breakpoints": TIMES[1:-1]}
    if method == "RK4":
        how = {"step": 0.25 / STEPS}
    stepper = Stepper(oscillator, 0.0, [1.0, 0.0], 3.0, method, args=(INPUTS[0], 2.0), **how)
    for i, end in enumerate(TIMES[1:]):
        if i:
            stepper.args = (INPUTS[i], 2.0)
            assert stepper.args == (INPUTS[i], 2.0) and stepper.t == TIMES[i]
        while stepper.t < end - 1e-9:
            stepper.step()
    # errors of the steps add up: a tolerance for each, and RK4's is h^4 / 120 at most
    allowed = rtol * stepper.nstep if method != "RK4" else 3 * (0.25 / STEPS) ** 4
    assert np.abs(stepper.y - exact()).max() < allowed
    assert stepper.status == "finished" and stepper.nfev > stepper.nstep >= 12


def test_steps_are_those_of_a_stepper_that_begins_there():
    stepper = Stepper(oscillator, 0.0, [1.0, 0.0], 3.0, args=(1.0, 2.0))
    stepper.step()
    length = stepper._run.view("solve.state")["h"][0]
    stepper.args = (5.0, 2.0)
    new = Stepper(oscillator, stepper.t, stepper.y, 3.0, args=(5.0, 2.0), first_step=length)
    for _ in range(3):
        stepper.step()
        new.step()
        assert stepper.t == new.t and np.array_equal(stepper.y, new.y)
    assert np.array_equal(stepper.interpolate(stepper.t_old), new.interpolate(new.t_old))


def rises(t, y, d, u):
    return y[0] - 1.5


def held(t, y, d, u):
    return [u * d[0]]


def doubles(t, y, d, u):
    return y, [2 * d[0]]


def test_copies_events_and_discrete_states_go_on():
    how = {"discrete": [2.0], "events": rises, "on_event": doubles, "max_step": 0.2}
    stepper = Stepper(held, 0.0, [1.0], 5.0, args=(1.0,), **how)
    stepper.step()
    stepper.args = (3.0,)
    copy = pickle.loads(pickle.dumps(stepper))
    for each in (stepper, copy):
        while each.t < 1.0:
            each.step()
    assert copy.t == stepper.t and np.array_equal(copy.y, stepper.y) and copy.nfev == stepper.nfev
    assert len(stepper.t_events[0]) == 1 and np.allclose(stepper.y_events[0], 1.5)
    assert stepper.discrete == copy.discrete == 4.0


def test_where_arguments_cannot_be_set():
    stepper = ended(Stepper(oscillator, 0.0, [1.0, 0.0], 1e-3, args=(1.0, 2.0)))
    with pytest.raises(AttributeError, match="has finished"):
        stepper.args = (2.0, 2.0)
    how = {"every": 0.3, "on_event": lambda t, y, u, k: y}
    acts = Stepper(oscillator, 0.0, [1.0, 0.0], 1.0, args=(1.0, 2.0), **how)
    with pytest.raises(AttributeError, match=r"`at` and `every`.*`discrete` states"):
        acts.args = (2.0, 2.0)
    with pytest.raises(AttributeError, match="cannot be set later"):
        acts.method = "RK23"
