"""The records of a method: Facts, for every solve, and Method, with the code to compile."""

import importlib
import math
import sys
from typing import Any, NamedTuple

import numpy as np

from ..output.arguments import MOST_INSIDE, MOST_ROOTS, SLOPE

SHARED_METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")  # SciPy has these, too
ON_PAIRS = " on complex states"  # suffix of the name of a method for complex states


class Facts(NamedTuple):
    """The facts about a method that a solve needs, without the code of the method.

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
    n_dense, dense_order : int
        Rows of the interpolant, and its order.
    start, dense_rows : str
        Names of two functions of the Method, which several methods may share, as
        ``stepping.first_step.hairer``; without a module if a call has made the function.
    second_order : bool
        Whether the method integrates q'' = a(t, q), so that `rhs` is the acceleration.
    separable : bool
        Whether the method also takes H = T(p) + V(q).
    h_max_share : float
        Longest step as a share of the span, unless the caller gives one.
    projects : bool
        Whether the state may be changed between two steps.
    cost : int
        Evaluations of a step, for a first estimate of its time; n_stages by default.
    n_matrices : int
        Number of matrices of n x n numbers that the method keeps behind its rows.
    complex_matrices : bool
        Whether two of the matrices are real and imaginary part of a complex matrix.
    series : bool
        Whether the loop is made for each function, from its trace.
    batched : bool
        Whether a loop of the method evaluates all stages at once, on vectors.
    takes_mass : bool
        Whether the method solves M y' = f.
    by_time : bool
        Whether the method needs the partial derivative df/dt.
    past, n_past : int
        The first row and the number of rows in which a method keeps more than its last step.
    before_events : int
        The computations before the first evaluation of the events, as in SciPy's solver of this
        name: SLOPE, JACOBIAN or NOTHING of `output.arguments`.
    stable_to : float
        The stability limit of an adaptive explicit method: see `stability_limit`.
    looks : tuple of float
        The times of a step at which the method evaluates the derivative with a weight in the error
        estimate, in rising order, as shares of the step.
    backward : str
        How a sweep goes back over the steps: "stages" of an explicit Runge-Kutta method, "kicks"
        of a symplectic one, those of a "rosenbrock" method, those of a "collocation" and of other
        implicit Runge-Kutta methods, "" not at all.
    loop : str
        The name of another method, if this method uses the loop of the other method.
    file : str
        The file that defines the Method.
    """

    name: str
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
    batched: bool = False
    takes_mass: bool = False
    by_time: bool = False
    past: int = 0
    n_past: int = 0
    before_events: int = SLOPE
    stable_to: float = 0.0
    looks: tuple = ()
    backward: str = ""
    loop: str = ""
    file: str = ""

    def __repr__(self):
        stages = f", {self.n_stages} stages" if self.n_stages > 1 else ""
        steps = "adaptive" if self.error_order else "constant"
        return f"<{self.name}: order {self.order}{stages}, {steps} steps>"

    def rows(self, n_matrix):
        """The number of rows of the work array, if a matrix takes `n_matrix` rows."""
        return self.n_rows + self.n_matrices * n_matrix

    @property
    def code(self):
        """The Method; RuntimeError if the file defines other facts than these."""
        base = method_in(self.file, self.name.removesuffix(ON_PAIRS))
        found = base if base.facts.name == self.name else base.on_pairs
        if found.facts._replace(file=self.file) != self:
            raise RuntimeError(f"{self.name} was changed: run `python -m bench.report.methods`")
        return found

    @property
    def events_at_once(self):
        """The largest number of occurrences of an event in a step."""
        return MOST_INSIDE if not self.series else MOST_ROOTS + 1  # one at a breakpoint

    @property
    def has_own_results(self):
        """True if the results are fastdyn's own, not those of SciPy's method of the name."""
        return self.name.removesuffix(ON_PAIRS) not in SHARED_METHODS

    @property
    def looks_inside(self):
        """True if two occurrences of an event within a step count."""
        return self.has_own_results and not self.like_matlab

    @property
    def is_pair(self):
        """True for an embedded explicit Runge-Kutta pair."""
        return bool(self.error_order and self.stable_to) and not self.series

    @property
    def like_matlab(self):
        """True if MATLAB's rules control the step, with the largest error as norm."""
        return self.start == "stepping.first_step.matlab"

    @property
    def largest_as_norm(self):
        """True if the norm of an error is its largest component, False if a mean of all."""
        return self.like_matlab or self.series or self.start == "stepping.first_step.lsoda"

    @property
    def tableau(self):
        """The coefficients as printed in the source."""
        return self.code.tableau


class Method(NamedTuple):
    """The code of a method.

    Parameters
    ----------
    facts : Facts
    kernel : function
        ``kernel(rhs, form)``, the loop around a right-hand side: see `adaptive.kernel`.
    start : function
        ``start(state, work, block, order, fsal_stage)``, the first derivative and step.
    dense_rows : function
        ``dense_rows(rhs, t, h, work, block, d)`` fills the rows of the interpolant beyond F2, and
        returns the number of evaluations.
    lane_kernel : function, optional
        A loop with a trajectory in each lane, if the steps are written for vectors: see
        `lanes.adaptive`.
    separable : function, optional
        ``separable(velocity)``, the `kernel` for H = T(p) + V(q), if the method takes such systems.
    batched : tuple (int, function), optional
        The number of stages of an implicit method, and the `kernel` that evaluates all stages at
        once on exact vectors.  Both kernels give equal bits.
    tableau : dict, optional
        Coefficients as printed, for the tests of the order conditions.
    rows_of_pair : function, optional
        ``rows_of_pair()``, the `dense_rows` for H = T(p) + V(q), if the method takes such systems.
    on_pairs : Method, optional
        The method for complex states, stored as pairs of real numbers.
    """

    facts: Facts
    kernel: Any
    start: Any
    dense_rows: Any
    lane_kernel: Any = None
    separable: Any = None
    batched: Any = None
    tableau: dict | None = None
    rows_of_pair: Any = None
    on_pairs: Any = None


CODE = frozenset(Method._fields)


def method(name, *, start, dense_rows, **fields):
    """A Method; `fields` are the fields of Method and Facts that do not follow from others."""
    code = {field: fields.pop(field) for field in CODE & fields.keys()}
    stable_to = stability_limit(code.get("tableau")) if fields["error_order"] else 0.0
    facts = Facts(
        name,
        start=_place(start),
        dense_rows=_place(dense_rows),
        separable=code.get("separable") is not None,
        batched=code.get("batched") is not None,
        stable_to=stable_to,
        **fields,
    )
    return Method(facts, start=start, dense_rows=dense_rows, **code)


def _place(function):
    """The name of a function behind that of its module in `kernels`.

    Alone if a call has made the function, or the module is not in `kernels`.
    """
    name = function.py_func.__name__
    module = function.py_func.__module__
    place = module.partition("kernels.")[2]
    if not place or getattr(sys.modules[module], name, None) is not function:
        return name
    return f"{place}.{name}"


def with_complex_states(method, kernel, start):
    """A Method that has a form for complex states, with another loop and start."""
    facts = method.facts
    own = facts._replace(
        name=facts.name + ON_PAIRS,
        start=_place(start),
        loop=facts.name if kernel is method.kernel and not facts.series else "",
    )
    given = {"facts": own, "kernel": kernel, "start": start, "lane_kernel": None}
    return method._replace(on_pairs=method._replace(**given))


def stability_limit(tableau):
    """The z at which |R(-z)| of an explicit method first exceeds 1, rounded down to 0.01."""
    if not tableau or "a" not in tableau:
        return 0.0
    z = np.arange(2000) / 100
    outside = np.abs(np.polyval(stability_polynomial(tableau), -z)) > 1.0 + 1e-12
    return float(z[outside.argmax() - 1])


def stability_polynomial(tableau):
    """The coefficients of R of an explicit method, from the highest on.

    R(z) = 1 + z b (1 + z A (1 + z A ...)): E. Hairer and G. Wanner, "Solving Ordinary Differential
    Equations II", section IV.2.
    """
    s = len(tableau["b"])
    a = np.array([np.pad(row.floats, (0, s - len(row))) for row in tableau["a"][:s]])
    b = np.array(tableau["b"].floats)
    powers = np.ones(s)
    coefficients: list[Any] = [1.0]
    for _ in range(s):
        coefficients.append(b @ powers)
        powers = a @ powers
    return coefficients[::-1]


def method_in(file, name):
    """The Method `name` in a file of this folder."""
    values = vars(importlib.import_module(f".{file}", __package__)).values()
    listed = [one for value in values for one in (value if type(value) is tuple else (value,))]
    return next(one for one in listed if isinstance(one, Method) and one.facts.name == name)


class Derivatives(NamedTuple):
    """The Jacobian of a right-hand side on vectors, for the `lane_kernel` of an implicit method.

    ``function(t, y, block, out)`` gives the entries of the Jacobian at (rows, columns), and behind
    the entries df/dt, n vectors.  `timed` tells whether df/dt may differ from zero.  `mass` has the
    rows and the columns of the numbers of a mass matrix, or is None.
    """

    function: Any
    rows: Any
    columns: Any
    timed: bool
    mass: Any = None
