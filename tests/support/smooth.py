"""Smooth functions drawn at random, by number, and which generator writes their Taylor series."""

import math
import random

from fastdyn import code_store
from fastdyn.compile import memory
from fastdyn.compile.traced import code as traced
from fastdyn.compile.traced import known
from fastdyn.compile.traced import make as by_tracing
from fastdyn.compile.traced import series as traced_series

OF_ONE = (
    lambda m, a: m.sin(a),
    lambda m, a: m.cos(a),
    lambda m, a: m.exp(-a * a),
    lambda m, a: m.tanh(a),
    lambda m, a: m.atan(a),
    lambda m, a: m.sqrt(1.5 + a * a),
    lambda m, a: m.log(2.0 + a * a),
    lambda m, a: (1.2 + a * a) ** -1.5,
    lambda m, a: (1.1 + a * a) ** (1 / 3),
    lambda m, a: 1.0 / (1.3 + a * a),
    lambda m, a: m.sinh(a / (1.0 + a * a)),
    lambda m, a: m.asinh(a),
    lambda m, a: m.expm1(m.sin(a)),
    lambda m, a: a * a * a / (1.0 + a**4),
)
OF_TWO = (
    lambda a, b: a + b,
    lambda a, b: a - b,
    lambda a, b: a * b / (1.0 + a * a),
    lambda a, b: a / (1.4 + b * b),
    lambda a, b: 0.7 * a - 0.3 * b,
    lambda a, b: a * b,
)


def drawn(number, n=None):
    """(fun, args, y0): a function of n components, which share parts, and two parameters."""
    rng = random.Random(number)
    n = n or rng.randint(1, 5)
    steps = [
        (rng.choice((1, 1, 2)), rng.random(), rng.random(), rng.random()) for _ in range(3 * n)
    ]
    ends = [(rng.randrange(10**6), rng.uniform(-1.0, 1.0), rng.randrange(n)) for _ in range(n)]

    def fun(t, y, p, q):
        known = [*y, t, p * y[0], math.sin(q * t)]
        for kind, f, a, b in steps:
            first, second = (known[int(x * len(known))] for x in (a, b))
            if kind == 1:
                known.append(OF_ONE[int(f * len(OF_ONE))](math, first))
            else:
                known.append(OF_TWO[int(f * len(OF_TWO))](first, second))
        return [f * known[-1 - i % (2 * n)] - 0.4 * y[j] for i, f, j in ends]

    args = rng.uniform(0.5, 1.5), rng.uniform(0.5, 2.0)
    return fun, args, [rng.uniform(-0.8, 0.8) for _ in range(n)]


def write_in_rows(monkeypatch, rows):
    """Let all series be written in rows, or none; no code is kept."""
    assembled = code_store.assembled
    monkeypatch.setattr(traced_series, "MAX_ONLINE", -1 if rows else 10**9)
    monkeypatch.setattr(
        traced.code_store, "assembled", lambda key, *how: assembled(None if how[1:] else key, *how)
    )
    empty = memory.Table()
    for module, name in (
        (known, "TABLE"),
        (by_tracing, "TABLE"),
        (by_tracing, "_functions"),
    ):
        monkeypatch.setattr(module, name, empty if name == "TABLE" else memory.Table())
