"""Derivatives of solutions: beside exact ones, and differences of tight solves."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from fastdyn import solve_ivp
from fastdyn.compile.derivatives import sensitivities
from fastdyn.compile.derivatives.jacobian import jacobian
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near
from fastdyn.problem.sensitivities import Variational, with_sensitivities
from fastdyn.systems import SYSTEMS

TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
LOCAL_TO_GLOBAL = 300.0  # steps of a run, whose errors add up


def oscillator(t, y, k, c):
    return [y[1], -k * y[0] - c * y[1]]


def exact(t, k, c):
    """exp(A t) of the oscillator, underdamped."""
    a = np.array([[0.0, 1.0], [-k, -c]])
    w = math.sqrt(k - c * c / 4)
    within = np.cos(w * t) * np.eye(2)[..., None]
    return np.exp(-c * t / 2) * (within + (np.sin(w * t) / w) * (a + c / 2 * np.eye(2))[..., None])


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Vern9", "Tsit5", "ode45", "RK23"])
def test_the_exact_ones_of_an_oscillator(method):
    k, c, y0, tol = 4.0, 0.3, np.array([1.0, 0.5]), 1e-7
    r = solve_ivp(
        oscillator, (0, 10), y0, method, args=(k, c), rtol=tol, atol=tol, sensitivity=("y0", "args")
    )
    h = 1e-5  # the exact solution is known to 1e-16: differences are off by h^2 and 1e-16 / h
    by_k = (exact(r.t, k + h, c) - exact(r.t, k - h, c)) / (2 * h)
    by_c = (exact(r.t, k, c + h) - exact(r.t, k, c - h)) / (2 * h)
    bound = LOCAL_TO_GLOBAL * tol
    assert list(r.sensitivity) == ["y0", "k", "c"]
    assert np.abs(r.sensitivity["y0"] - exact(r.t, k, c)).max() < bound
    assert np.abs(r.sensitivity["k"] - np.einsum("ijt,j->it", by_k, y0)).max() < bound
    assert np.abs(r.sensitivity["c"] - np.einsum("ijt,j->it", by_c, y0)).max() < bound


def satellite(t, w, mu):
    x, y, vx, vy = w
    r3 = (x * x + y * y) ** 1.5
    return [vx, vy, -mu * x / r3, -mu * y / r3]


def test_the_flow_of_a_satellite_is_symplectic():
    r = solve_ivp(satellite, (0, 30), [1, 0, 0, 1.2], args=(1.0,), sensitivity="y0", **TIGHT)
    unit = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
    for flow in np.moveaxis(r.sensitivity["y0"], -1, 0)[::10]:
        size = np.linalg.norm(flow, 2) ** 2
        assert np.abs(flow.T @ unit @ flow - unit).max() < LOCAL_TO_GLOBAL * 1e-12 * size
        assert abs(np.linalg.det(flow) - 1) < LOCAL_TO_GLOBAL * 1e-12 * size


def differences(solve, values, h=1e-5):
    """d solve(values) / d values, one component at a time: off by h^2 and 1e-12 / h."""
    values, columns = np.asarray(values, float), []
    for i in range(values.size):
        step = np.zeros(values.size)
        step[i] = h * max(1.0, abs(values.flat[i]))
        step = step.reshape(values.shape)
        columns.append((solve(values + step) - solve(values - step)) / (2 * step.flat[i]))
    return np.stack(columns, 1)


def chain(t, y, k, anchor):
    q, v = y[: len(k)], y[len(k) :]
    stretch = np.diff(np.concatenate([[anchor], q]))
    force = -k * stretch - 0.1 * np.sin(stretch)
    force = force - np.concatenate([force[1:], [0.0]])
    return np.concatenate([v, force])


def test_arrays_and_a_large_state():
    """Twelve masses: loops over like nodes; arguments that are arrays, start and number."""
    m = 12
    k, y0 = np.linspace(1, 2, m), np.concatenate([np.linspace(0, 1, m), np.zeros(m)])
    at = {"t_eval": [1.0, 2.0], **TIGHT}
    r = solve_ivp(chain, (0, 2), y0, args=(k, 0.3), sensitivity=("k", "y0", "args[1]"), **at)
    assert r.sensitivity["k"].shape == (2 * m, m, 2)
    assert r.sensitivity["y0"].shape == (2 * m, 2 * m, 2)
    assert r.sensitivity["anchor"].shape == (2 * m, 2)
    tolerance = {"rtol": 1e-6, "atol": 1e-6}
    by_k = differences(lambda k: solve_ivp(chain, (0, 2), y0, args=(k, 0.3), **at).y, k)
    assert np.allclose(r.sensitivity["k"], by_k, **tolerance)
    by_y0 = differences(lambda y: solve_ivp(chain, (0, 2), y, args=(k, 0.3), **at).y, y0)
    assert np.allclose(r.sensitivity["y0"], by_y0, **tolerance)
    by_a = differences(lambda a: solve_ivp(chain, (0, 2), y0, args=(k, a[0]), **at).y, [0.3])
    assert np.allclose(r.sensitivity["anchor"], by_a[:, 0], **tolerance)


def test_systems_of_the_course_by_their_parameters():
    r = SYSTEMS["pendulum"]().solve((0, 5), sensitivity="g", **TIGHT)
    at = {"t_eval": r.t, **TIGHT}
    by_g = differences(lambda g: SYSTEMS["pendulum"](g=g[0]).solve((0, 5), **at).y, [9.81])
    assert np.allclose(r.sensitivity["g"], by_g[:, 0], rtol=1e-6, atol=1e-6)


def test_the_solution_is_no_less_exact_than_without():
    for tol in (1e-4, 1e-7):
        given = {"method": "DOP853", "rtol": tol, "atol": tol, "t_eval": [20.0]}
        args = (satellite, (0, 20), [1, 0, 0, 1.1])
        fine = solve_ivp(*args, args=(1.0,), t_eval=[20.0], **TIGHT).y
        plain = solve_ivp(*args, args=(1.0,), **given)
        both = solve_ivp(*args, args=(1.0,), sensitivity="args", **given)
        assert np.abs(both.y - fine).max() <= 2 * np.abs(plain.y - fine).max()


def test_events_and_dense_output_are_of_the_state():
    def bottom(t, y, k, c):
        x, _ = y
        return x

    def stops(t, y, k, c):
        return y[-1] + 0.5

    stops.terminal, stops.direction = True, 1
    given = {"args": (4.0, 0.3), "rtol": 1e-9, "atol": 1e-9, "events": [bottom, stops]}
    plain = solve_ivp(oscillator, (0, 10), [1, 0.5], **given)
    r = solve_ivp(oscillator, (0, 10), [1, 0.5], dense_output=True, sensitivity="k", **given)
    assert r.status == 1 and r.sol(1.0).shape == (2,)
    for a, b in zip(r.t_events + r.y_events, plain.t_events + plain.y_events, strict=True):
        assert a.shape == b.shape and np.allclose(a, b, rtol=1e-7, atol=1e-7)
    assert np.allclose(r.sol(r.t), r.y, atol=1e-14)
    assert r.sensitivity["k"].shape == (2, len(r.t))


def test_backwards_with_breakpoints_in_fixed_steps():
    forward = solve_ivp(satellite, (0, 3), [1, 0, 0, 1.1], args=(1.0,), sensitivity="y0", **TIGHT)
    back = solve_ivp(
        satellite, (3, 0), forward.y[:, -1], args=(1.0,), sensitivity="y0", breakpoints=[1.0],
        **TIGHT,
    )  # fmt: skip
    product = back.sensitivity["y0"][..., -1] @ forward.sensitivity["y0"][..., -1]
    assert np.abs(product - np.eye(4)).max() < 1e-9
    for method in ("RK4", "Gauss8"):
        r = solve_ivp(
            satellite, (0, 3), [1, 0, 0, 1.1], method, args=(1.0,), sensitivity="y0", step=0.01
        )
        error = np.abs(r.sensitivity["y0"][..., -1] - forward.sensitivity["y0"][..., -1]).max()
        assert error < 1e-6  # 0.01^4, times the derivatives of the flow


def test_what_jumps_in_time_alone_or_only_bends_is_taken():
    def fun(t, y, c):
        switched = 1.0 if t < 1.3 else -1.0
        return [y[1], switched - c * abs(y[1]) * y[1] - max(y[0], 0.2)]

    at = {"breakpoints": [1.3], "t_eval": [2.0, 4.0], **TIGHT}
    r = solve_ivp(fun, (0, 4), [0.5, 0.3], args=(0.4,), sensitivity="c", **at)
    by_c = differences(lambda c: solve_ivp(fun, (0, 4), [0.5, 0.3], args=(c[0],), **at).y, [0.4])
    assert np.allclose(r.sensitivity["c"], by_c[:, 0], rtol=1e-5, atol=1e-6)  # O(h) at a bend


RAMPS = [
    lambda t, y, tau: [max(0.0, t - tau)],
    lambda t, y, tau: [t - tau if t > tau else 0.0],
    lambda t, y, tau: [np.where(t > tau, t - tau, 0.0)],
]


@pytest.mark.parametrize("ramp", RAMPS)
def test_a_ramp_begins_without_a_jump(ramp):
    """Beside rounding, a size of 5e-17 behind a zero was a jump."""
    how = TIGHT | {"method": "Tsit5", "t_eval": [1.0], "args": (0.3,)}
    r = solve_ivp(ramp, (0, 1), [0.0], sensitivity="tau", **how)
    assert abs(r.sensitivity["tau"][0, -1] + 0.7) < 1e-12
    r = solve_ivp(ramp, (0, 1), [0.0], adjoint="tau", **how)
    assert abs(r.vjp([[1.0]])["tau"] + 0.7) < 1e-12


def test_an_equation_that_holds_for_more_than_a_point():
    """``u == clip(u)``, as integrators are stopped: its own side has the derivatives."""

    def loop(t, y, most):
        e = 1.0 - y[0]
        u = 4.0 * e + 3.0 * y[1]
        sat = np.clip(u, -most, most)
        return [sat - y[0], e if u == sat else e - 0.5 * y[0]]

    start, how = [0.9, 0.3], TIGHT | {"method": "Tsit5", "args": (1.5,), "t_eval": [0.2]}
    r = solve_ivp(loop, (0, 0.2), start, sensitivity="y0", **how)
    matrix = np.array([[-5.0, 3.0], [-1.0, 0.0]])  # of [y0, y1], away from the limits
    assert np.abs(r.sensitivity["y0"][..., -1] - expm(0.2 * matrix)).max() < 1e-9
    back = solve_ivp(loop, (0, 0.2), start, adjoint="y0", **how).vjp([[1.0], [2.0]])["y0"]
    assert np.abs(back - [1.0, 2.0] @ expm(0.2 * matrix)).max() < 1e-9


def test_an_argument_that_is_not_used_has_none_and_whole_numbers_have_theirs():
    def fun(t, y, mass, unused):
        return [-y[0] / mass]

    r = solve_ivp(fun, (0, 1), [2.0], args=(2, 7.0), sensitivity="args", **TIGHT)
    assert not r.sensitivity["unused"].any()
    assert np.allclose(r.sensitivity["mass"][0], r.y[0] * r.t / 4, rtol=1e-10)
    again = solve_ivp(fun, (0, 1), [2.0], args=(4, 7.0), sensitivity="args", **TIGHT)
    assert np.allclose(again.sensitivity["mass"][0], again.y[0] * again.t / 16, rtol=1e-10)


def test_an_exponent_is_no_part_of_the_code():
    def fun(t, y, p):
        return [-(y[0] ** p)]

    r = solve_ivp(fun, (0, 1), [2.0], args=(2.0,), sensitivity="p", **TIGHT)
    by_p = differences(
        lambda p: solve_ivp(fun, (0, 1), [2.0], args=tuple(p), **TIGHT).y[:, -1], [2.0]
    )
    assert np.allclose(r.sensitivity["p"][:, -1], by_p[:, 0], rtol=1e-7)


def test_taylor_series_and_the_jacobian_of_the_variational_equations():
    args = (satellite, (0, 10), [1, 0, 0, 1.1])
    r = solve_ivp(*args, "Taylor", args=(1.0,), rtol=1e-12, atol=1e-12, sensitivity="args")
    other = solve_ivp(*args, args=(1.0,), t_eval=r.t, sensitivity="args", **TIGHT)
    assert np.allclose(r.sensitivity["mu"], other.sensitivity["mu"], rtol=1e-9, atol=1e-9)
    bound = sensitivities.bind_variational(
        Variational(oscillator, DERIVATIVE, 2, (1,), 1, 2), (4.0, 0.1), Near(0.0, 1.0, np.ones(2))
    )
    found = jacobian(bound.function)  # of [v, -k x - c v, s_v, -k s_x - c s_v - x]
    assert set(zip(found.rows, found.columns, strict=True)) == {
        (0, 1), (1, 0), (1, 1), (2, 3), (3, 0), (3, 2), (3, 3)
    }  # fmt: skip


def test_units_do_not_matter():
    """Metres and seconds: the tolerance of a column is that per unit of its direction."""
    mu, r0 = 3.986e14, 7e6
    v0 = 1.1 * math.sqrt(mu / r0)
    span = r0 / v0 * 10
    small = solve_ivp(satellite, (0, 10 * 1.1), [1, 0, 0, 1.1 / 1.1], args=(1 / 1.21,),
                      sensitivity="args", **TIGHT)  # fmt: skip
    large = solve_ivp(satellite, (0, span * 1.1), [r0, 0, 0, v0], "DOP853", args=(mu,),
                      sensitivity="args", rtol=1e-9, atol=1e-3)  # fmt: skip
    a, b = small.sensitivity["mu"][:, -1] / 1.21, large.sensitivity["mu"][:, -1] * mu
    assert np.allclose(b[:2] / r0, a[:2], rtol=1e-5, atol=1e-5)


def test_code_is_made_once(monkeypatch):
    made = []
    monkeypatch.setattr(sensitivities, "_extended", lambda *a: made.append(a))
    for c in (0.1, 0.2):
        solve_ivp(oscillator, (0, 1), [1, 0.5], args=(4.0, c), sensitivity=("y0", "args"))
    assert not made  # in `test_the_exact_ones_of_an_oscillator`, or never


def test_the_norm_is_that_of_the_state_and_the_mean_of_those_of_the_columns():
    from fastdyn.kernels.methods import METHODS
    from fastdyn.problem import validate
    from fastdyn.problem.arguments import Arguments
    from fastdyn.problem.sensitivities import directions_of

    rtol, atol = 1e-4, [1.0, 1e-6]
    asked = Arguments(
        fun=oscillator, t0=0.0, tf=1.0, y0=np.array([100.0, 0.0]), args=(4.0, 0.1),
        options={"rtol": rtol, "atol": atol},
    )  # fmt: skip
    problem = validate.problem(asked, METHODS["RK45"], DERIVATIVE)
    directions = directions_of(("y0", "k"), oscillator, problem.y0, problem.args)
    longer = with_sensitivities(problem, directions)
    expected = np.array([1.0, 1e-6, 1e-6, 1e-4, 2.5e-5, 1e-8, 1e-6, 2.5e-7])
    error, size = np.random.default_rng(0).uniform(0.1, 1.0, (2, 8))
    error *= expected + rtol * size
    squares = np.square(error / (expected + rtol * size))
    of_blocks = squares[:2].mean() + squares[2:].reshape(2, 3).mean(axis=0).mean()
    found = np.square(error / (longer.atol + longer.rtol * size)).mean()
    assert found == pytest.approx(of_blocks, rel=1e-14)
    matlab = with_sensitivities(problem._replace(method=METHODS["ode45"]), directions)
    assert matlab.rtol == rtol and np.allclose(matlab.atol, expected)  # its norm is no mean


@pytest.mark.parametrize("method", ["RK45", "DOP853"])
def test_errors_of_sensitivities_are_those_of_states(method):
    """Each column's error, in its tolerance, is below ten times the error of the state alone."""

    def prey(t, y, a, b, c, d):
        return [a * y[0] - b * y[0] * y[1], d * y[0] * y[1] - c * y[1]]

    at = {"method": method, "t_eval": np.linspace(0, 20, 41), "args": (1.5, 1.0, 3.0, 1.0)}
    tol, wanted = 1e-6, {"sensitivity": ("y0", "args")}
    exact = solve_ivp(prey, (0, 20), [2.0, 1.0], **at, **wanted, rtol=1e-12, atol=1e-13)
    alone, found = [
        solve_ivp(prey, (0, 20), [2.0, 1.0], **at, **more, rtol=tol, atol=tol)
        for more in ({}, wanted)
    ]

    def error(y, y_exact, unit=1.0):
        apart = (y - y_exact) / (tol / unit + tol * np.abs(y_exact))
        return np.sqrt(np.square(apart).mean(axis=0)).max()

    names = ["a", "b", "c", "d"]
    of_columns = [
        error(found.sensitivity[name], exact.sensitivity[name], max(1.0, value))
        for name, value in zip(names, at["args"], strict=True)
    ]
    assert error(found.y, exact.y) < error(alone.y, exact.y)
    assert max(of_columns) < 10 * error(alone.y, exact.y)
    assert found.nfev < 1.6 * alone.nfev  # 1.43; by the sum of all squares 1.67


def test_a_solve_that_ends_before_its_first_time_of_output():
    """Such a solve gives a failed result without points, as without sensitivities."""
    r = solve_ivp(lambda t, y: [y[0] ** 2], (0, 2), [1.0], t_eval=[1.5], sensitivity="y0")
    assert not r.success and "blows up" in r.message
    assert len(r.t) == 0 and r.sensitivity["y0"].shape == (1, 1, 0)
