"""Trajectories of DAEs a second: an ensemble, a loop of `solve_dae`, SciPy's Radau on the ODE."""

import numpy as np
from scipy.integrate import solve_ivp

from fastdyn import solve_dae, solve_dae_ensemble

from ..problems.many_daes import many_daes
from ..report.timing import interleaved

THREADS = (1, 2)


def _ensemble(many, threads):
    def run():
        return solve_dae_ensemble(
            many.F, (0, many.end), many.starts, args=(many.parameters,), threads=threads,
            rtol=many.rtol, atol=many.atol,
        ).y[:, 0]  # fmt: skip

    return run


def _loop(many, few):
    def run():
        return np.array([
            solve_dae(
                many.F, (0, many.end), start, args=(p,), rtol=many.rtol, atol=many.atol,
                t_eval=[many.end],
            ).y[0, -1]
            for start, p in zip(many.starts[few], many.parameters[few].tolist(), strict=True)
        ])  # fmt: skip

    return run


def _scipy(many, few, rtol, atol):
    def run():
        return np.array([
            many.first(
                solve_ivp(
                    many.reduced, (0, many.end), x, "Radau", args=(p,), rtol=rtol, atol=atol
                ).y[:, -1], p,
            )
            for x, p in zip(many.reduced_starts[few], many.parameters[few].tolist(), strict=True)
        ])  # fmt: skip

    return run


def rows(quick):
    """One row a problem and solver; loops solve a few of the trajectories."""
    count = 100 if quick else 2000
    few = slice(0, count, count // (4 if quick else 20))
    for many in [next(many_daes(count))] if quick else many_daes(count):
        truth = _scipy(many, few, 1e-10, 1e-13)()
        runs = {f"fastdyn ensemble, {n} threads": _ensemble(many, n) for n in THREADS}
        runs["fastdyn solve_dae in a loop"] = _loop(many, few)
        runs["SciPy Radau on the ODE in a loop"] = _scipy(many, few, many.rtol, many.atol)
        found = {name: run() for name, run in runs.items()}
        times = interleaved(runs, 3 if quick else 5, 0.1 if quick else 60.0)
        for name, (least, median) in times.items():
            whole = "ensemble" in name
            off = np.abs((found[name][few] if whole else found[name]) - truth)
            n = count if whole else len(truth)
            yield {
                "problem": many.name, "solver": name, "largest_error": float(off.max()),
                "a_second": n / least, "a_second_median": n / median,
            }  # fmt: skip
