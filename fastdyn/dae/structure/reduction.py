"""Reduction: a function F(t, y, y') of any index as an ordinary differential equation."""

import numpy as np

from . import choice, formulas
from .differentiate import differentiated
from .eliminate import pivots
from .equations import equations, without_aliases
from .signature import offsets, signature
from .start import check_regular, guess


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
        self.index, self.differentiated = found.structural_index, found.equations
        self.freedom = found.freedom
        self.system = _smallest(whole)
        order = pivots(self.system, t0, guess(self.system, y0, yp0))
        self.motion = formulas.motion(self.system, order)
        self.components = formulas.components(self.system, order)
        constrained = self.system.offsets.equations.any()
        self.projection = formulas.projection(self.system) if constrained else None

    def __repr__(self):
        counts = ", ".join(map(str, self.differentiated))
        return f"Reduction(index={self.index}, differentiated=[{counts}], freedom={self.freedom})"

    @property
    def parameters(self):
        """The numbers p of all functions."""
        return self.system.given.values

    def choice(self, t, z):
        """The Choice of states at a point z, all orders of all components.

        Raises
        ------
        start.Unsolved
            If the system is singular at this point.
        """
        matrix = self.system.matrices(np.array([float(t)]), z[:, None])[0]
        check_regular(self.system, t, matrix)
        return Choice(self.system, choice.choice(self.system.offsets, matrix))


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
    """A choice of states and dummy derivatives.

    Attributes
    ----------
    depths : tuple of choice.Depth
    states : tuple of int
        The components of y that are states; n l + j for derivative l of component j where that is
        no component itself.
    """

    def __init__(self, system, depths):
        self._system, self.depths = system, depths
        self._places, given = choice.states(system, depths), system.given
        self.states = tuple(
            sorted(
                order * given.n + given.columns[j] if name is None else name
                for j, order in self._places
                for name in [system.name(j, order)]
            )
        )

    def residual(self):
        """A residual of index 1, and its unknowns: see `formulas.residual`."""
        return formulas.residual(self._system, self._places)
