"""Where the splitting may be used: a dominant mass, small perturbations, planets far apart."""

import numpy as np

from .room import HILL, jacobi

LARGEST = 0.1  # perturbation, as a share of the attraction


def perturbations(planets, order):
    """The perturbation of each planet in Jacobi's coordinates, as a share of the attraction."""
    m = planets.masses[order]
    q = planets.q0[order]
    apart = q[None] - q[:, None]
    distances = np.linalg.norm(apart, axis=2) + np.eye(len(m))
    pulls = (m[None, :, None] * apart / distances[..., None] ** 3).sum(1)
    x = jacobi(m, q)
    r = np.linalg.norm(x, axis=1, keepdims=True)
    attraction = np.cumsum(m)[1:, None] / r**2
    return np.linalg.norm(jacobi(m, pulls) / attraction + x / r, axis=1)


def meeting(planets, q):
    """(i, j, share of the meeting distance) of the pair of planets that is closest to a meeting."""
    m = planets.masses
    r = np.linalg.norm(q - q[0], axis=1)
    apart = np.linalg.norm(q[None] - q[:, None], axis=2)
    hill = ((m[:, None] + m) / (3.0 * m[0])) ** (1.0 / 3.0) * np.maximum(r[:, None], r)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = apart / (HILL * hill)
    share[np.tril_indices(len(m))] = np.inf
    share[0] = np.inf
    i, j = np.unravel_index(np.nanargmin(share), share.shape)
    return int(i), int(j), float(share[i, j])


def refuse_if_not_planetary(planets, order):
    """Raise ValueError where the splitting of three bodies or more would be wrong or wasteful."""
    m = planets.masses
    if len(m) < 3:
        return
    if m.argmax() != 0:
        raise ValueError(
            f"WisdomHolman is for a dominant mass, which must be the first; body {m.argmax()} has "
            "the largest mass. Put it first, or take another method: see `Planets.rhs`."
        )
    found = perturbations(planets, order)
    if not found.max() <= LARGEST:
        worst = order[1 + int(np.nanargmax(found))]
        raise ValueError(
            f"the perturbation of body {worst} is {found.max():.2g} of what holds it in its orbit, "
            f"more than {LARGEST:g}: WisdomHolman is for a dominant mass and small ones around it; "
            "take another method with `Planets.rhs`."
        )
    i, j, share = meeting(planets, planets.q0)
    if share < 1.0:
        raise ValueError(
            f"bodies {i} and {j} are closer than {HILL:g} mutual Hill radii at the start: "
            "WisdomHolman does not follow encounters; take an adaptive method with `Planets.rhs`."
        )
