"""Calls of many members at once: an ensemble where there are no derivatives, else one by one."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.methods import METHODS
from fastdyn.problem.members import Shared
from fastdyn.problem.options.table import refused_by


class Axis(NamedTuple):
    """The first axis of some operands, which counts members; `size` is None without one."""

    size: Any
    of: tuple

    def member(self, operands, i):
        """The operands of one member."""
        pairs = zip(operands, self.of, strict=True)
        return [operand[i] if counts else operand for operand, counts in pairs]

    def each(self, function, operands):
        """The results of a function of operands, a list of arrays, for all members."""
        if self.size is None:
            return function(operands)
        found = [function(self.member(operands, i)) for i in range(self.size)]
        return [np.stack(arrays) for arrays in zip(*found, strict=True)]


def solved(call, values, axis, solve_ensemble=None):
    """The arrays of outputs and the status, as one list, of all members."""
    if axis.size and solve_ensemble is not None and _is_ensemble(call, axis):
        return _ensemble(call, values, axis, solve_ensemble)

    def one(own):
        arrays, status = call.solve(own)
        return [*arrays, np.array(float(status))]

    return axis.each(one, values)


def _is_ensemble(call, axis):
    """Whether an ensemble has the problem: numbers differ, or the initial state, and no events."""
    p = call.fixed
    if call.shapes.n_events or not (isinstance(p.method, str) and p.method in METHODS):
        return False
    scalar = [not call.inputs[i] or call.places[i] == 0 for i, own in enumerate(axis.of) if own]
    refused = {"discrete", *refused_by("solve_ensemble")}
    return all(scalar) and refused.isdisjoint(p.options)


def _ensemble(call, values, axis, solve_ensemble, names=()):
    """The lists of `solved`, and of `sloped` with the names of directions."""
    p = call.fixed
    y0 = call.constants[0]
    args = list(call.constants[1:])
    args = [Shared(a) if isinstance(a, np.ndarray | list) else a for a in args]
    for place, value, own in zip(call.places, values, axis.of, strict=True):
        value = np.array(value, float, order="C")
        if place == 0:
            y0 = value
        else:
            args[place - 1] = value if own else Shared(value) if value.ndim else float(value)
    if y0.ndim == 1 and not np.isfinite(y0).all():
        y0 = np.tile(y0, (axis.size, 1))
    if not np.isfinite(y0).all(axis=-1).any():
        shape = axis.size, call.shapes.n, call.shapes.n_points
        found = [np.full(shape, np.nan), np.full(axis.size, -1.0)]
        rows = shape[1] * shape[2], sum([shape[1] if name == "y0" else 1 for name in names])
        return [*found, np.full((axis.size, *rows), np.nan)] if names else found
    if axis.size == 1 and y0.ndim == 1:
        y0 = y0[None]
    more = {"sensitivity": names} if names else {}
    result = solve_ensemble(
        p.fun, p.t_span, y0, tuple(args), p.method, p.t_eval, **p.options, **more
    )
    found = [np.asarray(result.y), np.asarray(result.status, float)]
    if not names:
        return found
    parts = [each.reshape(axis.size, call.shapes.n, -1, call.shapes.n_points)
             for each in result.sensitivity.values()]  # fmt: skip
    slopes = np.concatenate(parts, axis=2).transpose(0, 1, 3, 2)
    return [*found, slopes.reshape(axis.size, -1, slopes.shape[-1])]


def sloped(call, wanted, values, axis, solve_ensemble=None):
    """The arrays of outputs, the status, and one matrix of slopes, as a list, of all members."""
    numbers = all(not call.inputs[i] or call.places[i] == 0 for i in wanted)
    numbers = numbers and call.fixed.options.get("mass") is None
    if axis.size and wanted and numbers and solve_ensemble is not None and _is_ensemble(call, axis):
        return _ensemble(call, values, axis, solve_ensemble, call.names(wanted))

    def one(own):
        found = call.forward(own, wanted)
        rows = [slope.reshape(-1, slope.shape[-1]) for slope in found.slopes]
        return [*found.outputs, np.array(float(found.status)), np.concatenate(rows)]

    return axis.each(one, values)


def pushed(call, wanted, operands, axis):
    """The derivatives of the outputs along tangents; operands are the values, then the tangents."""
    n = len(call.inputs)
    made = _once(lambda values: call.forward(values, wanted), axis, operands, n)
    return axis.each(lambda own: made(own[:n]).push(wanted, own[n:]), operands)


def pulled(call, wanted, operands, axis):
    """The derivatives by values `wanted`; operands are the values, then those by the outputs."""
    n = len(call.inputs)
    made = _once(lambda values: call.backward(values, wanted), axis, operands, n)
    return axis.each(lambda own: made(own[:n]).pull(own[n:]), operands)


def _once(make, axis, operands, n):
    """The function `make` of n values, called once if the values are those of all members."""
    if axis.size is None or any(axis.of[:n]):
        return make
    one = make(operands[:n])
    return lambda values: one
