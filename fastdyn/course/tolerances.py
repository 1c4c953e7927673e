"""Tolerances of the lessons: how much a computed value may differ from the exact one."""

import numpy as np


def tolerated(run, rtol, atol):
    """What `rtol` and `atol` let all steps of a run add to a component, before it grows."""
    return run.n_accepted * (atol + rtol * np.abs(run.y).max())
