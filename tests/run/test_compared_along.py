"""Code is compared along the way of Steppers, of many solves in one call, and of drift studies."""

import math

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.kernels.calls.block import JACOBIAN, RARE
from fastdyn.run.functions import compared
from fastdyn.run.solve_problem import run_of
from support.steppers import ended

WRONG = pytest.warns(fastdyn.CompileWarning, match=r"compiled form gives .*and Python")


def test_a_stepper_goes_on_in_python(wrong_choices):
    def fun(t, y):
        return [-0.1 if y[0] > 0.2 else -0.005]

    stepper = fastdyn.Stepper(fun, 0.0, [1.0], 40.0, max_step=0.5)
    with WRONG:
        while stepper.t < 8.5:  # from y = 0.2 on, at t = 8, the code is wrong
            stepper.step()
    ended(stepper)
    assert stepper.y[0] == pytest.approx(0.2 - 0.005 * 32.0, abs=0.005)


def test_steps_are_compared_in_turn(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})
    for _ in range(2):  # two Steppers of one function count their steps together
        ended(fastdyn.Stepper(lambda t, y: -0.31 * y, 0.0, [1.0], 8.0, max_step=1.0))
        monkeypatch.undo()
    assert 1 < len(seen) < 6 and seen[0] == compared.AT_FIRST


@pytest.mark.parametrize("times", [None, np.linspace(0.0, 3.0, 7)])
def test_many_solves_are_compared_at_their_ends(times, wrong_choices):
    c, rates = (2.5 if times is None else 2.25), np.linspace(1.0, 2.0, 30)
    fun = eval(f"lambda t, y, k: [-k * y[0] if y[0] > 0.2 else -{c} * y[0]]")
    solver = fastdyn.prepare(fun, (0, 3), [1.0], args=(5.0,), t_eval=times, rtol=1e-8, atol=1e-12)
    with WRONG:
        found = solver.many([1.0], (rates,))
    y = found.y[:, 0] if times is None else found.y[:, 0, -1]
    assert np.allclose(y, 0.2 * np.exp(-c * (3.0 - math.log(5.0) / rates)), rtol=1e-5)


def test_a_drift_study_is_repeated_in_python(wrong_choices):
    def fun(t, y):
        return [y[1], -y[0] if y[0] > -0.2 else -0.2 - 2.0 * y[0]]

    def energy(t, y):
        below = y[0] + 0.2
        return y[1] ** 2 + y[0] ** 2 + (below**2 if below < 0.0 else 0.0)

    given = {"t_end": 2.5, "y0": [1.0, 0.0], "invariants": {"E": energy}, "rtol": 1e-9}
    with WRONG:
        study = fastdyn.energy_drift(fun, "RK45", **given)
    assert study.drifts["E"].largest < 1e-3


def test_actions_are_compared_where_they_act(monkeypatch):
    seen = []
    monkeypatch.setattr(
        compared, "compare_along", lambda bound, t, y, _: seen.append((bound.mode, [*t], [*y]))
    )

    def ground(t, y):
        return y[0]

    ground.direction = -1
    found = fastdyn.solve_ivp(
        lambda t, y: [y[1], -9.81], (0, 2), [1.0, 0.0], events=ground,
        on_event=lambda t, y: [0.0, -0.8 * y[1]],
    )  # fmt: skip
    (at,) = [each[1:] for each in seen if each[0].acts_at_events]
    assert np.array_equal(at[0], found.t_events[0])
    assert np.array_equal(at[1], found.y_events[0])


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning", "ignore:overflow:RuntimeWarning")
@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA"])
def test_the_end_of_the_span_is_a_float_where_it_is_one_in_scipy(method):
    """Floats overflow with an exception, NumPy's numbers do not."""

    def fun(t, y):
        return [-(1.9 + min(10.0 ** (200 * t), 1.0)) * y[0]]

    for solve in (scipy.integrate.solve_ivp, fastdyn.solve_ivp):
        with pytest.raises(OverflowError):
            solve(fun, (0.0, 2.0), [1.0], method)


@pytest.mark.parametrize("mass", [None, np.diag([1.0, 1.0, 2.0])])
def test_steps_taken_again_leave_the_matrices_of_their_solve(mass):
    def fun(t, y):  # the output does not show the negative side of a component at 0
        a, b, c = np.maximum(y, 0)
        rates = 0.04 * a, 3e7 * b**2, 1e4 * b * c
        return [rates[2] - rates[0], rates[0] - rates[1] - rates[2], rates[1]]

    options = {} if mass is None else {"mass": mass}
    run = run_of(fastdyn.prepare(fun, (0, 1), [1.0, 0.0, 0.0], "Radau", **options)._problem)
    block, taken = run.bounds[0].block, []
    named, another = block.tolist()[JACOBIAN:RARE], run.another
    run.another = lambda: taken.append(True) or another()
    run.solve(run.problem.y0)
    assert taken and block.tolist()[JACOBIAN:RARE] == named
