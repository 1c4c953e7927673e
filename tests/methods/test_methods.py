"""Every method: its order at the end and between steps, and its evaluations."""

import numpy as np
import pytest

import fastdyn
from fastdyn.kernels.methods import METHODS
from support.motions import forced

BY_VALUES = [name for name, m in METHODS.items() if not m.series]
OF_ONE_ORDER = [name for name in BY_VALUES if name not in ("BDF", "LSODA")]
FIXED = [name for name, m in METHODS.items() if not m.error_order]


def exact(t):
    return np.array([np.cos(t), -np.sin(t)])


def at_fixed_step(method, h, t_end):
    """The forced oscillator at steps h, a power of 2, so that the times are exact."""
    if method in FIXED:
        options = {"step": h}
    else:
        options = {"first_step": h, "max_step": h, "rtol": 1e6, "atol": 1e6}
    r = fastdyn.solve_ivp(forced, (0, t_end), [1.0, 0.0], method, dense_output=True, **options)
    assert np.array_equal(r.t, np.arange(0, t_end + h, h))
    return r


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def short_steps(method):
    """Steps at which truncation is well above rounding and the next order well below."""
    powers = {6: (2, 5), 7: (1, 4), 8: (1, 4), 9: (0, 3), 10: (0, 3), 16: (0, 2)}
    return 2.0 ** -np.arange(*powers.get(METHODS[method].order, (4, 8)), dtype=float)


# Rounding covers the first term of its error before the next ones are small beside it.
FASTER = {"Vern9", "Yoshida8"}


@pytest.mark.parametrize("method", OF_ONE_ORDER)
def test_measured_order(method):
    steps = np.array([4.0, 2.0]) if method.endswith("16") else short_steps(method)
    runs = [at_fixed_step(method, h, 4.0) for h in steps]
    ends = [np.linalg.norm(r.y[:, -1] - exact(4.0)) for r in runs]
    near = 0.5 if METHODS[method].order < 8 or method in FASTER else 1.0
    above = 1.5 if method in FASTER else near
    assert -near < slope(steps, ends) - METHODS[method].order < above
    t = np.linspace(0, 4, 1001)
    between = [np.abs(r.sol(t) - exact(t)).max() for r in runs]
    order = min(METHODS[method].order, METHODS[method].dense_order + 1)
    if not method.endswith("16"):
        assert -near < slope(steps, between) - order < above


@pytest.mark.parametrize("method", OF_ONE_ORDER)
def test_measured_order_of_dense_output_in_one_step(method):
    """From an exact start, a polynomial of order p errs as h^(p + 1) inside the step."""
    steps = short_steps(method)
    errors = []
    for h in steps:
        t = np.linspace(0, h, 101)
        errors.append(np.abs(at_fixed_step(method, h, h).sol(t) - exact(t)).max())
    above = round(slope(steps, errors)) - METHODS[method].dense_order - 1
    assert above == 0 or (method in FASTER and 0 < above <= 2)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("dense_output", [False, True])
@pytest.mark.parametrize("method", BY_VALUES)
def test_evaluations_are_counted(method, dense_output):
    times = []

    def counted(t, y):
        times.append(t)
        return [y[1], -y[0]]

    options = {"step": 0.1} if method in FIXED else {}
    if METHODS[method].n_matrices:
        options["jac"] = [[0, 1], [-1, 0]]  # those for differences are not counted
    r = fastdyn.solve_ivp(counted, (0, 1), [1.0, 0.0], method, dense_output=dense_output, **options)
    assert len(times) == r.nfev


def test_a_last_step_beyond_the_end_is_interpolated():
    r = fastdyn.solve_ivp(forced, (0, 1), [1.0, 0.0], "RK4", step=0.03)
    assert r.t[-1] == 1.0 and r.n_accepted == 34 and abs(r.t[-2] - 0.99) < 1e-12
    assert np.abs(r.y[:, -1] - exact(1.0)).max() < 1e-7
