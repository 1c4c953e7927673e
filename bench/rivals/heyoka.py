"""heyoka: Taylor's method, compiled for the formulas and for the tolerance."""

import functools
import time

import heyoka as hy
import numpy as np

from ..problems import equations, outer_planets
from . import MANY_RTOL, MAX_STEPS

FIRST = """
x, v = hy.make_vars("x", "v")
def solve(made=[]):
    if not made:
        made.append(hy.taylor_adaptive([(x, v), (v, -{k} * x - v**{power})], [1.0, 0.0]))
    made[0].time = 0.0
    made[0].state[:] = [1.0, 0.0]
    made[0].propagate_until(5.0)
"""
MODES = {"heyoka": {}, "heyoka, fast_math": {"fast_math": True}}  # the second may reorder sums
UNROLLED = 200  # equations, of which more take minutes to compile without `compact_mode`
WITHOUT_DISK = "import heyoka as hy; hy.llvm_state.set_diskcache_enabled(False)"
FIRST_CALL = {
    "heyoka": ("import heyoka as hy", FIRST),
    "heyoka, disk cache off": (WITHOUT_DISK, FIRST),
}


def solvers(problem):
    """The adaptive integrator, for systems given by formulas: by default, and in any order."""
    return {
        name: functools.partial(_prepare, problem, options)
        for name, options in MODES.items() if problem.terms
    }  # fmt: skip


def integrator(problem, **options):
    """Build the integrator of a problem, at its start."""
    y = hy.make_vars(*(f"y{i}" for i in range(len(problem.y0))))
    rates = problem.terms(hy)(hy.time, y, *problem.args)
    system = list(zip(y, rates, strict=True))
    return hy.taylor_adaptive(system, [float(value) for value in problem.y0], **options)


def _prepare(problem, options, tol, times=None):
    run = integrator(problem, tol=tol, **options)
    y0, (begin, end) = np.array(problem.y0, dtype=float), problem.t_span

    def solve():
        run.time = begin
        run.state[:] = y0
        if times is not None:
            return run.propagate_grid(times)[-1][-1]
        run.propagate_until(end, max_steps=MAX_STEPS)
        return run.state.copy()

    return solve


def trajectories(many):
    """The batch integrator, as many trajectories at once as the processor has lanes."""
    return {name.replace("heyoka", "heyoka batch"): _batches(many, options)
            for name, options in MODES.items()}  # fmt: skip


def _batches(many, options):
    n, m = many.y0.shape[1], many.parameters.shape[1]
    terms = _satellite if many.terms is equations.satellite else many.terms(hy)
    y = hy.make_vars(*(f"y{i}" for i in range(n)))
    rates = terms(hy.time, y, *(hy.par[i] for i in range(m)))
    width = hy.recommended_simd_size()
    batch = hy.taylor_adaptive_batch(
        list(zip(y, rates, strict=True)), np.zeros((n, width)), tol=MANY_RTOL,
        pars=np.zeros((m, width)), **options,
    )  # fmt: skip

    def run():
        out = np.empty_like(many.y0)
        for i in range(0, len(out) - width + 1, width):
            batch.set_time(0.0)
            batch.state[:] = many.y0[i : i + width].T
            batch.pars[:] = many.parameters[i : i + width].T
            batch.propagate_until(many.t_end)
            out[i : i + width] = batch.state.T
        return out

    return run


def _satellite(t, w, GM):
    """`equations.satellite` by a power, which is the faster here."""
    x, y, vx, vy = w
    r2 = x * x + y * y
    return vx, vy, -GM * x * r2**-1.5, -GM * y * r2**-1.5


def orbits(orbit):
    """Compensated summation, at the default tolerance."""

    def make():
        x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
        r3 = (x * x + y * y) ** 1.5  # to divide by it rounds better than `_satellite`
        system = [(x, vx), (y, vy), (vx, -orbit.GM * x / r3), (vy, -orbit.GM * y / r3)]
        run = hy.taylor_adaptive(system, list(orbit.initial_state()), high_accuracy=True)

        def go(t):
            run.propagate_until(t)
            return run.state.copy()

        return go

    return {"heyoka high_accuracy": make}


PLANETS = {"heyoka high_accuracy": {"high_accuracy": True}, "heyoka": {}}
PLANET_STARTS = 8  # of 15 s each


def planets(times):
    """Its own model of bodies, with and without compensated sums, at the default tolerance."""
    return {name: functools.partial(_planets, times, made) for name, made in PLANETS.items()}


def _planets(times, options):
    n, grid = outer_planets.N, np.append(0.0, times)
    model = hy.model.nbody(n, masses=list(outer_planets.MASSES), Gconst=outer_planets.G)
    run = hy.taylor_adaptive(model, np.zeros(6 * n), **options)

    def go(y0):
        run.time = 0.0
        run.state[:] = y0.reshape(2, n, 3).swapaxes(0, 1).ravel()  # body by body
        begun = time.perf_counter()
        *_, n_steps, _, states = run.propagate_grid(grid)
        spent = time.perf_counter() - begun
        pairs = states[1:].reshape(-1, n, 2, 3).swapaxes(1, 2)
        return spent, pairs.reshape(len(times), -1), n_steps

    return go, PLANET_STARTS


def hybrid(given):
    """A loop in Python over the samples; impacts are an event of heyoka's with a callback."""
    return {
        name: functools.partial(_hybrid, given, options) for name, options in MODES.items()
    }  # fmt: skip


def _hybrid(h, options, tol):
    act, n, d = h.act(np), len(h.y0), np.array(h.d0)
    y = hy.make_vars(*(f"y{i}" for i in range(n)))
    system = list(zip(y, h.fun(hy.time, y, [hy.par[i] for i in range(len(d))]), strict=True))

    def change(run):
        run.state[:], d[:] = act(run.time, run.state.copy(), d)
        run.pars[:] = d[: len(run.pars)]

    def bounce(run, _):
        change(run)
        return True

    events = {}
    if h.period is None:
        falls = hy.event_direction.negative
        events = {"t_events": [hy.t_event(y[0], callback=bounce, direction=falls)]}
    start = [float(each) for each in h.y0]
    run = hy.taylor_adaptive(system, start, tol=tol, **events, **options)

    def solve():
        run.time, run.state[:], d[:] = 0.0, h.y0, h.d0
        if h.period is None:
            run.propagate_until(h.end)
            return run.state.copy()
        for k in range(round(h.end / h.period)):
            change(run)
            run.propagate_until((k + 1) * h.period)
        return run.state.copy()

    return solve


def gradients(given):
    """Its variational equations, forward, by all parameters."""
    return {
        f"{name}, forward": functools.partial(_gradient, given, options)
        for name, options in MODES.items()
    }


def _gradient(given, options, tol):
    n, m = len(given.y0), len(given.p)
    y = hy.make_vars(*(f"y{i}" for i in range(n)))
    rates = given.terms(hy.time, y, [hy.par[j] for j in range(m)])
    system = hy.var_ode_sys(list(zip(y, rates, strict=True)), hy.var_args.params, order=1)
    start = [float(each) for each in given.y0]
    compact = n * (m + 1) > UNROLLED
    run = hy.taylor_adaptive(
        system, start, tol=tol, pars=list(given.p), compact_mode=compact, **options
    )
    at_first = run.state.copy()
    rows = [run.get_vslice(order=1, component=i) for i in range(n)]

    def solve():
        run.time, run.state[:] = 0.0, at_first
        run.propagate_until(given.end, max_steps=MAX_STEPS)
        derivatives = np.array([run.state[row] for row in rows])
        return given.weights @ derivatives

    return solve
