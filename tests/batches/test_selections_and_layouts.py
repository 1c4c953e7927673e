"""Selections, layouts, copies and casts of long arrays are NumPy's, or are refused.

Each body has been wrong without a word, or is a relative of one that was.  `p` is a pulse.
"""

import contextlib

import numpy as np
import pytest

from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace
from fastdyn.trace.reads.program import reader
from support.long_arrays import in_batches

SETUP = """
import numpy as np
c = np.linspace(-1, 1, 64)
B = c.reshape(8, 8).copy()
F = np.asfortranarray(B)
S = c.astype(np.float32)
def f(t, y):
    p = 3*np.exp(-((t - .3137)/.006)**2)
"""
COMPILED = """
o = y+p; k = o > 2.; v = o[k]; o[k] = 0.; s = o.sum(); o[k] = v; r = o+.01*s
o = y+p; k = o > 2.; v = o[k]; w = v; v += 1.; o[k] = w; r = o
o = y+p; k = o > 2.; v = o[k]; k[:] = True; o[k] = 1.; r = o
o = y+p; k = o > 2.; o[k] = np.sqrt(o[k])+c[k]; r = o
o = y+p; o[o < 0] = 0; r = o
o = y+p; k = o > 2.; o[k] *= 2.; r = o
o = y+p; k = o > 2.; r = o*isinstance(o[k], np.ndarray)*(type(o) is np.ndarray)
m = (y+p).reshape(8, 8).T*2.; v = m.T.reshape(-1); v[:9] = 5.; r = m.ravel()
m = np.sin((y+p).reshape(8, 8).T); v = m.reshape(-1); v[:9] = 5.; r = m.ravel()
m = (y+p).reshape(8, 8, order='F')*2.; v = m.ravel('K'); v[:9] = 5.; r = m.ravel()+v
m = np.zeros((8, 8), order='F'); m[:] = (y+p).reshape(8, 8); v = m.ravel('K'); r = m.ravel()+v*.5
m = (y+p).reshape(8, 8).T; z = np.zeros_like(m); z += m; v = z.reshape(-1); v[:9] = 5; r = z.ravel()
m = (y+p).reshape(8, 8).T; v = m.copy('K'); w = v.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8).T; v = m.astype(float); w = v.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8).T; v = np.where(m > 2, 1., m); w = v.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8).T; v = np.clip(m, -1, 2); w = v.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8).T; v = np.gradient(m)[0]; w = v.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8); v = np.array(m, order='F'); w = v.T.reshape(-1); w[:9] = 5.; r = v.ravel()
m = (y+p).reshape(8, 8).T; v = np.ascontiguousarray(m); v[0] = 5.; r = m.ravel()
m = (y+p).reshape(8, 8); v = np.ascontiguousarray(m); v[0] = 5.; r = m.ravel()
m = y.reshape(8, 8); v = np.einsum('ij,jk->ki', m, m); w = v.T.reshape(-1); w[:9] = 3; r = v.ravel()
m = (y+p).reshape(8, 8); v = np.atleast_3d(m); v[0] = 3.; r = m.ravel()
m = y.reshape(4, 4, 4).T; v = m.sum(axis=0); w = v.reshape(-1); w[:3] = 5; r = np.tile(v.ravel(), 4)
m = F*(y+p).reshape(8, 8); v = m.T.reshape(-1); v[:9] = 5.; r = m.ravel()
m = np.array(F); v = m.T.reshape(-1); v[:9] = 5.; r = (m*(y+p).reshape(8, 8)).ravel()
r = (B.T.copy()*(y+p).reshape(8, 8)).ravel()
r = (B[::-1].copy()*(y+p).reshape(8, 8)).ravel()
r = F[int(t*5) % 3, int(t*9) % 8]*(y+p)+F.T[int(t*5) % 3, 2]
o = y+p; v = o.astype(float, copy=False); v[o > 2] = 1.; r = o
o = y+p; v = np.asarray(o, dtype=float); v[0] = 2.; r = o
o = y+p; k = o > 2.; k[:9] = o[:9]; r = k*.1
o = y+p; q = np.zeros_like(o > 2.); q[:] = o; r = q*.1
o = y+p; q = (o > 1.).astype(int); q += 2; r = o/q
o = y+p; q = np.where(o > 2., 3, 7.); q[5] = 2.7; r = q*.1
o = y+p; r = np.piecewise(o, [o > 2, o < -.3], [1., lambda v: v**2, lambda v: np.sin(v)+t])
""".strip().splitlines()
HARD = """
M = (y+p).reshape(8, 8).copy(); M[M[:, 0] > 2.] = 0.; r = M.ravel()
o = y+p; k = o > 2.; o[k] = o[k]+y[k[::-1]]; r = o
o = y+p; k = o > 2.; o[k] = o[k]*(2+c); r = o
o = y+p; k = o > 2.; o[k] = c; r = o
o = y+p; k = o > 2.; v = o[k]; k[:9] = True; o[k] = v; r = o
o = y+p; n = len(o[o > 2.]); r = o+.01*n
o = y+p; n = sum(1 for e in o[o > 2.]); r = o+.01*n
o = y+p; n = o[o > 2.][0]; r = o+.01*n
o = y+p; n = o[o > 2.] @ o[o > 2.]; r = o+.01*n
o = y+p; n = np.matmul(o[o > 2.], y[o > 2.]); r = o+.01*n
o = y+p; o[(o > 2.)[:32]] = 1.; r = o
o = (y+p).reshape(8, 8); o[:, o[0] > 2.] = 0.; r = o.ravel()
o = y+p; o[(np.abs(o)*9).astype(int) % 5] = 5.; r = o
o = y+p; o.flat[3] = 9.; r = o
o = y+p; np.copyto(o, 0., where=o > 2.); r = o
o = y+p; np.place(o, o > 2., [1., 2.]); r = o
o = y+p; np.putmask(o, o > 2., c); r = o
o = y+p; r = o+np.extract(o > 2., o).sum()
o = y+p; r = np.piecewise(o, [o > 2], [lambda v: v-v.mean(), lambda v: v*2])
o = y+p; r = np.piecewise(o, [o > 2], [lambda v: v.size*.1, lambda v: v*2])
o = np.zeros(64, np.float32); o[:] = y+p+1e7; r = o*.1
o = np.zeros(64, np.float32); o[3] = y[3]; r = o*.1
o = S*float(y[0]); r = o*.1
o = y+p; q = (o > 2.).astype(int); q[0] = 2.7; r = q*.1
o = y+p; q = (o > 2.)*2; q[0] = 2.7; r = q*.1
o = y+p; q = np.where(o > 2., 3, 7); q[5] = o[5]; r = q*.1
o = y+p; q = o > 2.; q += 1; r = q*.1
o = y+p; q = (o > 2.).astype(int); q += .5; r = q*.1
o = y+p; q = np.greater(o, 2., out=np.zeros(64, int)); r = q*.1
o = y+p; q = np.asarray_chkfinite(o); q[3] = 5.; r = o
m = (y+p).reshape(8, 8); v = np.einsum('ii->i', m); v[:] = .5; r = m.ravel()
V = np.reshape(B, -1); V[0] = t; r = y+V
G = np.asarray(c); G[0] = t; r = y+G
""".strip().splitlines()


def function(body):
    lines = body.replace("; ", "\n    ")
    space: dict = {}
    exec(f"{SETUP}    {lines}\n    return r\n", space)
    return space["f"]


def by_numbers(f):
    """The function as it is traced number by number."""
    found = trace(f, (), 64, (64,))
    values = found.graph.values
    return lambda t, y: evaluate(
        found.graph, found.outputs, np.array([t]), y[:, None], values
    )[0].ravel()  # fmt: skip


def assert_equal(f, compiled):
    rng = np.random.default_rng(3)
    for t in (0.0, 0.3137, 0.31, 0.5, 1.7):
        y = rng.uniform(-2.5, 2.5, 64)
        np.testing.assert_allclose(compiled(t, y.copy()), f(t, y.copy()), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("body", COMPILED)
def test_a_long_array_lies_in_memory_as_numpys(body):
    f = function(body)
    assert_equal(f, in_batches(f, 64)[0])


@pytest.mark.parametrize("body", COMPILED)
def test_so_does_an_array_that_is_traced_number_by_number(body):
    f = function(body)
    try:
        compiled = by_numbers(f)
    except Untraceable:
        return
    assert_equal(f, compiled)


@pytest.mark.parametrize("caught", [False, True])
@pytest.mark.parametrize("body", HARD)
def test_a_store_or_a_selection_is_numpys_or_is_refused(body, caught):
    """No handler of the user's sees the refusal."""
    if caught:
        *lines, last = body.split("; ")
        inner = "\n        ".join(lines)
        body = f"try:\n        {inner}\n    except Exception: r = o = -y; {last}"
    f = function(body)
    for compiled in (lambda f: in_batches(f, 64)[0], by_numbers):
        with contextlib.suppress(Untraceable):
            assert_equal(f, compiled(f))


@pytest.mark.parametrize("order", ["C", "F"])
def test_an_array_from_outside_in_another_order_is_traced_again(order):
    """The order in memory is part of what a later call checks."""
    f = function(
        "m = np.array(B); v = m.reshape(-1); v[:9] = 5.; r = (m*(y+p).reshape(8, 8)).ravel()"
    )
    f.__globals__["B"] = np.array(f.__globals__["B"], order=order)
    reads = trace(f, (), 64, (64,), batches=True).reads
    assert reader(reads)(f, ()) is not None
    f.__globals__["B"] = np.array(f.__globals__["B"], order="CF"[order == "C"])
    assert reader(reads)(f, ()) is None
