"""Delay equations that the tests of several files solve."""


def late(t, y, past, gain, tau):
    p = past(t - tau)
    return [-gain * p[1], p[0] - 0.2 * y[1]]


def mackey_glass(t, y, past, a, b, tau):
    p = past(t - tau)[0]
    return [a * p / (1 + p**10) - b * y[0]]
