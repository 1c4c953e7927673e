"""The memory of a run: Jacobi's coordinates and the constants of the splitting, laid out."""

import numpy as np

from fastdyn.kernels.methods.wisdom_holman.kepler import WIDTH
from fastdyn.kernels.methods.wisdom_holman.steps import CALLS, Motion, Room, padded
from fastdyn.kernels.state.record import K

HILL = 3.0  # the distance at which two planets meet, in mutual Hill radii
FAR = 1e200  # the square of a distance, whose cube is finite, of pairs that do not pull or meet


def jacobi(masses, q):
    """Jacobi's coordinates of the planets, (n, 3), of places or velocities of all bodies."""
    inner = np.cumsum(masses)[:-1, None]
    return q[1:] - np.cumsum(masses[:-1, None] * q[:-1], 0) / inner


def _rows(n, n_pairs):
    """The `work` array of a run, and its parts: CALLS, two Motions and the Room."""
    p = padded(n)
    vectors = 3 * p
    matrix = p * p
    motion = Motion(*[vectors] * len(Motion._fields))
    room = Room(
        h=vectors, s=vectors, d=vectors, some=max(vectors, 4 * WIDTH), mu=p, outer=p, inner=p,
        centre=matrix, weights=matrix, apart=matrix, near=matrix, of_pulls=matrix, of_star=matrix,
        masses=n + 1, body=n, drifting=6, pairs=2 * n_pairs,
    )  # fmt: skip
    ends = np.cumsum([CALLS.itemsize // 8, *motion, *motion, *room])
    wide = 6 * (n + 1)
    work = np.zeros((K + -(-ends[-1] // wide), wide))
    calls, *rows = np.split(work[K:].reshape(-1), ends)[:-1]
    each = iter(rows)
    parts = [type(part)(*[next(each) for _ in part]) for part in (motion, motion, room)]
    return work, calls.view(CALLS), *parts


def laid_out(masses, q, v, G, bodies, pairs):
    """The `work` array of a run, and its parts: CALLS, the Motions of the last step and of an
    output, the Room.

    Parameters
    ----------
    masses : array, shape (n + 1,)
        The star, then the planets from the inside to the outside.
    q, v : array, shape (n + 1, 3)
    G : float
    bodies : array, shape (n,)
        The place of each planet in the state.
    pairs : list
        (a, b) of the corrector.
    """
    n = len(masses) - 1
    p = padded(n)
    work, calls, last, out, room = _rows(n, len(pairs))
    eta = np.cumsum(masses)
    star = masses[0]
    m = masses[1:]
    filler = np.minimum(np.arange(p), n - 1)  # lanes without a planet follow the last
    out.x.reshape(3, p)[:] = jacobi(masses, q)[filler].T
    out.v.reshape(3, p)[:] = jacobi(masses, v)[filler].T
    room.mu[:] = (G * eta[1:])[filler]
    first = star / eta[:-1]
    room.outer[:n] = G * first * eta[1:]
    room.inner[:n] = G * eta[1:] * (eta[:-1] - star) / eta[:-1]
    room.apart[:] = FAR
    before = np.tril(np.ones((n, n)), -1)  # [i, j]: planet j counts before planet i
    _fill(room.centre, (m / eta[1:]) * before, p)
    _fill(room.weights, G * m * (1.0 - np.eye(n)), p)
    massless = (m == 0.0)[:, None] & (m == 0.0)
    _fill(room.apart, FAR * (massless | np.eye(n, dtype=bool)), p)
    hill = ((m[:, None] + m) / (3.0 * star)) ** (1.0 / 3.0)
    _fill(room.near, (HILL * hill) ** 2 * (1.0 - np.eye(n)), p)
    _fill(room.of_pulls, np.eye(n) - m / eta[:-1, None] * before, p)
    _fill(room.of_star, -G * star * m / eta[:-1, None] * before.T, p)
    room.masses[:] = masses
    room.body[:] = bodies
    room.drifting[:3] = masses @ q / eta[-1]
    room.drifting[3:] = masses @ v / eta[-1]
    room.pairs[:] = np.ravel(pairs)
    return work, calls, last, out, room


def _fill(row, matrix, p):
    """Store a matrix by columns, padded."""
    n = len(matrix)
    row.reshape(p, p)[:n, :n] = matrix.T
