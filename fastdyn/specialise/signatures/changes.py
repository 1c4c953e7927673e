"""The types of the arguments of the kernel that decides which switching times matter."""

from fastdyn.kernels.output.changes import Limits

from . import ROW, TABLE, WORDS, kernel_of

DECIDE = kernel_of(WORDS, Limits(*[0.0] * 8), ROW, ROW, ROW, TABLE, TABLE, ROW)
