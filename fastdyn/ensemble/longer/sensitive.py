"""Ensembles with `sensitivity`: the state of each trajectory is followed by its sensitivities."""

import functools

import numpy as np

from fastdyn.compile.derivatives.sensitivities import decides
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.kernels.state.record import ATOL
from fastdyn.problem.sensitivities import (
    Tolerances,
    by_name,
    check_method,
    directions_of,
    not_differentiable,
    with_sensitivities,
)

from ..trajectories import Trajectories

REDUCED = ("final", "first_event")


def bound(asked, problem, members, sensitivity, wanted):
    """The Directions, the problem for y followed by S, and the Bound of its equations.

    `members` get the longer states, too.
    """
    if not members.count:
        raise ValueError("an ensemble with `sensitivity` needs a trajectory.")
    directions, longer = _extended(asked, problem, members, sensitivity, wanted)
    n = members.n
    try:
        found, _ = members.bind(longer.fun, longer.mode, n, members.near(longer, n))
    except (Uncompilable, GaveUp) as reason:
        raise not_differentiable("sensitivity", problem, reason) from None
    if decides(found):
        raise ValueError(
            "an ensemble has no `sensitivity` of a function that decides by its state or by a "
            "differentiated argument (`if`, `where`, `sign`, rounding): solve_ivp, which looks for "
            "jumps along the solution, has."
        )
    return directions, longer, found


def _extended(asked, problem, members, sensitivity, wanted):
    if not members.complex and problem.method.second_order:
        raise ValueError(
            f"an ensemble has no `sensitivity` by {problem.method.name}: take a method for y' = f, "
            "or solve_ivp."
        )
    check_method(asked._replace(y0=asked.y0.view(complex) if members.complex else asked.y0),
                 problem.method)  # fmt: skip
    if any(item not in REDUCED for item in wanted):
        raise ValueError('with `sensitivity`, `reduce` takes "final" and "first_event".')
    start = members.state(members.usual)
    directions = directions_of(sensitivity, problem.fun, start, members.first)
    longer = with_sensitivities(problem._replace(y0=start), directions)
    if problem.method.error_order:
        sizes = _sizes(members, directions)
        of_columns = Tolerances(problem, sizes.shape[1]).of_columns(sizes)
        members.own_tolerances(ATOL, members.n, of_columns)
    starts = np.broadcast_to(longer.y0[members.n :], (len(members.y0), len(longer.y0) - members.n))
    members.y0 = np.ascontiguousarray(np.hstack([members.y0, starts]))
    members.n = len(longer.y0)
    return directions, longer


def _sizes(members, directions):
    """The sizes of the values of the directions, of shape (M or 1, n_directions)."""
    found = []
    for d in directions:
        if d.position == 0:
            values = members.y0
        elif d.position - 1 in members.varying:
            values = members.varying[d.position - 1][:, None]
        else:
            values = d.value.reshape(1, -1)
        found.append(np.abs(values.astype(float)))
    rows = max(map(len, found))
    return np.hstack([np.broadcast_to(each, (rows, each.shape[1])) for each in found])


class SensitiveTrajectories(Trajectories):
    """Trajectories with derivatives by the initial state and by arguments.

    Attributes
    ----------
    sensitivity : dict of str to ndarray, shape (M, n, ..., n_times) or (M, n, ...)
        The derivatives at the times of `t`, by the names of the variables, whose dimensions stand
        behind that of the state.
    """

    def __init__(self, directions, *given):
        super().__init__(*given)
        self._directions = directions
        self._n //= 1 + sum([d.size for d in directions])

    @functools.cached_property
    def sensitivity(self):
        r = self._results
        n = self._n
        numbers = r.y_end[:, None] if self._problem.t_eval is None else r.y_eval
        columns = numbers[..., n:].reshape(*numbers.shape[:2], n, -1)
        found = by_name(columns.transpose(0, 2, 3, 1), self._directions)
        if self._problem.t_eval is not None:
            return found
        return {name: each[..., 0] for name, each in found.items()}

    def __getitem__(self, i):
        found = super().__getitem__(i)
        k = range(len(self))[i]
        found.sensitivity = {
            name: each[k][..., None]
            if self._problem.t_eval is None
            else each[k, ..., : len(found.t)]
            for name, each in self.sensitivity.items()
        }
        return found
