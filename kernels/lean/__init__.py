"""Numba's own passes that kernels need, and arrays that own no memory."""
