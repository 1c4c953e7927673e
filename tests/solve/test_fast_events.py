"""Event functions much faster than the solution, whose steps contain several of their turns."""

import re
import types
import warnings

import numpy as np
import pytest
from scipy import integrate

from fastdyn import (
    Phase,
    Stepper,
    SwitchingWarning,
    prepare,
    solve_dae,
    solve_dde,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)

OWN = ("Tsit5", "Vern7", "Vern9", "Rodas5P", "Taylor", "auto")
SCIPYS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "ode45")
END = 20.0
W = 50.0


def turning(t, y, *args):
    return [y[1], -y[0]]


def same(t, y, *args):
    return y


def _by_time(t, y):
    return np.sin(W * t) - 0.9


FAST = {
    "sine": _by_time,
    "sine with the state": lambda t, y: y[0] - 1.2 * np.sin(W * t),
    "product": lambda t, y: y[0] * np.sin(W * t) * np.cos(7 * t) - 0.3,
    "nested": lambda t, y: np.sin(3 * np.sin(W * t)) - 0.4,
    "state": lambda t, y: np.sin(30 * y[0] + 1.0) - 0.5,
    "chirp": lambda t, y: np.sin(3 * t * t) - 0.6,
    "peak": lambda t, y: np.exp(-(((t - 7.3) / 0.002) ** 2)) - 0.5,
    "peak of the state": lambda t, y: np.exp(-(((y[0] - 0.4) / 0.002) ** 2)) - 0.5,
    "Laplace": lambda t, y: np.exp(-abs(y[1] - 0.3) / 0.001) - 0.5,
    "Lorentz": lambda t, y: 1 / (1 + ((t - 7.3) / 0.002) ** 2) - 0.5,
    "step": lambda t, y: np.tanh((t - 7.3) / 0.001) - 0.4 * np.cos(9 * t),
    "power": lambda t, y: (1.5 + 0.5 * np.sin(5 * t)) ** 40 - 2.0**39,
    "cusp": lambda t, y: np.sqrt(abs(y[0] - 0.4)) - 0.03,
    "cusp of a power": lambda t, y: abs(y[1] - 0.3) ** 0.3 - 0.1,
    "logarithm": lambda t, y: np.log(1e-6 + (y[0] - 0.4) ** 2) + 12.0,
    "rounding": lambda t, y: np.floor(20 * y[0]) % 2 - 0.5,
}


def fresh(g):
    """The function under another name, of which no warning has been given."""
    code = g.__code__.replace(co_name=f"fast_{id(object())}")
    return types.FunctionType(code, g.__globals__, closure=g.__closure__)


def expected(g):
    """The number of changes of sign along the solution, to a grid of 2e-5."""
    t = np.linspace(0.0, END, 1_000_001)
    sign = np.sign(g(t, np.array([np.cos(t), -np.sin(t)])))
    return int((sign[1:] != sign[:-1]).sum())


@pytest.mark.few(8)
@pytest.mark.parametrize("name", FAST)
@pytest.mark.parametrize("method", OWN)
def test_own_methods_count_each_occurrence(method, name):
    if method == "Taylor" and name in ("Laplace", "rounding", "cusp", "cusp of a power"):
        pytest.skip("Taylor refuses absolute values and roundings")
    found = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=FAST[name],
                      rtol=1e-8, atol=1e-8)  # fmt: skip
    assert len(found.t_events[0]) == expected(FAST[name])


@pytest.mark.few(8)
@pytest.mark.parametrize(
    "name", sorted(FAST.keys() - {"rounding"})
)  # an action leaves it on its side
@pytest.mark.parametrize("method", SCIPYS)
def test_what_acts_counts_by_each_method(method, name):
    found = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=FAST[name], on_event=same,
                      rtol=1e-8, atol=1e-8)  # fmt: skip
    assert len(found.t_events[0]) == expected(FAST[name])


@pytest.mark.few(8)
@pytest.mark.parametrize("name", FAST)
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "ode45"])
def test_methods_of_scipy_tell_of_lost_occurrences(method, name):
    g = fresh(FAST[name])
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=g, rtol=1e-6, atol=1e-6)
    lost = len(found.t_events[0]) < expected(g)
    told = [each for each in told if issubclass(each.category, SwitchingWarning)]
    assert not lost or len(told) == 1


def test_the_step_that_a_warning_proposes_suffices():
    g = fresh(FAST["peak"])
    with pytest.warns(SwitchingWarning, match="peak|fast_") as told:
        solve_ivp(turning, (0, END), [1.0, 0.0], "DOP853", events=g)
    step = float(re.findall(r"max_step=([\d.e-]+)", str(told[0].message))[0])
    found = solve_ivp(turning, (7.0, 7.5), [1.0, 0.0], "DOP853", events=g, max_step=step)
    assert len(found.t_events[0]) == 2


def test_more_occurrences_than_a_step_has_room_for_are_told():
    def humming(t, y):
        return np.sin(5000.0 * t)

    with pytest.warns(SwitchingWarning, match="changes too fast for the steps of Tsit5"):
        solve_ivp(lambda t, y: [-1e-6 * y[0]], (0, 10), [1.0], "Tsit5", events=humming)
    humming.terminal = 5000
    acts = solve_ivp(
        lambda t, y: [-1e-6 * y[0]], (0, 10), [1.0], "Tsit5", events=humming, on_event=same
    )
    assert acts.status == 1 and acts.t[-1] == pytest.approx(np.pi, rel=1e-12)  # t = 0 does not act


@pytest.mark.parametrize("method", ["RK45", "Vern9"])
def test_all_ways_of_a_solve_count_the_same(method):
    n = expected(_by_time)
    given = {"events": _by_time, "on_event": same, "rtol": 1e-6, "atol": 1e-8}
    for _ in range(3):
        assert len(solve_ivp(turning, (0, END), [1.0, 0.0], method, **given).t_events[0]) == n
    ready = prepare(turning, (0, END), [1.0, 0.0], method, **given)
    assert [len(ready().t_events[0]) for _ in range(3)] == [n, n, n]
    stepper = Stepper(turning, 0.0, [1.0, 0.0], END, method=method, **given)
    while stepper.status == "running":
        stepper.step()
    assert len(stepper.t_events[0]) == n


@pytest.mark.parametrize("method", ["RK45", "Vern9", "Rodas5P"])
def test_lanes_count_as_each_trajectory_does(method):
    def by_argument(t, y, w):
        return y[0] - 1.2 * np.sin(w * t)

    w = np.linspace(3.0, 90.0, 9)
    given = {"events": by_argument, "on_event": same, "rtol": 1e-6, "atol": 1e-8}
    lanes, alone = (
        solve_ensemble(turning, (0, END), [1.0, 0.0], (w,), method, simd=simd, **given)
        for simd in (True, False)
    )
    assert lanes.width > 1
    for i, each in enumerate(w):
        one = solve_ivp(turning, (0, END), [1.0, 0.0], method, args=(each,), **given)
        assert len(lanes.t_events[0][i]) == len(alone.t_events[0][i]) == len(one.t_events[0])


def test_phases_residuals_and_delays_count_each_occurrence():
    n = expected(_by_time)
    until = fresh(_by_time)
    until.terminal = True
    one = Phase(turning, until, lambda t, y: ("free", y))
    phases = solve_phases({"free": one}, "free", (0, END), [1.0, 0.0], "DOP853")
    assert len(phases.phases) == n + 1
    residual = solve_dae(
        lambda t, y, yp: [yp[0] + 0.1 * y[0]], (0, END), [1.0], events=_by_time, rtol=1e-6
    )
    assert len(residual.t_events[0]) == n
    delayed = solve_dde(
        lambda t, y, past: [-0.1 * past(t - 1.0)[0]],
        (0, END),
        [1.0],
        events=lambda t, y, past: np.sin(W * t) - 0.9,
    )
    assert len(delayed.t_events[0]) == n


@pytest.mark.parametrize("method", ["RK45", "Tsit5"])
def test_a_function_in_python_is_looked_at_by_its_values(method):
    def in_python(t, y):
        return float(str(np.sin(W * t) - 0.9))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = solve_ivp(turning, (0, END), [1.0, 0.0], method, events=in_python, on_event=same)
    assert len(found.t_events[0]) == expected(_by_time)


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853"])
def test_methods_of_scipy_keep_scipys_occurrences_before_they_tell(method):
    """The first call looks inside the steps, and the second does not."""
    for phase in np.linspace(0.1, 3.0, 6):

        def g(t, y, phase=phase):
            return np.sin(W * t + phase)

        g.__code__ = g.__code__.replace(co_name=f"sine_{method}_{phase:.1f}")
        given = turning, (0, END), [1.0, 0.0], method
        expected = integrate.solve_ivp(*given, events=g).t_events[0]
        with pytest.warns(SwitchingWarning, match="crosses zero"):
            first = solve_ivp(*given, events=g).t_events[0]
        again = solve_ivp(*given, events=g).t_events[0]
        assert np.array_equal(first, again) and first == pytest.approx(expected, rel=1e-9)
