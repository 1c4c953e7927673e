"""Reduction: a function F(t, y, y') of any index as an ordinary differential equation."""

import numpy as np

from . import choice, formulas, trajectory
from .differentiate import differentiated
from .equations import equations, without_aliases
from .signature import offsets, signature
from .start import check_regular



class Reduction:
    """The index reduction of ``fun(t, y, yp, *args)``: see `reduce_index`.

    Attributes
    ----------
    index : int
        The structural index: 0 for an ordinary differential equation.
    differentiated : ndarray of int
        How often each equation is differentiated.
    freedom : int
        The number of states: so many components of a start are free.
    """

    def __init__(self, fun, t0, y0, yp0, args):
        whole = equations(fun, t0, y0, yp0, args)
        found = offsets(signature(whole), whole.rows, whole.columns)
        self.index, self.differentiated = found.index, found.equations
        self.freedom = found.freedom
        self.system = _smallest(whole)
        self.motion = formulas.motion(self.system)
        self.components = formulas.components(self.system)
        self._made: dict = {}

    def __repr__(self):
        counts = ", ".join(map(str, self.differentiated))
        return f"Reduction(index={self.index}, differentiated=[{counts}], freedom={self.freedom})"

    def parameters(self, bound):
        """The numbers p of all functions."""
        return np.append(self.system.given.values, bound)

    def choose(self, t, z):
        """The Choice of states at a point, and the growth there: see `choice`.

        Raises
        ------
        start.Unsolved
            If the system is singular at this point.
        """
        matrix = self.system.matrices(np.array([float(t)]), z[:, None])[0]
        check_regular(self.system, t, matrix)
        depths = choice.choice(self.system.offsets, matrix)
        found = self._made.get(depths)
        if found is None:
            found = self._made[depths] = Choice(self.system, depths)
        return found, choice.growth(matrix, depths)

    def state_of(self, z):
        """The reduced state in an array of all orders of all components."""
        return z[trajectory.places(self.system)]


def _smallest(whole):
    """The Differentiated equations with as few components as possible.

    A component that is a derivative of higher order than the equations determine stays itself.
    """
    barred: set = set()
    while True:
        few = without_aliases(whole, barred)
        found = differentiated(few, offsets(signature(few), few.rows, few.columns))
        d = dict(zip(few.columns, found.offsets.components, strict=True))
        beyond = {k for k, (j, order) in few.alias.items() if order > d[j]}
        if not beyond:
            return found
        barred |= beyond


class Choice:
    """A choice of states, with the functions that belong to the choice.

    Attributes
    ----------
    states : tuple of int
        The components of y that are states; n (l) + j for derivative l of component j where that
        is no component itself.
    """

    def __init__(self, system, depths):
        self.depths, self.places = depths, choice.states(system, depths)
        self.projection = formulas.projection(system, depths) if depths else None
        self.pivots = formulas.pivots(system, depths)
        self._system = system
        given = system.given
        self.states = tuple(
            sorted(
                order * given.n + given.columns[j] if name is None else name
                for j, order in self.places
                for name in [system.name(j, order)]
            )
        )

    def residual(self):
        """A residual of index 1: see `formulas.residual`."""
        return formulas.residual(self._system, self.places)
