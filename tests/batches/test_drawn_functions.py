"""Drawn functions of long arrays, with slices, stores, masks, sums and gathers, beside NumPy."""

import random

import numpy as np
import pytest

from fastdyn.trace.graph.refusal import Untraceable
from support.long_arrays import in_batches

LINES = """
v = a*b - .5*a
v = np.roll(a, k) - b
v = np.where(a > .1, a, b*.3)
v = np.sin(a) + np.cos(b)
v = np.zeros_like(a); v[1:-1] = a[2:]-2*b[1:-1]+a[:-2]; v[0] = a[1]; v[-1] = b[0]*b[1]
v = a.copy(); v[a > .3] = .25
v = a.copy(); v[::2] = b[1::2]*2
v = a - b.mean()
v = a - b[3:].sum()*.1
v = a*b.max() + a.min()
v = a/(1+np.abs(b).sum())
v = a[P]*.5 + b
v = a[::-1] + b[P]
v = np.cumsum(a)*.1 - b
v = np.concatenate([a[:n//2]*2, b[n//2:]])
v = np.clip(a, -.5, C)
v = A@a*.1 + b
v = (a.reshape(-1, 4).sum(axis=1).repeat(4))*.1 + b
v = (a.reshape(4, -1).sum(axis=0)[None, :]*np.ones((4, 1))).ravel() + b
u = a.reshape(4, -1); w = 0*u; w[1:-1, 1:-1] = u[2:, 1:-1]-2*u[1:-1, :-2]; v = w.ravel()+b
v = (a.reshape(-1, 4).T*b.reshape(4, -1)).ravel()
v = np.empty_like(a); v[:] = [a[(i+1) % n]*(b[i]-b[i-1])*C[i] for i in range(n)]
v = a*C + D[0]*t
v = np.stack([a[::2], b[1::2]], axis=1).ravel()
v = np.outer(a[:4], b[:n//4]).ravel()
v = np.where(C > 0, a, b); v[3:7] += a[5]
v = a.copy(); v[5] = b[2]*a[3]; v[n-3:] *= 2.
v = ((a > .2) & (b < .5))*a
v = (a > .2); v[:9] = b[:9] > 0; v = v*a
v = np.array([a[(7*i) % n]*D[i % 3]+b[i] for i in range(n)])
""".strip().splitlines()


def drawn(seed, n):
    """A function of n numbers, and its text."""
    choose, numbers = random.Random(seed), np.random.default_rng(seed)
    lines, names = ["def fun(t, y):"], ["y"]
    for i in range(choose.randint(3, 8)):
        a, b = (choose.choice(names[-4:]) for _ in range(2))
        line = choose.choice(LINES)
        lines += [
            f"    a, b, k = {a}, {b}, {choose.choice([1, 2, 5, -1])}",
            f"    {line}; v{i} = v",
        ]
        names.append(f"v{i}")
    lines.append(f"    return {choose.choice([names[-1], f'{names[-1]}-{choose.choice(names)}'])}")
    text = "\n".join(lines)
    scope = {
        "np": np, "n": n, "P": numbers.permutation(n), "C": numbers.standard_normal(n),
        "A": numbers.standard_normal((n, n)), "D": np.array([0.5, 1.5, -1.0]),
    }  # fmt: skip
    exec(text, scope)
    return scope["fun"], text


@pytest.mark.few(6)
@pytest.mark.parametrize("n", [64, 100, 1000])
@pytest.mark.parametrize("seed", range(12))
def test_the_code_of_a_drawn_function_has_its_values(n, seed):
    fun, text = drawn(1000 * n + seed, n)
    try:
        call, traced = in_batches(fun, n)
    except Untraceable as reason:
        pytest.skip(str(reason))
    assert traced.in_batches
    y = np.random.default_rng(seed).standard_normal((3, n))
    for state in (*y, 0.1 * y[0]):
        expected = fun(0.3, state)
        size = np.abs(expected).max()
        np.testing.assert_allclose(call(0.3, state), expected, 1e-10, 1e-11 * size, err_msg=text)
