"""What a method is: facts, and its code, which is imported when it has to be compiled."""

import importlib
import math
from typing import Any, NamedTuple

import numpy as np

from ..output.arguments import MOST_ROOTS

ON_PAIRS = " on complex states"  # ends the name of a method for complex states


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
    series : bool
        Whether the loop is made for each function, from its trace.
    takes_mass : bool
        Whether the method solves M y' = f, with the time derivative of f.
    on_pairs : Method, optional
        The method for complex states, which are stored as pairs of real numbers.
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
    series: bool = False
    takes_mass: bool = False
    on_pairs: Any = None


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

    `file` is where the Method is defined.  `start` and `dense_rows` name kernels that several
    methods may have in common.  `separable` is true of a method for H = T(p) + V(q); `loop` names
    the method whose loop this one takes, if another's.  `stable_to` is the z > 0 at which the
    stability function R(-z) of an explicit pair first exceeds 1 in size.
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
    stable_to: float = 0.0

    def rows(self, n_matrix):
        """Rows that the method keeps in the work array, where a matrix takes so many."""
        return self.n_rows + self.n_matrices * n_matrix

    @property
    def code(self):
        """The Method; RuntimeError if it is not what the facts say."""
        found = method_in(self.file, self.name)
        if facts_of(found, self.file) != self._replace(loop=""):
            raise RuntimeError(f"{self.name} was changed: run `python -m bench.report.methods`")
        return found

    @property
    def events_at_once(self):
        """How often an event may occur in a step."""
        return MOST_ROOTS if self.series else 1

    @property
    def like_matlab(self):
        """True of a pair under MATLAB's control of the step, with the largest error as norm."""
        return self.start == "matlab"

    def ends_at_the_end(self, inside):
        """True if the last evaluation of a step is at its end, in SciPy as here.

        With `inside`, the interpolant is evaluated, whose stages may come later.
        """
        return self.start == "hairer" and not (inside and self.n_rows > self.fsal_stage + 1)

    @property
    def tableau(self):
        """Coefficients as printed."""
        return self.code.tableau


SHARED = [
    name for name in Facts._fields
    if name in Method._fields and name not in ("start", "dense_rows", "separable")
]  # fmt: skip


def method_in(file, name):
    """The Method of that name in a file; of "NAME on complex states" that of NAME."""
    module = importlib.import_module(f".{file}", __package__)
    base = name.removesuffix(ON_PAIRS)
    found = {method.name: method for method in _methods_in(vars(module).values())}[base]
    return found if name == base else found.on_pairs


def facts_of(method, file):
    """The Facts of a Method, but for `loop`."""
    rows = method.dense_rows.py_func
    return Facts(
        **{name: getattr(method, name) for name in SHARED},
        file=file,
        start=method.start.py_func.__name__,
        dense_rows=f"{rows.__module__.rpartition('.')[2]}.{rows.__name__}",
        separable=method.separable is not None,
        stable_to=stability_limit(method.tableau) if method.error_order else 0.0,
    )


def every_fact(file, name):
    """The Facts of a method, and of its form on complex states, if there is one."""
    method = method_in(file, name)
    yield facts_of(method, file)
    if method.on_pairs is not None:
        shares = method.on_pairs.kernel is method.kernel and not method.series
        yield facts_of(method.on_pairs, file)._replace(loop=name if shares else "")


def stability_limit(tableau):
    """The z at which |R(-z)| of an explicit method first exceeds 1, rounded down to 0.01.

    R(z) = 1 + z b (1 + z A (1 + z A ...)): E. Hairer and G. Wanner, "Solving Ordinary Differential
    Equations II", section IV.2.
    """
    if not tableau or "a" not in tableau:
        return 0.0
    s = len(tableau["b"])
    a = np.array([np.pad(row.floats, (0, s - len(row)))[:s] for row in tableau["a"][:s]])
    b, powers = np.array(tableau["b"].floats), np.ones(s)
    coefficients = [1.0]
    for _ in range(s):
        coefficients.append(b @ powers)
        powers = a @ powers
    z = np.arange(2000) / 100
    outside = np.abs(np.polyval(coefficients[::-1], -z)) > 1.0 + 1e-12
    return float(z[outside.argmax() - 1])


def _methods_in(values):
    for value in values:
        if isinstance(value, Method):
            yield value
        elif type(value) is tuple:
            yield from _methods_in(value)
