"""The measured quantities of a state, with their exact derivatives."""

from typing import Any

import numpy as np

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import value_of
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.reads.reads import flat

from .free import FIXED, Template

STEP = float(np.finfo(float).eps) ** (1 / 3)  # of central differences, relative to the value
SAME = 1e-9  # relative difference of machine code and Python that counts as rounding


class Linear:
    """Components of the state, or a constant matrix times the state."""

    def __init__(self, observed, n):
        if observed is None:
            observed = range(n)
        try:
            given = np.asarray(list(observed) if isinstance(observed, range) else observed)
        except ValueError:
            given = np.array(None)
        if given.dtype.kind in "iu" and given.ndim <= 1:
            index = np.atleast_1d(given)
            if not len(index) or not ((-n <= index) & (index < n)).all():
                raise ValueError(
                    f"`observed` must be components 0 to {n - 1} of the state; got {observed!r}."
                )
            self.index, self.matrix = index % n, np.eye(n)[index]
        elif given.dtype.kind in "fiu" and given.ndim == 2 and given.shape[1] == n:
            self.index, self.matrix = None, given.astype(float)
            if not np.isfinite(self.matrix).all():
                raise ValueError("`observed` must be finite.")
        else:
            raise ValueError(
                f"`observed` must be components of the state, a matrix (n_series, {n}), or a "
                f"function of (t, y, *args); got {observed!r}."
            )

    def groups(self, n_series):
        """The quantity that each series measures."""
        if self.index is not None:
            return [("y", int(i)) for i in self.index]
        return [("row", tuple(row)) for row in self.matrix]

    def of(self, held):
        """What is observed, as a function of the leaves of the arguments: itself."""
        return self

    def values(self, t, y, args):
        """The observed quantities, of shape (n_series, n_times)."""
        return self.matrix @ y if self.index is None else y[self.index]

    def slopes(self, t, y, slopes, places, x):
        """(values, derivatives by the parameters) from those of the state."""
        if self.index is not None:
            return y[self.index], slopes[self.index]
        return self.matrix @ y, np.tensordot(self.matrix, slopes, 1)


class ObservingFunction:
    """``fun(t, y, *args)``; its derivatives are exact if the function can be traced."""

    def __init__(self, fun, n_series, n):
        self.fun = fun
        self.n_series = n_series
        self.n = n
        self.size = max(n, n_series)
        self._compared = False

        def padded(t, z, *args):  # as many results as the state has numbers
            found = fun(t, z[:n], *args)
            found = list(found) if hasattr(found, "__len__") else [found]
            return [*found, *[0.0] * (len(z) - len(found))]

        self._padded = padded

    def of(self, held):
        """What is observed, as a function of the leaves of the arguments."""
        fun = held.function(self.fun)
        return self if fun is self.fun else ObservingFunction(fun, self.n_series, self.n)

    def groups(self, n_series):
        """The quantity that each series measures."""
        return [(self.fun, i) for i in range(n_series)]

    def values(self, t, y, args):
        """The observed quantities in Python, of shape (n_series, n_times)."""
        found = np.empty((self.n_series, len(t)))
        for i, at in enumerate(t):
            with np.errstate(all="ignore"):  # as compiled code: the fit looks at the result
                one = np.asarray(value_of(self.fun, args, "observed", float(at), y[:, i].copy()))
            if one.dtype.kind not in "fiub" or one.ndim > 1 or one.size != self.n_series:
                raise ValueError(
                    f"`observed` must return {self.n_series} real numbers, one for each series; "
                    f"got {one.dtype} of shape {one.shape}."
                )
            found[:, i] = one
        return found

    def slopes(self, t, y, slopes, places, x):
        """(values, derivatives by the parameters) from those of the state."""
        args = places.at(x)[1]
        traced = self._traced(t, y, places, args)
        if traced is None:
            return self._differences(t, y, slopes, places, args)
        graph, outputs, entries, groups, values = traced
        z = np.zeros((self.size, len(t)))
        z[: self.n] = y
        wanted = [*outputs, *entries.values()]
        found = evaluate(graph, wanted, t, z, values)[0]
        model = found[: self.n_series]
        by = found[self.n_series :]
        total = np.zeros((self.n_series, *slopes.shape[1:]))
        for (row, column), values_of in zip(entries, by, strict=True):
            if column < self.n:
                total[row] += values_of * slopes[column]
            else:
                total[row, groups[column - self.n]] += values_of
        if not self._compared:
            self._compared = True
            self._compare(t, y, args, model)
        return model, total

    def _compare(self, t, y, args, model):
        own = self.values(t, y, args)
        size = np.abs(own).max(axis=1, keepdims=True)
        if not (np.abs(own - model) <= SAME * size).all() and np.isfinite(own).all():
            raise ValueError(
                "`observed` gives other values in Python than as a formula: it must depend on t, y "
                "and args alone."
            )

    def _traced(self, t, y, places, args) -> Any:
        """(graph, outputs, entries, parameters, values of the code); None without derivatives.

        `entries` has the node of the derivative of output i by component j, or by the parameter
        j - n of the list `parameters`.
        """
        held = {j: a for j, a in enumerate(places.args, 1) if isinstance(a, Template)}
        self.values(t[:1], y[:, :1], args)  # mistakes are reported by Python
        near = Near(t[0], t[-1], np.r_[y[:, 0], np.zeros(self.size - self.n)])
        attempt = Attempt(self._padded, args, DERIVATIVE, self.size, held)
        found = traced_function(attempt, near)
        if found is None:
            return None
        function, given, at = found
        graph = function.traced.trace.graph
        outputs = function.traced.stored[: self.n_series]
        slots = []
        parameters = []
        for j, template in held.items():
            first = function.traced.trace.reads.groups[at[j - 1]].first
            for k in np.flatnonzero(template.index.ravel() != FIXED):
                slots.append(first + k)
                parameters.append(template.index.ravel()[k])

        def made():
            inputs = [graph.make("y", (), i) for i in range(self.n)]
            inputs += [graph.make("par", (), int(slot)) for slot in slots]
            rows = partials(graph, outputs, inputs)
            return {(i, j): node for i, row in enumerate(rows) for j, node in row.items()}

        try:
            entries = function.derived(("observed", self.n, tuple(slots)), made)
        except Untraceable:
            return None
        return graph, outputs, entries, parameters, flat([value for _, value in given])

    def _differences(self, t, y, slopes, places, args):
        """Central differences of the function along the state and the arguments."""
        found = self.values(t, y, args)
        total = np.zeros((self.n_series, *slopes.shape[1:]))
        for i in range(self.n):
            h = STEP * np.maximum(np.abs(y[i]), np.abs(y[i]).max() or 1.0)
            up = y.copy()
            down = y.copy()
            up[i], down[i] = y[i] + h, y[i] - h
            by = self.values(t, up, args) - self.values(t, down, args)
            total += (by / (up[i] - down[i]))[:, None, :] * slopes[i]
        for j, template in enumerate(places.args):
            if not isinstance(template, Template):
                continue
            for at in np.ndindex(template.index.shape):
                if not template.free[at]:
                    continue
                value = np.asarray(args[j])[at]
                h = STEP * max(abs(value), 1e-3)
                ends = []
                for moved in (value + h, value - h):
                    changed = np.array(args[j], float)
                    changed[at] = moved
                    changed = changed if changed.ndim else float(changed)
                    ends.append(self.values(t, y, (*args[:j], changed, *args[j + 1 :])))
                total[:, template.index[at]] += (ends[0] - ends[1]) / (2 * h)
        return found, total
