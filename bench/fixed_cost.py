"""What a call costs whatever it solves: the satellite over 28 steps."""

import numpy as np
import scipy.integrate

import fastdyn

from .problems import PROBLEMS
from .timing import interleaved

TARGET = 40


def rows(quick):
    """Times of one call, and how many times SciPy's is longer."""
    p = PROBLEMS[0]
    for label, t_eval in (("default output", None), ("1000 points", np.linspace(0, 20, 1000))):
        given = {"t_span": (0.0, 20.0), "y0": p.y0, "args": p.args, "t_eval": t_eval}
        fastdyn.solve_ivp(p.fun, **given, tier="specialised")
        times = interleaved(
            {
                "fastdyn": lambda given=given: fastdyn.solve_ivp(p.fun, **given),
                "SciPy": lambda given=given: scipy.integrate.solve_ivp(p.fun, **given),
            },
            20 if quick else 1000,
        )
        ratio = times["SciPy"][0] / times["fastdyn"][0]
        yield {
            "output": label,
            "fastdyn_us": times["fastdyn"][0] * 1e6,
            "scipy_us": times["SciPy"][0] * 1e6,
            "scipy_over_fastdyn": ratio,
            "target": f">= {TARGET}",
            "met": bool(ratio >= TARGET),
        }
