"""Tolerances of the lessons: how much a computed value may differ from the exact one."""

from typing import Any

import numpy as np

RTOL = 1e-9
ATOL = 1e-12
TIGHT: dict[str, Any] = {"rtol": RTOL, "atol": ATOL}


def tolerated(run, rtol=RTOL, atol=ATOL, axis=None):
    """The error that `rtol` and `atol` allow all steps of a run in a component, before it grows."""
    return run.n_accepted * (atol + rtol * np.abs(run.y).max(axis))
