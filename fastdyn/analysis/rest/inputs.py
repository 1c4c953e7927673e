"""Inputs and outputs of linearised equations: the matrices B, C and D."""

from typing import Any, NamedTuple

import numpy as np

from ..equations import SystemEquations
from .kinds import not_differentiable


class Ports(NamedTuple):
    """The names of inputs and outputs, and their matrices."""

    inputs: tuple
    outputs: tuple
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


def ports(equations, t, y, inputs, outputs):
    """The Ports of equations at a state.

    Parameters
    ----------
    inputs : str, int, or list of these
        Arguments of the equations: numbers, and arrays of shape (m,).
    outputs : None, str, int, list of these, callable, or dict of callable
        As of `linearise`.
    """
    n, places = len(y), [equations.parameter(name) for name in _listed(inputs)]
    if len(set(places)) < len(places):
        raise ValueError(f"`inputs` names one argument twice; got {inputs!r}.")
    names = []
    values = [y]
    shapes = []
    for j in places:
        value = _numbers(equations, j)
        label = equations.parameter_label(j).name
        names += [f"{label}[{i}]" for i in range(len(value))] if value.ndim else [label]
        values.append(np.atleast_1d(value))
        shapes.append(value.ndim)
    z = np.concatenate(values)
    sizes = [len(each) for each in values[1:]]

    def arguments(z):
        given = list(equations.args)
        at = n
        for j, size, is_row in zip(places, sizes, shapes, strict=True):
            given[j] = z[at : at + size] if is_row else z[at]
            at += size
        return given

    known, observed, count = _outputs(equations, n, outputs)
    whole = max(len(z), count)
    z = np.concatenate([z, np.zeros(whole - len(z))])

    def slopes(fun, rows):
        def padded(t, z):
            found = fun(t, z[:n], *arguments(z))
            found = list(found) if hasattr(found, "__len__") else [found]
            return [*found, *[0.0] * (len(z) - len(found))]

        padded.__name__ = getattr(fun, "__name__", "fun")
        longer = SystemEquations(padded, (), None)
        derivatives = longer.differentiated(t, z)
        found = derivatives.at(t, z)
        broken = not_differentiable(longer, derivatives, t, z, found)
        found = np.where(broken, np.nan, found)[:rows, : n + len(names)]
        if np.isinf(found).any():
            raise ValueError(f"The derivatives by `inputs` are not finite at t = {t:g}, y = {y}.")
        return found[:, :n], found[:, n:]

    B = slopes(equations.fun, n)[1]
    C, D = slopes(observed, count)
    return Ports(tuple(names), known, B, C, D)


def _listed(names):
    return names if isinstance(names, list | tuple) else [names]


def _numbers(equations, j):
    value = equations.args[j]
    found = np.asarray(value)
    if isinstance(value, bool) or found.dtype.kind not in "fiu" or found.ndim > 1 or not found.size:
        name = equations.parameter_label(j).name
        raise TypeError(f"The input {name!r} must be a number, or numbers (m,); got {value!r}.")
    return found.astype(float)


def _outputs(equations, n, outputs) -> Any:
    """(names, ``observed(t, y, *args)``, number of outputs)."""
    labels = [label.name for label in equations.labels(n)]
    if callable(outputs):
        one = np.atleast_1d(np.asarray(outputs(0.0, np.zeros(n), *equations.args), float))
        name = getattr(outputs, "__name__", "output").strip("<>")
        many = len(one) > 1
        names = [f"{name}[{i}]" for i in range(len(one))] if many else [name]
        return tuple(names), outputs, len(one)
    if isinstance(outputs, dict):
        functions = tuple(outputs.values())
        if not functions or not all(map(callable, functions)):
            raise TypeError(f"`outputs` as a dict has functions (t, y, *args); got {outputs!r}.")

        def observed(t, y, *args):
            return [function(t, y, *args) for function in functions]

        return tuple(map(str, outputs)), observed, len(functions)
    chosen = []
    for one in range(n) if outputs is None else _listed(outputs):
        if isinstance(one, str) and one in labels:
            chosen.append(labels.index(one))
        elif not isinstance(one, str | bool) and one in range(n):
            chosen.append(int(one))
        else:
            raise ValueError(f"There is no component {one!r}; choose from {', '.join(labels)}.")
    return (
        tuple([labels[i] for i in chosen]),
        lambda t, y, *args: [y[i] for i in chosen],
        len(chosen),
    )
