"""Initial states and parameters of many solves, one row each."""

import functools
import math
from typing import Any

import numpy as np

from fastdyn.compile.bind import bind, bind_matrix
from fastdyn.compile.derivatives.sensitivities import bind_saltation, bind_variational
from fastdyn.compile.fingerprint import Constant
from fastdyn.compile.functions import with_callback
from fastdyn.compile.parameters import FLOAT, pack
from fastdyn.compile.python_callback import Callback, Held
from fastdyn.compile.sentences import warn_once
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FIRST, RAISED_WORD

from .validate import initial_state

LARGEST_WHOLE = 2.0**53  # up to here, floats hold all whole numbers
KINDS = {"f": float, "i": int, "b": bool}  # of the numbers of one trajectory
OF_CODE = "an argument that differs between trajectories is True or False, part of Numba's code"


class Shared:
    """An argument that is one array, common to all trajectories of an ensemble.

    Parameters
    ----------
    value : array_like
        What `fun` gets for this argument in each trajectory, in any shape.
    """

    def __init__(self, value):
        self.value = value


def _column(j, value):
    """An argument as a 1-D array with an entry for each member; None for a common value."""
    if isinstance(value, Shared) or not isinstance(value, np.ndarray | list):
        return None
    array = np.asarray(value)
    if array.ndim == 0:
        return None
    if array.ndim > 1 or array.dtype.kind not in "fiub":
        rows = (
            " Rows of parameters are given as columns: args=tuple(parameters.T)."
            if (array.ndim == 2)
            else ""
        )
        raise ValueError(
            f"`args[{j}]` must be a number or a 1-D array of numbers, one a trajectory; it has "
            f"shape {array.shape} and dtype {array.dtype}. Wrap what all share in `Shared`; give "
            f"real and imaginary parts of complex numbers as two arguments.{rows}"
        )
    if array.dtype.kind in "iu" and (abs(array.astype(float)) > LARGEST_WHOLE).any():
        raise ValueError(
            f"`args[{j}]` has whole numbers beyond 2**53 that differ between trajectories: floats "
            "do not hold them."
        )
    if array.dtype.kind == "u":
        array = array.astype(np.int64)
    return array if array.dtype.kind in "ib" else array.astype(float)


def _count(y0, columns, name):
    """The number of members, on which the states, an argument `name`, and all columns agree."""
    lengths = {f"args[{j}]": len(c) for j, c in columns.items()}
    if y0.ndim == 2:
        lengths[name] = len(y0)
    many = {each: length for each, length in lengths.items() if length != 1}
    if len(set(many.values())) > 1:
        said = ", ".join(f"`{each}` has {length}" for each, length in many.items())
        raise ValueError(
            f"everything that varies must have one entry a trajectory: {said}. "
            "Wrap an array that all trajectories share in `Shared`."
        )
    return next(iter(many.values()), 1)


def _states(y0, name):
    """The states as an array of shape (M, n) or (n,), float64 or complex128, with a finite row."""
    array = np.asarray(y0)
    if array.ndim < 2:
        return initial_state(y0, name)
    if array.ndim > 2:
        raise ValueError(f"`{name}` must have shape (n,) or (M, n); got {array.shape}.")
    if array.dtype.kind not in "fiubc":
        raise TypeError(f"`{name}` must be numbers; got an array of {array.dtype}.")
    array = np.ascontiguousarray(array, dtype=complex if array.dtype.kind == "c" else float)
    if len(array) and not np.isfinite(array).all(axis=1).any():
        raise ValueError(
            f"All components of `{name}` must be finite; trajectory 0 is not, nor others."
        )
    return array


class Members:
    """The initial states and the arguments of all trajectories.

    Attributes
    ----------
    count, n : int
    y0 : ndarray, shape (count, n) or (1, n)
        Initial states.  Complex states alternate real and imaginary parts, and n counts both.
    complex : bool
    finite : ndarray of bool, shape (count,) or (1,)
    usual : int
        The first trajectory with a finite initial state, 0 if there is none.
    first : tuple
        Arguments of the first trajectory.
    varying : dict of int to ndarray
        The arguments that differ, by position.
    words : ndarray of int64, shape (count, n_columns)
        The values of `varying` in the words of blocks: first for functions of one trajectory, in
        the order of `varying`, then for vectors.
    """

    def __init__(self, y0, args, name="y0"):
        self.times: dict = {}  # times of schedules that differ, see ensemble/times.py
        self._tolerances = 0, np.empty((0, 2), int)
        self.segments: Any = None  # (segments of all, first rows), if `fun` switches with the time
        states = _states(y0, name)
        self.complex = states.dtype.kind == "c"
        states = states.view(float) if self.complex else states
        columns = {j: _column(j, a) for j, a in enumerate(args)}
        columns = {j: c for j, c in columns.items() if c is not None}
        self.count = _count(states, columns, name)
        self.y0 = np.atleast_2d(states)
        self.n = self.y0.shape[1]
        self.finite: np.ndarray = np.isfinite(self.y0).min(axis=1, initial=True)
        self.usual = int(np.argmax(self.finite)) if len(self.finite) else 0
        self.varying = {j: c for j, c in columns.items() if len(c) != 1}
        shared = (a.value if isinstance(a, Shared) else a for a in args)
        firsts = {j: (c if len(c) else np.ones(1, c.dtype))[0] for j, c in columns.items()}
        given = (firsts.get(j, a) for j, a in enumerate(shared))
        self.first = tuple(a.item() if isinstance(a, np.generic) else a for a in given)
        plain = [np.ascontiguousarray(c) for c in self.varying.values()]
        words = [(c if c.dtype == float else c.astype(np.int64)).view(np.int64) for c in plain]
        words += [c.astype(float).view(np.int64) for c in plain]
        self.words = np.ascontiguousarray(
            np.array(words, np.int64).reshape(len(words), -1 if words else self.count).T
        )

    def lengthen(self, times):
        """Append zeros to each state, so that its length is `times` the former length."""
        self.y0 = np.hstack([self.y0, np.zeros((len(self.y0), (times - 1) * self.n))])
        self.n *= times

    def args(self, i):
        """Arguments of trajectory i."""
        given = list(self.first)
        for j, column in self.varying.items():
            given[j] = column[i].item()
        return tuple(given)

    def state(self, i):
        """Initial state of trajectory i."""
        return self.y0[i if len(self.y0) > 1 else 0]

    def near(self, problem, n):
        """The Near at which functions of n numbers will be called; None without a trajectory."""
        if not self.count:
            return None
        return Near(problem.t0, problem.tf, np.resize(self.state(self.usual), n))

    def bind(self, fun, mode, n, near=None, probe=None):
        """Bind a function with the arguments of the first trajectory.

        Returns
        -------
        (Bound, list of (int, int))
            For each varying argument, the word of the block and the column of `words`.
        """
        if not callable(fun):
            return bind_matrix(fun), []
        bound = self.bound(fun, self.first, mode, n, near, probe)
        held = [bound.values[bound.at[j]][0] for j in self.varying] if bound.function else []
        if bound.function is None or any(isinstance(kind, Constant) for kind in held):
            if probe is not None:
                probe()
            announce = bound.callback and bound.callback.announce
            if bound.function is not None:  # Numba's code holds the first trajectory's truth value
                announce = functools.partial(warn_once, fun, OF_CODE)
            return self._in_python(fun, mode, n, announce), [
                (FIRST + column, column) for column in range(len(self.varying))
            ]
        n = len(held)  # columns of `words`; behind them are the same numbers as floats
        return bound, [
            (bound.word(j), column + n if held[column] == FLOAT else column)
            for column, j in enumerate(self.varying)
        ]

    def bound(self, fun, args, mode, n, near, probe=None):
        """The Bound of a function with arguments, whose code is that of all trajectories."""
        varying = tuple([j + 1 for j in self.varying])
        if mode.sensitivities:
            near = near._replace(y0=fun.own(near.y0))
            return bind_variational(fun, args, near, varying=varying)
        if mode.saltation:
            return bind_saltation(fun, args, near, varying)
        return bind(fun, args, mode, n, near, probe, varying=varying)

    def own_tolerances(self, row, first, values):
        """Let the numbers of a row of the work array, from `first` on, differ by trajectory.

        `values` are (M or 1, ...) numbers.
        """
        values = values.reshape(len(values), -1)
        differ = np.flatnonzero((values != values[:1]).any(axis=0))
        columns = self.words.shape[1] + np.arange(len(differ))
        self._tolerances = row, np.column_stack([first + differ, columns])
        if len(differ):
            own = np.ascontiguousarray(values[:, differ]).view(np.int64)
            self.words = np.ascontiguousarray(np.hstack([self.words, own]))

    def tolerances(self, work):
        """The places of the numbers of a work array that differ, in the form of `places`."""
        row, components = self._tolerances
        begin = work.ctypes.data + 8 * row * work.shape[1]
        return [(begin + 8 * at, column, 0) for at, column in components.tolist()]

    def _in_python(self, fun, mode, n, announce):
        """Bind a function that stays in Python, and reads its arguments from the block."""
        block = np.zeros(FIRST + len(self.varying), np.int64)
        floats = block.view(float)

        def called(t, y):
            given = list(self.first)
            for at, (j, column) in enumerate(self.varying.items(), FIRST):
                kind = KINDS[column.dtype.kind]
                given[j] = kind(floats[at] if kind is float else block[at])
            try:
                return fun(t, y, *given)
            except Exception:
                block[RAISED_WORD] = 1
                return np.full(mode.n_results(n), math.nan)

        callback = Callback(called, mode, n, announce)
        return with_callback(callback, called, Held(), mode, block)

    def places(self, kernel, block):
        """Write common values into a vector kernel's block.

        Returns (address, column of `words`, bytes from lane to lane) of each varying value.
        """
        at = FIRST
        keepalive = []
        found = []
        kernel.keepalive.append(keepalive)
        for parameters in kernel.parameters:  # the parameters of one function
            column = len(self.varying)
            for parameter_type, value in parameters:
                if parameter_type[0] == "lanes":
                    found.append((block.ctypes.data + 8 * at, column, 8))
                    at = at + parameter_type[1]
                    column = column + 1
                else:
                    at = pack(parameter_type, value, block, block.view(float), at, keepalive)
        return found
