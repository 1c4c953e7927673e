"""Compiled kernels: methods, the loops over steps, and the parts of methods and loops."""
