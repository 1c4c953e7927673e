"""Characteristic roots of a delay equation around a state of rest: Chebyshev collocation."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.delays.past import at_each
from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from ..equations import count as whole_number
from ..equations import equations_of, state_of

FEWEST, MOST = 16, 256  # collocation nodes, doubled until the rightmost roots stay
SETTLED = 1e-9  # distance, relative to 1 + |root|, at which two roots are one
NEWTON = 20  # steps of Newton's method that polish a root
AT_REST = 1e-8  # largest rate of a state of rest, relative to the terms of its linearisation


@dataclasses.dataclass(frozen=True, repr=False)
class DelayRoots(Displayed):
    """
    The characteristic roots of a linearised delay equation, the rightmost first.

    Attributes
    ----------
    roots : ndarray of complex
        Roots of det(z I - A - sum B_k exp(-z tau_k)) = 0, each polished by Newton's method.
    delays : ndarray
        The delays tau_k at the state of rest.
    a, b : ndarray, shapes (n, n) and (number of delays, n, n)
        The derivatives of f by the present state, and by each past state.
    stable : bool or None
        Whether all roots have negative real parts; None if the rightmost root is zero to rounding.
    rates : ndarray
        f at the state, which is zero at rest.
    """

    roots: np.ndarray
    delays: np.ndarray
    a: np.ndarray
    b: np.ndarray
    stable: bool | None
    rates: np.ndarray

    @property
    def kind(self):
        """The word "stable", "unstable" or "undecided"."""
        return {True: "stable", False: "unstable", None: "undecided"}[self.stable]

    def __str__(self):
        shown = ", ".join(f"{z:.6g}" for z in self.roots[:4])
        return f"{self.kind}; {len(self.roots)} roots, the rightmost {shown}"

    @filled()
    def plot(self, **options) -> Any:
        """Draw the roots in the complex plane.

        Parameters
        ----------
        {figure}
        """
        from fastdyn.plot.analysis.linear import roots

        return roots(self, **options)


class _Parts:
    """What stands for `past` in a linearisation: a part of the state for each call."""

    def __init__(self, t, parts=None, still=None):
        self.delays = []
        self._t = t
        self._parts = parts
        self._still = still

    def __call__(self, t):
        return at_each(self._part, t)

    def _part(self, s):
        k = len(self.delays)
        self.delays.append(self._t - s)
        return self._still if self._parts is None else self._parts[k]

    def derivative(self, s):
        raise ValueError("`characteristic_roots` is not computed for neutral equations.")


@shown_when_wrong(t=kinds.number)
def characteristic_roots(fun, y, args=(), count=10, t=0.0):
    """The rightmost characteristic roots of a delay equation around a state of rest.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, past, *args)``, as for `solve_dde`.
    y : array_like, shape (n,)
        The state of rest, fun(t, y, y everywhere) = 0.
    args : tuple, optional
    count : int, optional
        The number of roots.
    t : float, optional
        The time of the linearisation.

    Returns
    -------
    DelayRoots

    Raises
    ------
    ValueError
        If the function cannot be traced, reads a derivative of the past, or the state is no state
        of rest.

    Notes
    -----
    The linearised equation y' = A y(t) + sum B_k y(t - tau_k) is a differential operator on the
    interval of the largest delay, which Chebyshev collocation makes a matrix (D. Breda, S. Maset
    and R. Vermiglio, "Pseudospectral differencing methods for characteristic roots of delay
    differential equations", SIAM J. Sci. Comput. 27, 2005).  The number of nodes is doubled until
    the roots stay; Newton's method polishes each to rounding.
    """
    equations = equations_of(fun, args)
    state = state_of(equations, y, "y")
    count = whole_number(count, "count")
    n = len(state)
    seen = _Parts(float(t), still=state)
    rates = np.atleast_1d(np.asarray(fun(float(t), state.copy(), seen, *equations.args), float))
    delays = np.array(seen.delays, float)
    if (delays < 0.0).any():
        raise ValueError(f"a delay is {delays.min():.10g}: `past` is for times before t.")
    m = len(delays)

    def whole(t, z, *args):
        parts = _Parts(t, z.reshape(m + 1, n)[1:])
        return np.concatenate([np.atleast_1d(fun(t, z[:n], parts, *args)), np.zeros(n * m)])

    at = np.tile(state, m + 1)
    slopes = equations._replace(fun=whole).differentiated(float(t), at).at(float(t), at)[:n]
    blocks = slopes.reshape(n, m + 1, n).swapaxes(0, 1)
    if np.abs(rates).max() > AT_REST * (1.0 + np.abs(slopes) @ np.abs(at)).max():
        raise ValueError(f"`y` is no state of rest: `fun` is {rates} there, and must be zero.")
    taus = np.unique(delays)
    b = np.array([blocks[1:][delays == tau].sum(axis=0) for tau in taus]).reshape(-1, n, n)
    roots = _rightmost(blocks[0], b, taus, count)
    size = 1.0 + np.abs(slopes).sum()
    first = roots[0].real
    stable = None if abs(first) < 1e-12 * size else bool(first < 0.0)
    return DelayRoots(roots, taus, blocks[0], b, stable, rates)


def _rightmost(a, b, taus, count):
    """The `count` rightmost roots, polished."""
    if not taus.any():
        return _sorted(np.linalg.eigvals(a + b.sum(axis=0)))[:count]
    last = None
    nodes = FEWEST
    while True:
        found = np.linalg.eigvals(_collocated(a, b, taus, nodes))
        found = _sorted(_distinct([_polished(z, a, b, taus) for z in _sorted(found)[: 2 * count]]))
        found = found[:count]
        same = last is not None and len(last) == len(found)
        if same and np.abs(found - last).max() < SETTLED * (1.0 + np.abs(found).max()):
            return found
        if nodes >= MOST:
            return found
        last = found
        nodes *= 2


def _collocated(a, b, taus, nodes):
    """The matrix of the operator on Chebyshev's nodes from 0 back to the largest delay."""
    n = len(a)
    k = np.arange(nodes + 1)
    x = np.cos(np.pi * k / nodes)
    ends = np.where((k == 0) | (k == nodes), 2.0, 1.0)
    weights = (-1.0) ** k / ends
    apart = x[:, None] - x + np.eye(nodes + 1)
    d = weights / weights[:, None] / apart  # of Lagrange's polynomials, by barycentric weights
    np.fill_diagonal(d, 0.0)
    np.fill_diagonal(d, -d.sum(axis=1))
    matrix = np.kron(d * (2.0 / taus[-1]), np.eye(n))
    first = np.zeros((nodes + 1, n, n))
    first[0] = a
    for tau, each in zip(taus, b, strict=True):
        at = 1.0 - 2.0 * tau / taus[-1] - x
        near = np.abs(at) < 1e-14
        shares = np.where(near, 1.0, 0.0) if near.any() else weights / at / (weights / at).sum()
        first += shares[:, None, None] * each
    matrix[:n] = first.swapaxes(0, 1).reshape(n, -1)
    return matrix


def _polished(z, a, b, taus):
    """A root by Newton's method on (z I - A - sum B exp(-z tau)) v = 0, |v| fixed; or NaN."""
    n = len(a)

    def matrices(z):
        decay = np.exp(-z * taus)[:, None, None]
        value = z * np.eye(n) - a - (decay * b).sum(axis=0)
        return value, np.eye(n) + (taus[:, None, None] * decay * b).sum(axis=0)

    with np.errstate(all="ignore"):
        value, _ = matrices(z)
        if not np.isfinite(value).all():
            return np.nan
        v = np.linalg.svd(value)[2][-1].conj()
        step: Any = np.full(n + 1, np.inf)
        for _ in range(NEWTON):
            value, slope = matrices(z)
            if not (np.isfinite(value).all() and np.isfinite(slope).all()):
                return np.nan
            bordered = np.zeros((n + 1, n + 1), complex)
            bordered[:n, :n] = value
            bordered[:n, n] = slope @ v
            bordered[n, :n] = v.conj()
            try:
                step = np.linalg.solve(bordered, np.r_[-value @ v, 0.0])
            except np.linalg.LinAlgError:
                return z  # a multiple root, which the collocation has as precisely as it can
            v = v + step[:n]
            v /= np.linalg.norm(v)
            z = z + step[n]
            if abs(step[n]) < 1e-15 * (1.0 + abs(z)):
                return z
    return z if abs(step[n]) < SETTLED * (1.0 + abs(z)) else np.nan


def _sorted(roots):
    return roots[np.lexsort((np.abs(roots.imag), -roots.real.round(12)))]


def _distinct(roots):
    """The finite roots, each once."""
    found = []
    for z in roots:
        if np.isfinite(z) and all(abs(z - other) > SETTLED * (1.0 + abs(z)) for other in found):
            found.append(z)
    return np.array(found, complex)
