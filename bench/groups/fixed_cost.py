"""What a call costs whatever it solves: the satellite over thirty steps, and a thousand outputs."""

import numpy as np

from .. import rivals
from ..problems import SATELLITE, error, reference
from ..report.timing import interleaved

TOL, T_END = 1e-6, 9.0  # thirty steps of RK45
TARGET = 40
POINTS = 1000


def rows(quick):
    """Times of one call by every solver, and their ratio to solve_ivp of fastdyn."""
    problem = SATELLITE._replace(t_span=(0.0, T_END))
    exact = reference(problem)
    made = rivals.solvers(problem)
    for output, times in (("end", None), ("1000 points", np.linspace(0.0, T_END, POINTS))):
        runs = {name: prepare(TOL, times) for name, prepare in made.items()}
        runs = {name: run for name, run in runs.items() if run is not None}
        errors = {name: error(run(), exact) for name, run in runs.items()}
        seconds = interleaved(runs, 10 if quick else 500, 0.5 if quick else 10.0)
        mine = seconds["fastdyn RK45 by solve_ivp"][0]
        for name, (least, median) in seconds.items():
            ratio = least / mine
            judged = name == "SciPy RK45"
            yield {
                "output": output,
                "solver": name,
                "error": errors[name],
                "min_us": least * 1e6,
                "median_us": median * 1e6,
                "of_fastdyn": ratio,
                "target": f">= {TARGET}" if judged else "",
                "met": bool(ratio >= TARGET) if judged else None,
            }
