"""Numba's entry point: it registers the functions of fastdyn that `@njit` code may call."""


def init():
    """Register `solve_linear` and `constrained`."""
    from fastdyn.kernels.algebra import for_numba  # noqa: F401
