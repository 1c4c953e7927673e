"""Every method: its order, its steps, its two tiers; and SciPy's steps where they are SciPy's."""

import math

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.kernels import METHODS

FIXED = [name for name, m in METHODS.items() if not m.error_order]
SCIPYS = ["RK23", "RK45", "DOP853"]


def oscillator(t, y):
    return [y[1], -y[0]]


def satellite(t, w):
    x, y, vx, vy = w
    r3 = (x * x + y * y) ** 1.5
    return [vx, vy, -x / r3, -y / r3]


def projectile(t, w):
    vx, vy, vz = w[3:]
    s = 0.5 * math.sqrt(vx * vx + vy * vy + vz * vz)
    return [vx, vy, vz, -s * vx, -s * vy, -s * vz - 9.81]


def pendulum(t, y):
    return y[1], -9.81 * math.sin(y[0])


def lorenz(t, w):
    x, y, z = w
    return 10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z


def van_der_pol(t, y):
    return [y[1], (1 - y[0] ** 2) * y[1] - y[0]]


def lotka_volterra(t, y):
    return [1.5 * y[0] - y[0] * y[1], y[0] * y[1] - 3 * y[1]]


def arenstorf(t, w):
    x, y, vx, vy = w
    m = 0.012277471
    d1, d2 = ((x + m) ** 2 + y * y) ** 1.5, ((x - 1 + m) ** 2 + y * y) ** 1.5
    ax = x + 2 * vy - (1 - m) * (x + m) / d1 - m * (x - 1 + m) / d2
    ay = y - 2 * vx - (1 - m) * y / d1 - m * y / d2
    return vx, vy, ax, ay


def building(t, y):
    k, d, w, height = 100.0, 0.1, 9.0, 10.0
    top = 2 * k * (y[1] - y[0] - height)
    return [
        y[2],
        y[3],
        -2 * k * (y[0] - d * math.sin(w * t) - height) + top - 9.81,
        -top - 9.81,
    ]


def brusselator(t, y):
    return np.array([1 + y[0] ** 2 * y[1] - 4 * y[0], 3 * y[0] - y[0] ** 2 * y[1]])


def growth(t, y):
    return 0.3 * y


PROBLEMS = {
    "circle": (satellite, (0, 20), [1, 0, 0, 1]),
    "ellipse": (satellite, (0, 10), [1, 0, 0, 1.2]),
    "projectile": (projectile, (0, 5), [0, 0, 0, 10, 10, 20]),
    "pendulum": (pendulum, (0, 5), [1.0, 0.0]),
    "Lorenz": (lorenz, (0, 1), [1.0, 1.0, 1.0]),
    "van der Pol": (van_der_pol, (0, 10), [2.0, 0.0]),
    "Lotka-Volterra": (lotka_volterra, (0, 10), [10.0, 5.0]),
    "Arenstorf": (arenstorf, (0, 5), [0.994, 0, 0, -2.00158510637908252]),
    "building": (building, (0, 5), [10 - 0.0981, 20 - 0.14715, 0, 0]),
    "Brusselator": (brusselator, (0, 10), [1.5, 3.0]),
    "growth": (growth, (0, 10), [1.0, 2.0]),
    "backward": (oscillator, (10, 0), [1.0, 0.0]),
}


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("method", SCIPYS)
def test_the_steps_are_scipys(method, name):
    fun, t_span, y0 = PROBLEMS[name]
    n = len(y0)
    for options in (
        {},
        {"rtol": 1e-7, "atol": np.logspace(-10, -8, n)},
        {"rtol": 1e-5, "max_step": 0.1, "first_step": 0.01},
    ):
        ours = fastdyn.solve_ivp(fun, t_span, y0, method, dense_output=True, **options)
        theirs = scipy.integrate.solve_ivp(fun, t_span, y0, method, dense_output=True, **options)
        assert ours.nfev == theirs.nfev and len(ours.t) == len(theirs.t)
        # SciPy's BLAS adds in another order, and where an error estimate nearly vanishes the next
        # step inherits that rounding.  The solutions agree to a hundredth of the tolerance.
        np.testing.assert_allclose(ours.t, theirs.t, rtol=1e-3, atol=1e-3)
        t = np.linspace(*t_span, 41)
        scale = np.abs(theirs.y).max() * max(1e-6, 0.01 * options.get("rtol", 1e-3))
        np.testing.assert_allclose(ours.sol(t), theirs.sol(t), rtol=0, atol=scale)


def at_fixed_step(method, h, **options):
    if method in FIXED:
        options |= {"step": h}
    else:
        options |= {"first_step": h, "max_step": h, "rtol": 1e6, "atol": 1e6}
    r = fastdyn.solve_ivp(oscillator, (0, 4), [1.0, 0.0], method, dense_output=True, **options)
    np.testing.assert_allclose(np.diff(r.t)[:-1], h, rtol=1e-9)
    return r


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def exact(t):
    return np.array([np.cos(t), -np.sin(t)])


@pytest.mark.parametrize("method", METHODS)
def test_measured_orders(method):
    m = METHODS[method]
    steps = 4 / np.array([8, 11, 16, 23]) if m.order == 8 else 4 / np.array([40, 57, 80, 113])
    runs = [at_fixed_step(method, h) for h in steps]
    ends = [np.linalg.norm(r.y[:, -1] - exact(4.0)) for r in runs]
    assert abs(slope(steps, ends) - m.order) < 0.35
    t = np.linspace(0, 4, 501)
    between = [np.abs(r.sol(t) - exact(t)).max() for r in runs]
    # A polynomial of order p inside steps whose ends have order q errs as the lower of p + 1, q.
    assert slope(steps, between) > min(m.dense_order + 1, m.order) - 0.4


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [2, 4, 16, 18])
def test_both_tiers_give_the_same_bits(method, n):
    y0 = np.linspace(1, 2, n)
    options = {"step": 0.01} if method in FIXED else {"rtol": 1e-7}
    runs = [
        fastdyn.solve_ivp(chain, (0, 3), y0, method, dense_output=True, tier=tier, **options)
        for tier in ("pointer", "specialised")
    ]
    assert np.array_equal(runs[0].t, runs[1].t) and np.array_equal(runs[0].y, runs[1].y)
    t = np.linspace(0, 3, 99)
    assert np.array_equal(runs[0].sol(t), runs[1].sol(t))


def chain(t, y):
    m = y.size // 2
    out = np.empty(y.size)
    for i in range(m):
        left = y[i - 1] if i > 0 else 0.0
        right = y[i + 1] if i < m - 1 else 0.0
        out[i] = y[m + i]
        out[m + i] = left - 2 * y[i] + right - 0.1 * math.sin(y[i])
    return out


# Check values of MATLAB's ode45: satellite, t in [0, 100], AbsTol 1e-6.
ODE45 = {
    1e-3: (169, 0.7103238831871562, -40.39),
    1e-4: (213, 0.990228304639257, -0.980),
    1e-5: (346, 0.9997323860025205, -0.0265),
    1e-6: (468, 0.999988067261381, -0.00119),
}


@pytest.mark.parametrize("rtol", ODE45)
def test_ode45_on_the_satellite(rtol):
    steps, radius, energy = ODE45[rtol]
    r = fastdyn.solve_ivp(satellite_sqrt, (0, 100), [1, 0, 0, 1], "ode45", rtol=rtol)
    x, y, vx, vy = r.y
    assert (r.n_accepted, r.n_rejected) == (steps, 0)
    assert abs(math.hypot(x[-1], y[-1]) - radius) < 1e-11
    change = 100 * ((vx[-1] ** 2 + vy[-1] ** 2) / 2 - 1 / math.hypot(x[-1], y[-1]) + 0.5) / 0.5
    assert abs(change / energy - 1) < 0.005  # the printed digits


def satellite_sqrt(t, w):
    x, y, vx, vy = w
    r3 = math.sqrt(x * x + y * y) ** 3
    return [vx, vy, -x / r3, -y / r3]


def test_ode45_on_van_der_pol_takes_the_published_steps():
    r = fastdyn.solve_ivp(van_der_pol, (0, 20), [2.0, 0.0], "ode45")
    published = [0, 1.0048e-4, 6.0285e-4, 0.0031, 0.0157, 0.0785, 0.2844, 0.5407, 0.8788, 1.4032]
    assert len(r.t) == 60 and r.n_rejected == 10
    np.testing.assert_allclose(r.t[:10], published, rtol=1e-2, atol=5e-5)


@pytest.mark.parametrize("method", METHODS)
def test_tighter_tolerance_or_step_means_smaller_error(method):
    levels = [1e-4, 1e-6, 1e-8] if method not in FIXED else [0.02, 0.01, 0.005]
    errors = []
    for level in levels:
        options = {"step": level} if method in FIXED else {"rtol": level, "atol": level * 1e-3}
        r = fastdyn.solve_ivp(satellite, (0, 6 * math.pi), [1, 0, 0, 1], method, **options)
        errors.append(np.linalg.norm(r.y[:, -1] - [1, 0, 0, 1]))
    assert slope(levels, errors) > 0.7 * (1 if method not in FIXED else METHODS[method].order)


def test_velocity_verlet_keeps_the_energy_over_a_thousand_orbits():
    h = 2 * math.pi / 200
    r = fastdyn.solve_second_order(
        gravity, (0, 1000 * 2 * math.pi), [1.0, 0.0], [0.0, 1.1], step=h, t_eval=None
    )
    x, y, vx, vy = r.y
    energy = (vx**2 + vy**2) / 2 - 1 / np.hypot(x, y)
    early, late = np.ptp(energy[:2000]), np.ptp(energy)
    assert late < 1.1 * early < 1e-3


def gravity(t, q):
    r3 = (q[0] ** 2 + q[1] ** 2) ** 1.5
    return -q[0] / r3, -q[1] / r3


def test_second_order_is_the_first_order_form():
    options = {"step": 0.01, "dense_output": True}
    a = fastdyn.solve_second_order(gravity, (0, 3), [1.0, 0.0], [0.0, 1.1], **options)
    b = fastdyn.solve_ivp(satellite, (0, 3), [1.0, 0.0, 0.0, 1.1], "VelocityVerlet", **options)
    np.testing.assert_allclose(a.y, b.y, rtol=0, atol=1e-13)


def test_a_last_step_beyond_the_end_is_interpolated():
    r = fastdyn.solve_ivp(oscillator, (0, 1), [1.0, 0.0], "RK4", step=0.03)
    assert r.t[-1] == 1.0 and r.n_accepted == 34 and abs(r.t[-2] - 0.99) < 1e-12
    assert np.abs(r.y[:, -1] - exact(1.0)).max() < 1e-7
