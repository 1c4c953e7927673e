"""The problems: equations, initial states, spans, end states."""

import functools
import json
import math
import pathlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.fft import dst, idst
from scipy.integrate import solve_ivp

from fastdyn import solve_linear
from fastdyn.systems import SYSTEMS

from . import equations

BODIES, CHAIN = "bodies", "chain"  # C++ functions for any number of components
REFERENCES = pathlib.Path(__file__).with_name("references.json")


class Problem(NamedTuple):
    """A right-hand side with its data.

    Attributes
    ----------
    name : str
    fun : callable
        ``fun(t, y, *args)`` in plain Python, which Numba compiles.
    t_span : tuple
    y0 : list or ndarray
    args : tuple
    code : str
        Name of the C++ function in reference.cpp, empty if there is none.
    terms : callable, optional
        The equations over a namespace, for formulas.
    into : callable, optional
        ``into(t, y, d)``, the right-hand side in loops, written into d; there are no `args`.
    arrays : callable, optional
        The equations over a namespace of whole arrays, where `terms` would be too many.
    """

    name: str
    fun: Any
    t_span: tuple
    y0: Any
    args: tuple
    code: str = ""
    terms: Callable | None = None
    into: Callable | None = None
    arrays: Callable | None = None


def small(terms, t_end, y0, args, name="", code=""):
    """A problem of few components, from t = 0."""
    word = terms.__name__
    return Problem(name or word, terms(math), (0.0, t_end), y0, args, code or word, terms)


def in_place(problem):
    """``into(t, y, d)`` compiled, the parameters constants of the code."""
    if problem.into is not None:
        return njit(problem.into)
    inner, n, args = njit(problem.fun), len(problem.y0), problem.args

    @njit
    def into(t, y, d):
        rates = inner(t, y, *args)
        for i in range(n):
            d[i] = rates[i]

    return into


def compiled(problem):
    """``fun(t, y)`` compiled, as a user of SciPy writes it: it gives an array."""
    into = in_place(problem)

    @njit
    def fun(t, y):
        d = np.empty(y.size)
        into(t, y, d)
        return d

    return fun


def _large(name, into, t_end, y0, code, **others):
    def fun(t, y):
        d = np.empty_like(y)
        into(t, y, d)
        return d

    return Problem(name, fun, (0.0, t_end), y0, (), code, into=into, **others)


def _satellite(e):
    start = [1.0, 0.0, 0.0, math.sqrt(1.0 + e)]
    return small(equations.satellite, 100.0, start, (1.0,), f"satellite, e = {e:g}")


def _vehicle():
    """In motion from the start: at rest |v| v has no Taylor series."""
    slope = math.tan(0.1)  # the front wheel's angle at t = 0, L = 1
    start = [0.0, 0.0, 0.0, 1.0, -0.5 * slope, slope]
    return small(equations.vehicle, 20.0, start, (1.0, 1.0, 0.1), "vehicle", "vehicle_explicit")


def _pleiades():
    places = [3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4]
    rates = [0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0]
    start = np.array([*places, *rates], dtype=float)
    into, arrays = equations.pleiades_into, equations.pleiades_arrays
    return _large("Pleiades", into, 3.0, start, "pleiades", terms=equations.pleiades, arrays=arrays)


SATELLITE, PROJECTILE, PENDULUM = PROBLEMS = (
    _satellite(0.0)._replace(name="satellite"),
    small(equations.projectile, 5.0, [0.0, 0.0, 0.0, 10.0, 10.0, 20.0], (0.5, 9.81)),
    small(equations.pendulum, 20.0, [0.0, 0.1], (9.81, 1.0)),
)
BUILDING = SYSTEMS["building"]()
LEAP = (0.994, 0.0, 0.0, -2.00158510637908252240537862224)
WORK = (
    _satellite(0.0),
    _satellite(0.3),
    _satellite(0.6),
    PROJECTILE._replace(name="projectile with drag"),
    small(equations.building, 20.0, list(BUILDING.initial_state()), BUILDING.args[:6]),
    PENDULUM._replace(name="pendulum, swinging", y0=[0.0, 5.0]),
    small(
        equations.constrained_pendulum, 20.0, [0.0, 1.0, 4.0, 0.0], (9.81,), "constrained pendulum"
    ),
    _vehicle(),
    small(equations.arenstorf, 17.0652165601579625588917206249, LEAP, (0.012277471,), "Arenstorf"),
    _pleiades(),
    small(equations.lorenz, 10.0, [1.0, 1.0, 1.0], (10.0, 28.0, 8.0 / 3.0), "Lorenz"),
    small(equations.henon_heiles, 100.0, [0.0, 0.1, 0.5, 0.0], (), "Hénon-Heiles"),
)


def five_equations(t, w, g, l, m, rate):  # noqa: E741
    """The constrained pendulum as the course writes it, the whole matrix at each evaluation."""
    x, y, vx, vy = w
    r = m * math.sqrt(x * x + y * y)
    solved = solve_linear(
        (
            (1.0, 0.0, 0.0, 0.0, 0.0),
            (0.0, 1.0, 0.0, 0.0, 0.0),
            (0.0, 0.0, 1.0, 0.0, x / r),
            (0.0, 0.0, 0.0, 1.0, y / r),
            (0.0, 0.0, x, y, 0.0),
        ),
        (vx, vy, 0.0, g, -vx * vx - vy * vy),
    )
    return [solved[0], solved[1], solved[2], solved[3]]


def course():
    """The systems of the course that have a C++ counterpart, t = 20."""
    pairs = [PENDULUM]
    for name in ("building", "pendulum_xy", "vehicle"):
        system = SYSTEMS[name]()
        start = list(system.initial_state())
        pairs.append(Problem(name, system.rhs, (0.0, 20.0), start, system.args, name))
    whole = pairs[2]._replace(name="pendulum_xy, 5x5 as in C++", fun=five_equations)
    return [*pairs, whole]


def chain_of(n):
    """A chain of n / 2 equal masses on springs between two walls, one end plucked."""
    y0 = np.zeros(n)
    y0[0] = 1.0
    into, arrays = equations.chain_into, equations.chain_arrays
    return _large(f"chain {n}", into, 20.0, y0, CHAIN, arrays=arrays)


def bodies_of(count):
    """`count` bodies of one mass in all, at rest at random places of the unit cube."""
    half = 3 * count
    y0 = np.zeros(2 * half)
    y0[:half] = np.random.default_rng(1).random(half)
    into, arrays = equations.bodies_into, equations.bodies_arrays
    return _large(f"{count} bodies", into, 0.01, y0, BODIES, arrays=arrays)


@functools.cache
def _stored():
    return json.loads(REFERENCES.read_text())


def reference(problem):
    """The end state.

    From references.json for the problems of the work-precision diagrams; the chain by its normal
    modes, which the sine transform finds; else by DOP853 at rtol 1e-13.
    """
    t = problem.t_span[1]
    for other in WORK:
        same = (problem.terms, problem.t_span, list(problem.y0), problem.args)
        if problem.terms and same == (other.terms, other.t_span, list(other.y0), other.args):
            return np.array([float(word) for word in _stored()[other.name]["y"]])
    if problem.into is equations.chain_into:
        m = len(problem.y0) // 2
        w = 2.0 * np.sin(np.arange(1, m + 1) * np.pi / (2 * (m + 1)))
        a = dst(problem.y0[:m], type=1)
        return np.r_[idst(a * np.cos(w * t), type=1), idst(-a * w * np.sin(w * t), type=1)]
    fun = problem.fun if problem.into is None else compiled(problem)
    given = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    args = problem.args if problem.into is None else None
    return solve_ivp(fun, problem.t_span, problem.y0, args=args, **given).y[:, -1]


def error(y, exact):
    """The largest error of a component, relative to the largest component."""
    return float(np.max(np.abs(y - exact)) / np.max(np.abs(exact)))
