"""One call from another library: its outputs, and their derivatives in both directions."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..ivp import solve_ivp
from .outputs import contracted

FEW = 8  # directions up to which sensitivities cost less than a sweep back: 2 to 4 solves
NOTE = (
    "`fun` is to be written with NumPy and Python's own operations, which fastdyn traces and "
    "differentiates; it is not called with arrays of another library."
)


class Fixed(NamedTuple):
    """The part of a call that all its solves share: arguments of `solve_ivp`, without values."""

    fun: Any
    t_span: tuple
    method: Any
    t_eval: np.ndarray
    events: Any
    options: dict


class Call:
    """A call without the values of the arrays that vary.

    One rule chooses how derivatives are computed: by `sensitivity`, except for those of one number
    by more than FEW numbers, which are those of `adjoint` where `adjoint` covers the problem.

    Attributes
    ----------
    fixed : Fixed
    shapes : outputs.Shapes
    constants : tuple
        y0 and args, with None in the places of the values.
    places : tuple of int
        The places of the values: 0 is that of y0, j that of the j-th argument.
    inputs : tuple of tuple of int
        The shapes of the values.
    """

    def __init__(self, fixed, shapes, constants, places, inputs):
        self.fixed = fixed
        self.shapes = shapes
        self.inputs = inputs
        self.constants = constants
        self.places = places
        self._has_adjoint = True  # until a solve shows that it has not

    def placed(self, values):
        """The initial state and the arguments, with values in their places."""
        given = list(self.constants)
        for i, value in zip(self.places, values, strict=True):
            value = np.array(value, float, order="C")
            given[i] = float(value) if value.ndim == 0 else value
        return given[0], tuple(given[1:])

    def solve(self, values):
        """The arrays of outputs, and the status; a state that is not finite is a failure."""
        result = self._solved(values)
        if result is None:
            return self.shapes.unreached(), -1
        return self.shapes.outputs(result), result.status

    def _solved(self, values, **more):
        p = self.fixed
        y0, args = self.placed(values)
        if not np.isfinite(y0).all():
            return None
        try:
            return solve_ivp(
                p.fun, p.t_span, y0, p.method, p.t_eval, events=p.events, args=args, **p.options,
                **more,
            )  # fmt: skip
        except Exception as error:
            error.add_note(NOTE)
            raise

    def names(self, wanted):
        """The names of some values, by their numbers, as `sensitivity` takes them."""
        places = [self.places[i] for i in wanted]
        return tuple(["y0" if place == 0 else f"args[{place - 1}]" for place in places])

    def are_few(self, wanted):
        """Whether the values whose numbers are `wanted` have few components."""
        return self.size(wanted) <= FEW

    def size(self, wanted):
        """The number of components of the values whose numbers are `wanted`."""
        return sum([math.prod(self.inputs[i]) for i in wanted])

    def forward(self, values, wanted):
        """The Slopes by the values whose numbers are `wanted`."""
        wanted = [i for i in wanted if math.prod(self.inputs[i])]
        if not wanted:
            return Slopes(self, [], self._solved(values))
        return Slopes(self, wanted, self._solved(values, sensitivity=self.names(wanted)))

    def backward(self, values, wanted):
        """The Pullback to the values whose numbers are `wanted`."""
        return Pullback(self, values, wanted)

    def reverse(self, values, wanted):
        """(A result that keeps its steps, None) or (None, Slopes) for derivatives by `wanted`."""
        named = [i for i in wanted if math.prod(self.inputs[i])]
        if not self._has_adjoint or self.are_few(named):
            return None, self.forward(values, wanted)
        try:
            return self._solved(values, adjoint=self.names(named)), None
        except ValueError:
            slopes = self.forward(values, wanted)  # raises what is wrong for both
            self._has_adjoint = False
            return None, slopes


class Slopes:
    """The derivatives of the outputs by all wanted values, from one solve with sensitivities.

    Attributes
    ----------
    outputs, status
        Those of this solve.
    slopes : list of ndarray
        For each array of outputs, the derivatives of shape (..., m) by all components of the
        wanted values in a row.
    """

    def __init__(self, call, wanted, result):
        self._call = call
        self._wanted = wanted
        self._sizes = [math.prod(call.inputs[i]) for i in wanted]
        self.slopes = []
        if result is None:
            self.outputs = call.shapes.unreached()
            self.status = -1
            self.slopes = [np.full((*o.shape, sum(self._sizes)), np.nan) for o in self.outputs]
        else:
            self.outputs = call.shapes.outputs(result)
            self.status = result.status
            self.slopes = call.shapes.slopes(result, list(result.sensitivity) if wanted else [])

    def push(self, wanted, tangents):
        """The derivatives of the outputs along `tangents`, those of the values `wanted`."""
        along = [np.ravel(v) for i, v in zip(wanted, tangents, strict=True) if i in self._wanted]
        if not along:
            return [np.zeros(shape) for shape in self._call.shapes.arrays()]
        return [slope @ np.concatenate(along) for slope in self.slopes]

    def pull(self, wanted, g):
        """The derivatives by the values `wanted` of a number, from those by the outputs."""
        total = contracted(self.slopes, g) if self._wanted else np.empty(0)
        parts = np.split(np.broadcast_to(total, sum(self._sizes)), np.cumsum(self._sizes)[:-1])
        found = dict(zip(self._wanted, parts, strict=True)) if self._wanted else {}
        return [np.reshape(found.get(i, []), self._call.inputs[i]) for i in wanted]


class Pullback:
    """The derivatives of numbers that depend on the outputs, by the rule of Call.

    Attributes
    ----------
    outputs, status
        As of `Call.solve`.
    """

    def __init__(self, call, values, wanted):
        self._call, self._wanted = call, tuple(wanted)
        self._values = [np.array(value, float) for value in values]
        self._result, self._slopes = call.reverse(self._values, self._wanted)
        if self._slopes is not None:
            self.outputs, self.status = self._slopes.outputs, self._slopes.status
        elif self._result is None:
            self.outputs = call.shapes.unreached()
            self.status = -1
        else:
            self.outputs, self.status = call.shapes.outputs(self._result), self._result.status

    def pull(self, g):
        """The derivatives by the wanted values of a number, from those by the outputs."""
        if self._slopes is not None:
            return self._slopes.pull(self._wanted, g)
        inputs = [self._call.inputs[i] for i in self._wanted]
        result = self._result
        if not any(np.any(each) for each in g):
            return [np.zeros(shape) for shape in inputs]
        there = [np.isfinite(each) | (by == 0) for each, by in zip(self.outputs, g, strict=True)]
        if result is None or not result.success or not all(each.all() for each in there):
            return [np.full(shape, np.nan) for shape in inputs]
        found = iter(result.vjp(g[0][:, : len(result.t)], **self._at_events(g)).values())
        return [np.asarray(next(found)) if math.prod(s) else np.zeros(s) for s in inputs]

    def _at_events(self, g):
        """The derivatives by the fields `t_events` and `y_events`, as `vjp` takes them."""
        found: dict = {"t_events": [], "y_events": []}
        for i, times in enumerate(self._result.t_events or ()):
            for name, by in zip(found, g[1 + 2 * i :], strict=False):
                rows = np.zeros((len(times), *by.shape[1:]))
                rows[: len(by)] = by[: len(times)]
                found[name].append(rows if np.any(rows) else None)
        return {name: each for name, each in found.items() if each}
