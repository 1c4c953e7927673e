"""Stiff problems of the literature, small ones."""

from typing import Any, NamedTuple

import numpy as np

from bench.problems.stiff import hires, robertson

EPS = np.finfo(float).eps


def robertson_jacobian(t, y):
    _, b, c = y
    return [
        [-0.04, 1e4 * c, 1e4 * b],
        [0.04, -1e4 * c - 6e7 * b, -1e4 * b],
        [0.0, 6e7 * b, 0.0],
    ]


def van_der_pol(t, y, mu):
    return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]


def van_der_pol_jacobian(t, y, mu):
    return np.array([[0.0, 1.0], [-2 * mu * y[0] * y[1] - 1.0, mu * (1 - y[0] ** 2)]])


def spring(t, y):
    return [y[1], -y[0]]


def heat(t, y):
    """The heat equation by the method of lines, with a source that depends on the temperature."""
    inner = np.zeros(len(y) + 2)
    inner[1:-1] = y
    n = len(y) + 1
    return n * n * (inner[2:] - 2.0 * y + inner[:-2]) + np.exp(-y)


class Problem(NamedTuple):
    """What `solve_ivp` takes."""

    fun: Any
    t_span: tuple
    y0: list
    options: dict
    args: tuple = ()


PROBLEMS = {
    "Robertson": Problem(robertson, (0, 1e5), [1.0, 0.0, 0.0], {}),
    "van der Pol": Problem(
        van_der_pol, (0, 1500), [2.0, 0.0], {"rtol": 1e-5, "atol": 1e-7}, (1e3,)
    ),
    "HIRES": Problem(hires, (0, 321.8122), [1, 0, 0, 0, 0, 0, 0, 0.0057], {"atol": 1e-7}),
    "spring": Problem(spring, (0, 5), [1.0, 0.0], {"rtol": 1e-7, "atol": 1e-9}),
    "back": Problem(
        spring, (5, 0), [1.0, 0.0], {"rtol": 1e-4, "max_step": 0.3, "first_step": 0.01}
    ),
    "heat": Problem(heat, (0, 2), list(np.ones(30)), {"rtol": 1e-5, "atol": 1e-8}),
}


def in_other_roundings(problem, seed):
    """The problem with each component of the derivative off by a unit in the last place."""
    off = 1.0 + EPS * np.random.default_rng(seed).choice([-1.0, 1.0], len(problem.y0))
    return problem._replace(fun=lambda t, y, *args: off * problem.fun(t, y, *args))


def counts(run):
    return len(run.t), run.nfev, run.njev, run.nlu, run.status


def solved(solve, problem, method, **options):
    p = problem
    with np.errstate(invalid="ignore"):  # SciPy's BDF subtracts memory that nobody has written
        return solve(p.fun, p.t_span, p.y0, method, args=p.args, **p.options, **options)
