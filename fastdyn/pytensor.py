"""`solve_ivp` for PyTensor, and so for PyMC: an Op with its derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from fastdyn.plot.needed import needed
from fastdyn.solve.differentiable import Library, Solution, door

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


def _solution(call, values):
    *arrays, status = SolveOp(call)(*values, return_list=True)
    return call.shapes.solution(pt.constant(call.fixed.t_eval.astype(float)), arrays, status)


solve_ivp = door(
    __name__, PYTENSOR, _solution, arrays="variables", array="a variable",
    shapes="  The shapes of all variables must be known.", use=": a sampler rejects it",
)  # fmt: skip


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


PullOp.transposed = PushOp
PushOp.transposed = PullOp
