"""Time a step and component against the number of components: a chain of springs."""

import scipy.integrate
from numba import njit

import fastdyn

from .problems import chain, chain_of
from .timing import interleaved


def rows(quick):
    """Nanoseconds a step and component, for fastdyn and for SciPy with the jitted function."""
    jitted = njit(chain)
    for n in (10, 100) if quick else (10, 100, 1000, 10_000):
        problem = chain_of(n)
        given = {"t_span": problem.t_span, "y0": problem.y0, "t_eval": [20.0]}
        given |= {"rtol": 1e-6, "atol": 1e-9}
        r = fastdyn.solve_ivp(chain, **given, tier="specialised")
        steps = r.n_accepted + r.n_rejected
        times = interleaved(
            {
                "fastdyn": lambda g=given: fastdyn.solve_ivp(chain, **g),
                "SciPy": lambda g=given: scipy.integrate.solve_ivp(jitted, **g),
            },
            3 if quick else 50,
        )
        ours, theirs = (times[s][0] / (steps * n) * 1e9 for s in ("fastdyn", "SciPy"))
        yield {
            "n": n,
            "steps": steps,
            "fastdyn_ns": ours,
            "scipy_njit_ns": theirs,
            "target": "<= SciPy",
            "met": bool(ours <= theirs),
        }
