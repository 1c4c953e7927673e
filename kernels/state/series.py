"""Where the rows of the work array hold a Taylor series.

Those from K on are its coefficients: y(t_old + s) = sum(row[K + k] (s / scale)^k).
"""

from .record import K

HIGHEST = 25  # order of the series
LOW, SCALE = K + HIGHEST + 1, K + HIGHEST + 2  # what is rounded off the state; the unit of time
N_ROWS = HIGHEST + 3
