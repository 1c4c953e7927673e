"""The guesses of an ensemble of DAEs, [y, y'] of each trajectory, and its checked arguments."""

import numpy as np

from fastdyn.problem import validate
from fastdyn.problem.members import Members
from fastdyn.run.functions.compared import off_the_solution

from ..problem import checked

FEW = 8  # most guesses at which F is tried


class Guesses(Members):
    """Members whose states are [y, y'], first the guesses, then the consistent starts."""

    def near(self, problem, n):
        near = super().near(problem, n)
        return near and near._replace(y0=np.resize(off_the_solution(self.state(self.usual)), n))

    def begin_at(self, starts):
        """Replace the states by starts, (M, 2 n) or (1, 2 n), nan where there is none."""
        self.y0 = starts
        self.finite = np.isfinite(starts).all(axis=1)
        self.usual = int(np.argmax(self.finite))


def guesses_of(y0, yp0, args):
    """The Guesses, from states of shape (M, n) or (n,)."""
    y0 = _rows(y0, "y0")
    yp0 = np.zeros(y0.shape[-1]) if yp0 is None else _rows(yp0, "yp0")
    if not y0.shape[-1]:
        raise ValueError("`y0` is empty: there is nothing to solve.")
    if yp0.shape[-1] != y0.shape[-1]:
        raise ValueError(
            f"`yp0` must have one number for each of `y0`: it has {yp0.shape[-1]}, and `y0` "
            f"{y0.shape[-1]}."
        )
    if y0.ndim == yp0.ndim == 2 and len(y0) != len(yp0) and 1 not in (len(y0), len(yp0)):
        raise ValueError(
            f"`y0` has rows of {len(y0)} trajectories, and `yp0` of {len(yp0)}: give both one row "
            "a trajectory, or one for all."
        )
    shape = np.broadcast_shapes(y0.shape, yp0.shape)
    both = np.concatenate([np.broadcast_to(each, shape) for each in (y0, yp0)], axis=-1)
    found = Guesses(both, validate.extra_arguments(args))
    if not found.count:
        raise ValueError("`y0` has no rows: an ensemble of DAEs needs a trajectory.")
    return found


def _rows(values, name):
    """States of shape (M, n) or (n,); the numbers of a row may be nan."""
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise TypeError(f"`{name}` is complex: split the unknowns of F into real and imaginary.")
    if array.ndim > 2:
        raise ValueError(f"`{name}` must have shape (n,) or (M, n); got {array.shape}.")
    if array.ndim < 2 or array.dtype.kind not in "fiub":
        return validate.initial_state(values, name)
    return array.astype(float)


def first_given(F, t_span, guesses, has_rates, t_eval, events, given, options):
    """The problem.DaeArguments of the first trajectory that F takes, among FEW; raises without one.

    Without `has_rates`, no `yp0` was given.
    """
    n = guesses.n // 2
    finite = np.flatnonzero(np.broadcast_to(guesses.finite, guesses.count))
    errors = []
    for i in finite[np.unique(np.linspace(0, len(finite) - 1, FEW).astype(int))].tolist():
        y0, yp0 = np.split(guesses.state(i), 2)
        try:
            return checked(
                F, t_span, y0, yp0 if has_rates else None, t_eval, False, events, guesses.args(i),
                given, dict(options),
            )  # fmt: skip
        except Exception as error:
            errors.append(error)
    error = errors[0]
    if callable(F) and _fits_columns(F, t_span, guesses, n):
        raise ValueError(
            f"`y0` has shape {(guesses.count, n)}, and F fits its columns: a row is a trajectory; "
            "give `y0.T`."
        ) from error
    raise error


def _fits_columns(F, t_span, guesses, n):
    """Whether F returns as many numbers as `y0` has rows, for a column of `y0`."""
    if len(guesses.y0) < 2 or guesses.varying:
        return False
    column = guesses.y0[:, 0]
    try:
        found = F(float(t_span[0]), column.copy(), np.zeros(len(column)), *guesses.first)
        return np.shape(np.asarray(found, float)) == column.shape != (n,)
    except Exception:  # of the user's function, at a state of another length
        return False
