"""Cases of selections, layouts, copies and casts of long arrays, with a pulse between the outputs.

The pulse at t = 0.3137 is over before the next output: what is wrong only where a mask selects
elements shows there, and nowhere at the start.
"""

import random
import re

from .compose import HEADER, Case

SETUP = """
c = np.linspace(-1, 1, 64)
B = c.reshape(8, 8).copy()
F = np.asfortranarray(B)
def fun(t, y):
    p = 3*np.exp(-((t - .3137)/.006)**2)
"""
ROWS = """
o = y+p
o = y+p
o = y+p
o = y+p*c
o = (y+p)[::-1]
o = np.where(y > .2, y, p)
o = np.zeros(64); o[:] = y+p
o = np.empty_like(y); o[...] = y+p
o = np.asarray(y+p, float)
o = y.copy(); o += p
"""
MASKS = """
k = o > $x
k = o > $x
k = (o > $x) & (y < .3)
k = (o > $x) | (c > .5)
k = (o > $x) ^ (y > 0)
k = ~(o < $x)
k = np.abs(o) > $x
k = (o > $x)[::-1]
k = o.reshape(8, 8).T.ravel() > $x
k = np.isclose(o, $x, atol=.3)
k = np.logical_not(o > $x)
k = c > .3
k = o[0] > $x
k = o[:32] > $x
k = (o > $x).reshape(8, 8)
k = (o > $x); k[:9] = True
k = (o > $x) == (y > 0)
k = np.r_[True, np.diff(o) > $x]
"""
SELECTIONS = """
o[k] = .5
o[k] *= .5
o[k] += y[k]
o[k] = o[k]**2
o[k] = 3
o[k] = t
o[k] /= 2
o[k] = -o[k]
v = o[k]; o[k] = 0.; s = o.sum(); o[k] = v; o = o+.01*s
v = o[k]; v *= 2.; o[k] = v
v = o[k]; w = v; w += 1.; o[k] = v
v = o[k]; w = v; w = w+1.; o[k] = v
v = o[k]; o += 1.; o[k] = v
v = o[k]; k[:9] = ~k[:9]; o[k] = v
v = o[k]; v[0] = 5.; o[k] = v
o[k] = o[~k]
o[k] = y[k[::-1]]
o[k] = o[k]+y[k[::-1]]
o[k] = np.sqrt(np.abs(o[k]))
o[k] = np.maximum(o[k], y[k])
o[k] = c[k]
o[k] = (2+c)[k]*o[k]
o[k] = o[k]*(2+c)
o[k] = y
o[k] = o[k][::-1]
o[k] = o[k].mean()
o[k] = o.mean()
o[k] -= o[k].max() if k.any() else 0.
o[k][0] = 5.
o[k][:] = 5.
o[k, ] = .5
o[~k] = .5
o[k & (y > 0)] = .2
o[o > $x] = o[k]
o[k] = np.where(o[k] > 1., 1., o[k])
o[k] = o[k].clip(-1, 1)
o[np.flatnonzero(k)] = .5
o[np.where(k)] = .5
o.T[k] = .5
n = len(o[k]); o = o+.01*n
n = o[k].size; o = o+.01*n
o = o+.01*o[k].sum()
o = o+.01*sum(o[k])
o = o+.01*(o[k] @ o[k])
o = o+.01*np.dot(o[k], y[k])
o = o+.01*(o[k] > .3).sum()
o = o+.1*isinstance(o[k], np.ndarray)
for e in o[k]: o = o+.001*e
o = np.where(k, o, .5)
o = np.where(k, o[::-1], o)
np.copyto(o, .5, where=k)
np.place(o, k, [1., 2.])
np.putmask(o, k, c)
o = o+.01*np.extract(k, o).sum()
o = o+.01*np.compress(k, o).sum()
o = o+.01*k.sum()
o = o*k
o = o+k
o = np.piecewise(o, [k], [lambda v: v*.5, lambda v: v-.1])
o = np.piecewise(o, [k, ~k], [lambda v: v-v.mean(), .3])
o = np.piecewise(o, [k, o < 0], [lambda v: v*.5, .2, lambda v: np.cos(v)])
o = np.piecewise(o, [k], [lambda v: v+.01*v.size, .1])
o = np.select([k, o < -.3], [o*.5, -o], .1)
o = np.add(o, 1., out=o.copy(), where=k)
np.multiply(o, 2., out=o, where=k)
w = o.copy(); w[k] = 1.; o = w-o
w = np.zeros_like(o); w[k] = o[k]; o = w
w = np.full(64, .1); w[k] = o[k]; o = w
"""
ALIASES = """
w = o[::2]; w[:5] = .3
w = o.reshape(8, 8); w[1] = .3
w = o.reshape(8, 8).T; w[1] *= .5
w = o.reshape(8, 8).T*2.; w[1] = .5; o = o+w.ravel()
w = np.asarray(o); w[3] = .5
w = np.asarray(o, float); w[3] = .5
w = np.asarray(o, order='F'); w[3] = .5
w = o.astype(float, copy=False); w[5] = .1
w = o.astype(float); w[5] = .1
w = np.array(o, copy=None); w[2] = .3
w = np.array(o); w[2] = .3
w = np.ascontiguousarray(o); w[0] = 3.
w = np.ascontiguousarray(o[::2]); w[0] = 3.
w = np.require(o); w[1] = .2
w = o.view(); w[1] = 2.
w = np.atleast_2d(o); w[0, 3] = 1.
w = np.atleast_3d(o); w[0, 3] = 1.
w = np.expand_dims(o, 1); w[3] = 1.
w = o[:]; o = o*2; w[3] = 5.
w = o; o += 1.; o = o+.1*w
w = o.real; w[4] = .4
w = np.real(o); w[4] = .4
w = np.nan_to_num(o, copy=False); w[4] = .4
w = np.flip(o); w[4] = .4
w = np.split(o, 4)[1]; w[:] = .4
w = o[[1, 2, 3]]; w[0] = 4.
w = np.broadcast_to(o, (2, 64)).copy(); w[1, 3] = 1.; o = o+w[0]
w = +o; w[3] = 2.
w = np.reshape(B, -1).copy(); w[3] = 2.; o = o+w
w = B.T.copy(); o = o+w.ravel()
w = np.array(F); v = w.T.reshape(-1); v[:9] = .5; o = o+w.ravel()
w = F.copy(); v = w.T.reshape(-1); v[:9] = .5; o = o+w.ravel()
o[3:9] = o[:6]
o[1:] += o[:-1]
np.add(o[1:], o[:-1], out=o[1:])
o.shape = (8, 8); o = o.T.ravel()
o.flat[3] = .4
o.resize(64); o[3] = .1
o = o*(type(o) is np.ndarray)
"""
CASTS = """
q = np.zeros(64, $T); q[:] = 3*o; o = o+.1*q
q = np.zeros(64, $T); q[3] = 2.7*o[0]; o = o+.1*q
q = np.zeros_like(o, dtype=$T); q[:] = 3*o; o = o+.1*q
q = np.empty_like(y, $T); q[...] = o > $x; o = o+.1*q
q = (o > $x).astype($T); q[3] = 2.7; o = o+.1*q
q = (o > $x).astype($T); q += 2; o = o+.1*q
q = (o > $x).astype($T); q *= 2.5; o = o+.1*q
q = (o > $x).astype($T); q //= 2; o = o+.1*q
q = (o > $x).astype($T); q = q/2+q; o = o+.1*q
q = (o > $x)*2; q[0] = 2.7; o = o+.1*q
q = (o > $x)+1; q[0] = 2.7; o = o+.1*q
q = (o > $x)*2.; q[0] = 2.7; o = o+.1*q
q = np.where(o > $x, 3, 7); q[1] = 2.6; o = o+.1*q
q = np.where(o > $x, 3, 7.); q[1] = 2.6; o = o+.1*q
q = np.where(o > $x, 3, 7)*2; q[1:3] = o[1:3]; o = o+.1*q
q = np.full(64, 2); q[o > $x] = 5; o = o+.1*q
q = np.full_like(o, 2); q[3] = 2.5; o = o+.1*q
q = np.arange(64); q[o > $x] = 5; o = o+.01*q
q = np.arange(64); q = q+o; o = .1*q
q = o > $x; q[:9] = o[:9]; o = o+.1*q
q = o > $x; q += 1; o = o+.1*q
q = o > $x; q *= 2.5; o = o+.1*q
q = o > $x; q |= y > 0; o = o+.1*q
q = np.zeros_like(o > $x); q[:] = o; o = o+.1*q
q = np.ones_like(o > $x); q[3] = 0.; o = o+.1*q
q = o.astype($T); o = o+.1*q
q = np.asarray(o, $T); o = o+.1*q
q = np.array(o, dtype=$T); o = o+.1*q
q = np.multiply(o, 3., out=np.zeros(64, $T), casting='unsafe'); o = o+.1*q
q = np.add(o > $x, 1, out=np.zeros(64)); o = o+.1*q
q = np.greater(o, $x, out=np.zeros(64)); o = o+.1*q
q = np.floor(o, out=np.zeros_like(o > $x), casting='unsafe'); o = o+.1*q
q = (o.reshape(8, 8) > $x).sum(axis=0); q[0] = 2.5; o = o+np.tile(q, 8)
q = np.sum(o.reshape(8, 8) > $x, axis=1)*.5; q[0] = 2.5; o = o+np.tile(q, 8)
q = np.concatenate([o[:32] > $x, y[32:] > 0]); q[0] = 2.5; o = o+.1*q
q = np.clip((o > $x).astype(int), 0, 3); q[0] = 2.5; o = o+.1*q
q = o*np.float32(.1); o = o+q
q = c.astype(np.float32); q[3] = o[3]; o = o+q
q = np.sign(o).astype($T); o = o+.1*q
q = np.stack([o > $x, y > 0]).sum(axis=0); q[2] = .5; o = o+.1*q
"""
MATRICES = """
m = o.reshape(8, 8)
m = o.reshape(8, 8).copy()
m = o.reshape(8, 8).T
m = o.reshape(8, 8).T
m = o.reshape(8, 8, order='F')
m = o.reshape(8, 8, order='F')
m = np.asfortranarray(o.reshape(8, 8))
m = np.zeros((8, 8), order='F'); m[:] = o.reshape(8, 8)
m = np.full((8, 8), .1, order='F'); m += o.reshape(8, 8)
m = o.reshape(8, 8)[::-1]
m = o.reshape(8, 8)[:, ::-1]
m = o.reshape(4, 4, 4).transpose(2, 0, 1).reshape(8, 8)
m = o.reshape(4, 4, 4).transpose(2, 1, 0)*1.5; m = m.reshape(8, 8)
m = o.reshape(4, 4, 4).transpose(1, 0, 2)+0.; v = m.ravel('K'); v[:5] = .2; m = m.reshape(8, 8)
m = o.reshape(4, 2, 8).swapaxes(0, 1); m = np.abs(m).reshape(8, 8)
m = np.moveaxis(o.reshape(8, 8), 0, 1)
m = F*o.reshape(8, 8)
m = o.reshape(8, 8)+F
m = np.array([o[8*i:8*i+8] for i in range(8)])
m = np.outer(o[:8], o[8:16])
m = np.stack([o[::2], o[1::2]], axis=1).reshape(8, 8)
m = np.column_stack([o[8*i:8*i+8] for i in range(8)])
"""
CHANGES = """
m = m*2.
m = np.sin(m)
m = m+B
m = F+m
m = m.T
m = m+m.T
m = np.where(m > $x, m, .5)
m = np.where(F > 0, m, F)
m = m.copy()
m = m.copy('K')
m = m.copy('F')
m = m.copy('A')
m = np.copy(m)
m = m.astype(float)
m = m.astype(float, order='C')
m = m.astype(float, copy=False)
m = (m > $x)*m
m = (m > $x).astype(float)+m
m = np.clip(m, -1, 2)
m = np.array(m)
m = np.array(m, order='F')
m = np.array(m, order='C')
m = np.asarray(m, order='F')
m = np.ascontiguousarray(m)
m = np.asfortranarray(m)
m = np.require(m, float, 'F')
m = np.roll(m, 1, 0)
m = np.roll(m, 3)
m = m[:, ::-1]
m = np.concatenate([m, m])[:8]
m = np.concatenate([m, B], axis=1)[:, 4:12]
m = np.stack([m, m])[1]
m = np.stack([m, m], axis=-1)[..., 0]
m = m @ F*.3
m = F @ m*.3
m = np.dot(m, m.T)*.1
m = np.einsum('ij->ji', m)
m = np.einsum('ij,jk->ki', m, B)
m = np.einsum('ij,kj->ik', m, m)*.1
m = np.einsum('ij,ij->ij', m, F)
m = np.gradient(m)[1]
m = np.zeros_like(m)+m
m = np.zeros_like(m, order='C')+m
w = np.empty_like(m); w[...] = m; m = w
m = np.tile(m, (1, 1))
m = np.repeat(m, 2, axis=0)[::2]
m = np.rot90(m)
m = np.pad(m, 1)[1:-1, 1:-1]
m = np.pad(m, 1, mode='wrap')[:-2, 1:-1]
m = np.minimum(m, m.T)
m = np.maximum(F, m)
m = m.reshape(4, 2, 8).sum(axis=1).repeat(2, axis=0)
m = m.reshape(8, 4, 2).max(axis=2).repeat(2, axis=1)
m = np.select([m > $x], [m], .3)
m = np.cumsum(m, axis=0)*.2
m = np.sort(m, axis=0)
m = np.diff(m, axis=0, prepend=0.)
m = np.flip(m, 0)
m = m.reshape(8, 8, order='A')
m = m.reshape(16, 4).reshape(8, 8)
m = m.reshape(16, 4, order='F').T.reshape(8, 8)
m = np.interp(m, [-1., 0., 3.], [0., .5, 1.])
m = np.round(m, 1)
m = np.nan_to_num(m)
m = m[[1, 0, 2, 3, 4, 5, 6, 7]]
m = m[:, [1, 0, 2, 3, 4, 5, 6, 7]]
m = np.take(m, range(8), axis=1)
m = np.fft.fft(m, axis=0).real*.3
m = np.triu(m)
m = np.linalg.inv(m @ m.T+3*np.eye(8))
m = np.piecewise(m, [m > $x], [lambda v: v*.5, lambda v: v+.1])
m = m/np.linalg.norm(m)
m = m-m.mean(axis=0)
m = m-m.mean(axis=1, keepdims=True)
m = np.vstack([m[1:], m[:1]])
m = np.hstack([m[:, 1:], m[:, :1]])
m = np.delete(np.insert(m, 0, .1, axis=1), 0, axis=1)
m = np.broadcast_to(m[0], (8, 8)).copy()
m = np.meshgrid(m[0], m[1])[0]
"""
STORES = """
v = m.reshape(-1); v[:9] = .5
v = m.reshape(-1); v[:9] = .5
v = m.ravel(); v[:9] = .5
v = np.ravel(m); v[:9] = .5
v = m.T.reshape(-1); v[:9] = .5
v = m.T.ravel(); v[:9] = .5
v = m.ravel('K'); v[:9] = .5
v = m.ravel('A'); v[:9] = .5
v = m.ravel('F'); v[:9] = .5
v = m.flatten(); v[:9] = .5
v = m.flatten('K'); m = m+.1*v.reshape(8, 8)
v = m.reshape(64, order='F'); v[:9] = .5
v = m.reshape(4, 16); v[1] = .5
v = m.reshape(2, 4, 8); v[1, 2] = .5
v = m.swapaxes(0, 1).reshape(-1); v[:9] = .5
v = m[1:3].reshape(-1); v[:9] = .5
v = m[:, 1:3].reshape(-1); v[:9] = .5
v = m[:, 0]; v[:] = .5
v = np.asarray(m, order='C').reshape(-1); v[:9] = .5
v = np.asfortranarray(m).T.reshape(-1); v[:9] = .5
v = np.require(m, None, 'F').T.reshape(-1); v[:9] = .5
v = np.squeeze(m[None]); v[0] = .2
v = np.atleast_3d(m); v[0] = .3
v = np.moveaxis(m, 0, 1); v[0] = .3
v = m.view(); v[0] = .3
v = m.astype(float, copy=False); v[0] = .3
v = np.einsum('ij->ji', m); v[0] = .3
v = np.einsum('ii->i', m); v[:] = .5
v = np.diagonal(m).copy(); v[0] = 5.; m = m+v
v = np.diagonal(m); v[0] = 5.
v = np.split(m, 2)[1]; v[0] = .3
v = np.dsplit(m[:, :, None], 1)[0]; v[0] = .3
m[m > $x] = .5
m[m > $x] *= .5
m[m > $x] = m.T[m > $x]
m[m > $x] = m[m.T > $x]
m[m[:, 0] > $x] = .5
m[m[0] > $x] *= .5
m[:, m[0] > $x] = .5
m[m[:, 0] > $x, 1] = .5
m[m[:, 0] > $x, m[0] > $x] = .5
m[m.sum(axis=1) > $x] = 0.
m.T[m.T > $x] = .2
m[(m > $x).ravel()] = .3
m.ravel()[(m > $x).ravel()] = .3
m.reshape(-1)[m.reshape(-1) > $x] = .3
np.fill_diagonal(m, .5)
m.flat[3] = .5
m.flat = m.T.ravel()
m += m.T
m[1:] += m[:-1]
np.add(m, m.T, out=m)
np.multiply(m, 2., out=m.T)
m.real[0] = .5
m[:] = m.T
m[::-1] = m
m[[0, 1]] = m[[1, 0]]
m[np.diag_indices(8)] = .3
m[1], m[2] = m[2], m[1]
s = m.sum(axis=0); s[0] = 2.5; m = m+s
m.shape = (4, 16)
for row in m: row *= .5
for e in m.ravel(): e *= 2
"""
BACK = """
o = m.ravel()
o = m.ravel()
o = m.reshape(-1)
o = m.ravel('K')
o = m.ravel('F')
o = m.flatten('F')
o = m.T.ravel('A')
o = m.T.reshape(64)
o = np.concatenate(m)
"""
TYPES = "int", "int", "float", "bool", "np.float32", "'f4'", "np.int8", "np.int64", "'d'"
CAUGHT = "TypeError", "ValueError", "IndexError", "Exception", "BaseException"


def draw_selection(seed, index):
    """Case `index` of a seed: three to six lines on one array, then the frame."""
    draw = random.Random(f"selections {seed}:{index}")

    def line(table):
        """A line of a table with its gaps drawn."""
        text = draw.choice(table.strip().splitlines())
        text = text.replace("$x", draw.choice(("2.", "2.", "1.5", ".9", "-.2")))
        return re.sub(r"\$T", lambda _: draw.choice(TYPES), text)

    lines = [line(ROWS)]
    for _ in range(draw.choice((1, 1, 2))):
        kind = draw.choice(("mask", "mask", "mask", "matrix", "matrix", "matrix", "alias", "cast"))
        if kind == "mask":
            lines += [line(MASKS), *(_perhaps_caught(line(SELECTIONS), draw) for _ in "ab")]
        elif kind == "matrix":
            lines.append(line(MATRICES))
            lines += [line(CHANGES) for _ in range(draw.choice((0, 1, 1, 2)))]
            lines += [_perhaps_caught(line(STORES), draw) for _ in range(draw.choice((1, 1, 2)))]
            lines.append(line(BACK))
        else:
            lines.append(_perhaps_caught(line(ALIASES if kind == "alias" else CASTS), draw))
    body = "\n".join([*lines, "return -.4*y+p*np.tanh(o)"])
    indented = "\n".join("    " + each for each in body.splitlines())
    how = {
        "way": "pulse", "method": "RK45", "rtol": 1e-6, "atol": 1e-8, "span": (0.27, 0.37),
        "y0": [round(draw.uniform(-0.9, 0.9), 3) for _ in range(64)],
    }  # fmt: skip
    text = f"{HEADER}{SETUP}{indented}\n\ndef watched():\n    pass\n\nHOW = {how!r}\n"
    return Case(f"{seed}:{index}", "selections", text)


def _perhaps_caught(line, draw):
    """A line, now and then in a ``try`` whose handler changes the answer."""
    if draw.random() < 0.75 or line.startswith("for "):
        return line
    return f"try: {line}\nexcept {draw.choice(CAUGHT)}: o = o*.9"
