"""Boundary value problems by collocation."""
