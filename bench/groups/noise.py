"""Nanoseconds a step and path: fastdyn, NumPy, a loop by Numba, diffrax, sdeint, jitcsde.

Two equations: dX = -X dt + 0.2 dW, with ends beside the exact law, and dX = 0.3 X dt + 0.8 X dW in
64 steps, with the root mean square error of the ends on their own paths.
"""

import functools
import math
import os
import tempfile

import numpy as np

from fastdyn import solve_langevin, solve_sde

from ..report.timing import interleaved

STEPS, RATE, SIGMA = 1000, 1.0, 0.2
EXACT = math.exp(-RATE), SIGMA * math.sqrt((1.0 - math.exp(-2.0 * RATE)) / (2.0 * RATE))
FEW_STEPS, GROWTH, SHAKES = 64, 0.3, 0.8


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


def _of_diffrax(paths, steps, solver, a, g, kept):
    """One jitted call of diffrax for all paths; its result has the ends, and W(1) if `kept`."""
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)

    def one(key):
        noise = diffrax.UnsafeBrownianPath(shape=(), key=key)
        if kept:
            noise = diffrax.VirtualBrownianTree(0.0, 1.0, tol=0.5 / steps, shape=(), key=key)
        terms = diffrax.MultiTerm(diffrax.ODETerm(a), diffrax.ControlTerm(g, noise))
        solved = diffrax.diffeqsolve(
            terms, getattr(diffrax, solver)(), 0.0, 1.0, 1.0 / steps, 1.0, max_steps=steps + 1,
            saveat=diffrax.SaveAt(t1=True), adjoint=diffrax.ForwardMode(),
        )  # fmt: skip
        return solved.ys[0], noise.evaluate(0.0, 1.0)

    keys = jax.random.split(jax.random.PRNGKey(0), paths)
    solve = jax.jit(jax.vmap(one))
    return lambda: [np.asarray(each) for each in solve(keys)]


def _diffrax(paths):
    """Euler's method of diffrax over a path that is not kept."""
    solve = _of_diffrax(
        paths, STEPS, "Euler", lambda t, y, args: -RATE * y, lambda t, y, args: SIGMA, False
    )
    return lambda: solve()[0]


def _sdeint(paths):
    """sdeint takes one path at a time."""
    import sdeint

    generator = np.random.default_rng(1)
    times = np.linspace(0.0, 1.0, STEPS + 1)

    def end():
        return sdeint.itoEuler(
            lambda x, t: -RATE * x, lambda x, t: np.array([[SIGMA]]), np.ones(1), times,
            generator=generator,
        )[-1, 0]  # fmt: skip

    return lambda: np.array([end() for _ in range(paths)])


def _jitcsde(paths, rtol):
    """jitcsde chooses its steps: one path at a time, in compiled C."""
    import jitcsde

    made = jitcsde.jitcsde([-RATE * jitcsde.y(0)], [SIGMA], additive=True, verbose=False)
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # setuptools would read the pyproject.toml of this project
        try:
            made.compile_C()
        finally:
            os.chdir(here)
    made.set_integration_parameters(rtol=rtol, atol=rtol / 100)

    def end(seed):
        made.set_seed(seed)
        made.set_initial_value(np.ones(1), 0.0)
        return made.integrate(1.0)[0]

    return lambda: np.array([end(seed) for seed in range(paths)])


def _if_installed(runs, name, make, *given):
    try:
        runs[name] = make(*given)
    except ImportError:
        pass


def _grown(paths, method):
    """Ends and W(1) of fastdyn's paths of the linear equation, and the run that is timed."""

    def run():
        return solve_sde(
            lambda t, y: GROWTH * y, lambda t, y: SHAKES * y, (0, 1), [1.0], step=1.0 / FEW_STEPS,
            paths=paths, rng=1, method=method, threads=1,
        )  # fmt: skip

    return run, lambda found: (found.y_end[:, 0], found.brownian()[:, 0, -1])


def _grown_by_diffrax(paths, solver):
    solve = _of_diffrax(
        paths, FEW_STEPS, solver, lambda t, y, args: GROWTH * y, lambda t, y, args: SHAKES * y, True
    )
    return solve, lambda found: found


def _grown_by_sdeint(paths, method):
    import sdeint

    generator = np.random.default_rng(1)
    times = np.linspace(0.0, 1.0, FEW_STEPS + 1)

    def one():
        moves = generator.normal(0.0, FEW_STEPS**-0.5, (FEW_STEPS, 1))
        y = getattr(sdeint, method)(
            lambda x, t: GROWTH * x, lambda x, t: np.diag(SHAKES * x), np.ones(1), times, dW=moves,
            generator=generator,
        )  # fmt: skip
        return y[-1, 0], moves.sum()

    return lambda: np.array([one() for _ in range(paths)]).T, lambda found: found


def _errors_on_paths(paths, quick):
    """Rows of the linear equation, whose solution is known by W."""
    runs = {}
    for method in ("EulerMaruyama", "Milstein", "Platen"):
        runs[f"fastdyn {method}, on paths"] = _grown(8 * paths, method)
    for solver in ("Euler", "ItoMilstein"):
        _if_installed(runs, f"diffrax {solver}, tree", _grown_by_diffrax, paths, solver)
    for method in ("itoEuler", "itoSRI2"):
        _if_installed(runs, f"sdeint {method}, on paths", _grown_by_sdeint, paths // 16, method)
    timed = {name: run for name, (run, _) in runs.items()}
    for name, (least, median) in interleaved(timed, 3, 1.0 if quick else 60.0).items():
        run, ends_of = runs[name]
        ends, w = ends_of(run())
        error = ends - np.exp(GROWTH - SHAKES**2 / 2 + SHAKES * w)
        steps = len(ends) * FEW_STEPS
        yield {
            "solver": name, "ns": 1e9 * least / steps, "ns_median": 1e9 * median / steps,
            "error_on_paths": float(np.sqrt(np.mean(error**2))), "mean_error": float(error.mean()),
        }  # fmt: skip


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
    _if_installed(runs, "diffrax Euler, vmap", _diffrax, paths // 16)
    _if_installed(runs, "sdeint itoEuler", _sdeint, paths // 1024)
    for rtol in (1e-2, 1e-4):
        _if_installed(runs, f"jitcsde, rtol {rtol:g}", _jitcsde, paths // 16, rtol)
    times = interleaved(runs, 3 if quick else 7, 1.0 if quick else 60.0)
    for name, (least, median) in times.items():
        ends = runs[name]()
        steps = len(ends) * STEPS
        row = {"solver": name, "ns": 1e9 * least / steps, "ns_median": 1e9 * median / steps}
        if "jitcsde" in name:  # its steps are its own: the time of a whole path
            row = {"solver": name, "us_of_a_path": 1e6 * least / len(ends)}
        if "BAOAB" not in name:
            error = EXACT[1] / math.sqrt(len(ends))
            row |= {"mean": float(ends.mean()), "deviations": (ends.mean() - EXACT[0]) / error}
        yield row
    yield from _errors_on_paths(paths // 8, quick)
