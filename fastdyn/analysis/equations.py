"""The equations of an analysis: a function of the user or a system, its values and its Jacobian."""

import inspect
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.bind import bind
from fastdyn.compile.compare import called
from fastdyn.compile.derivatives.compare import compare_jacobian
from fastdyn.compile.derivatives.jacobian import jacobian
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import called_with, explained
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.ensemble.labels import argument_labels, argument_names, component_labels
from fastdyn.problem.members import Shared
from fastdyn.problem.validate import extra_arguments, initial_state
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat

SUMS = ("add", "sub")  # the operations with the largest rounding errors, because terms may cancel
AROUND = 0.1  # share of a component's size by which states of a comparison are moved


class NotConvergedError(RuntimeError):
    """Raised if a search fails; the message says how far the search came, and what may help."""


class SystemEquations(NamedTuple):
    """y' = fun(t, y, *args); `system` is None for a function of the user."""

    fun: Any
    args: tuple
    system: Any

    def labels(self, n):
        """Name and unit of each component of the state."""
        return component_labels(self.system, n)

    def parameter(self, name):
        """The position in `args` of a parameter, by its name or its position."""
        labels = [label.name for label in argument_labels(self.fun, self.args, self.system)]
        if isinstance(name, str) and name in labels:
            return labels.index(name)
        if not isinstance(name, str | bool) and name in range(len(labels)):
            return int(name)
        raise ValueError(f"There is no parameter {name!r}; {self._known(labels)}")

    def _known(self, labels):
        """The known parameters, in words, and the names of arguments without a value."""
        bare = self.system is None and not self.args
        written = [label.name for label in argument_names(self.fun)] if bare else []
        if written:
            names = ", ".join(map(repr, written))
            return (
                f"`fun` has {names} after t and y, but `args` is empty: give the values by `args`, "
                "and one of these names as the parameter."
            )
        return f"the parameters are {', '.join(map(repr, labels)) or 'none'}."

    def parameter_label(self, j):
        """Name and unit of a parameter."""
        return argument_labels(self.fun, self.args, self.system)[j]

    def number(self, j):
        """The value of a parameter, which must be a real number."""
        value = self.args[j]
        if (
            isinstance(value, bool)
            or np.ndim(value)
            or not isinstance(value, int | float | np.number)
        ):
            name = self.parameter_label(j).name
            raise TypeError(f"The parameter {name!r} must be a number to be varied; got {value!r}.")
        return float(value)

    def replaced(self, j, value):
        """The equations with another value of a parameter."""
        args = (*self.args[:j], float(value), *self.args[j + 1 :])
        return self._replace(args=args)

    def rates(self, t, y):
        """f(t, y) in Python, refused if its length is not that of y."""
        try:
            found = np.asarray(self.fun(t, y.copy(), *self.args), float)
        except Exception as error:
            explained(error, called_with(self.fun, self.args), "fun", t, y)
            raise
        if found.shape != y.shape:
            raise ValueError(
                f"`fun` must return {len(y)} numbers, as many as the state has; got shape "
                f"{found.shape}."
            )
        return found

    def differentiated(self, t, y):
        """A Derivatives of the equations, traced around a time and a state.

        Raises
        ------
        ValueError
            If the function cannot be traced or differentiated.
        """
        self.rates(t, y)  # mistakes of the user are reported by Python
        n = len(y)
        bound = bind(self.fun, self.args, DERIVATIVE, n, Near(t, t + 1.0, y))
        traced = bound.function is not None and bound.function.traced is not None
        attempt = Attempt(self.fun, self.args, DERIVATIVE, n)
        reason = None if traced else attempt.why() or "it has no trace"
        found = None
        try:
            found = jacobian(bound.function, True) if traced else None
        except Untraceable as refused:
            reason = str(refused)
        if found is None:
            name = getattr(self.fun, "__name__", "fun")
            raise ValueError(
                f"The Jacobian needs a function that can be traced and differentiated, and "
                f"`{name}` cannot: {reason}."
            )
        rng = np.random.default_rng(0)
        size = AROUND * np.maximum(np.abs(y), AROUND)
        states = [y, *(y + size * rng.standard_normal((2, n)))]
        compare_jacobian(bound, [t, t, t], states)
        return Derivatives(bound, found, n)


class Derivatives(NamedTuple):
    """Compiled df/dy and df/dt of equations."""

    bound: Any
    code: Any
    n: int

    @property
    def autonomous(self):
        """Whether f does not depend on t; forcing that jumps has no derivative, but a time."""
        outputs = self.bound.function.traced.stored[: self.n]
        return self.code.autonomous and not any(node.op == "t" for node in live(outputs))

    def at(self, t, y):
        """df/dy, shape (n, n)."""
        out, *_ = called(
            self.bound, self.code.function, self.code.size, float(t), np.asarray(y, float)
        )
        matrix = np.zeros((self.n, self.n))
        matrix[self.code.rows, self.code.columns] = out[: len(self.code.rows)]
        return matrix

    def underflow(self, t, y):
        """Whether a number in f(t, y) is too small for a float, and is 0 or nearly so."""
        traced = self.bound.function.traced
        outputs = traced.stored[: self.n]
        values = flat([value for _, value in self.bound.values])
        given = traced.trace.graph, outputs, np.array([float(t)]), y[:, None], values
        try:
            evaluate(*given, under="raise")
        except FloatingPointError:
            return True
        return False

    def summands(self, t, y):
        """The largest number that is added or subtracted inside each rate, shape (n,)."""
        traced = self.bound.function.traced
        outputs = traced.stored[: self.n]
        nodes = [[a for node in live([o]) if node.op in SUMS for a in node.args] for o in outputs]
        values = flat([value for _, value in self.bound.values])
        watch = [a for each in nodes for a in each]
        found = evaluate(traced.trace.graph, [], np.array([float(t)]), y[:, None], values, watch)
        sizes = np.abs(np.asarray(found[1], float).reshape(-1))
        sizes[~np.isfinite(sizes)] = 0.0
        ends = np.cumsum([len(each) for each in nodes])
        return np.array([part.max(initial=0.0) for part in np.split(sizes, ends[:-1])])


def equations_of(fun: Any, args: Any = ()):
    """The SystemEquations of a function or of a system.

    Raises
    ------
    TypeError
        For anything else, and for arguments beside a system.
    """
    if inspect.isclass(fun) and hasattr(fun, "rhs"):
        name = getattr(fun, "name", fun.__name__)
        raise TypeError(f"`{name}` is a class of systems: write {name}(), with parameters.")
    if not inspect.isclass(fun) and hasattr(fun, "rhs") and hasattr(fun, "states"):
        if len(extra_arguments(args)):
            raise TypeError(f"`args` of the {fun.name} are its parameters; set them by name.")
        return SystemEquations(fun.rhs, fun.args, fun)
    if not callable(fun):
        raise TypeError(f"`fun` must be a function of (t, y, *args), or a system; got {fun!r}.")
    return SystemEquations(fun, extra_arguments(args), None)


def state_of(equations, y0, name="y0"):
    """A state as a new array of floats; of a system, its initial state if none is given."""
    if y0 is None:
        if equations.system is None:
            raise ValueError(f"`{name}` is missing: only a system has an initial state of its own.")
        y0 = equations.system.initial_state()
    y0 = initial_state(y0, name)
    if y0.dtype.kind == "c":
        raise TypeError(f"`{name}` must be real: split complex components into their parts.")
    if not y0.size:
        raise ValueError(f"`{name}` has no components.")
    if equations.system is not None and len(y0) != len(equations.system.states):
        names = ", ".join(state.name for state in equations.system.states)
        raise ValueError(
            f"`{name}` of the {equations.system.name} must be {len(equations.system.states)} "
            f"numbers ({names}); got {len(y0)}."
        )
    return y0


def shared(args):
    """Arguments of an ensemble that all trajectories share."""
    return tuple([Shared(a) if isinstance(a, np.ndarray | list) else a for a in args])


def box_of(box, n) -> Any:
    """Pairs (low, high), as an array of shape (n, 2).

    Raises
    ------
    ValueError
        For another shape, numbers that are not finite, and empty intervals.
    """
    try:
        found = np.asarray(box, float)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim != 2 or found.shape[-1] != 2 or not len(found) or n not in (None, len(found)):
        wanted = "each component" if n is None else f"each of the {n} components"
        raise ValueError(f"`box` must have a pair (low, high) for {wanted}; got {box!r}.")
    if not np.isfinite(found).all() or (found[:, 0] >= found[:, 1]).any():
        raise ValueError(f"`box` must have finite pairs with low < high; got {box!r}.")
    return found


def positive(value, name):
    """A positive finite number."""
    if (
        isinstance(value, bool)
        or not np.isscalar(value)
        or not isinstance(value, int | float | np.number)
    ):
        raise TypeError(f"`{name}` must be a positive number; got {value!r}.")
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"`{name}` must be a positive number; got {value!r}.")
    return float(value)


def count(value, name, least=1):
    """A whole number, at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ValueError(f"`{name}` must be a whole number, at least {least}; got {value!r}.")
    return int(value)
