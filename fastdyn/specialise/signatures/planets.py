"""The types of the arguments of the steps of WisdomHolman."""

import numpy as np

from fastdyn.kernels.methods.wisdom_holman.steps import CALLS, Motion, Room

from . import ROW, STATES, kernel_of

MOTION = Motion(*[ROW] * len(Motion._fields))
ROOM = Room(*[ROW] * len(Room._fields))
TAKE_STEPS = kernel_of(STATES, np.empty(0, CALLS), MOTION, MOTION, ROOM, ROW, 0)
