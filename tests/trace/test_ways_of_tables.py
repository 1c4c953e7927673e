"""A hundred ways to use long arrays and lists: the same numbers, and those of now."""

import copy
import math

import numpy as np
import pytest

from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.paths.runs import trace
from fastdyn.trace.reads.program import reader
from fastdyn.trace.reads.reads import flat

RNG = np.random.default_rng(0)
A, B, C = RNG.normal(size=60), RNG.normal(size=(60, 4)), RNG.normal(size=(5, 6, 4))
NC, F, Z, BO = B[:, 1], np.asfortranarray(B), np.zeros(30), A > 0
I = (np.arange(60) * 7) % 60  # noqa: E741
L, LI, LL, T = A.tolist(), I.tolist(), B.tolist(), tuple(A.tolist())
RO, NL = A.copy(), list(A)
RO.flags.writeable = False
CHANGED = [A, B, C, L, LL, NL, BO, I, LI, Z]
POINTS = (0.3, 1.7, -2.2, 0.05)
WAYS = """
A[int(9*abs(y))]
B[int(9*abs(y)),2]
B[3,int(abs(y))%4]
B[-1][int(abs(y))%4]
NC[int(9*abs(y))]
F[int(9*abs(y)),3]
F.T[2][int(9*abs(y))]
RO[int(9*abs(y))]
I[int(9*abs(y))]*1.0
L[LI[int(9*abs(y))]]
A[I][3]*y
A[I[2:5]].sum()*y
A[[1,2,3]].sum()*y
A[A>0.5].sum()*y
A[BO].mean()+y
LL[int(9*abs(y))][1]
sum(LL[3])*y
C[int(abs(y))%5,2,1]
C[int(abs(y))%5,:,1].sum()
C[2,int(abs(y))%6,3]*C[...,1][2,3]
C[int(abs(y))%5,int(2*abs(y))%6,3]
len(A)*y+len(L)+len(T)+len(B)
A.shape[0]*y+B.shape[1]
float(A[3])*y
(A[3:20:4]*y).sum()
A[5:9][int(abs(y))%4]
A[:, None][3,0]*y
A.reshape(6,10)[2][int(abs(y))%10]
B.ravel()[int(9*abs(y))]
B.flatten()[int(9*abs(y))]
A.copy()[int(9*abs(y))]
np.concatenate([A[:2],L[:2],T[:2]]).sum()*y
np.dot(A,A)*y
A@A*y
(A*A).sum()+y
np.linalg.norm(A)*y
max(L)*y+min(T)+max(A)
L.index(L[7])*y
(L[4] in L)*y
y if A.any() else -y
y if A.all() else -y
np.where(A>y,A,0.0).sum()
np.maximum(A,y).sum()
np.cumsum(A)[5]*y
np.diff(A)[5]*y
np.mean(L)*y+np.std(A)
[v*y for v in L][3]
sum(v*y for v in T)
math.fsum(L)*y
dict(zip(range(60),L))[5]*y
list(reversed(L))[2]*y
[*L,1.0][-2]*y
(T+(1.0,))[-2]*y
(L*2)[70]*y
list(enumerate(A))[4][1]*y
A.tolist()[4]*y
A.item(4)*y
A.max()*y+A.argmax()
np.roll(A,3)[4]*y
np.trapezoid(A,dx=.1)*y
np.polyval(A[:4],y)
np.outer(A[:3],A[:2]).sum()*y
NL[int(9*abs(y))]
Z[int(9*abs(y))%30]+y
(A+y)[3]
(y*A)[3]
(A>y).sum()
A[round(9*abs(y))%60]
A[int(np.floor(9*abs(y)))]
A[(9*np.abs(np.array([y,2*y]))).astype(int)].sum()
np.take(A,int(3))*y
np.asarray(L)[int(9*abs(y))]
np.array(LL)[int(9*abs(y)),1]
np.array(T).sum()*y
copy.copy(A)[int(9*abs(y))]
copy.deepcopy(L)[int(9*abs(y))]
A[-1]*y+A[-60]+L[-60]
A.size*y+A.ndim
np.argmin(A)*y
np.isfinite(A).all()*y
A.clip(0,.5)[3]*y
abs(A)[3]*y
(-A)[3]*y
(A**2)[3]*y
B.T.shape[0]*y
B.sum(axis=0)[2]*y
B.mean(axis=1)[2]*y
B[2:4,1:3].sum()*y
(B[2]*np.array([y,1,2,3])).sum()
B[[1,2]][:,0].sum()*y
np.einsum('ij,j->i',B,np.array([y,1.,2.,3.]))[4]
(B@np.array([y,1.,2.,3.]))[4]
A.astype(int)[3]*y+A.astype(float)[4]
L==L and y or 0.
(A==A).all()*y
I.sum()*y
np.zeros(60)[I].sum()+y
np.arange(60.)[I][4]*y
BO.sum()*y
T.count(T[3])*y
tuple(A)[3]*y
set(LI).__len__()*y
list(map(lambda a,b:a*b,A,L))[3]*y
any(v>y for v in L)*1.0
next(i for i,v in enumerate(L) if v>0.5)*y
A.std()*y+A.var()+A.prod()
np.flip(A)[2]*y
A[::-1][2]*y
np.stack([A,A])[1,3]*y
np.vstack([A,L])[1,3]*y
""".strip().split("\n")


def compared(found, fun, values):
    """At all points, exceptions included."""
    for y in POINTS:
        state = np.full((1, 1), y)
        at = found.graph, found.outputs, np.zeros(1), state, values, [found.raising]
        mine, raises = evaluate(*at)
        try:
            theirs = fun(0.0, state[:, 0])
        except (IndexError, ValueError):
            assert raises[0, 0]
            continue
        assert not raises[0, 0]
        np.testing.assert_allclose(mine[:, 0], theirs, rtol=1e-9)


def change():
    """Other numbers in all that is not fixed."""
    for array in (A, B, C, Z):
        array[:] = RNG.normal(size=array.shape)
    BO[:] = ~BO
    I[:] = RNG.permutation(60)
    L[:], NL[:], LI[:] = RNG.normal(size=60).tolist(), list(RNG.normal(size=60)), I.tolist()
    for row in LL:
        row[:] = RNG.normal(size=4).tolist()


@pytest.mark.parametrize("way", WAYS)
def test_as_python_has_it_now(way):
    of_number = eval(f"lambda y: {way}", globals() | {"math": math})

    def fun(t, y):
        return [of_number(y[0]) * 1.0]

    found = trace(fun, (), 1, (1,))
    compared(found, fun, found.graph.values)
    before = [copy.deepcopy(each) for each in CHANGED]
    try:
        change()
        given = reader(found.reads)(fun, ())
        if given is not None:
            compared(found, fun, flat(given))
    finally:
        for each, old in zip(CHANGED, before, strict=True):
            each[:] = old
