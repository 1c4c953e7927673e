"""diffrax in double precision, one jitted function a problem and solver."""

import functools

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from . import MAX_STEPS

jax.config.update("jax_enable_x64", True)
METHODS = ("Dopri5", "Tsit5", "Dopri8")
GRADIENT_STEPS = 4096  # diffrax's default: more take more checkpoints
FIRST_CALL = {
    "diffrax": (
        "import diffrax, jax, jax.numpy as jnp",
        """
jax.config.update("jax_enable_x64", True)
def fun(t, y, args):
    return jnp.stack([y[1], -{k} * y[0] - y[1] ** {power}])
@jax.jit
def compiled(y0):
    return diffrax.diffeqsolve(
        diffrax.ODETerm(fun), diffrax.Dopri5(), 0.0, 5.0, None, y0, max_steps=10_000,
        stepsize_controller=diffrax.PIDController(rtol=1e-3, atol=1e-6),
    ).ys
def solve():
    return compiled(jnp.array([1.0, 0.0])).block_until_ready()
""",
    ),
}


def solvers(problem):
    """The explicit pairs, with the default controller."""
    return {
        f"diffrax {name}": functools.partial(_prepare, problem, _jitted(problem, name))
        for name in METHODS
        if problem.arrays or problem.terms
    }


def stiff(given):
    """Kvaerno5 with the controller that its documentation names for stiff problems.

    Only for what jax can trace: equations in arithmetic, which are those for everybody.
    """
    p = given.problem
    if given.mass is not None or p.into is not None or np.iscomplexobj(p.y0):
        return {}
    term = diffrax.ODETerm(lambda t, y, _: jnp.stack(p.fun(t, y)))
    y0 = jnp.array(p.y0, dtype=float)
    try:
        jax.eval_shape(term.vector_field, 0.0, y0, None)
    except (TypeError, jax.errors.ConcretizationTypeError):
        return {}

    @jax.jit
    def solve(y0, rtol, atol):
        control = diffrax.PIDController(rtol=rtol, atol=atol, pcoeff=0.3, icoeff=0.4)
        return diffrax.diffeqsolve(
            term, diffrax.Kvaerno5(), *p.t_span, None, y0, max_steps=MAX_STEPS, throw=False,
            stepsize_controller=control, saveat=diffrax.SaveAt(t1=True),
        ).ys  # fmt: skip

    def prepare(tol):
        return lambda: np.asarray(solve(y0, tol, tol * given.floor).block_until_ready())[-1]

    return {"diffrax Kvaerno5": prepare}


def _jitted(problem, name):
    begin, end = problem.t_span
    rates = (problem.arrays or problem.terms)(jnp)
    term = diffrax.ODETerm(lambda t, y, _: jnp.stack(rates(t, y, *problem.args)))
    if problem.arrays:
        term = diffrax.ODETerm(lambda t, y, _: rates(t, y))

    @jax.jit
    def solve(y0, tol, times):
        return diffrax.diffeqsolve(
            term, getattr(diffrax, name)(), begin, end, None, y0, max_steps=MAX_STEPS, throw=False,
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            saveat=diffrax.SaveAt(ts=times) if times is not None else diffrax.SaveAt(t1=True),
        ).ys  # fmt: skip

    return solve


def _prepare(problem, solve, tol, times=None):
    y0 = jnp.array(problem.y0, dtype=float)
    times = None if times is None else jnp.array(times)
    solve(y0, tol, times).block_until_ready()
    return lambda: np.asarray(solve(y0, tol, times).block_until_ready())[-1]


def hybrid(given):
    """The pairs in a compiled loop: `scan` over the samples, or `while` over the impacts."""
    return {
        f"diffrax {name} in a loop": functools.partial(_hybrid, given, _loop(given, name))
        for name in METHODS
    }


def _loop(h, name):
    act = h.act(jnp)
    term = diffrax.ODETerm(lambda t, y, d: jnp.stack(h.fun(t, y, d)))

    def acted(t, y, d):
        return tuple(jnp.stack([jnp.asarray(x, float) for x in each]) for each in act(t, y, d))

    def to(t, end, y, d, tol, **options):
        return diffrax.diffeqsolve(
            term, getattr(diffrax, name)(), t, end, None, y, d, max_steps=MAX_STEPS, throw=False,
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            saveat=diffrax.SaveAt(t1=True), **options,
        )  # fmt: skip

    def sample(tol, carried, k):
        y, d = acted(k * h.period, *carried)
        found = to(k * h.period, (k + 1) * h.period, y, d, tol)
        return (found.ys[-1], d), None

    def impact(tol, carried):
        t, y, d = carried
        event = diffrax.Event(
            lambda t, y, args, **_: y[0], optimistix.Newton(tol, 1e-14), direction=False
        )
        found = to(t, h.end, y, d, tol, event=event)
        t = found.ts[-1]
        behind, more = acted(t, found.ys[-1], d)
        over = t >= h.end
        return t, jnp.where(over, found.ys[-1], behind), jnp.where(over, d, more)

    @jax.jit
    def solve(y, d, tol):
        if h.period is not None:
            samples = jnp.arange(round(h.end / h.period))
            return jax.lax.scan(functools.partial(sample, tol), (y, d), samples)[0][0]
        return jax.lax.while_loop(
            lambda carried: carried[0] < h.end, functools.partial(impact, tol), (0.0, y, d)
        )[1]

    return solve


def _hybrid(h, solve, tol):
    y0, d0 = jnp.array(h.y0, dtype=float), jnp.array(h.d0, dtype=float)
    solve(y0, d0, tol).block_until_ready()
    return lambda: np.asarray(solve(y0, d0, tol).block_until_ready())


def gradients(given):
    """Reverse mode through the steps, with checkpoints, and forward mode; both jitted."""
    modes = {
        "backward": (jax.grad, diffrax.RecursiveCheckpointAdjoint()),
        "forward": (jax.jacfwd, diffrax.ForwardMode()),
    }
    p = jnp.array(given.p)

    def prepare(solve, tol):
        return lambda: np.asarray(solve(p, tol).block_until_ready())

    return {
        f"diffrax {name}, {mode}": functools.partial(prepare, _derivatives(given, name, *how))
        for name in METHODS
        for mode, how in modes.items()
    }


def _derivatives(given, name, derivative, adjoint):
    rates = given.arrays(jnp) if given.arrays else given.terms
    stacked = rates if given.arrays else lambda t, y, p: jnp.stack(rates(t, y, p))
    weights, y0 = jnp.array(given.weights), jnp.array(given.y0, float)

    @jax.jit
    @derivative
    def solve(p, tol):
        return weights @ diffrax.diffeqsolve(
            diffrax.ODETerm(stacked), getattr(diffrax, name)(), 0.0, given.end, None, y0, p,
            max_steps=GRADIENT_STEPS, throw=False, adjoint=adjoint, saveat=diffrax.SaveAt(t1=True),
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
        ).ys[-1]  # fmt: skip

    return solve
