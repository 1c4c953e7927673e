"""y'' = -2 y in every way a function can be written."""

import functools

import numpy as np
from numba import njit

STIFFNESS = 2.0

MATRIX = np.array([[0.0, 1.0], [-2.0, 0.0]])


class Settings:
    k = 2.0


SETTINGS = Settings()


def pull(x):
    return -STIFFNESS * x


class Oscillator:
    def __init__(self, k):
        self.k, self.matrix = k, MATRIX

    def method(self, t, y):
        return [y[1], -self.k * y[0]]

    def acceleration(self, x):
        return -self.k * x

    def calls_method(self, t, y):
        return np.array([y[1], self.acceleration(y[0])])

    def __call__(self, t, y):
        return self.matrix @ y


def returns_list(t, y):
    return [y[1], -2 * y[0]]


def returns_array(t, y):
    return np.array([y[1], -STIFFNESS * y[0]], dtype=float)


def returns_tuple(t, y):
    x, v = y
    return v, pull(x)


def returns_variable(t, y):
    dydt = [y[1], -2.0 * y[0]]
    return dydt


def fills_zeros(t, y):
    out = np.zeros(2)
    out[0], out[1] = y[1], -2 * y[0]
    return out


def fills_like(t, y):
    out = np.empty_like(y)
    out[:] = y[::-1]
    out[1] *= -2
    return out


def slices(t, y):
    return np.concatenate((y[1:], -2 * y[:1]))


def doubles_slices(t, y):
    return (y[::-1] + y[::-1]) * np.array([0.5, -1.0])


def writes_to_y(t, y):
    y[0] = max(y[0], -10.0)
    return [y[1], -2 * y[0]]


def fills_list(t, y):
    out = [0.0] * 2
    out[0], out[1] = y[1], -2 * y[0]
    return out


def comprehends(t, y):
    return np.array([v * 1.0 for v in (y[1], -2 * y[0])])


def branches(t, y):
    if t < 1:
        return [y[1], -2 * y[0]]
    return [y[1], -2.0 * y[0]]


def has_inner(t, y):
    def inner(x):
        return -2 * x

    return [y[1], inner(y[0])]


def reads_object(t, y):
    return [y[1], -SETTINGS.k * y[0]]


def reads_class(t, y):
    return [y[1], -Settings.k * y[0]]


def takes(t, y, k=2.0):
    return [y[1], -k * y[0]]


def takes_matrix(t, y, factor, matrix):
    return matrix @ y * factor


def takes_nested(t, y, values):
    a, (b, c) = values
    return [a * y[1], -b * c * y[0]]


def takes_any(t, y, *k):
    return [y[1], -k[0] * y[0]]


def takes_first(k, t, y):
    return [y[1], -k * y[0]]


def takes_function(t, y, g):
    return [y[1], g(y[0])]


def closure_over(k):
    return lambda t, y: [y[1], -k * y[0]]


OSCILLATOR = Oscillator(2.0)

CASES = {
    "list": (returns_list, ()),
    "array": (returns_array, ()),
    "tuple": (returns_tuple, ()),
    "variable": (returns_variable, ()),
    "zeros": (fills_zeros, ()),
    "empty_like": (fills_like, ()),
    "slices": (slices, ()),
    "slice arithmetic": (doubles_slices, ()),
    "list filled": (fills_list, ()),
    "comprehension": (comprehends, ()),
    "branches": (branches, ()),
    "inner function": (has_inner, ()),
    "object's attribute": (reads_object, ()),
    "class attribute": (reads_class, ()),
    "default": (takes, ()),
    "int for a float": (takes, (2,)),
    "array argument": (takes_matrix, (1.0, MATRIX)),
    "strided argument": (takes_matrix, (1, np.repeat(MATRIX, 2, axis=1)[:, ::2])),
    "nested tuple": (takes_nested, ((1.0, (2.0, 1)),)),
    "star": (takes_any, (2.0,)),
    "function argument": (takes_function, (pull,)),
    "lambda": (lambda t, y: [y[1], -2 * y[0]], ()),
    "closure": (closure_over(2.0), ()),
    "partial": (functools.partial(takes_first, 2.0), ()),
    "partial keyword": (functools.partial(takes, k=2.0), ()),
    "method": (OSCILLATOR.method, ()),
    "method calling method": (OSCILLATOR.calls_method, ()),
    "callable object": (OSCILLATOR, ()),
    "njit": (njit(returns_list), ()),
    "njit, typed": (njit("float64[:](float64, float64[:])")(fills_zeros), ()),
}
