"""The types of the arguments of the loop over paths of stochastic equations."""

import numpy as np

from fastdyn.kernels.noise.arguments import RUN, Places

from . import ROW, TABLE, WORDS, kernel_of

PATHS = kernel_of(
    np.empty(0, RUN), WORDS, TABLE, TABLE, TABLE, Places(ROW, TABLE, TABLE, ROW, TABLE)
)
