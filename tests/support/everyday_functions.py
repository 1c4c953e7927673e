"""Everyday functions, many alike."""

import math

import numpy as np
from numba import njit

A = np.array([[0.0, 1.0], [-3.0, -0.2]])

B = np.array([[0.0, 1.0], [-5.0, -0.2]])

STIFFNESS = 1.5


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
