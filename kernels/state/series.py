"""The rows of the work array that hold a Taylor series.

The rows from K on are the coefficients: y(t_old + s) = sum(row[K + k] (s / scale)^k).
"""

from .record import K

HIGHEST = 25  # order of the series
LOW, SCALE = K + HIGHEST + 1, K + HIGHEST + 2  # the rounding error of the state; the unit of time
N_ROWS = HIGHEST + 3
