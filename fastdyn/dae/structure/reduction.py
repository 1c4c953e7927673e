"""Reduction: a function F(t, y, y') of any index as an ordinary differential equation."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fastdyn.compile import memory
from fastdyn.compile.functions import GROWING
from fastdyn.trace.graph.expressions import live
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from ..problem import checked
from . import choice, formulas
from .differentiate import differentiated
from .eliminate import pivots
from .equations import equations, without_aliases
from .signature import offsets, signature
from .start import check_regular, guess

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, State

NODES = 100  # of a graph, which take as much memory as a small function


class Structure(NamedTuple):
    """The structure of equations F: the graph of F determines the structure for all parameters.

    Attributes
    ----------
    found : signature.Offsets
        Of the equations as they are given.
    system : Differentiated
    differential : frozenset of int
        The components whose derivatives occur in F.
    """

    found: Any
    system: Any
    differential: frozenset


_structures = memory.Table()  # by the keys of graphs
_formulas = memory.Table()  # functions of the reduced state, by the keys of graphs and more


class Reduction:
    """The index reduction of ``fun(t, y, yp, *args)``: see `reduce_index`.

    The structure is remembered; the pivots are those of the present values.  `varying` has the
    positions of arguments, from 1, that differ between trajectories.

    Attributes
    ----------
    index : int
        The structural index: 0 for an ordinary differential equation.
    differentiated : ndarray of int
        How often each equation is differentiated.
    freedom : int
        The number of states: so many components of a start are free.
    differential : frozenset of int
        The components whose derivatives occur in the function.
    pivots : tuple
        The pivots of the elimination in `motion`: see `eliminate`.
    """

    def __init__(self, given, varying=()):
        whole, key = equations(given, varying)
        known = _structures.get(key)
        if known is None:
            with GROWING:
                known = _structures.put(key, _structure(whole), _size(whole))
        found, system, self.differential = known
        self.index, self.differentiated = found.structural_index, found.equations.copy()
        self.freedom = found.freedom
        known = system.given._replace(values=whole.values, varied=whole.varied)
        self.system = system._replace(given=known)
        self._key, self._size = key, _size(whole)
        self.pivots = tuple(pivots(self.system, given.t0, guess(self.system, given.y0, given.yp0)))
        self.motion = self._function(formulas.motion, self.pivots)
        constrained = system.offsets.equations.any()
        self.projection = self._function(formulas.projection) if constrained else None

    def components(self, used):
        """The function (t, x, p) that returns y; nan for components that are not `used`."""
        return self._function(formulas.components, self.pivots, tuple(sorted(used)))

    def elements(self):
        """The function (t, x, p) that returns the elements of the matrix."""
        return self._function(formulas.elements)

    def slopes(self):
        """The formulas.Slopes of the equations by the components and by what `varied` names."""
        return self._function(formulas.slopes, self.system.given.varied)

    def _function(self, formula, *given):
        """The function of a formula, or what else a formula makes, remembered."""
        place = (self._key, formula.__name__, *given)
        found = _formulas.get(place)
        if found is None:
            with GROWING:
                found = _formulas.put(place, formula(self.system, *given), self._size)
        return found

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
    n = whole.n
    rates = {node.data - n for node in live(whole.outputs) if node.op == "y" and node.data >= n}
    return Structure(found, _smallest(whole), frozenset(rates))


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
        self._system = system
        self.depths = depths
        self._places = choice.states(system, depths)
        given = system.given
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


@shown_when_wrong(fun=kinds.function_of("(t, y, yp)"), t0=kinds.number)
def reduce_index(
    fun: Callable,
    y0: State,
    yp0: State | None = None,
    args: Args | None = None,
    t0: float = 0.0,
) -> Reduction:
    """Analyse and reduce the index of ``fun(t, y, yp, *args) = 0``, from a plain Python function.

    The function is traced. Its equations are differentiated by time, exactly, as often as their
    structure says, so that they determine the derivative of each component.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, yp, *args)`` returns n residuals for n components of y and their derivatives.
    y0, yp0 : array_like, shape (n,)
        A state near which the function is called; `yp0` is zero by default.
    args : tuple, optional
        Further arguments of the function.
    t0 : float
        The time at which the function is called.

    Returns
    -------
    Reduction
        With `index`, `differentiated` and `freedom`.

    Raises
    ------
    ValueError
        If the structure is singular, or the function cannot be traced.
    """
    span = (t0, float(t0) + 1.0)
    return Reduction(checked(fun, span, y0, yp0, None, False, None, args, None, {}))
