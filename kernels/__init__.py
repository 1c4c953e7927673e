"""Compiled kernels: methods, the loops around them, and what these are made of."""
