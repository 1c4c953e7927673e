"""Functions of long arrays as their authors write them, and random programs of NumPy."""

import numpy as np
import scipy.sparse

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.paths.runs import trace

from .machine_code import called

N = 144
RANDOM = np.random.default_rng(5)
ORDER = RANDOM.permutation(N)
DENSE = RANDOM.normal(size=(N, N))
WEIGHTS = RANDOM.normal(size=N)
LINKS = scipy.sparse.random_array((N, N), density=0.05, rng=RANDOM).tocsr()
KNOTS, HEIGHTS = np.linspace(-2, 2, 40), np.sin(np.arange(40.0))
STEPS = (
    "a + b", "a * b", "a - 2.0 * b", "np.sin(a)", "np.where(a > b, a, b)", "np.maximum(a, 0.1)",
    "np.roll(a, 1)", "np.roll(a, -3)", "a[::-1]", "np.concatenate([a[5:], a[:5]])",
    "np.roll(a.reshape(6, -1), 1, 1).ravel()", "np.roll(a.reshape(6, -1), 2, 0).ravel()",
    "a.reshape(6, -1).T.ravel()", "a.reshape(4, 6, -1).transpose(2, 0, 1).ravel()",
    "np.stack([a[::2], b[1::2]], axis=1).ravel()", "np.pad(a[2:-2], 2, mode='wrap')",
    "np.pad(a[1:-1], 1)", "np.repeat(a[::2], 2)", "np.tile(a[: len(a) // 3], 3)",
    "a - np.mean(b)", "a * np.sum(b) * 0.01", "a + np.max(b)", "a[ORDER] + b",
    "np.concatenate([np.diff(a), b[:1]])", "a + WEIGHTS", "a * WEIGHTS[::-1]",
    "(a.reshape(6, -1) - b.reshape(6, -1).mean(axis=1)[:, None]).ravel()",
    "(a.reshape(6, -1) * b.reshape(6, -1)[:, :1]).ravel()", "put(a, b)", "interior(a, b)",
    "np.exp(-a * a)", "np.clip(a, -0.5, b)", "np.abs(a) ** 1.5", "a ** 3", "np.gradient(a)",
    "np.hypot(a, b)", "np.sign(a) * b", "np.arctan2(a, b)", "np.interp(a, KNOTS, HEIGHTS)",
    "0.1 * (DENSE @ a)", "LINKS @ a", "masked(a, b)", "(a > 0) * b", "a / (1.0 + b * b)",
    "np.sqrt(np.abs(a))", "a % 1.5", "np.floor(a)", "b * a[3] + a[-1]", "a - np.min(b) * t",
    "np.sum(a.reshape(6, -1) * b.reshape(6, -1), axis=0).repeat(6)", "np.linalg.norm(a) * b",
    "np.any(a > 2.5) * b", "np.convolve(a, [1.0, -2.0, 1.0], 'same')",
    "np.outer(a[:12], b[:12]).ravel()",
    "np.std(a) + b", "np.append(a[1:], 0.0)", "np.flip(b)", "np.full_like(a, 0.3) * a",
    "np.hstack((a[:3], b[3:]))", "np.heaviside(a, 0.5) * b", "np.tanh(a) - np.log1p(b * b)",
)  # fmt: skip


def put(a, b):
    c = np.empty_like(a)
    c[::3] = a[::3]
    c[1::3] = b[2::3]
    c[2::3] = 0.5
    return c


def interior(a, b):
    u, w = a.reshape(6, -1), b.reshape(6, -1)
    c = np.zeros(u.shape)
    c[1:-1, 2:-1] = u[1:-1, 2:-1] - w[:-2, 1:-2]
    return c.ravel()


def masked(a, b):
    c = a - 0.5
    c[c < 0] = 0.0
    c[b > 1] = b[b > 1] * 2.0
    return c


def program(seed):
    """A function ``f(t, y)`` of random steps, and its lines."""
    random = np.random.default_rng(seed)
    lines, names = ["a = b = c = y"], "abc"
    for _ in range(random.integers(2, 9)):
        lines.append(f"{names[random.integers(3)]} = {STEPS[random.integers(len(STEPS))]}")
    ends = "return a + c", "return np.concatenate([b[: len(b) // 2], a[len(a) // 2 :]])"
    lines.append(ends[random.integers(2)])
    scope = {"np": np, "put": put, "interior": interior, "masked": masked, "ORDER": ORDER,
             "WEIGHTS": WEIGHTS, "DENSE": DENSE, "LINKS": LINKS, "KNOTS": KNOTS,
             "HEIGHTS": HEIGHTS}  # fmt: skip
    exec("def f(t, y):\n    " + "\n    ".join(lines), scope)
    return scope["f"], lines


def in_batches(function, n, args=()):
    """The machine code of a function of long arrays, as ``function(t, y)``, and its trace."""
    found = trace(function, args, n, (n,), batches=True)
    traced = Traced(found, DERIVATIVE, n, True)
    values = list(zip(traced.kinds, traced.trace.reads.close(), strict=True))
    return called(traced.compiled(), values, DERIVATIVE, n), traced


# -- hard for the pieces


def laplace(u):
    return np.roll(u, 1, 0) + np.roll(u, -1, 0) + np.roll(u, 1, 1) + np.roll(u, -1, 1) - 4 * u


def interior_of_twelve(t, y):
    u = y.reshape(12, 12)
    du = np.zeros((12, 12))
    du[1:-1, 1:-1] = u[:-2, 1:-1] + u[2:, 1:-1] + u[1:-1, :-2] + u[1:-1, 2:] - 4 * u[1:-1, 1:-1]
    return du.ravel()


def flat_edges(t, y):
    p = np.pad(y.reshape(12, 12), 1, mode="edge")
    return (p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:] - 4 * p[1:-1, 1:-1]).ravel()


def interleaved(t, y):
    u, v = y.reshape(-1, 2).T
    return np.stack([v * u, np.sin(u) + np.roll(v, 1)], axis=1).ravel()


def columns(t, y):
    u = y.reshape(-1, 3)
    du = np.zeros_like(u)
    du[:, 0] = u[:, 1] * u[:, 2]
    du[:, 1] = -u[:, 0] * u[:, 2]
    du[1:, 2] = u[1:, 0] - u[:-1, 0]
    return du.ravel()


def biharmonic(t, y):
    u = y.reshape(12, 12)
    return laplace(laplace(u)).ravel()


def dear_chain(t, y):
    e = np.exp(np.sin(y))
    f = np.tanh(np.roll(e, 1) - e)
    return np.roll(f, -1) - f


def shuffled(t, y):
    return np.sin(y[ORDER]) - y


def shuffled_dear(t, y):
    return np.sin(y)[ORDER] - y


def rows_and_columns(t, y):
    u = y.reshape(12, 12)
    return (u - u.mean(axis=1)[:, None] * u.max() + np.sum(np.cos(u), axis=0)).ravel()


def all_pairs(t, y):
    return np.sin(y[None, :] - y[:, None]).sum(axis=1)


def network(t, y):
    return LINKS @ np.tanh(y) - DENSE.T @ y


def in_place(t, y):
    dy = -y
    dy += 2.0
    dy[1:] += y[:-1]
    dy *= y
    view = dy[::3]
    view[...] = np.cos(t)
    return dy


def few_cells(t, y):
    dy = -y
    for i in range(0, len(y), 16):
        a, b = y[i], y[i + 1]
        dy[i], dy[i + 1] = a * b, np.sin(b) - 0.3 * a
    return dy


def by_the_sum(t, y):
    if y.sum() > 0.0:
        return np.cos(y)
    return -y * y[0]


def list_of_arrays(t, y):
    u, v = np.split(y, 2)
    return np.array([v, -u]).ravel()


def vector_of_scalars(t, y):
    m = np.mean(y)
    return np.array([m * v if i % 2 else v - m for i, v in enumerate(y)])


HARD = (
    interior_of_twelve, flat_edges, interleaved, columns, biharmonic, dear_chain, shuffled,
    shuffled_dear, rows_and_columns, all_pairs, network, in_place, few_cells, by_the_sum,
    list_of_arrays, vector_of_scalars,
)  # fmt: skip
