"""Python functions from a graph: straight lines of text, which fastdyn traces like any function."""

import functools
import itertools
import math
from typing import Any

import numpy as np

from fastdyn.kernels.algebra.linear import solve_linear
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.written import function_of


class Text:
    """The text of a function ``(t, x, p)`` of the time, of numbers, and of parameters.

    Attributes
    ----------
    inputs : dict
        The texts of input nodes, by key; a change holds for the lines that follow.
    """

    def __init__(self, graph, inputs):
        self.graph, self.inputs = graph, dict(inputs)
        self.lines, self._n, self._known = [], itertools.count(), {}

    def let(self, inputs):
        """Give inputs other values from here on."""
        self.inputs.update(inputs)
        self._known = {}

    def named(self, text):
        """A new name for the value of a text."""
        name = f"v{next(self._n)}"
        self.lines.append(f"{name} = {text}")
        return name

    def values(self, nodes):
        """The names of the values of nodes."""
        for node in live(nodes):
            if node.key not in self._known:
                args = [self._known[a.key] for a in node.args]
                self._known[node.key] = self._value(node, args)
        return [self._known[node.key] for node in nodes]

    def solved(self, matrix, right):
        """The names of the solution of a linear system, which is given in names."""
        if len(right) == 1:
            return [self.named(f"{right[0]} / {matrix[0][0]}")]
        names = [f"v{next(self._n)}" for _ in right]
        rows = ", ".join(f"({', '.join(row)})" for row in matrix)
        self.lines.append(f"{', '.join(names)} = solve_linear(({rows}), ({', '.join(right)}))")
        return names

    def function(self, name, results) -> Any:
        """The function that returns the results, which are texts."""
        given = results if isinstance(results, str) else f"[{', '.join(results)}]"
        lines = [f"def {name}(t, x, p, *args):", *self.lines, f"return {given}"]
        return _made(name, "\n    ".join(lines) + "\n")

    def _value(self, node, args):
        if node.op in ("t", "par", "const", "y"):
            return self._leaf(node)
        return self.named(_formula(node, args))

    def _leaf(self, node):
        if node.op == "t":
            return "t"
        if node.op == "par":
            return f"p[{node.data}]"
        if node.op == "const":
            finite = isinstance(node.data, bool) or math.isfinite(node.data)
            return repr(node.data) if finite else f"float('{node.data}')"
        return self.inputs[node.key]


def _formula(node, args):
    operation = OPERATIONS[node.op]
    if operation.sign:
        return f"{args[0]} {operation.sign} {args[1]}"
    if node.op == "select":
        return f"np.where({', '.join(args)})"
    if isinstance(operation.value, np.ufunc):
        return f"np.{operation.value.__name__}({', '.join(args)})"
    if operation.in_math:
        return f"math.{operation.in_math.__name__}({', '.join(args)})"
    raise ValueError(
        "index reduction takes no tables and no calls of libraries: the function interpolates, "
        "looks up or calls one; write it as a formula."
    )


@functools.lru_cache(256)
def _made(name, text):
    """The function of a text, one and the same for the same text, so that its code is kept."""
    space: dict[str, Any] = {
        "__name__": __name__, "np": np, "math": math, "solve_linear": solve_linear,
    }  # fmt: skip
    made = function_of(text, name, "index reduction", space)
    made.text = text
    return made
