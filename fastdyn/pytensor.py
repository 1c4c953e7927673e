"""`solve_ivp` for PyTensor, and so for PyMC: an Op with its derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.plot.needed import needed
from fastdyn.solve.differentiable import Library, Solution, call_of

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Function, Functions, Method, Times, TimeSpan

pytensor = needed("pytensor", "fastdyn.pytensor needs")
pt = needed("pytensor.tensor")
graph = needed("pytensor.graph")
gradient = needed("pytensor.gradient")

__all__ = ["Solution", "SolveOp", "solve_ivp"]

TWICE = (
    "fastdyn.pytensor.solve_ivp is differentiated once: its Hessian is not available.  Samplers by "
    "gradients, as NUTS, need none."
)
PYTENSOR = Library(
    "PyTensor",
    lambda value: isinstance(value, graph.Variable),
    lambda value: True,
    lambda value: getattr(value, "dtype", type(value).__name__),
    lambda values: pt.stack([pt.as_tensor(value, dtype=_own_type(value)) for value in values]),
    lambda value: value.type.shape,
    "convert it by .astype('float64').",
    "give it by pt.specify_shape(value, shape), or as a sequence of numbers.",
)


def _own_type(value):
    return value.dtype if isinstance(value, graph.Variable) else "float64"


def solve_ivp(
    fun: Function,
    t_span: TimeSpan,
    y0: Any,
    method: Method = "RK45",
    t_eval: Times | None = None,
    events: Functions | None = None,
    args: tuple = (),
    *,
    occurrences: int = 1,
    **options: Any,
) -> Solution:
    """Solve ``y' = fun(t, y, *args)`` as a function of PyTensor's variables.

    Parameters
    ----------
    fun, t_span, method, events
        As in `fastdyn.solve_ivp`: `fun` is written with NumPy, and compiled by fastdyn.
    y0 : array_like, shape (n,)
        Initial state; a variable of float64, of known length, or a sequence with such numbers.
    t_eval : array_like, optional
        Times of output; by default the end of the span alone.
    args : tuple
        Arguments of `fun` and of the events.  Variables of float64, of known shape, vary; all else
        is fixed.
    occurrences : int
        The number of occurrences of each event that are returned.
    **options
        Tolerances and other options of `fastdyn.solve_ivp`, fixed.

    Returns
    -------
    Solution
        A NamedTuple of variables: `t`, `y` of shape (n, n_points), `t_events`, `y_events`,
        `status`.  Times of events are differentiated, too, and the states there as they move.
        What a run does not reach is nan, as is all of a run that fails: a sampler rejects it.

    Raises
    ------
    TypeError, ValueError
        For float32 and integers that should vary, for variables of unknown shape or that `fun`
        takes from outside of `args`, and as `fastdyn.solve_ivp`.

    Notes
    -----
    Derivatives are those of `sensitivity`; those by more than eight numbers in reverse are those of
    `adjoint`, where it covers the problem.  They are of first order.
    """
    call, values = call_of(
        PYTENSOR, fun, t_span, y0, method, t_eval, events, args, occurrences, options
    )
    *arrays, status = SolveOp(call)(*values, return_list=True)
    return call.shapes.solution(pt.constant(call.fixed.t_eval.astype(float)), arrays, status)


class _OfCall(graph.Op):
    """An Op of the values of a Call, which is a part of it."""

    __props__ = ("call",)
    transposed: Any

    def __init__(self, call):
        self.call = call

    def _types(self, shapes):
        return [pt.TensorType("float64", shape=shape)() for shape in shapes]


class SolveOp(_OfCall):
    """The outputs of a Call, and the status, as a function of its values."""

    def make_node(self, *values):
        """The node of an application to variables."""
        given = [pt.as_tensor(value) for value in values]
        outputs = self._types(self.call.shapes.arrays())
        return graph.Apply(self, given, [*outputs, pt.TensorType("int64", shape=())()])

    def perform(self, node, inputs, output_storage):
        """Solve."""
        arrays, status = self.call.solve(inputs)
        for storage, array in zip(output_storage, [*arrays, np.array(status)], strict=True):
            storage[0] = array

    def infer_shape(self, fgraph, node, shapes):
        """The shapes are known."""
        return [*[tuple(map(pt.constant, s)) for s in self.call.shapes.arrays()], ()]

    def connection_pattern(self, node):
        """The status is not differentiable."""
        n = len(self.call.shapes.arrays())
        return [[True] * n + [False] for _ in node.inputs]

    def L_op(self, inputs, outputs, output_grads):
        """The derivatives of a number by the values, from those by the outputs."""
        pairs = zip(outputs[:-1], output_grads[:-1], strict=True)
        g = [_or_zeros(*each) for each in pairs]
        return PullOp(self.call)(*inputs, *g, return_list=True)


class _Linear(_OfCall):
    """An Op that is linear in the inputs behind the values; the derivatives of one are another."""

    def L_op(self, inputs, outputs, output_grads):
        """The derivatives by those inputs; by the values, they would be second derivatives."""
        n = len(self.call.inputs)
        g = [_or_zeros(*each) for each in zip(outputs, output_grads, strict=True)]
        back = self.transposed(self.call)(*inputs[:n], *g, return_list=True)
        none = [gradient.grad_not_implemented(self, i, x, TWICE) for i, x in enumerate(inputs[:n])]
        return [*none, *back]


def _or_zeros(output, g):
    """The derivatives by an output; zeros if the number does not depend on the output."""
    unused = isinstance(g.type, gradient.DisconnectedType)
    return pt.zeros(output.type.shape, "float64") if unused else g


class PullOp(_Linear):
    """The derivatives of a number by the values, from the values and those by the outputs."""

    def make_node(self, *inputs):
        """The node of an application to variables."""
        return graph.Apply(
            self, [pt.as_tensor(each) for each in inputs], self._types(self.call.inputs)
        )

    def perform(self, node, inputs, output_storage):
        """Solve, and go back."""
        n = len(self.call.inputs)
        found = self.call.backward(inputs[:n], tuple(range(n))).pull(inputs[n:])
        for storage, array in zip(output_storage, found, strict=True):
            storage[0] = np.array(array)


class PushOp(_Linear):
    """The derivatives of the outputs, from the values and the tangents along which they are."""

    def make_node(self, *inputs):
        """The node of an application to variables."""
        outputs = self._types(self.call.shapes.arrays())
        return graph.Apply(self, [pt.as_tensor(each) for each in inputs], outputs)

    def perform(self, node, inputs, output_storage):
        """Solve with sensitivities."""
        n = len(self.call.inputs)
        wanted = tuple(range(n))
        found = self.call.forward(inputs[:n], wanted).push(wanted, inputs[n:])
        for storage, array in zip(output_storage, found, strict=True):
            storage[0] = array


PullOp.transposed, PushOp.transposed = PushOp, PullOp
