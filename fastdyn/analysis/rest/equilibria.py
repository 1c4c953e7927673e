"""Equilibria: Newton's method with exact Jacobians, from many starts."""

import dataclasses
from typing import Any

import numpy as np
from scipy.optimize import root
from scipy.stats import qmc

from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from ..equations import SystemEquations, box_of, count, equations_of, state_of
from .linear import Linearisation, at_rest, linearised

SAME = 1e-6  # equilibria closer than this share of the box count as one equilibrium
EDGE = 1e-9  # an equilibrium may lie outside of the box by this share of the box
POLISH = 4  # steps of Newton's method after the search
BESIDE = 1e-3  # share of the box at which further equilibria are sought beside a singular one
SINGULAR = 1e-9  # singular values of a singular Jacobian, relative to the largest
ROUNDING = 1e-13  # of f, relative to its terms


@dataclasses.dataclass(frozen=True, repr=False)
class Equilibria(Displayed):
    """
    The equilibria that were found; a sequence of `Linearisation`.

    Attributes
    ----------
    found : list of Linearisation
    box : ndarray, shape (n, 2), or None
        The region that was searched.
    n_starts : int
        Number of starts of the search.
    message : str
        The outcome of the search.
    """

    equations: SystemEquations
    found: list[Linearisation]
    box: np.ndarray | None
    n_starts: int
    message: str

    def __len__(self):
        return len(self.found)

    def __getitem__(self, i):
        return self.found[i]

    def __iter__(self):
        return iter(self.found)

    def __str__(self):
        return "\n".join([self.message, *(str(each) for each in self.found)])

    @filled()
    def plot(self, **options) -> Any:
        """Draw the eigenvalues of all equilibria in the complex plane.

        Parameters
        ----------
        {figure}
        """
        from fastdyn.plot.analysis.linear import eigenvalues

        return eigenvalues(self, **options)


@shown_when_wrong(guesses=kinds.array, t=kinds.number)
def equilibria(fun, box=None, guesses=None, args=(), t=0.0, n_starts=200):
    """Search for states at which f(t, y) = 0.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    box : array_like, shape (n, 2), optional
        A pair (low, high) for each component; the search begins at `n_starts` points in the box,
        and keeps equilibria inside.
    guesses : array_like, shape (m, n) or (n,), optional
        Further starts; without `box`, all equilibria are kept. For a system, the default is its
        initial state.
    args : tuple
        Arguments of a function.
    t : float
        Time, for equations that depend on the time.
    n_starts : int
        Starts in the box.

    Returns
    -------
    Equilibria
        The equilibria, sorted by first component, then by the next components. If no equilibrium
        was found, `message` gives the reason. A search from finitely many starts can miss an
        equilibrium.

    Raises
    ------
    ValueError
        For a box or guesses of the wrong shape, and for a function that cannot be traced or
        differentiated.

    Notes
    -----
    Powell's hybrid method (SciPy's `root`) runs from each start, with the exact Jacobian. Results
    at which f is not zero up to rounding are dropped.

    Examples
    --------
    >>> swing = lambda t, y: [y[1], -np.sin(y[0]) - 0.1 * y[1]]
    >>> [each.kind for each in equilibria(swing, [(-1, 4), (-1, 1)])]  # stable focus, saddle
    """
    equations = equations_of(fun, args)
    t = float(t)
    starts, region = _starts(equations, box, guesses, count(n_starts, "n_starts"))
    derivatives = equations.differentiated(t, starts[0])
    size = np.ptp(region, axis=1) if region is not None else 1.0 + np.abs(starts).max(axis=0)
    found = []
    for start in starts:
        state = _zero(equations, derivatives, t, start)
        if state is None or not _inside(state, region, size):
            continue
        if all(np.abs((state - other.y) / size).max() > SAME for other in found):
            here = linearised(equations, derivatives, t, state)
            if here.equilibrium:
                found.append(here)
    fills = {id(each) for each in found if _goes_on(equations, derivatives, each, size)}
    n_states = len(found)
    n_filling = len(fills)
    found = [e for e in found if id(e) not in fills or _is_zero(derivatives, e)]
    n_lost = n_states - len(found)
    n_filling -= n_lost
    found.sort(key=lambda each: tuple(np.round(each.y / size, 6)))
    where = "in the box " if region is not None else ""
    number = {0: "No equilibrium was", 1: "One equilibrium was"}.get(
        len(found), f"{len(found)} equilibria were"
    )
    message = f"{number} found {where}from {len(starts)} starts."
    if n_lost:
        message += (
            f" At {n_lost} further states `fun` is next to zero, or a number in it is too small "
            "for a float: these are no equilibria."
        )
    if n_filling:
        message += (
            f" {n_filling} of them have further equilibria beside them: equilibria fill a curve or "
            "a region, of which the search finds single states."
        )
    broken = sum(bool(np.isnan(each.matrix).any()) for each in found)
    if broken:
        message += (
            f" `fun` is not differentiable at {broken} of them: beside a kink or a jump there may "
            "be further states of rest, which the search does not find."
        )
    return Equilibria(equations, found, region, len(starts), message)


def _starts(equations, box, guesses, n_starts):
    """(states at which the search begins, the box or None)."""
    if guesses is None and box is None:
        return state_of(equations, None, "guesses")[None], None
    starts = []
    region = None
    n = None
    if guesses is not None:
        rows = [guesses] if np.ndim(guesses) == 1 else guesses
        starts = [state_of(equations, row, "guesses") for row in rows]
        n = len(starts[0])
        if any(len(start) != n for start in starts):
            raise ValueError("`guesses` must have rows of one length.")
    if box is not None:
        region = box_of(box, n or (len(equations.system.states) if equations.system else None))
        sobol = qmc.Sobol(len(region), rng=0).random_base2(int(np.ceil(np.log2(n_starts))))
        middle = np.full((1, len(region)), 0.5)
        unit = np.concatenate([middle, sobol])[: max(n_starts, 1)]
        starts = [*starts, *(region[:, 0] + unit * np.ptp(region, axis=1))]
    return np.array(starts), region


def _zero(equations, derivatives, t, start):
    """A state at which f is about zero, reached from a start; None if the search fails."""
    with np.errstate(all="ignore"):
        try:
            state = root(
                lambda y: equations.rates(t, y), start, jac=lambda y: derivatives.at(t, y)
            ).x
            state = _polished(equations, derivatives, t, state)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None  # the iteration left the domain of `fun`
    return state + 0.0 if np.isfinite(state).all() else None


def _polished(equations, derivatives, t, state):
    """A state after some steps of Newton's method."""
    for _ in range(POLISH):
        rates = equations.rates(t, state)
        matrix = derivatives.at(t, state)
        state = state - np.linalg.lstsq(matrix, rates, rcond=1e-12)[0]
    return state


def _goes_on(equations, derivatives, here, size):
    """Whether further equilibria lie beside an equilibrium, in a direction in which f' is zero."""
    if not np.isfinite(here.matrix).all():
        return False
    _, values, vectors = np.linalg.svd(here.matrix)
    for v in vectors[values <= SINGULAR * values.max()]:
        for step in (BESIDE, -BESIDE):
            with np.errstate(all="ignore"):
                try:
                    start = here.y + step * size * v
                    state = _polished(equations, derivatives, here.t, start)
                    rates = equations.rates(here.t, state)
                    matrix = derivatives.at(here.t, state)
                except (ArithmeticError, ValueError, np.linalg.LinAlgError):
                    continue
            moved = np.abs((state - here.y) / size).max() > BESIDE / 2 * np.abs(v).max()
            if moved and np.isfinite(state).all() and at_rest(rates, matrix, state):
                return True
    return False


def _is_zero(derivatives, here):
    """Whether f is zero up to rounding in the directions in which f' does not change f."""
    if derivatives.underflow(here.t, here.y):
        return False
    vectors, values, _ = np.linalg.svd(here.matrix)
    null = vectors[:, values <= SINGULAR * values.max()]
    terms = np.maximum(derivatives.summands(here.t, here.y), np.abs(here.rates))
    return bool((np.abs(here.rates @ null) <= ROUNDING * (terms @ np.abs(null))).all())


def _inside(state, region, size):
    if region is None:
        return True
    edge = EDGE * size
    return bool(((state >= region[:, 0] - edge) & (state <= region[:, 1] + edge)).all())
