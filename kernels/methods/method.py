"""What a method is: facts, and its code, which is imported when it has to be compiled."""

import importlib
import math
from typing import Any, NamedTuple

from ..output.arguments import MOST_ROOTS


class Method(NamedTuple):
    """A method: its loop, and what others need to know of it.

    Parameters
    ----------
    name : str
    order : int
    error_order : int
        Order of the error estimate, 0 for fixed steps.
    n_stages : int
        Evaluations of the derivative in a step, tried or accepted.
    n_rows : int
        Rows of stages that the method keeps in the work array; see `n_matrices`.
    fsal_stage : int
        The stage that is the derivative at the end of a step.
    kernel : function
        ``kernel(rhs, form)``, the loop around a right-hand side: see `adaptive.kernel`.
    start : function
        ``start(state, work, block, order, fsal_stage)``, the first derivative and step.
    n_dense : int
        Rows of the interpolant.
    dense_rows : function
        ``dense_rows(rhs, t, h, work, block, d)`` fills the rows beyond F2, returns its evaluations.
    dense_order : int
    second_order : bool
        Whether the method integrates q'' = a(t, q): the derivative it calls is the acceleration.
    lane_kernel : function, optional
        The same with a trajectory in each lane, if the steps are written for it: see
        `lanes.adaptive`.
    separable : function, optional
        ``separable(velocity)``, the `kernel` for H = T(p) + V(q), if the method is made for it.
    h_max_share : float
        Longest step as a share of the span, unless the caller gives one.
    projects : bool
        Whether the state may be changed between two steps.
    cost : int
        Evaluations that a step may take, for the first guess of its time; n_stages unless given.
    n_matrices : int
        Matrices of n x n numbers that the method keeps behind its rows.
    complex_matrices : bool
        Whether two of these are a complex one.
    batched : tuple (int, function), optional
        The number of stages of an implicit method, and the `kernel` that evaluates all of them on
        exact vectors, with the same bits.
    tableau : dict
        Coefficients as printed, for the tests of the order conditions.
    """

    name: str
    order: int
    error_order: int
    n_stages: int
    n_rows: int
    fsal_stage: int
    kernel: Any
    start: object
    n_dense: int
    dense_rows: object
    dense_order: int
    second_order: bool = False
    lane_kernel: Any = None
    separable: Any = None
    h_max_share: float = math.inf
    projects: bool = True
    cost: int = 0
    n_matrices: int = 0
    complex_matrices: bool = False
    batched: Any = None
    tableau: dict | None = None


class Derivatives(NamedTuple):
    """Of a right-hand side on vectors, for the `lane_kernel` of a method that factorises.

    ``function(t, y, block, out)`` gives the entries of the Jacobian in these places, and behind
    them df/dt, n vectors, which `timed` says may differ from zero.
    """

    function: Any
    rows: Any
    columns: Any
    timed: bool


class Facts(NamedTuple):
    """What a solve needs to know of a method whose kernels are compiled; see `Method`.

    `file` is where its Method is defined.  `start` and `dense_rows` name what several methods may
    have in common.  `separable` says whether it is made for H = T(p) + V(q), too; `series` whether
    its loop is made for each function, from its trace; `takes_mass` whether it solves M y' = f,
    with the time derivative of f; `loop` names the method whose loop it takes, if another's.
    """

    name: str
    file: str
    order: int
    error_order: int
    n_stages: int
    n_rows: int
    fsal_stage: int
    n_dense: int
    dense_order: int
    start: str
    dense_rows: str
    second_order: bool = False
    separable: bool = False
    h_max_share: float = math.inf
    projects: bool = True
    cost: int = 0
    n_matrices: int = 0
    complex_matrices: bool = False
    series: bool = False
    takes_mass: bool = False
    loop: str = ""

    def rows(self, n_matrix):
        """Rows that the method keeps in the work array, where a matrix takes so many."""
        return self.n_rows + self.n_matrices * n_matrix

    @property
    def code(self):
        """The Method; RuntimeError if it is not what the facts say."""
        module = importlib.import_module(f".{self.file}", __package__)
        found = {method.name: method for method in _methods_in(vars(module).values())}[self.name]
        if any(getattr(found, field) != getattr(self, field) for field in SHARED) or (
            found.start.py_func.__name__ != self.start
            or (found.separable is not None) != self.separable
        ):
            raise RuntimeError(f"{self.name} is not what kernels/methods/__init__.py says of it")
        return found

    @property
    def events_at_once(self):
        """How often an event may occur in a step."""
        return MOST_ROOTS if self.series else 1

    @property
    def tableau(self):
        """Coefficients as printed."""
        return self.code.tableau


SHARED = set(Method._fields) & set(Facts._fields) - {"start", "dense_rows", "separable"}


def _methods_in(values):
    for value in values:
        if isinstance(value, Method):
            yield value
        elif type(value) is tuple:
            yield from _methods_in(value)
