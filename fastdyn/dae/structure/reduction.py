"""Reduction: a function F(t, y, y') of any index as an ordinary differential equation."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile import memory
from fastdyn.compile.derivatives.jacobian import GROWING

from . import choice, formulas
from .differentiate import differentiated
from .eliminate import pivots
from .equations import equations, without_aliases
from .signature import offsets, signature
from .start import check_regular, guess

NODES = 100  # of a graph, which take as much memory as a small function


class Structure(NamedTuple):
    """What the graph of F alone determines, for all values of parameters.

    Attributes
    ----------
    found : signature.Offsets
        Of the equations as they are given.
    system : Differentiated
    """

    found: Any
    system: Any


_structures = memory.Table()  # by the keys of graphs
_formulas = memory.Table()  # by the keys of graphs, and pivots


class Reduction:
    """The index reduction of ``fun(t, y, yp, *args)``: see `reduce_index`.

    The structure is remembered; the pivots are those of the present values.

    Attributes
    ----------
    index : int
        The structural index: 0 for an ordinary differential equation.
    differentiated : ndarray of int
        How often each equation is differentiated.
    freedom : int
        The number of states: so many components of a start are free.
    """

    def __init__(self, given):
        whole, key = equations(given)
        known = _structures.get(key)
        if known is None:
            with GROWING:
                known = _structures.put(key, _structure(whole), _size(whole))
        found, system = known
        self.index, self.differentiated = found.structural_index, found.equations.copy()
        self.freedom = found.freedom
        self.system = system._replace(given=system.given._replace(values=whole.values))
        order = tuple(pivots(self.system, given.t0, guess(self.system, given.y0, given.yp0)))
        functions = _formulas.get((key, order))
        if functions is None:
            with GROWING:
                functions = _formulas.put((key, order), _functions(system, order), _size(whole))
        self.motion, self.components, self.projection = functions

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


def _structure(whole):
    found = offsets(signature(whole), whole.rows, whole.columns)
    return Structure(found, _smallest(whole))


def _functions(system, order):
    """The functions (motion, components, projection) of a system; None for no constraints."""
    constrained = system.offsets.equations.any()
    return (
        formulas.motion(system, order),
        formulas.components(system, order),
        formulas.projection(system) if constrained else None,
    )


def _size(whole):
    """The size of what is remembered of a graph, for `memory.Table`."""
    return 1 + len(whole.graph.nodes) // NODES


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
