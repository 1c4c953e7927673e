"""Kernels around one right-hand side: by pointer, inlined in registers, and on vectors."""
