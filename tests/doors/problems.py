"""Problems of two open reports about gradients after events, and a pendulum."""

import numpy as np

TIMES = np.linspace(0.5, 3.0, 6)
TIGHT = {"rtol": 1e-11, "atol": 1e-11}


def pendulum(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


def chain(t, y, stiffness):
    """Masses on a line between two walls; each spring has its own stiffness."""
    x, v = np.split(y, 2)
    stretch = np.concatenate((x[:1], x[1:] - x[:-1], -x[-1:]))
    force = stiffness * (stretch + 0.1 * stretch**3)
    return np.concatenate((v, force[1:] - force[:-1]))


def first_up(t, y, stiffness):
    return y[2]


first_up.terminal, first_up.direction = 2, 1


def cannonball(t, y, drag):
    """diffrax #451: range, height, speed and angle of a ball with air drag."""
    _, _, v, angle = y
    slowed = 0.5 * 1.225 * v**2 * 0.005 * drag
    return [
        v * np.cos(angle), v * np.sin(angle), -slowed - 9.80665 * np.sin(angle),
        -9.80665 * np.cos(angle) / v,
    ]  # fmt: skip


def height(t, y, drag):
    return y[1]


height.terminal, height.direction = True, -1


def fall(t, y, k):
    """A ball that falls from height 10 with drag proportional to its speed."""
    return [y[1], -9.81 - k * y[1]]


def ground(t, y, k):
    return y[0]


ground.terminal, ground.direction = True, -1


def time_of_fall(k, g=9.81, h=10.0):
    """The time of the fall, and its derivative by k, from the closed form of the height."""
    t = np.sqrt(2 * h / g)
    for _ in range(50):  # Newton
        e = np.exp(-k * t)
        t -= (h - g / k * t + g / k**2 * (1 - e)) / (-g / k * (1 - e))
    e = np.exp(-k * t)
    by_k = g / k**2 * t - 2 * g / k**3 * (1 - e) + g / k**2 * t * e
    return t, by_k / (g / k * (1 - e))


def ramp(t, y, end):
    """diffrax #729: a state that grows at the rate of another one, until the time `end`."""
    return [y[1], 0.0]


def reached(t, y, end):
    return t - end


def stop(t, y, end):
    return [y[0], 0.0]
