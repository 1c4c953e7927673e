"""Functions that compiled code would lose or garble: each makes a fresh one, some with an event."""

import math

import numpy as np

LIST = [2.0, 3.0]


def nonlocal_flag():
    fired = False

    def fun(t, y):
        nonlocal fired
        if y[0] < 0.6:
            fired = True
        return [0.0] if fired else [-y[0]]

    return fun


def with_event_that_sets_a_flag():
    fired = False

    def fun(t, y):
        return [-5.0 * y[0]] if fired else [-y[0]]

    def event(t, y):
        nonlocal fired
        if y[0] < 0.6:
            fired = True
        return y[0] - 0.6

    return fun, event


def with_event_that_sets_an_attribute():
    class Settings:
        k = 1.0

    settings = Settings()

    def event(t, y):
        if y[0] < 0.6:
            settings.k = 4.0
        return y[0] - 0.6

    return (lambda t, y: [-settings.k * y[0]]), event


def with_event_that_sets_an_item():
    box = [1.0]

    def event(t, y):
        if y[0] < 0.6:
            box[0] = 4.0
        return y[0] - 0.6

    return (lambda t, y: [-box[0] * y[0]]), event


def counting_array():
    log = np.zeros(1)

    def fun(t, y):
        log[0] += 1
        return [-log[0] * y[0] * 0.01]

    return fun


def counting_view():
    log = np.zeros(4)[::2]

    def fun(t, y):
        log[0] += 1
        return [-log[0] * y[0] * 0.01]

    return fun


def counting_list():
    log = []

    def fun(t, y):
        log.append(t)
        return [-len(log) * y[0] * 0.01]

    return fun


def random_numbers():
    return lambda t, y: [-y[0] * np.random.rand()]  # noqa: NPY002


def factorial():
    def fun(t, y):
        n = 1
        for i in range(1, 26):
            n *= i
        return [-y[0] * (n / 1.5e25)]

    return fun


def factorial_later():
    def fun(t, y):
        n = 1
        for i in range(1, 18 + int(10 * t)):
            n = i * n
        return [-y[0] * (1 + n % 7)]

    return fun


def power_of_whole_numbers():
    def fun(t, y):
        n = 3 + int(t)
        return [-y[0] * n**41 / 3**41]

    return fun


def shifted():
    def fun(t, y):
        n = 64 + int(t)
        return [-y[0] * (1 << n) / 2**64]

    return fun


def negated():
    def fun(t, y):
        n = -(2**63) + int(t)
        return [-y[0] * (-n - 1) / 2**63]

    return fun


def whole_of_float():
    return lambda t, y: [-y[0] * int(1e25 + t) / 1e25]


def floor_of_float():
    return lambda t, y: [-y[0] * math.floor(1e25 + t) / 1e25 * round(1e19) / 1e19]


def unassigned():
    def fun(t, y):
        if t < 0.5:
            k = 2.0
        return [-k * y[0]]

    return fun


def assigned_by_a_loop():
    def fun(t, y):
        for i in range(3):
            k = i
        return [-k * y[0]]

    return fun


def beyond_the_end():
    table = np.array([1.0, 2.0])
    return lambda t, y: [-table[int(4 * t)] * y[0]]


def complex_eigenvalues():
    matrix = np.array([[0.0, 1.0], [-1.0, 0.0]])
    return lambda t, y: [-y[0] + np.linalg.eigvals(matrix)[0].real]


def complex_later():
    """Numba's code gives up where the eigenvalues become complex."""

    def fun(t, y):
        x = 1.0 + abs(y[0])
        while x > 1e-9:  # no trace
            x /= 2
        matrix = np.array([[0.0, 1.0], [0.5 - t, x * 1e-9]])
        return [-y[0] * (1.0 + np.linalg.eigvals(matrix).real.max())]

    return fun


def sees_a_list():
    return lambda t, y: [-LIST[0] * y[0] * len(LIST)]


def repeated_list():
    def fun(t, y):
        twice = LIST * 2
        return [-twice[2] * y[0]]

    return fun


FUNCTIONS = [
    nonlocal_flag, with_event_that_sets_a_flag, with_event_that_sets_an_attribute,
    with_event_that_sets_an_item, counting_array, counting_view, counting_list, random_numbers,
    factorial, factorial_later, power_of_whole_numbers, shifted, negated, whole_of_float,
    floor_of_float, unassigned, assigned_by_a_loop, beyond_the_end, complex_eigenvalues,
    complex_later, sees_a_list, repeated_list,
]  # fmt: skip
