"""Every method: its order, and the steps that others who have it publish or take."""

import math
from decimal import Decimal

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.kernels.methods import METHODS

EPS = float(np.finfo(float).eps)
FIXED = [name for name, m in METHODS.items() if not m.error_order]
SCIPYS = ["RK23", "RK45", "DOP853"]


def forced(t, y):
    """q'' of time and, nonlinearly, of q, solved by q = cos t."""
    return [y[1], math.sin(math.cos(t)) - math.cos(t) - math.sin(y[0])]


def exact(t):
    return np.array([np.cos(t), -np.sin(t)])


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
    "forced": (forced, (0, 10), [1.0, 0.0]),
}


BLOWN_UP = [("projectile", -1), ("Lorenz", -1)]  # backward in time, drag feeds them
RUNS = [(name, sign) for name in PROBLEMS for sign in (1, -1) if (name, sign) not in BLOWN_UP]
OPTIONS = [{}, {"rtol": 1e-7}, {"rtol": 1e-5, "max_step": 0.1, "first_step": 0.01}]


def meets(t, y):
    return y[0] - y[-1] - 0.1


def rises(t, y):
    return y[0] - 0.5


rises.direction = 1


def distances(a, b, t):
    """How far two runs of as many steps are apart: times, ends of steps, in between, events."""
    assert (a.nfev, a.status, len(a.t)) == (b.nfev, b.status, len(b.t))
    assert list(map(len, a.t_events)) == list(map(len, b.t_events))
    events = [np.abs(p - q).max(initial=0) for p, q in zip(a.t_events, b.t_events, strict=True)]
    apart = [np.abs(p - q).max() for p, q in ((a.t, b.t), (a.y, b.y), (a.sol(t), b.sol(t)))]
    return np.array([*apart, *events])


@pytest.mark.parametrize(("name", "direction"), RUNS)
@pytest.mark.parametrize("method", SCIPYS)
def test_the_steps_are_scipys(method, name, direction):
    """Apart no more than SciPy is from itself when the initial state changes in its last digits.

    That differs between problems by many orders: an error estimate near zero is mostly rounding,
    and the next step and all that follow inherit it.
    """
    fun, t_span, y0 = PROBLEMS[name]
    t_span = t_span[::direction]
    t, y0 = np.linspace(*t_span, 101), np.array(y0, dtype=float)
    for options in OPTIONS:
        if "rtol" in options:
            options = options | {"atol": 1e-9 * np.logspace(-1, 1, len(y0))}
        given = {"method": method, "dense_output": True, "events": (meets, rises), **options}
        theirs = scipy.integrate.solve_ivp(fun, t_span, y0, **given)
        nearby = [
            distances(
                scipy.integrate.solve_ivp(fun, t_span, y0 * (1 + k * EPS), **given), theirs, t
            )
            for k in (-2, 2, 4)
        ]
        rounding = EPS * np.array([10.0, *[np.abs(theirs.y).max()] * 2, 10.0, 10.0])
        ours = fastdyn.solve_ivp(fun, t_span, y0, **given)
        assert (distances(ours, theirs, t) <= 20 * (np.max(nearby, axis=0) + rounding)).all()


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
FASTER = {"Vern9"}


@pytest.mark.parametrize("method", METHODS)
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


@pytest.mark.parametrize("method", METHODS)
def test_measured_order_of_dense_output_in_one_step(method):
    """From an exact start, a polynomial of order p errs as h^(p + 1) inside the step."""
    steps = short_steps(method)
    errors = []
    for h in steps:
        t = np.linspace(0, h, 101)
        errors.append(np.abs(at_fixed_step(method, h, h).sol(t) - exact(t)).max())
    above = round(slope(steps, errors)) - METHODS[method].dense_order - 1
    assert above == 0 or (method in FASTER and 0 < above <= 2)


def half_a_digit(text):
    return 0.5 * 10.0 ** Decimal(text).as_tuple().exponent


# Check values of ode45's rule, satellite, t in [0, 100], AbsTol 1e-6: steps, none rejected;
# r at the end; change of energy and of angular momentum in percent.
ODE45 = {
    1e-3: (169, 0.7103238831871562, "-40.39", "-15.60"),
    1e-4: (213, 0.990228304639257, "-0.980", "-0.487"),
    1e-5: (346, 0.9997323860025205, "-0.0265", "-0.0133"),
    1e-6: (468, 0.999988067261381, "-0.00119", "-0.000597"),
}


@pytest.mark.parametrize("rtol", ODE45)
def test_ode45_on_the_satellite(rtol):
    steps, radius, *printed = ODE45[rtol]
    x0 = np.array([1.0, 1 - 2 * EPS, 1 + 2 * EPS])
    runs = [fastdyn.solve_ivp(satellite, (0, 100), [x, 0, 0, 1], "ode45", rtol=rtol) for x in x0]
    assert {(r.n_accepted, r.n_rejected) for r in runs} == {(steps, 0)}
    at_end = [math.hypot(*r.y[:2, -1]) for r in runs]
    assert abs(at_end[0] - radius) <= 20 * (np.ptp(at_end) + EPS)
    x, y, vx, vy = runs[0].y
    energy = (vx**2 + vy**2) / 2 - 1 / np.hypot(x, y)
    for values, text in zip((energy, x * vy - y * vx), printed, strict=True):
        change = 100 * (values[-1] - values[0]) / abs(values[0])
        assert abs(change - float(text)) <= half_a_digit(text)


def test_ode45_on_van_der_pol_takes_the_published_steps():
    published = "0 1.0048e-04 6.0285e-04 .0031 .0157 .0785 .2844 .5407 .8788 1.4032 1.8905 2.3778"
    r = fastdyn.solve_ivp(van_der_pol, (0, 20), [2.0, 0.0], "ode45")
    assert (len(r.t), r.n_rejected, r.nfev) == (60, 10, 415)
    for t, text in zip(r.t, published.split(), strict=False):
        assert abs(t - float(text)) <= half_a_digit(text)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("dense_output", [False, True])
@pytest.mark.parametrize("method", METHODS)
def test_evaluations_are_counted(method, dense_output):
    times = []

    def counted(t, y):
        times.append(t)
        return [y[1], -y[0]]

    options = {"step": 0.1} if method in FIXED else {}
    r = fastdyn.solve_ivp(counted, (0, 1), [1.0, 0.0], method, dense_output=dense_output, **options)
    assert len(times) == r.nfev


def test_a_last_step_beyond_the_end_is_interpolated():
    r = fastdyn.solve_ivp(forced, (0, 1), [1.0, 0.0], "RK4", step=0.03)
    assert r.t[-1] == 1.0 and r.n_accepted == 34 and abs(r.t[-2] - 0.99) < 1e-12
    assert np.abs(r.y[:, -1] - exact(1.0)).max() < 1e-7
