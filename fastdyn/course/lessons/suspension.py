"""The suspension's lesson: free vibration (course 3.3.2, example 2)."""

import math

import numpy as np

from fastdyn.course.tolerances import TIGHT, tolerated
from fastdyn.systems.suspension import Suspension


def lesson(board):
    suspension = Suspension()
    run = suspension.solve(**TIGHT, events="turning", dense_output=True)
    board.say(
        """Released from rest, the vehicle swings about its static deflection. The deflection
        alone tells the frequency: w = sqrt(g / deflection). Tolerated: each step adds its
        rtol and atol; an error e of position or velocity becomes at most (w + 1/w + 1) e."""
    )
    w = suspension.natural_frequency
    allowed = tolerated(run) * (1.0 + w + 1.0 / w)
    board.zero("largest error of the state", run.error(), allowed)
    turns = run.t_events[0][run.t_events[0] > 0.1 * suspension.period]
    period = 2.0 * turns[-1] / len(turns)
    tolerance = 2.0 * allowed / (w**2 * suspension.amplitude) / len(turns)
    board.check("period from the turning points (s)", period, suspension.period, tolerance)
    x = run.y[0]
    middle = 0.5 * (run.y_events[0][1][0] + run.y_events[0][2][0])
    board.check("middle of the swing (m)", middle, suspension.equilibrium, allowed)
    board.check("amplitude (m)", x.max() - middle, suspension.amplitude, 2.0 * allowed)
    frequency = math.sqrt(suspension.g / suspension.static_deflection)
    board.check("sqrt(g / deflection) (rad/s)", frequency, w, 4e-15 * w)
    change = np.ptp(run.invariants()["energy"])
    force = suspension.k * suspension.amplitude + suspension.m * w * suspension.amplitude
    board.check("change of the energy (J)", change, 0.0, allowed * force)
    released = Suspension(x0=0.43).solve(dense_output=True)  # amplitude and deflection differ
    board.figure("suspension", released.plot(label="computed, released at 0.43 m"))
