"""`nonnegative`: components that must not be negative."""

import math
import warnings

import numpy as np
import pytest

from fastdyn import Stepper, prepare, solve_ensemble, solve_ivp
from fastdyn.matlab import ode15s, ode45, odeset

EXPLICIT = ("RK23", "RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "ode45", "ode23")
IMPLICIT = ("Radau", "BDF", "LSODA", "Rodas5P")


def tank(t, y):
    return [-math.sqrt(y[0])]  # empty from t = 2 on


@pytest.mark.parametrize("method", EXPLICIT + IMPLICIT)
def test_an_empty_tank_rests(method):
    found = solve_ivp(
        tank, (0, 50), [1.0], method, nonnegative=True, dense_output=True, max_step=5.0
    )
    times = np.linspace(0, 50, 2001)
    exact = np.where(times < 2, (1 - times / 2) ** 2, 0.0)
    assert found.status == 0
    assert found.y.min() >= 0.0 and found.sol(times).min() >= 0.0
    assert np.abs(found.sol(times)[0] - exact).max() < 5e-3
    assert found.y[0, -1] == 0.0 if method != "Radau" else found.y[0, -1] < 1e-9
    assert found.nfev < 700
    at = solve_ivp(tank, (0, 50), [1.0], method, nonnegative=True, t_eval=times)
    assert at.y.min() >= 0.0


def robertson(t, y):
    first, second = -0.04 * y[0] + 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [first, -first - second, second]


@pytest.mark.parametrize(
    "rtol, atol",
    [(1e-2, 1e-4), (1e-4, 1e-6), (1e-3, 1e-5), (1e-2, 1e-3), (1e-1, 1e-3), (1e-5, 1e-5)],
)
def test_lsoda_begins_anew_with_steps_short_enough(rtol, atol):
    given = {"method": "LSODA", "rtol": rtol, "atol": atol, "nonnegative": True}
    found = solve_ivp(robertson, (0, 4e10), [1.0, 0, 0], **given)
    assert found.status == 0 and found.y.min() >= 0.0
    assert found.y[:, -1] == pytest.approx([0, 0, 1], abs=1e-3)


@pytest.mark.parametrize("method", ("Radau", "BDF", "Rodas5P"))
def test_robertson_at_loose_tolerances(method):
    """Without the option, a small negative y_2 grows beyond all bounds (SciPy: -1e6)."""
    found = solve_ivp(
        robertson, (0, 1e11), [1.0, 0, 0], method, rtol=1e-2, atol=1e-3, nonnegative=True
    )
    assert found.status == 0 and found.y.min() >= 0.0
    assert found.y[:, -1] == pytest.approx([0, 0, 1], abs=0.04)


@pytest.mark.filterwarnings("ignore::fastdyn.StiffnessWarning")
def test_what_is_added_is_said_if_much():
    """An explicit method, its steps limited by stability, throws y_2 about zero at a large atol."""
    with pytest.warns(UserWarning, match="times their `atol` was added"):
        found = solve_ivp(robertson, (0, 4), [1.0, 0, 0], rtol=1e-2, atol=1e-3, nonnegative=True)
    assert found.y.min() >= 0.0


@pytest.mark.parametrize("method", IMPLICIT)
def test_the_knee(method):
    """Dahlquist's knee: y = 1 - x up to 1, then 0; without the option, -x + 1 is followed on."""

    def knee(x, y):
        return ((1 - x) * y - y * y) / 1e-6

    assert solve_ivp(knee, (0, 2), [1.0], "BDF").y[0, -1] < -0.99
    found = solve_ivp(knee, (0, 2), [1.0], method, nonnegative=[0], dense_output=True)
    assert found.y.min() >= 0.0 and found.y[0, -1] < 1e-6
    assert found.sol(0.5)[0] == pytest.approx(0.5, abs=1e-3)
    assert found.sol(1.5)[0] < 1e-6


@pytest.mark.parametrize("method", EXPLICIT + IMPLICIT)
def test_the_example_of_matlab(method):
    """y' = -|y|, whose solution exp(-t) is lost below zero: MATLAB's example of NonNegative."""

    def fall(t, y):
        return -np.abs(y)

    found = solve_ivp(fall, (0, 40), [1.0], method, nonnegative=True)
    assert found.y.min() >= 0.0 and found.y[0, -1] < 1e-2 and found.status == 0


def test_matlabs_option():
    solution = ode45(lambda t, y: -abs(y), [0, 40], [1.0], odeset("NonNegative", [0]))
    assert solution.y.min() >= 0.0
    solution = ode15s(robertson, [0, 1e11], [1, 0, 0], odeset("NonNegative", True, "RelTol", 1e-2))
    assert solution.y.min() >= 0.0


def test_only_what_is_listed():
    def fun(t, y):
        return [-1.0, -1.0, -1.0]

    for listed in ([1], np.array([1]), 1, [False, True, False], np.array([False, True, False])):
        found = solve_ivp(fun, (0, 3), [1.0, 1.0, 1.0], nonnegative=listed)
        assert found.y[:, -1] == pytest.approx([-2, 0, -2], abs=1e-6)
        assert found.y[1].min() >= 0.0
    for off in (False, None, [], [False] * 3):
        found = solve_ivp(fun, (0, 3), [1.0, 1.0, 1.0], nonnegative=off)
        assert found.y[1, -1] == pytest.approx(-2.0)


def test_backwards_in_time():
    found = solve_ivp(lambda t, y: [math.sqrt(y[0])], (2, 0), [0.49], nonnegative=True)
    assert found.status == 0 and found.y[0, -1] == 0.0


class InPython:
    """A function that is called in Python only, and fails for negative states."""

    calls = 0

    def __call__(self, t, y):
        self.calls += 1
        return [-math.sqrt(y[0]), 1.0]


@pytest.mark.parametrize("method", ("RK45", "BDF", "Radau", "Rodas5P", "LSODA"))
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_functions_in_python(method):
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = solve_ivp(InPython(), (0, 5), [1.0, 0.0], method, nonnegative=[0])
    assert found.status == 0 and found.y[0].min() >= 0.0 and found.y[0, -1] < 1e-6


@pytest.mark.parametrize("method", ("RK45", "ode45", "Rodas5P", "BDF"))
def test_ensembles_prepared_solves_and_steppers(method):
    def drain(t, y, k):
        return [-k * math.sqrt(y[0])]

    k = np.linspace(0.1, 3.0, 11)
    for simd in ("auto", False):
        many = solve_ensemble(drain, (0, 4), [1.0], args=(k,), method=method, nonnegative=True,
                              t_eval=np.linspace(0, 4, 9), simd=simd)  # fmt: skip
        assert many.success.all() and many.y.min() >= 0.0
        assert many.y_end[:, 0] == pytest.approx(np.maximum(1 - 2 * k, 0) ** 2, abs=5e-3)
    solver = prepare(drain, (0, 4), [1.0], method=method, args=(1.0,), nonnegative=True)
    alone = solve_ivp(drain, (0, 4), [1.0], method, args=(1.0,), nonnegative=True)
    assert np.array_equal(solver().y, alone.y)
    assert solver.many(args=(k,)).y.min() >= 0.0
    stepper = Stepper(drain, 0.0, [1.0], 4.0, method=method, args=(1.0,), nonnegative=True)
    taken = 0
    while stepper.status == "running":
        before = stepper.t
        stepper.step()
        taken += 1
        assert stepper.t > before and stepper.y[0] >= 0.0
        assert stepper.interpolate(0.5 * (before + stepper.t))[0] >= 0.0
    assert taken == alone.n_accepted and stepper.y == alone.y[:, -1]


def test_events_and_their_actions():
    def low(t, y):
        return math.sqrt(y[0]) - 0.1

    found = solve_ivp(
        tank, (0, 10), [1.0], events=low, on_event=lambda t, y: [1.0], nonnegative=True, rtol=1e-6
    )
    assert found.t_events[0] == pytest.approx(1.8 * np.arange(1, 6), abs=1e-3)
    assert found.y.min() >= 0.0


def test_a_negative_state_ends_with_a_sentence():
    def low(t, y):
        return y[0] - 0.1

    found = solve_ivp(tank, (0, 10), [1.0], events=low, on_event=lambda t, y: [-1.0],
                      nonnegative=True)  # fmt: skip
    assert found.status == -1 and found.y.min() >= 0.0
    assert "`on_event` of event 0, `low`, returned a negative number" in found.message
    solver = prepare(tank, (0, 1), [1.0], nonnegative=True)
    with pytest.raises(ValueError, match="`nonnegative` lists component 0"):
        solver([-1.0])
    many = solve_ensemble(tank, (0, 1), [[1.0], [-1.0]], nonnegative=True)
    assert many.status.tolist() == [0, -1]


def test_with_a_domain():
    """A logarithm of the one, a root of the other component."""

    def fun(t, y):
        return [-math.sqrt(y[0]), -0.5 + 0.0 * math.log(y[1])]

    for method in ("RK45", "Rodas5P", "BDF"):
        found = solve_ivp(
            fun, (0, 5), [0.25, 1.5], method, nonnegative=[0], domain=lambda t, y: y[1]
        )
        assert found.status == -3 and found.t[-1] == pytest.approx(3.0, abs=1e-9)
        assert found.y.min() >= 0.0 and found.y[0, -1] == 0.0


def test_with_a_jacobian():
    from scipy.sparse import csc_matrix

    def fun(t, y):
        return [-100 * y[0] + y[1], -1.0]

    full = np.array([[-100.0, 1.0], [0.0, 0.0]])
    for jac in (full, lambda t, y: full, csc_matrix(full), lambda t, y: csc_matrix(full)):
        for method in ("Radau", "BDF", "Rodas5P"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = solve_ivp(fun, (0, 3), [1.0, 1.0], method, jac=jac, nonnegative=True)
            assert found.status == 0 and found.y.min() >= 0.0
            assert found.y[:, -1] == pytest.approx([0, 0], abs=1e-5)


@pytest.mark.parametrize(
    ("options", "said"),
    (
        ({"nonnegative": [2]}, "from 0 to 1"),
        ({"nonnegative": [-1]}, "from 0 to 1"),
        ({"nonnegative": [0, 0]}, "each component once"),
        ({"nonnegative": [0.0]}, "indices of components, or 2 bools"),
        ({"nonnegative": "all"}, "indices of components, or 2 bools"),
        ({"nonnegative": [True]}, "indices of components, or 2 bools"),
        ({"nonnegative": True, "y0": [1.0, -1.0]}, "lists component 1, which `y0` begins at -1"),
        ({"nonnegative": True, "method": "Taylor"}, "Taylor does not take `nonnegative`"),
        ({"nonnegative": True, "method": "RK4", "step": 0.1}, "RK4 does not take `nonnegative`"),
        ({"nonnegative": True, "sensitivity": "y0"}, "`sensitivity` and `nonnegative`"),
        ({"nonnegative": True, "project": lambda t, y: y}, "`nonnegative` and `project`"),
        ({"nonnegative": True, "atol": 0.0}, "positive `atol`"),
        ({"nonnegative": True, "method": "Rodas5P", "mass": np.eye(2)}, "`nonnegative` and `mass`"),
        ({"nonnegative": True, "y0": [1j, 1.0]}, "`nonnegative`: for real states only"),
    ),
)
def test_refused(options, said):
    given = {"y0": [1.0, 1.0], **options}
    with pytest.raises((ValueError, TypeError), match=said):
        solve_ivp(lambda t, y: -y, (0, 1), **given)
