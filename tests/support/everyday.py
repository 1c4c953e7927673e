"""Everyday functions, many alike: what processes that share a cache must not mix up."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

import fastdyn
from fastdyn import systems

A = np.array([[0.0, 1.0], [-3.0, -0.2]])
B = np.array([[0.0, 1.0], [-5.0, -0.2]])
STIFFNESS = 1.5


class Case(NamedTuple):
    """A problem over (0, 1); `fold` is a Fold, `events` and `project` are functions."""

    fun: Any
    args: tuple = ()
    y0: tuple = (1.0, 0.5)
    events: Any = None
    project: Any = None
    fold: Any = None


def rate(t, y, k):
    return -k * y


def rate_of(t, y, k):
    return [-k * x for x in y]


def first(t, y):
    return [-0.5 * y[0], -0.25 * y[1]]


def second(t, y):
    return [-1.5 * y[0], -0.25 * y[1]]


def third(t, y):
    return [-4 * y[0], -0.25 * y[1]]


def pull(x):
    return -2.0 * x


def push(x):
    return 3.0 * x


def by_pull(t, y):
    return [y[1], pull(y[0])]


def by_push(t, y):
    return [y[1], push(y[0])]


def with_helper(k):
    def helper(x):
        return -k * math.sin(x)

    def swinging(t, y):
        return [y[1], helper(y[0])]

    return swinging


def with_other_helper(k):
    def helper(x):
        return -k * math.tanh(x)

    def swinging(t, y):
        return [y[1], helper(y[0])]

    return swinging


@njit
def jitted(x):
    return -1.25 * x


def by_jitted(t, y):
    return [y[1], jitted(y[0])]


def looped(t, y):
    total = 0.0
    for i in range(3):
        total += (i + 1) * y[0]
    return [y[1], -total]


def looped_more(t, y):
    total = 0.0
    for i in range(4):
        total += (i + 1) * y[0]
    return [y[1], -total]


def while_loop(t, y, n):
    total, i = 0.0, 0
    while i < n:
        total += y[0] / (1 + i)
        i += 1
    return [y[1], -total]


def solved(t, y):
    return np.linalg.solve(np.array([[2.0, 0.5], [0.5, 1.0]]), -y)


def solved_too(t, y):
    return np.linalg.solve(np.array([[4.0, 0.5], [0.5, 1.0]]), -y)


def inverted(t, y):
    return np.linalg.inv(np.eye(2) * 2.0 - A) @ y


def times_a(t, y):
    return A @ y


def times_b(t, y):
    return B @ y


def of_matrix(t, y, matrix):
    return matrix @ y


def sliced(t, y):
    d = np.empty(2)
    d[:1] = y[1:]
    d[1:] = -2.0 * y[:1]
    return d


def filled(t, y):
    d = np.zeros(2)
    d[0], d[1] = y[1], -3.0 * y[0]
    return d


def flagged(t, y, on):
    return [y[1], -y[0] if on else y[0]]


def of_tuple(t, y, both):
    a, b = both
    return [a * y[1], -b * y[0]]


def of_list(t, y, both):
    return [both[0] * y[1], -both[1] * y[0]]


def of_count(t, y, n):
    return [y[1], -n * y[0] / 2]


def of_global(t, y):
    return [y[1], -STIFFNESS * y[0]]


def closed_over(k):
    return lambda t, y: [y[1], -k * y[0]]


def closed_over_whole(k):
    return lambda t, y: [-y[0] * 2**k, -y[1]]


def of_time(t, y):
    return [math.cos(t), y[0]]


def of_time_too(t, y):
    return [math.sin(t), y[0]]


def by_parts(t, y):
    return [0.0, -y[0]] if t < 0.5 else [y[1], 0.0]


def complex_inside(t, y):
    z = (y[0] + 1j * y[1]) * (0.5j - 0.1)
    return [z.real, z.imag]


def quadratic(t, y):
    return [y[1], -y[0] * y[0]]


def halfway(t, y):
    return y[0] - 0.9


def threshold(t, y):
    return y[0] - 0.95


def damped(t, y):
    return [y[1], -2.0 * y[0] - 0.1 * y[1]]


def to_circle(t, y):
    r = math.hypot(y[0], y[1])
    return [y[0] / r, y[1] / r]


def to_ellipse(t, y):
    r = math.hypot(y[0], 2.0 * y[1])
    return [y[0] / r, y[1] / r]


def turning(t, y):
    return [y[1], -y[0]]


def smaller(value, t, y):
    return min(value, y[0])


def summed(value, t, y):
    return value + y[0] * y[0]


def of_all_kinds(t, y):
    """Makes Numba load what most of the others need."""
    a = np.array([[1.0, math.sin(t)], [0.0, 1.0]])
    z = np.linalg.solve(a, -0.75 * y)
    return [(a @ y)[1], z[0]]


class Oscillator:
    def __init__(self, k):
        self.k = k

    def motion(self, t, y):
        return [y[1], -self.k * y[0]]

    def __call__(self, t, y):
        return [y[1], -2.0 * self.k * y[0]]


def steered(t, w):
    return 0.1 + 0.1 * math.sin(2.0 * t), 0.2 * math.cos(2.0 * t), 0.3


def held(t, w):
    return 0.1, 0.0, 0.1


def of_system(system):
    return Case(system.rhs, system.args, tuple(system.initial_state()))


CASES = {
    "first": Case(of_all_kinds),
    "int 2": Case(rate, (2,)),
    "float 2.5": Case(rate, (2.5,)),
    "bool": Case(rate, (True,)),
    "int 3, list": Case(rate_of, (3,)),
    "float 3.5, list": Case(rate_of, (3.5,)),
    "-0.5": Case(first),
    "-1.5": Case(second),
    "-4": Case(third),
    "pull": Case(by_pull),
    "push": Case(by_push),
    "helper": Case(with_helper(1.0)),
    "helper 2": Case(with_helper(2.0)),
    "other helper": Case(with_other_helper(1.0)),
    "jitted": Case(by_jitted),
    "loop": Case(looped),
    "longer loop": Case(looped_more),
    "while": Case(while_loop, (3,)),
    "solve": Case(solved),
    "solve too": Case(solved_too),
    "inv": Case(inverted),
    "A @ y": Case(times_a),
    "B @ y": Case(times_b),
    "matrix": Case(of_matrix, (A,)),
    "strided matrix": Case(of_matrix, (np.zeros((4, 4))[::2, ::2] - np.eye(2),)),
    "slices": Case(sliced),
    "filled": Case(filled),
    "true": Case(flagged, (True,)),
    "false": Case(flagged, (False,)),
    "tuple": Case(of_tuple, ((1.0, 2.0),)),
    "tuple of int": Case(of_tuple, ((1, 2.0),)),
    "list": Case(of_list, ([1.0, 2.0],)),
    "count": Case(of_count, (3,)),
    "global": Case(of_global),
    "closure": Case(closed_over(2.0)),
    "closure of int": Case(closed_over_whole(1)),
    "closure of int 2": Case(closed_over_whole(2)),
    "cos": Case(of_time),
    "sin": Case(of_time_too),
    "branch": Case(by_parts),
    "complex": Case(complex_inside),
    "quadratic": Case(quadratic),
    "partial": Case(functools.partial(of_count, n=5)),
    "method": Case(Oscillator(2.0).motion),
    "callable": Case(Oscillator(2.0)),
    "event": Case(damped, events=halfway),
    "event too": Case(damped, events=threshold),
    "circle": Case(turning, y0=(0.6, 0.8), project=to_circle),
    "ellipse": Case(turning, y0=(0.6, 0.4), project=to_ellipse),
    "fold": Case(damped, fold=fastdyn.Fold(smaller, 1e9)),
    "fold too": Case(damped, fold=fastdyn.Fold(summed)),
    "vehicle": of_system(systems.vehicle(driver=steered)),
    "vehicle too": of_system(systems.vehicle(driver=held)),
    "satellite": of_system(systems.satellite(V=1.1)),
    "rod": of_system(systems.rod()),
}
