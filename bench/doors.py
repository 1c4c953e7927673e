"""``python -m bench.doors``: gradients in JAX's jit beside diffrax, and vmap beside a loop.

Microseconds, the least of many calls.  It needs jax and diffrax.
"""

import bench.one_thread  # noqa: F401  before all that follow

# isort: split
import time
import types

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

import fastdyn
import fastdyn.jax

SECONDS, MEMBERS = 3.0, 1000


def pendulum(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


def lotka_volterra(t, y, a, b, c, d):
    return [a * y[0] - b * y[0] * y[1], -c * y[1] + d * y[0] * y[1]]


def chain(t, y, stiffness):
    x, v = np.split(y, 2)
    stretch = np.concatenate((x[:1], x[1:] - x[:-1], -x[-1:]))
    force = stiffness * (stretch + 0.1 * stretch**3)
    return np.concatenate((v, force[1:] - force[:-1]))


def network(t, y, first, bias, second, offset):
    return second @ np.tanh(first @ y + bias) + offset


def problems():
    """(name, function, span, initial state, arguments, tolerance, number of outputs)."""
    rng = np.random.default_rng(0)
    yield "pendulum", pendulum, (0, 10), np.array([1.0, 0.0]), (9.81, 0.2), 1e-8, 50
    rates = 1.1, 0.4, 0.4, 0.1
    yield "Lotka, Volterra", lotka_volterra, (0, 10), np.array([10.0, 5.0]), rates, 1e-8, 50
    for n in (30, 300):
        y0 = np.append(rng.normal(size=n), np.zeros(n))
        yield f"chain of {n}", chain, (0, 10), y0, (np.linspace(0.5, 2, n + 1),), 1e-6, 50
    layers = rng.normal(size=(30, 8)) / 3, np.zeros(30), rng.normal(size=(8, 30)) / 6, np.zeros(8)
    yield "network", network, (0, 3), rng.normal(size=8), layers, 1e-6, 20


def by_fastdyn(fun, span, times, tolerance):
    how = {"t_eval": times, "rtol": tolerance, "atol": tolerance}

    def loss(y0, args):
        return (fastdyn.jax.solve_ivp(fun, span, y0, "Tsit5", args=args, **how).y ** 2).sum()

    return loss


def by_diffrax(fun, span, times, tolerance):
    in_jax = types.FunctionType(fun.__code__, {**globals(), "np": jnp})
    term = diffrax.ODETerm(lambda t, y, args: jnp.asarray(in_jax(t, y, *args)))
    steps = diffrax.PIDController(rtol=tolerance, atol=tolerance)
    how = {"saveat": diffrax.SaveAt(ts=times), "stepsize_controller": steps, "max_steps": 10_000}

    def loss(y0, args):
        given = term, diffrax.Tsit5(), span[0], span[1], None, y0, args
        return (diffrax.diffeqsolve(*given, **how).ys ** 2).sum()

    return loss


def least(call):
    """The least time of a call, in microseconds."""
    jax.block_until_ready(call())
    found, end = [], time.perf_counter() + SECONDS
    while len(found) < 5 or time.perf_counter() < end:
        begin = time.perf_counter()
        jax.block_until_ready(call())
        found.append(time.perf_counter() - begin)
    return 1e6 * min(found)


def measured(name, fun, span, y0, args, tolerance, n_times):
    """Print one row."""
    times = np.linspace(*span, n_times + 1)[1:]
    how = {"rtol": tolerance, "atol": tolerance, "args": args}
    row = [least(lambda: fastdyn.solve_ivp(fun, span, y0, "Tsit5", times, **how).y)]
    given, gradients = (jnp.asarray(y0), tuple(map(jnp.asarray, args))), []
    for door in (by_fastdyn, by_diffrax):
        loss = door(fun, span, times, tolerance)
        solve, both = jax.jit(loss), jax.jit(jax.value_and_grad(loss, (0, 1)))
        begin = time.perf_counter()
        found = jax.tree.leaves(jax.block_until_ready(both(*given))[1])
        first = 1e6 * (time.perf_counter() - begin)
        gradients.append(np.concatenate([np.ravel(each) for each in found]))
        row += [least(lambda solve=solve: solve(*given)), least(lambda: both(*given)), first]  # noqa: B023
    apart = np.abs(gradients[0] - gradients[1]).max() / np.abs(gradients[1]).max()
    print(f"{name:16}", *[f"{each:10.0f}" for each in row], f"apart {apart:.0e}", flush=True)


def many():
    """Print the times of members under vmap, and one by one."""
    times, stiffness = np.linspace(0, 10, 51)[1:], jnp.linspace(5.0, 12.0, MEMBERS)
    for door in (by_fastdyn, by_diffrax):
        whole = door(pendulum, (0.0, 10.0), times, 1e-8)

        def loss(k, whole=whole):
            return whole(jnp.array([1.0, 0.0]), (k, 0.2))

        for kind, function in (("values", loss), ("gradients", jax.value_and_grad(loss))):
            at_once, singly = jax.jit(jax.vmap(function)), jax.jit(function)
            row = least(lambda: at_once(stiffness)), MEMBERS * least(lambda: singly(stiffness[0]))  # noqa: B023
            print(f"{door.__name__}, {kind}:", *[f"{each:10.0f}" for each in row], flush=True)


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    for problem in problems():
        measured(*problem)
    many()
