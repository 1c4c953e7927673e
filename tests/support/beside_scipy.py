"""One short solve beside SciPy's."""

import numpy as np
from scipy.integrate import solve_ivp as reference

import fastdyn

START = np.array([0.4, 0.9])


def agrees(fun, *args):
    mine = fastdyn.solve_ivp(fun, (0.0, 1.0), START, args=args)
    theirs = reference(fun, (0.0, 1.0), START, args=args)
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=0)
