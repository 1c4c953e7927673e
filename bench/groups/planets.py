"""The outer planets for 10^6 years: time, and the energy error of many starts, beside others."""

import math

import numpy as np

from .. import rivals
from ..problems import outer_planets

LOOKS = 100  # of each run
STARTS = 64


def rows(quick):
    """Seconds for the whole time, and the root mean square of the energy error over the starts."""
    years, starts = (1e3, 2) if quick else (1e6, STARTS)
    times = np.linspace(0.0, years, LOOKS + 1)[1:]
    first = None
    for name, make in rivals.planets(times).items():
        go, few = make()
        seconds, errors, n_steps = [], [], None
        for seed in range(min(few, starts)):
            y0 = outer_planets.start(seed)
            spent, states, n_steps = go(y0)
            energy = outer_planets.energy(np.vstack([y0, states]))
            seconds.append(spent)
            errors.append(np.asarray(energy[1:] / energy[0] - 1.0, float))
        rms = np.sqrt(np.mean(np.square(errors), axis=0))
        first = first or min(seconds)
        yield {
            "solver": name,
            "years": years,
            "starts": len(errors),
            "seconds": min(seconds),
            "of_first": min(seconds) / first,
            "steps": n_steps,
            "rms_tenth": float(rms[LOOKS // 10 - 1]),
            "rms_end": float(rms[-1]),
            "mean_end": float(np.mean(errors, axis=0)[-1]),
            "brouwer": 2.0**-53 * math.sqrt(n_steps) if n_steps else None,
        }
