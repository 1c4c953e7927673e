"""Every method against exact motion, energy over a thousand orbits, and the two tiers."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.integrate
from scipy.special import ellipj, ellipk

import fastdyn
from fastdyn.kernels.methods import METHODS
from fastdyn.specialise import scalar, shared_or_inlined
from support.motions import pendulum, satellite

EPS = float(np.finfo(float).eps)

FIXED = [name for name, m in METHODS.items() if not m.error_order]

ADAPTIVE = [name for name in METHODS if name not in FIXED]

RTOLS = 10.0 ** -np.arange(5, 12)  # from where the errors are small to where rounding is not


def tides(q):
    """Derivative of the satellite's acceleration."""
    r = math.hypot(*q)
    return 3 * np.outer(q, q) / r**5 - np.eye(2) / r**3


def kepler(speed):
    """The orbit from (1, 0) with the velocity (0, speed), at periapsis."""
    e = speed**2 - 1
    a = 1 / (1 - e)

    def exact(t):
        M = np.asarray(t) / a**1.5
        u = M + e * np.sin(M)
        for _ in range(20):  # Newton's iteration, far past convergence
            u = u - (u - e * np.sin(u) - M) / (1 - e * np.cos(u))
        b, rate = a * math.sqrt(1 - e**2), 1 / (a**1.5 * (1 - e * np.cos(u)))
        x, y = a * (np.cos(u) - e), b * np.sin(u)
        return np.array([x, y, -a * np.sin(u) * rate, b * np.cos(u) * rate])

    return exact


def swing(amplitude):
    """The pendulum released at rest; sin(theta / 2) = k cd(w t), by Jacobi's functions."""
    k, w = math.sin(amplitude / 2), math.sqrt(9.81)

    def exact(t):
        sn, cn, _, _ = ellipj(w * np.asarray(t) + ellipk(k * k), k * k)
        return np.array([2 * np.arcsin(k * sn), 2 * k * w * cn])

    return exact


class Motion(NamedTuple):
    """A motion with its solution; `force` is the derivative of the acceleration at q."""

    fun: Any
    exact: Any
    force: Any
    t_end: float


MOTIONS = {
    "circle": Motion(satellite, kepler(1.0), tides, 13.0),
    "ellipse": Motion(satellite, kepler(1.2), tides, 13.0),
    "pendulum": Motion(pendulum, swing(2.0), lambda q: [[-9.81 * math.cos(q[0])]], 5.0),
}


@functools.cache
def flow(name):
    """How a small displacement at the start has grown at t, as a matrix."""
    motion = MOTIONS[name]
    n = len(motion.exact(0.0))
    m = n // 2

    def rate(t, columns):
        jacobian = np.zeros((n, n))
        jacobian[:m, m:], jacobian[m:, :m] = np.eye(m), motion.force(motion.exact(t)[:m])
        return (jacobian @ columns.reshape(n, n)).ravel()

    run = scipy.integrate.solve_ivp(
        rate, (0, motion.t_end), np.eye(n).ravel(), "DOP853", rtol=1e-6, dense_output=True
    )
    return lambda t: run.sol(t).T.reshape(-1, n, n)


def solved(method, name, level):
    """A run at the tolerance or the step `level`, and the largest error at the ends of steps."""
    motion = MOTIONS[name]
    options = {"step": level} if method in FIXED else {"rtol": level, "atol": level}
    span = (0, motion.t_end)
    r = fastdyn.solve_ivp(motion.fun, span, motion.exact(0.0), method, **options)
    assert r.success and r.t[-1] == motion.t_end
    return r, np.linalg.norm(r.y - motion.exact(r.t), axis=0)


def slope(levels, errors):
    return np.polyfit(np.log(levels), np.log(errors), 1)[0]


@pytest.mark.few
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_error_is_what_the_tolerated_errors_of_the_steps_grow_to(method, name):
    """A step errs by (atol + rtol |y|) in each component, and the exact flow carries that on."""
    for rtol in RTOLS:
        r, errors = solved(method, name, rtol)
        grown = flow(name)(r.t)
        to_the_end = np.linalg.norm(grown[-1] @ np.linalg.inv(grown[1:]), ord=2, axis=(1, 2))
        size = np.maximum(np.abs(r.y[:, 1:]), np.abs(r.y[:, :-1]))
        tolerated = np.linalg.norm(rtol + rtol * size, axis=0)
        assert errors[-1] <= (to_the_end * tolerated).sum()


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_error_is_proportional_to_the_tolerance(method, name):
    """The factor changes less than a hundredfold over all tolerances, six decades."""
    errors = [solved(method, name, rtol)[1].max() for rtol in RTOLS]
    assert abs(slope(RTOLS, errors) - 1) < 2 / (len(RTOLS) - 1)


@pytest.mark.few
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("method", [m for m in FIXED if "16" not in m])  # at rounding at once
def test_error_falls_with_the_step_as_the_order_says(method, name):
    errors, least = [], 1e-9 if METHODS[method].order > 8 else 1e-11
    for k in range(12):
        try:
            errors.append(solved(method, name, 2.0**-k)[1].max())
        except AssertionError:  # far too long a step: it blows up or does not converge
            errors.append(np.inf)
        if errors[-1] < least:
            break
    before, after = [e for e in errors if e > least][-2:]
    assert abs(np.log2(before / after) - METHODS[method].order) < 0.6


def gravity(t, q):
    r3 = (q[0] ** 2 + q[1] ** 2) ** 1.5
    return -q[0] / r3, -q[1] / r3


def test_velocity_verlet_keeps_a_modified_energy_over_a_thousand_orbits():
    """The energy errs by h^2 times a function of the state, the rest by h^4, and nothing grows.

    E. Hairer, C. Lubich and G. Wanner, "Geometric numerical integration illustrated by the
    Stormer-Verlet method", Acta Numerica 12 (2003), section 3: H + h^2 (v V'' v / 12 - |V'|^2 / 24)
    is kept up to h^4.
    """
    period = 2 * math.pi / (2 - 1.1**2) ** 1.5
    plain, modified, per_orbit = [], [], np.array([200, 400])
    for h in period / per_orbit:
        span = (0, 1000 * period)
        r = fastdyn.solve.solve_second_order(gravity, span, [1.0, 0.0], [0.0, 1.1], step=h)
        x, y, vx, vy = r.y
        distance, v2 = np.hypot(x, y), vx**2 + vy**2
        energy = v2 / 2 - 1 / distance
        bent = v2 / distance**3 - 3 * (x * vx + y * vy) ** 2 / distance**5
        plain.append(np.ptp(energy))
        modified.append(np.ptp(energy + h * h * (bent / 12 - 1 / distance**4 / 24)))
        assert np.ptp(energy[: len(energy) // 100]) > (1 - h) * plain[-1]
    assert round(slope(1 / per_orbit, plain)) == 2
    assert round(slope(1 / per_orbit, modified)) == 4


def test_second_order_is_the_first_order_form():
    options = {"step": 0.01, "dense_output": True}
    a = fastdyn.solve.solve_second_order(gravity, (0, 3), [1.0, 0.0], [0.0, 1.1], **options)
    b = fastdyn.solve_ivp(satellite, (0, 3), [1.0, 0.0, 0.0, 1.1], "VelocityVerlet", **options)
    assert np.abs(a.y - b.y).max() <= EPS * a.n_accepted * np.abs(a.y).max()


def ring(t, y):
    """Each component pulled by its neighbour, and by the time."""
    out = np.empty(y.size)
    for i in range(y.size):
        out[i] = math.sin(y[i - 1]) - 0.5 * y[i] + 0.1 * math.cos(t)
    return out


def solved_in(compile, method, n):
    y0, options = np.linspace(1, 2, n), {"dense_output": True, "compile": compile}
    if METHODS[method].second_order:
        q0, v0 = y0[: n // 2], y0[: n // 2]
        return fastdyn.solve.solve_second_order(ring, (0, 3), q0, v0, method, step=0.01, **options)
    options |= {"step": 0.01} if method in FIXED else {"rtol": 1e-7}
    return fastdyn.solve_ivp(ring, (0, 3), y0, method, **options)


# One method of each loop, norm and controller at every size; the others at one in each tier.
EACH_KIND = ("RK45", "DOP853", "ode45", "RK4", "BlanesMoan6", "Gauss8", "GaussNystrom8")

SIZES = [
    (method, n)
    for method, m in METHODS.items()
    for n in ([2, 4, 16, 18] if m.second_order else [1, 4, 7, 16, 17])
    if method in EACH_KIND or (n == 4 and not m.series and not m.n_matrices)
]


@pytest.mark.few(6)
@pytest.mark.parametrize(("method", "n"), SIZES)
def test_both_tiers_give_the_same_bits(method, n, monkeypatch):
    built = []

    def watched(*given):
        built.append(given)
        return build(*given)

    build = shared_or_inlined.inlined_kernel
    monkeypatch.setattr(shared_or_inlined, "inlined_kernel", watched)
    monkeypatch.setattr(scalar.target, "vector_registers", lambda: 16)
    a = solved_in("shared", method, n)
    assert not built
    b = solved_in("inlined", method, n)
    assert len(built) == (n <= (7 if METHODS[method].is_pair else 16))
    assert np.array_equal(a.t, b.t) and np.array_equal(a.y, b.y)
    assert (a.nfev, a.n_rejected) == (b.nfev, b.n_rejected)
    t = np.linspace(0, 3, 301)
    assert np.array_equal(a.sol(t), b.sol(t))
