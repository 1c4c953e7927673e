"""Exceptions of Python's arithmetic."""


def divided_by_zero():
    """Raise ZeroDivisionError with Python's message."""
    return 1.0 / 0.0


def zero_to_a_negative_power():
    """Raise ZeroDivisionError with Python's message."""
    return 0.0**-1.0


def too_large_a_power():
    """Raise OverflowError with Python's message."""
    return 10.0**400.0
