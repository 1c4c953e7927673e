"""solve_sde and solve_langevin: equations with noise, on many paths at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.ensemble.threads import number_of
from fastdyn.kernels.noise.arguments import KEEPS, KICK
from fastdyn.plot.needed import progress_bar
from fastdyn.problem.validate import extra_arguments, function, initial_state, time_span
from fastdyn.run.enough_memory import check_room
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.kinds import shown

from .equations import ConstantColumn, Equations, check_events, equations, passages_of
from .grid import grid, outputs
from .paths import Paths, SolvedPaths, Taken
from .plan import NoDerivative, NoisePlan, bound_functions, kernel_of, method_for, near_of, noise_of
from .pulses import warn_of_pulses
from .reductions import stacked, wanted
from .run import Runner

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from fastdyn.problem.argument_types import Args, Function, Functions, State, Times, TimeSpan

CALCULI = ("ito", "stratonovich")
MOST_PATHS = 2**32  # the word of a path in the counter of the random numbers
KEYS = 2**64
FRICTIONLESS = 1e-12  # friction over a step below which the noise of a step has its limit, sqrt(h)


class Asked(NamedTuple):
    """The arguments that solve_sde and solve_langevin share, checked."""

    grid: Any
    y0: np.ndarray
    single: bool
    n_paths: int
    args: tuple
    times: Any
    events: list
    reduce: dict
    key: int
    n_threads: int
    progress: bool
    has_events: bool


@shown_when_wrong(
    step=kinds.number, paths=kinds.whole, refine=kinds.whole, threads=kinds.whole,
    method=kinds.text, calculus=kinds.text, noise=kinds.text, progress=kinds.flag,
    t_eval=kinds.times, rng=kinds.seed,
)  # fmt: skip
def solve_sde(
    drift: Function,
    diffusion: Function | Any,
    t_span: TimeSpan,
    y0: State,
    *,
    step: float,
    paths: int | None = None,
    args: Args = (),
    method: str = "auto",
    calculus: str = "ito",
    noise: str = "auto",
    t_eval: Times | None = None,
    events: Functions | None = None,
    reduce: str | Callable | Sequence | Mapping | None = None,
    refine: int = 0,
    rng: Any = None,
    threads: int | None = None,
    progress: bool = False,
) -> Paths:
    """Solve ``dy = drift(t, y) dt + diffusion(t, y) dW`` at constant step, on one or many paths.

    Parameters
    ----------
    drift : callable
        ``drift(t, y, *args)`` returns n numbers for y of shape (n,).
    diffusion : callable, float or array_like
        ``diffusion(t, y, *args)`` returns n numbers, each times a noise of its own, or a matrix
        (n, m), with a column for each of m sources of noise.  Numbers in place of a function do not
        depend on t and y.
    t_span : (float, float)
        Start and end, in this order.
    y0 : array_like, shape (n,) or (M, n)
        The start, the same for all paths or one for each.
    step : float
        Longest step.  The span is divided into equal steps.
    paths : int, optional
        The number M of paths.  By default as many as `y0` has rows, or a single path.
    args : tuple
        Further arguments of all functions, the same for all paths.
    method : str
        "auto", or a method of the table below.  "auto" takes the method of the highest order on
        paths that holds for the noise: SRA1 for additive noise, Milstein for noise whose components
        do not mix, else EulerMaruyama or EulerHeun.
    calculus : {"ito", "stratonovich"}
        The meaning of the integral by dW.  For additive noise both are equal.
    noise : {"auto", "scalar"}
        "scalar": the n numbers of `diffusion` are one column, times a single source of noise.
    t_eval : array_like, optional
        Times of output, which are ends of steps.  By default the ends of all steps for a single
        path, the end of the span otherwise.
    events : callable or list of callables, optional
        Functions ``g(t, y, *args)`` with attributes `direction` and `terminal` as in `solve_ivp`.
        The result has the time of each path's first passage through g = 0, also of passages between
        the ends of a step (by a Brownian bridge).  A path stays where a terminal event ends it.
    reduce : str, callable, sequence or dict of these, optional
        Numbers to gather from all paths at the times of output, in place of the paths: "mean",
        "variance", "standard_error", "median", "quantiles", `Quantiles`, `Histogram`, or functions
        of (t, y) with y of shape (M, n).
    refine : int
        How often to halve the steps.  Each path follows the same Brownian motion as with
        ``refine=0``, so that differences are the error of the longer step.
    rng : None, int, numpy.random.Generator, BitGenerator or SeedSequence
        What `numpy.random.default_rng` takes (SPEC 7).  A path depends on the seed and on its
        number: neither on `threads` nor on the number of paths.
    threads : int, optional
        Number of threads; by default all processors.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Paths

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense; a method that does not hold for the noise or the integral.

    Notes
    -----
    ============== ======== ======= ============================== ===============
    method         on paths moments noise                          integral
    ============== ======== ======= ============================== ===============
    EulerMaruyama  0.5      1       any                            Ito
    EulerHeun      0.5      1       any                            Stratonovich
    Milstein       1        1       components do not mix          both
    SRA1           1.5      2       independent of the state       both
    Platen         1        2       components do not mix          Ito
    ============== ======== ======= ============================== ===============

    The random numbers are Philox 4x32-10 of (path, source, step), made normal by Box and Muller's
    transformation; see `fastdyn.kernels.random`.  Functions that can be traced take 8 paths at a
    time in the vectors of the processor; others run one path at a time (`Paths.reason`).
    """
    function(drift, "drift")
    options = {"step": step, "paths": paths, "t_eval": t_eval, "events": events}
    options |= {"reduce": reduce, "refine": refine, "rng": rng, "threads": threads}
    asked = _asked(t_span, y0, args, progress, **options)
    if calculus not in CALCULI:
        raise ValueError(f"`calculus={calculus!r}` is unknown; choose from {', '.join(CALCULI)}.")
    if noise not in ("auto", "scalar"):
        raise ValueError(f"`noise={noise!r}` is unknown; choose from auto, scalar.")
    start = asked.y0[0]
    own = equations(drift, diffusion, asked.grid.t0, start, asked.args, noise == "scalar")
    check_events(asked, start)
    return or_in_python(lambda: _solved(asked, own, method, calculus, own.n, {}))


@shown_when_wrong(
    accel=kinds.function_of("(t, q)"), step=kinds.number, paths=kinds.whole, refine=kinds.whole,
    threads=kinds.whole, method=kinds.text, friction=kinds.numbers, sigma=kinds.numbers,
    progress=kinds.flag, t_eval=kinds.times, rng=kinds.seed,
)  # fmt: skip
def solve_langevin(
    accel: Function,
    t_span: TimeSpan,
    q0: State,
    v0: State,
    *,
    friction: Any,
    sigma: Any,
    step: float,
    paths: int | None = None,
    args: Args = (),
    method: str = "BAOAB",
    t_eval: Times | None = None,
    events: Functions | None = None,
    reduce: str | Callable | Sequence | Mapping | None = None,
    refine: int = 0,
    rng: Any = None,
    threads: int | None = None,
    progress: bool = False,
) -> Paths:
    """Solve Langevin's equation, q'' = accel(t, q) - friction q' + sigma dW/dt, at constant step.

    Parameters
    ----------
    accel : callable
        ``accel(t, q, *args)`` returns n accelerations for q of shape (n,).
    q0, v0 : array_like, shape (n,) or (M, n)
        Positions and velocities at the start.
    friction : float or array_like, shape (n,)
        Rate at which velocities decay, 1/s; zero or positive.
    sigma : float or array_like, shape (n,)
        Strength of the noise.  At temperature T, a particle of mass m has
        ``sigma = sqrt(2 friction k T / m)``.
    method : {"BAOAB", "OBABO"}
        Splittings that take friction and noise exactly.  Both have order 2 in moments; BAOAB has
        the exact variance of positions in a harmonic well, at any step.
    t_span, step, paths, args, t_eval, events, reduce, refine, rng, threads, progress
        As in `solve_sde`.  Events are functions of (t, y) with y = [q, v], without passages between
        the ends of steps, because the noise does not act on positions at once.

    Returns
    -------
    Paths
        The states are [q, v].

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense.
    """
    function(accel, "accel")
    q0 = np.atleast_2d(_states(q0, "q0"))
    v0 = np.atleast_2d(_states(v0, "v0"))
    if q0.shape[1] != v0.shape[1] or (len(q0) != len(v0) and 1 not in (len(q0), len(v0))):
        raise ValueError(f"`q0` and `v0` must have one shape; got {q0.shape} and {v0.shape}.")
    m = max(len(q0), len(v0))
    y0 = np.hstack([np.broadcast_to(each, (m, q0.shape[1])) for each in (q0, v0)])
    options = {"step": step, "paths": paths, "t_eval": t_eval, "events": events}
    options |= {"reduce": reduce, "refine": refine, "rng": rng, "threads": threads}
    asked = _asked(t_span, y0 if m > 1 else y0[0], args, progress, **options)
    n = q0.shape[1]
    rate = _of_components(friction, n, "friction")
    strength = _of_components(sigma, n, "sigma")
    if (rate < 0.0).any():
        raise ValueError(f"`friction` must not be negative; got {shown(friction)}.")
    start = asked.y0[0]
    own = equations(accel, strength, asked.grid.t0, start[:n], asked.args, False)
    check_events(asked, start)
    found = method_for(method, "ito", "additive", langevin=True)
    h = asked.grid.h
    keeps, deviation = _relaxation(rate, strength, h / found.relaxations)
    rows = {KEEPS: keeps, KICK: deviation / np.sqrt(h)}
    return or_in_python(lambda: _solved(asked, own, method, "ito", 2 * n, rows))


def _relaxation(rate, strength, h):
    """What a time h of friction leaves of a velocity, and the deviation of its noise."""
    keeps = np.exp(-rate * h)
    slow = rate * h < FRICTIONLESS
    safe = np.where(slow, 1.0, rate)
    variance = np.where(slow, h, -np.expm1(-2.0 * safe * h) / (2.0 * safe))
    return keeps, strength * np.sqrt(variance)


def _of_components(value, n, name):
    array = np.asarray(value, float)
    if array.shape not in ((), (n,)) or not np.isfinite(array).all():
        raise ValueError(f"`{name}` must be a number, or {n} numbers; got {shown(value)}.")
    return np.broadcast_to(array, (n,)).copy()


def _states(y0, name="y0"):
    """`y0` as an array of shape (n,) or (M, n)."""
    array = np.asarray(y0)
    if array.dtype.kind == "c":
        raise ValueError(f"`{name}` must be real: give real and imaginary parts as components.")
    if array.ndim > 2 or array.dtype.kind not in "fiub":
        raise TypeError(f"`{name}` must be numbers, of shape (n,) or (M, n); got {shown(y0)}.")
    if array.ndim < 2:
        return initial_state(y0)
    return array.astype(float)


def _asked(t_span, y0, args, progress, **options):
    """The Asked of arguments; `options` are those from `step` to `threads`."""
    step, paths, t_eval, events, reduce, refine, rng, n_threads = options.values()
    t0, tf = time_span(t_span)
    steps = grid(t0, tf, float(step), int(refine))
    y0 = _states(y0)
    single = y0.ndim == 1 and paths is None
    y0 = np.atleast_2d(y0)
    n_paths = len(y0) if paths is None else int(paths)
    if not 0 < n_paths <= MOST_PATHS:
        raise ValueError(f"`paths` must be 1 to 2**32; got {shown(paths)}.")
    if len(y0) not in (1, n_paths):
        raise ValueError(f"`y0` has {len(y0)} rows for {n_paths} paths: one for all, or one each.")
    if y0.shape[1] == 0:
        raise ValueError("`y0` has no components.")
    if not np.isfinite(y0).all():
        raise ValueError("All components of `y0` must be finite.")
    if t_eval is not None:
        times = np.asarray(t_eval, float)
    elif single:
        check_room(y0.shape[1] * (steps.n_steps + 1), "all steps of the path are", "give `t_eval`")
        times = steps.t0 + steps.h * np.arange(steps.n_steps + 1)
        times[-1] = steps.tf
    else:
        times = None
    check_room(
        y0.shape[1] * n_paths * (1 + (0 if times is None or reduce else len(times))),
        "the states are",
        "take fewer `paths`, or `reduce`",
    )
    key = int(np.random.default_rng(rng).integers(KEYS, dtype=np.uint64, endpoint=False))
    return Asked(
        steps, y0, single, n_paths, extra_arguments(args), times, passages_of(events),
        wanted(reduce), key, number_of(n_threads), progress, events is not None,
    )  # fmt: skip


def _solved(asked, own, method, calculus, n, rows):
    """The Paths of checked arguments; `rows` are given rows of the work array."""
    steps = asked.grid
    near = near_of(steps.t0, steps.tf, asked.y0[0])
    watched = [event.function for event in asked.events]
    bounds = bound_functions(own, watched, asked.args, near, n)
    kind = noise_of(own, bounds, calculus)
    found = method_for(method, calculus, kind, langevin=bool(rows))
    terminal = tuple(event.limit > 0 for event in asked.events)
    if found.langevin:
        bounds = bounds._replace(columns=[])
        own = own._replace(columns=[])
    plan = NoisePlan(
        found, n, own.n, own.n_sources, own.diagonal, len(own.columns), calculus == "ito", terminal
    )
    try:
        kernel = kernel_of(plan, own, bounds, watched, asked.args, near)
    except NoDerivative:
        if method != "auto":
            raise
        found = method_for(method, calculus, kind, derivative=False)
        kernel = kernel_of(plan._replace(method=found), own, bounds, watched, asked.args, near)
    warn_of_pulses(bounds, steps, asked.y0[0], found)
    directions = [float(np.sign(event.direction)) for event in asked.events]
    y0 = np.broadcast_to(asked.y0.T, (n, asked.n_paths))
    key = asked.key - KEYS if asked.key >= KEYS // 2 else asked.key
    runner = Runner(kernel, plan, steps, key, y0, directions, rows, asked.n_threads)
    t, y, reduced = _walked(asked, runner)
    runner.compare(steps.tf)
    facts = Taken(
        found.name, calculus, kind, steps.h, steps.n_steps, steps.n_steps * found.evaluations,
        kernel.width, kernel.reason, asked.key,
    )  # fmt: skip
    solved = SolvedPaths(
        t, y, runner.y.copy(), reduced, runner.passages.copy() if asked.has_events else None,
        facts, lambda: _brownian(asked, own.n_sources),
    )  # fmt: skip
    return Paths(solved, asked.single)


def _walked(asked, runner):
    """Take all paths through the times of output; (times, states or None, reductions)."""
    steps = asked.grid
    single = asked.single
    times = np.array([steps.tf]) if asked.times is None else asked.times
    done = outputs(steps, times)
    ends = done if len(done) and done[-1] == steps.n_steps else np.append(done, steps.n_steps)
    n, n_paths = runner.y.shape
    keeps = not asked.reduce or single
    y = np.empty((len(times), n, n_paths)) if keeps else None
    found: dict = {name: [] for name in asked.reduce}

    def each(k):
        if k >= len(times):
            return
        if y is not None:
            y[k] = runner.y
        for name, gather in asked.reduce.items():
            found[name].append(np.array(gather(float(times[k]), runner.seen.T)))

    with progress_bar(asked.progress, total=steps.n_steps, unit=" steps") as bar:
        runner.to(ends.tolist(), each, bar)
    reduced = {name: stacked(name, parts) for name, parts in found.items() if parts}
    return times, y, reduced


def _brownian(asked, m):
    """The Brownian motion of a solve: the solution of dW = dW, with the numbers of the solve."""
    still = Equations(_nothing, [ConstantColumn(np.ones(m))], True, m, m, True)
    plain = asked._replace(y0=np.zeros((1, m)), args=(), events=[], reduce={}, has_events=False)
    return _solved(plain, still, "EulerMaruyama", "ito", m, {})._solved.y


def _nothing(t, y):
    return 0.0 * y
