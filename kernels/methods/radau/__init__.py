"""Radau IIA of order 5, with SciPy's steps."""
