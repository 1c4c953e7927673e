"""Solves of equations whose index is reduced: the run of the reduced state, and its result."""
