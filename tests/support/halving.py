"""A function of a number that only Numba compiles."""


def halved(x):
    """A loop that tracing refuses: its end depends on x."""
    x = abs(x) + 1.0
    while x > 1e-3:
        x /= 2
    return x
