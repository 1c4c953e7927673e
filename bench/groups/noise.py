"""Nanoseconds a step and path of dX = -X dt + 0.2 dW: fastdyn, NumPy, a loop by Numba, diffrax."""

import functools
import math

import numpy as np

from fastdyn import solve_langevin, solve_sde

from ..report.timing import interleaved

STEPS, RATE, SIGMA = 1000, 1.0, 0.2
EXACT = math.exp(-RATE), SIGMA * math.sqrt((1.0 - math.exp(-2.0 * RATE)) / (2.0 * RATE))


def _fastdyn(paths, method, threads):
    def run():
        return solve_sde(
            lambda t, y: -RATE * y, SIGMA, (0, 1), [1.0], step=1.0 / STEPS, paths=paths, rng=1,
            method=method, threads=threads,
        ).y_end[:, 0]  # fmt: skip

    return run


def _langevin(paths):
    def run():
        return solve_langevin(
            lambda t, q: -q, (0, 1), [1.0], [0.0], friction=1.0, sigma=SIGMA, step=1.0 / STEPS,
            paths=paths, rng=1, threads=1,
        ).y_end[:, 0]  # fmt: skip

    return run


def _numpy(paths, draw):
    def run():
        x, h = np.ones(paths), 1.0 / STEPS
        kick = SIGMA * math.sqrt(h)
        for _ in range(STEPS):
            x += -RATE * x * h + kick * draw(paths)
        return x

    return run


@functools.cache
def _loop_of_numba():
    import numba

    @numba.njit
    def loop(paths, steps, generator):
        ends, h = np.empty(paths), 1.0 / steps
        kick = SIGMA * math.sqrt(h)
        for path in range(paths):
            x = 1.0
            for _ in range(steps):
                x += -RATE * x * h + kick * generator.standard_normal()
            ends[path] = x
        return ends

    return loop


def _diffrax(paths):
    """Euler's method of diffrax over a path that is not kept, one jitted call; None without it."""
    try:
        import diffrax
        import jax
    except ImportError:
        return None
    jax.config.update("jax_enable_x64", True)

    def one(key):
        noise = diffrax.UnsafeBrownianPath(shape=(), key=key)
        terms = diffrax.MultiTerm(
            diffrax.ODETerm(lambda t, y, args: -RATE * y),
            diffrax.ControlTerm(lambda t, y, args: SIGMA, noise),
        )
        solved = diffrax.diffeqsolve(
            terms, diffrax.Euler(), 0.0, 1.0, 1.0 / STEPS, 1.0, max_steps=STEPS + 1,
            saveat=diffrax.SaveAt(t1=True), adjoint=diffrax.ForwardMode(),
        )  # fmt: skip
        return solved.ys[0]

    keys = jax.random.split(jax.random.PRNGKey(0), paths)
    solve = jax.jit(jax.vmap(one))
    return lambda: np.asarray(solve(keys))


def rows(quick):
    """One row a solver: nanoseconds a step and path, and the ends beside the exact law."""
    paths = 1024 if quick else 16384
    generator = np.random.Generator(np.random.SFC64(1))
    runs = {
        "fastdyn EulerMaruyama, 1 thread": _fastdyn(paths, "EulerMaruyama", 1),
        "fastdyn EulerMaruyama, 2 threads": _fastdyn(paths, "EulerMaruyama", 2),
        "fastdyn SRA1, 1 thread": _fastdyn(paths, "SRA1", 1),
        "fastdyn BAOAB, 1 thread": _langevin(paths),
        "NumPy arrays, SFC64": _numpy(paths, generator.standard_normal),
        "loop by Numba, EulerMaruyama": lambda: _loop_of_numba()(paths, STEPS, generator),
    }
    few = _diffrax(paths // 16)
    if few is not None:
        runs["diffrax Euler, vmap"] = few
    times = interleaved(runs, 3 if quick else 7, 1.0 if quick else 60.0)
    for name, (least, median) in times.items():
        ends = runs[name]()
        steps = len(ends) * STEPS
        row = {"solver": name, "ns": 1e9 * least / steps, "ns_median": 1e9 * median / steps}
        if "BAOAB" not in name:
            error = EXACT[1] / math.sqrt(len(ends))
            row |= {"mean": float(ends.mean()), "deviations": (ends.mean() - EXACT[0]) / error}
        yield row
