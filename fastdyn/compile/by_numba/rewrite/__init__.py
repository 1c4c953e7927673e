"""Numba's reading of a user's function, changed where compiled code would differ from Python."""
