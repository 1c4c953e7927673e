"""The problems: right-hand sides, initial states, spans, and exact or reference end states."""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.fft import dst, idst
from scipy.integrate import solve_ivp
from scipy.special import ellipj

from fastdyn import solve_linear
from fastdyn.systems import SYSTEMS


class Problem(NamedTuple):
    """A right-hand side with its data; `args` are its parameters after (t, y)."""

    name: str
    fun: Any
    t_span: tuple
    y0: list
    args: tuple
    code: str = ""

    @property
    def entry(self):
        """Name of the C++ function in reference.cpp, that of `fun` unless `code` says another."""
        return self.code or self.fun.__name__


def satellite(t, w, GM):
    """Point mass on a plane orbit: [x, y, vx, vy]."""
    x, y, vx, vy = w
    r2 = x * x + y * y
    c = -GM / (r2 * math.sqrt(r2))
    return [vx, vy, c * x, c * y]


def projectile(t, w, drag, g):
    """Throw with quadratic drag, z upwards: [x, y, z, vx, vy, vz]."""
    vx, vy, vz = w[3], w[4], w[5]
    s = drag * math.sqrt(vx * vx + vy * vy + vz * vz)
    return [vx, vy, vz, -s * vx, -s * vy, -s * vz - g]


def pendulum(t, w, g, length):
    """Mathematical pendulum: [angle, its rate]."""
    theta, omega = w
    return [omega, -(g / length) * math.sin(theta)]


def chain(t, y):
    """Unit masses on unit springs between two walls: [q, v]."""
    n = y.size // 2
    out = np.empty(y.size)
    q = y[:n]
    out[:n] = y[n:]
    out[n + 1 : -1] = q[:-2] - 2.0 * q[1:-1] + q[2:]
    out[n] = q[1] - 2.0 * q[0]
    out[-1] = q[-2] - 2.0 * q[-1]
    return out


def five_equations(t, w, g, l, V0, m, rate):  # noqa: E741
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
    pairs = [PROBLEMS[2]]
    for name in ("building", "pendulum_xy", "vehicle"):
        system = SYSTEMS[name]()
        start = list(system.initial_state())
        pairs.append(Problem(name, system.rhs, (0.0, 20.0), start, system.args, name))
    whole = pairs[2]._replace(name="pendulum_xy, 5x5 as in C++", fun=five_equations)
    return [*pairs, whole]


PROBLEMS = (
    Problem("satellite", satellite, (0.0, 100.0), [1.0, 0.0, 0.0, 1.0], (1.0,)),
    Problem("projectile", projectile, (0.0, 5.0), [0.0, 0.0, 0.0, 10.0, 10.0, 20.0], (0.5, 9.81)),
    Problem("pendulum", pendulum, (0.0, 20.0), [0.0, 0.1], (9.81, 1.0)),
)


def chain_of(n):
    """A chain of n / 2 equal masses on springs between two walls, one end plucked."""
    y0 = np.zeros(n)
    y0[0] = 1.0
    return Problem(f"chain {n}", chain, (0.0, 20.0), y0, ())


def reference(problem):
    """The end state: exact where a formula is known, else DOP853 at rtol 1e-13.

    The circular orbit; the pendulum from the bottom by Jacobi's elliptic functions
    (sin(theta/2) = k sn(w t), k = theta'(0) / 2w < 1); the chain by its normal modes, which the
    sine transform finds.
    """
    t = problem.t_span[1]
    if problem.fun is satellite:
        return np.array([math.cos(t), math.sin(t), -math.sin(t), math.cos(t)])
    if problem.fun is pendulum:
        w = math.sqrt(problem.args[0] / problem.args[1])
        k = problem.y0[1] / (2.0 * w)
        sn, cn, _, _ = ellipj(w * t, k * k)
        return np.array([2.0 * math.asin(k * sn), 2.0 * k * w * cn])
    if problem.fun is chain:
        m = len(problem.y0) // 2
        w = 2.0 * np.sin(np.arange(1, m + 1) * np.pi / (2 * (m + 1)))
        a = dst(problem.y0[:m], type=1)
        return np.r_[idst(a * np.cos(w * t), type=1), idst(-a * w * np.sin(w * t), type=1)]
    r = solve_ivp(
        problem.fun, problem.t_span, problem.y0, "DOP853", rtol=1e-13, atol=1e-14, args=problem.args
    )
    return r.y[:, -1]
