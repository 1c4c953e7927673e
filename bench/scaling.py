"""Time a step and component against the number of components: a chain of springs."""

import scipy.integrate
from numba import njit

import fastdyn

from . import cpp
from .problems import chain, chain_of, reference
from .timing import interleaved

RTOL, ATOL = 1e-6, 1e-9
GROWTH = 1.1


def rows(quick):
    """Nanoseconds a step and component, for fastdyn, SciPy with the jitted function, and C++.

    `growth` is fastdyn's time over its least at any shorter chain; above one it grows, and
    GROWTH leaves room for noise.
    """
    jitted = njit(chain)
    least = float("inf")
    for n in (10, 100) if quick else (10, 100, 1000, 10_000):
        problem = chain_of(n)
        t_end = problem.t_span[1]
        given = {"t_span": problem.t_span, "y0": problem.y0, "t_eval": [t_end]}
        given |= {"rtol": RTOL, "atol": ATOL}
        r = fastdyn.solve_ivp(chain, **given, tier="specialised")
        scipy.integrate.solve_ivp(jitted, **given)
        steps = r.n_accepted + r.n_rejected
        references = cpp.solvers(problem, 5, RTOL, ATOL)
        times = interleaved(
            {
                "fastdyn": lambda g=given: fastdyn.solve_ivp(chain, **g),
                "SciPy": lambda g=given: scipy.integrate.solve_ivp(jitted, **g),
                **references,
            },
            3 if quick else 200,
            0.5 if quick else 4.0,
        )
        each = {name: best / (steps * n) * 1e9 for name, (best, _) in times.items()}
        ours, theirs = each["fastdyn"], each["SciPy"]
        fastest = min((each[name] for name in references), default=None)
        growth, least = ours / min(least, ours), min(least, ours)
        yield {
            "n": n,
            "steps": steps,
            "error": float(abs(r.y[:, -1] - reference(problem)).max()),
            "fastdyn_ns": ours,
            "scipy_njit_ns": theirs,
            "cpp_ns": fastest,
            "of_scipy": ours / theirs,
            "of_fastest_cpp": ours / fastest if fastest else None,
            "growth": growth,
            "target": f"of_scipy <= 1, growth <= {GROWTH}",
            "met": bool(ours <= theirs and growth <= GROWTH),
        }
