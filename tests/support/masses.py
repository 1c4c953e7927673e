"""M y' = f(t, y) of index 1: a component that decays, and one that follows from the first."""

import numpy as np

TAKE = ("Rodas5P", "Radau", "BDF")  # the methods that take a mass matrix
MASS = np.diag([1.0, 0.0])


def root(x):
    """The z of z + z^3 = x."""
    found = np.roots([1.0, 0.0, 1.0, -x])
    return float(found[np.abs(found.imag).argmin()].real)


def decaying(t, y, k=1.0):
    x, z = y
    return [-k * x, z + z**3 - x]


def half(t, y, k=1.0):
    return y[0] - 0.5


def refill(t, y, k=1.0):
    return [4.0 * y[0], 17.0]  # z is a guess, and what the action says of it does not count
