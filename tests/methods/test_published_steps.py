"""The steps that others who have a method publish or take: SciPy's, and ode45's."""

import math
from decimal import Decimal

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from support.motions import PROBLEMS, satellite, van_der_pol

EPS = float(np.finfo(float).eps)

SCIPYS = ["RK23", "RK45", "DOP853"]


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


@pytest.mark.few
@pytest.mark.filterwarnings("ignore:.meets. crosses zero")  # twice in a step: SciPy counts one
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
