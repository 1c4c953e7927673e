"""The outer planets of `fastdyn.planets`, in astronomical units, years, solar masses."""

import numpy as np

from fastdyn.planets import outer, outer_planets

SYSTEM = outer_planets()
YEAR, G, MASSES = outer.YEAR, SYSTEM.G, SYSTEM.masses
N = len(MASSES)
PULLS = G * MASSES
NEARBY = 1e-8  # relative size of the changes that tell one start from another


def start(seed):
    """State [places, rates] in the frame of the centre of mass: seed 0 is that of 1969."""
    y = np.array([SYSTEM.q0, SYSTEM.v0])
    if seed:
        y *= 1.0 + NEARBY * np.random.default_rng(seed).normal(size=y.shape)
    return (y - (MASSES @ y)[:, None] / MASSES.sum()).ravel()


def fun(t, y):
    """The motion of the six bodies."""
    q = y[: 3 * N].reshape(N, 3)
    a = np.zeros((N, 3))
    for i in range(N):
        for j in range(i):
            d = q[j] - q[i]
            r2 = d @ d
            pull = d / (r2 * np.sqrt(r2))
            a[i] = a[i] + PULLS[j] * pull
            a[j] = a[j] - PULLS[i] * pull
    return np.concatenate([y[3 * N :], a.ravel()])


def energy(y):
    """Energy of states, shape (n_times, 36), in the processor's widest numbers."""
    q, v = np.asarray(y, np.longdouble).reshape(-1, 2, N, 3).swapaxes(0, 1)
    total = 0.5 * (MASSES * (v**2).sum(axis=-1)).sum(axis=-1)
    for i in range(N):
        for j in range(i):
            apart = np.sqrt(((q[:, i] - q[:, j]) ** 2).sum(axis=-1))
            total -= G * MASSES[i] * np.longdouble(MASSES[j]) / apart
    return total
