"""Switches, pulses and chattering: functions that change with the time, or where the state decides.

The end states of solutions that slide along a switch are Filippov's, by hand.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline, PchipInterpolator, interp1d

KNOTS = np.arange(11.0)
RECORD = np.where(KNOTS == 5.0, 1.0, 0.0)
FINE = np.linspace(0.0, 10.0, 2001)
BELL = np.exp(-(((FINE - 5.0) / 0.05) ** 2))
HELD, LINEAR = interp1d(KNOTS, RECORD, kind="previous"), interp1d(KNOTS, RECORD)
SPLINE, SHAPED = CubicSpline(FINE, BELL), PchipInterpolator(KNOTS, RECORD)
CELLS = np.linspace(1.0, 9.0, 80)


class Switch(NamedTuple):
    """A problem; without its `end`, this is computed by steps of at most `max_step`."""

    name: str
    fun: Any
    t_span: tuple = (0.0, 10.0)
    y0: Any = (0.0,)
    args: tuple = ()
    end: Any = None
    max_step: float = 2e-3


def _ladder(t):
    if t < 5.0:
        return 0.0
    elif t < 5.5:
        return 1.0
    return 0.0


INPUTS = {  # of y' = u(t) (1 - y) - y
    "5 < t < 6": lambda t: 1.0 if 5 < t < 6 else 0.0,
    "t >= 5 and t <= 5.25": lambda t: 1.0 if t >= 5 and t <= 5.25 else 0.0,
    "if, elif, else": _ladder,
    "(t > 5) * (t < 6)": lambda t: (t > 5) * (t < 6),
    "np.where((t > 5) & (t < 6), 1, 0)": lambda t: np.where((t > 5) & (t < 6), 1.0, 0.0),
    "np.heaviside": lambda t: np.heaviside(t - 5, 0.5) - np.heaviside(t - 5.1, 0.5),
    "np.sign": lambda t: 0.5 * (np.sign(t - 5) - np.sign(t - 6)),
    "np.piecewise": lambda t: np.piecewise(t, [t < 5, t >= 5.5], [0.0, 0.0, 1.0]),
    "np.select": lambda t: np.select([t < 5, t < 5.5], [0.0, 1.0], 0.0),
    "abs(t - 5.5) < 0.25": lambda t: 1.0 if abs(t - 5.5) < 0.25 else 0.0,
    "t % 4 > 3.9": lambda t: 1.0 if t % 4.0 > 3.9 else 0.0,
    "math.fmod(t, 4) > 3.9": lambda t: 1.0 if math.fmod(t, 4.0) > 3.9 else 0.0,
    "floor(2 t) == 11": lambda t: 1.0 if math.floor(2 * t) == 11 else 0.0,
    "round(t) == 5": lambda t: 1.0 if round(t) == 5 else 0.0,
    "a thousand pulses, t % 0.01 < 1e-3": lambda t: 1.0 if t % 0.01 < 1e-3 else 0.0,
    "math.sin(t) > 0.99": lambda t: 1.0 if math.sin(t) > 0.99 else 0.0,
    "scipy.signal.square": lambda t: 0.5 + 0.5 * signal.square(t, 0.02),
    "two sines > 1.1": lambda t: 1.0 if math.sin(t) + 0.5 * math.sin(3 * t + 1) > 1.1 else 0.0,
    "exp(-(10 (t - 5))**2) > 0.5": lambda t: 1.0 if math.exp(-((10 * (t - 5)) ** 2)) > 0.5 else 0.0,
    "a record, u[int(t / dt)]": lambda t: RECORD[min(int(t / 1.0), 10)],
    "a record, np.searchsorted": lambda t: RECORD[np.searchsorted(KNOTS, t, side="right") - 1],
    "interp1d, previous": lambda t: HELD(t),
    "interp1d": lambda t: LINEAR(t),
    "np.interp, one peak": lambda t: np.interp(t, KNOTS, RECORD),
    "np.interp, 2000 knots": lambda t: np.interp(t, FINE, BELL),
    "CubicSpline, 2000 knots": lambda t: SPLINE(t),
    "PchipInterpolator": lambda t: SHAPED(t),
    "max(0, 1 - 4 abs(t - 5))": lambda t: max(0.0, 1 - 4 * abs(t - 5)),
    "np.clip, a short trapezium": lambda t: np.clip(t - 5, 0, 0.1) - np.clip(t - 5.2, 0, 0.1),
}


def _relaxed(u):
    return lambda t, y: [u(t) * (1.0 - y[0]) - y[0]]


def _struck(t, y, start, width):
    return [y[1], (50.0 if start < t < start + width else 0.0) - y[0] - 0.1 * y[1]]


def _warmed(t, y):
    heat = 1.0 if 5 < t < 5.1 else 0.0
    return 9.0 * (np.roll(y, 1) + np.roll(y, -1) - 2 * y) + heat * (CELLS > 5) - 0.1 * y


def _one_by_one(t, y):
    return np.where((t > CELLS) & (t < CELLS + 0.01), 1.0, 0.0) * (1 - y) - y


def _stiff(t, y):
    u = 1.0 if 2000 < t < 2000.5 else 0.0
    return [-1e4 * (y[0] - math.cos(1e-3 * t) - u), y[0] - y[1]]


def _charged(t, y):
    u = abs(math.sin(t))
    return [10.0 * (u - y[0]) - 0.2 * y[0] if u > y[0] else -0.2 * y[0]]


TIMES = [
    *(Switch(name, _relaxed(u)) for name, u in INPUTS.items()),
    Switch("a pulse of 1 in a million", _relaxed(lambda t: 1.0 if 7e5 < t < 7e5 + 1 else 0.0),
           (0.0, 7e5 + 2), max_step=math.inf),
    Switch("a blow of 0.01, from `args`", _struck, y0=(0.0, 0.0), args=(5.0, 0.01)),
    Switch("backwards", _relaxed(lambda t: 1.0 if 5 < t < 6 else 0.0), (10.0, 4.0)),
    Switch("80 cells, one pulse", _warmed, y0=np.zeros(80)),
    Switch("80 cells, a pulse each", _one_by_one, y0=np.zeros(80)),
    Switch("a stiff problem", _stiff, (0.0, 2001.0), (1.0, 1.0), max_step=math.inf),
]  # fmt: skip


def _thermostat(t, y):
    return [-0.1 * (y[0] - 5.0) + (3.0 if y[0] < 20.0 else 0.0)]


def _relay(t, y):
    return [y[1], -1.0 if y[0] + y[1] > 0.0 else 1.0]


STATES = [
    Switch("a thermostat without hysteresis", _thermostat, (0.0, 50.0), (5.0,), end=[20.0]),
    Switch("a tank with a limit", lambda t, y: [0.1 if y[0] <= 1.0 else 0.0], (0.0, 50.0),
           end=[1.0]),
    Switch("a tank with a limit of 0.3", lambda t, y: [0.0 if y[0] > 0.3 else 0.1], (0.0, 50.0),
           end=[0.3]),
    Switch("a relay, y' = -sign(y)", lambda t, y: [-np.sign(y[0])], (0.0, 5.0), (1.0,), end=[0.0]),
    Switch("a block with dry friction", lambda t, y: [y[1], -0.3 * 9.81 * np.sign(y[1])],
           (0.0, 5.0), (0.0, 3.0), end=[9.0 / (2 * 0.3 * 9.81), 0.0]),
    Switch("a relay along x + v = 0", _relay, (0.0, 10.0), (0.4, 0.0),
           end=[2.1827179e-05, -2.1827179e-05]),
    Switch("a pump against a leak", lambda t, y: [(2.0 if y[0] < 1.0 else 0.0) - 1.0], (0.0, 5.0),
           end=[1.0]),
    Switch("a rectifier", _charged, (0.0, 20.0)),
    Switch("an outflow, max(0, y - 1)", lambda t, y: [0.5 - max(0.0, y[0] - 1.0)], (0.0, 10.0)),
]  # fmt: skip
