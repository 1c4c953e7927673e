"""The discrete solution of an explicit pair in NumPy at given steps, for complex steps."""

import itertools

import numpy as np

from fastdyn.kernels.methods import BY_NAME

TINY = 1e-30  # a complex step, whose square is no number


def replayed(fun, steps, y0, args, method, t_eval):
    """The outputs at t_eval, (n, n_points), real or complex, of the steps that end at `steps`."""
    table, y = BY_NAME[method].tableau, np.asarray(y0)
    s, a, c = len(table["b"]), [row.floats for row in table["a"]], table["c"].floats
    found = []
    sign = 1.0 if steps[-1] >= steps[0] else -1.0
    at = np.searchsorted(sign * steps, sign * t_eval, "left") - 1
    at = np.clip(at, 0, len(steps) - 2)
    for i, (t, end) in enumerate(itertools.pairwise(steps)):
        h, k, points = end - t, [], t_eval[at == i]
        new = None
        for j in range(len(a) if len(points) else s):
            u = y + h * sum((w * x for w, x in zip(a[j], k, strict=False) if w), 0.0 * y)
            new = u if j == s else new
            k.append(np.array(fun(t + c[j] * h, u, *args)))
        if new is None:
            new = y + h * sum(w * x for w, x in zip(a[s], k, strict=True) if w)
        found += [_inside((x - t) / h, h, y, new, k, s, table["d"]) for x in points]
        y = new
    return np.array(found).T


def _inside(x, h, y, new, k, s, d):
    """The interpolant at x, in the form of Hairer, Norsett and Wanner, section II.6."""
    rise = new - y
    rows = [rise, h * k[0] - rise, 2 * rise - h * (k[s] + k[0])]
    rows += [h * sum(w * v for w, v in zip(row.floats, k, strict=False)) for row in d]
    total = 0.0 * y
    for i in range(len(rows) - 1, -1, -1):
        total = (rows[i] + total) * (x if i % 2 == 0 else 1.0 - x)
    return y + total


def gradient(fun, steps, y0, args, method, t_eval, g, which):
    """The derivatives of sum(g y) by numbers (0, i) of y0 and (j, i) of argument j, from 1."""
    found = []
    for position, i in which:
        own = [np.array(y0, complex), *[np.array(v, complex) for v in args]]
        own[position].reshape(-1)[i] += 1j * TINY
        given = [v[()] if v.ndim == 0 else v for v in own[1:]]
        y = replayed(fun, steps, own[0], given, method, t_eval)
        found.append((g * y).sum().imag / TINY)
    return np.array(found)


def by_complex_steps(number, y0, args):
    """The derivatives of ``number(*y0, *args)`` by each of its arguments."""
    values, found = [*y0, *args], []
    for i in range(len(values)):
        moved = [v + (1j * TINY if i == j else 0.0) for j, v in enumerate(values)]
        found.append(number(*moved).imag / TINY)
    return np.array(found)


def flat(found):
    """The numbers of a dict of arrays."""
    return np.concatenate([np.ravel(v) for v in found.values()])
