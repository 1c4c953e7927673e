"""Slips in odeint, and in MATLAB's names for equations with a past, boundaries and residuals."""

import pytest

from fastdyn import matlab, odeint
from support.slips import NUMBER, NUMBERS, rows_of, said_to


def spring(y, t):
    return [y[1], -y[0]]


def rates(t, y):
    return [y[1], -y[0]]


def residual(t, y, yp):
    return [yp[0] - y[1], yp[1] + y[0]]


def delayed(t, y, Z):
    return [-Z[0, 0]]


def ends(a, b):
    return [a[0], b[0] - 1.0]


ODEINT = {"func": spring, "y0": [1.0, 0.0], "t": [0.0, 1.0]}
OF_TIMES = "`tspan` must be two or more finite times; got 1.0"
DELAYS = {"ddefun": delayed, "history": [1.0], "tspan": [0.0, 2.0]}
GUESS = matlab.bvpinit([0.0, 0.5, 1.0], [0.0, 1.0])
BOUNDARIES = {"odefun": rates, "bcfun": ends, "solinit": GUESS}
OF_BOUNDARIES = [
    ({"odefun": 3}, "`odefun` must be a function of (x, y); got 3"),
    ({"bcfun": "x"}, "`bcfun` must be a function of (ya, yb); got the text 'x'"),
    ({"solinit": [0, 1]}, "`solinit` must be a result of `bvpinit`, or an earlier solution"),
    ({"options": "x"}, "`options` must be what `odeset(...)` returns"),
]
OF_DELAYS = [
    ({"ddefun": rates}, "`ddefun` is called as ddefun(t, y, Z): too many"),
    ({"history": "x"}, "`history` must be n numbers, a function of t"),
    ({"tspan": 1.0}, OF_TIMES),
]
TABLE = {
    "odeint": (odeint, ODEINT, [
        ({"func": "f"}, "`func` must be a function of (y, t); got the text 'f'"),
        ({"y0": "1, 0"}, f"`y0` {NUMBERS}the text '1, 0'"),
        ({"y0": None}, f"`y0` {NUMBERS}None"),
        ({"y0": [[1, 0]]}, "y0 must be one-dimensional; got shape (1, 2)"),
        ({"t": "abc"}, "`t` must be a sequence of times; got the text 'abc'"),
        ({"t": 1.0}, "t must be one-dimensional; got 1.0"),
        ({"t": [0, 2, 1]}, "monotonically increasing or monotonically decreasing"),
        ({"Dfun": 3}, "`Dfun` must be a function of (y, t); got 3"),
        ({"rtol": "x"}, f"`rtol` {NUMBERS}the text 'x'"),
        ({"rtol": -1}, "`rtol` must not be negative or NaN; got -1"),
        ({"atol": [1, 2, 3]}, "`atol` has shape (3,), and `y0` has 2 components"),
        ({"tcrit": "x"}, f"`tcrit` {NUMBERS}the text 'x'"),
        ({"ml": "x"}, f"`ml` {NUMBER}the text 'x'"),
        ({"mxstep": "x"}, f"`mxstep` {NUMBER}the text 'x'"),
        ({"mxstep": -1}, "`mxstep` must not be negative; got -1"),
        ({"hmax": "x"}, f"`hmax` {NUMBER}the text 'x'"),
        ({"h0": "x"}, f"`h0` {NUMBER}the text 'x'"),
        ({"mxordn": -1}, "Incorrect value for mxordn: -1"),
    ]),
    "ode15i": (
        matlab.ode15i, {"odefun": residual, "tspan": [0, 1], "y0": [1, 0], "yp0": [0, -1]}, [
            ({"odefun": rates}, "`odefun` is called as odefun(t, y, yp): too many"),
            ({"tspan": 1.0}, OF_TIMES),
            ({"y0": [1.0]}, "`yp0` must have one number for each of `y0`"),
        ],
    ),
    "dde23": (matlab.dde23, {**DELAYS, "lags": [1.0]}, [
        *OF_DELAYS,
        ({"lags": "x"}, f"`lags` {NUMBERS}the text 'x'"),
        ({"lags": -1}, "`lags` must be positive"),
        ({"lags": lambda t, y: t - 1}, f"`lags` {NUMBERS}"),
    ]),
    "ddesd": (matlab.ddesd, {**DELAYS, "delays": lambda t, y: [t - 1.0]}, [
        *OF_DELAYS,
        ({"delays": None}, f"`delays` {NUMBERS}None"),
    ]),
    "bvpinit": (matlab.bvpinit, {"x": [0, 1], "yinit": [0, 1]}, [
        ({"x": "x"}, "`x` must be a sequence of times; got the text 'x'"),
        ({"yinit": None}, f"`yinit` {NUMBERS}None"),
    ]),
    "bvp4c": (matlab.bvp4c, BOUNDARIES, OF_BOUNDARIES),
    "bvp5c": (matlab.bvp5c, BOUNDARIES, OF_BOUNDARIES),
}  # fmt: skip


@pytest.mark.parametrize(("call", "given", "words", "kind"), rows_of(TABLE))
def test_a_slip_is_answered(call, given, words, kind):
    assert words in said_to(call, given, kind)
