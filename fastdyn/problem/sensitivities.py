"""Derivatives of the solution: `sensitivity` and `adjoint`, checked, and the extended problem."""

import inspect
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import DERIVATIVE, JUMP, SENSITIVITIES, Mode
from fastdyn.compile.python_callback import evaluate
from fastdyn.kernels.methods import METHODS

from .events import of_own
from .options.table import refused_among

START, ARGUMENTS = "y0", "args"
ACTIONS = "on_event", "at", "every"  # options

NOT_WITH_ADJOINT = {  # fields of Arguments
    "sensitivity": "it and `vjp` are two ways to the same derivatives",
    "dense_output": "`vjp` takes derivatives by `y`; give the times as `t_eval`",
    "error_estimate": "its second pass has other steps",
    "vectorized": "",
}


class Direction(NamedTuple):
    """A variable of differentiation: `position` 0 for y0, j for the j-th of `args`."""

    name: str
    position: int
    value: np.ndarray

    @property
    def size(self):
        return self.value.size


class Variational(NamedTuple):
    """``fun``, followed by the variational equations.

    `directions` are positions, as in Direction, in the order of the columns.  For q'' = a(t, q),
    the equations are those of q and its n rows of S, and `n_start` is the length of [q, v].
    """

    fun: Any
    mode: Mode
    n: int
    directions: tuple
    n_directions: int
    n_start: int

    def positions(self):
        """The positions of the arguments among the directions."""
        return tuple(sorted({j for j in self.directions if j}))

    def as_traced(self):
        """What is traced: function, mode, length of the state, arguments that vary."""
        return self.fun, self.mode, self.n, self.positions()

    def __call__(self, t, z, *args):
        """Call the function alone, which may raise: Python cannot compute the sensitivities."""
        own = evaluate(lambda t, y: self.fun(t, y, *args), self.mode, t, z[: self.n])
        return np.concatenate([own, np.zeros(len(z) - self.n)])


class Saltation(NamedTuple):
    """``jump``, extended to the sensitivities; `event` is None for a schedule."""

    fun: Any
    event: Any
    jump: Any
    n: int
    directions: tuple
    n_directions: int

    @property
    def n_start(self):
        return self.n

    def n_together(self):
        """The number of results of `together`."""
        return self.n if self.event is None else 3 * self.n + 1

    def as_traced(self):
        """What is traced: function, mode, length of the state, arguments that vary."""
        positions = tuple(sorted({j for j in self.directions if j}))
        return self.together(), DERIVATIVE, self.n_together(), positions

    def together(self):
        """One function, for one trace: the new state, f before and behind, the event."""
        fun, event, jump, n = self.fun, self.event, self.jump, self.n

        def changed(t, w, *args):
            found = jump(t, np.array(w[:n]), *args)
            new = list(found) if hasattr(found, "__len__") else [found]
            if event is None:
                return new
            before, behind = fun(t, w[:n], *args), fun(t, np.array(new), *args)
            return [*new, *before, *behind, event(t, w[:n], *args)]

        return changed

    def __call__(self, t, z, *args):
        """Call the function alone, which may raise: Python cannot compute the sensitivities."""
        own = evaluate(lambda t, y: self.jump(t, y, *args), JUMP, t, z[: self.n])
        return np.concatenate([own, np.zeros(len(z) - self.n)])


def directions_of(wanted, fun, y0, args, option="sensitivity"):
    """The Directions that an option names."""
    given = (wanted,) if isinstance(wanted, str) else wanted
    try:
        given = list(given)
    except TypeError:
        given = [wanted]
    names, general, found = _names(fun, args), _general(args), {}
    for name in given:
        if name == START:
            found[START] = Direction(START, 0, y0)
        elif name == ARGUMENTS:
            found |= {n: _of_argument(n, j, args, option) for j, n in enumerate(names, 1)}
        elif name in names or name in general:
            j = (names if name in names else general).index(name) + 1
            found[names[j - 1]] = _of_argument(names[j - 1], j, args, option)
        else:
            known = ", ".join(map(repr, (START, ARGUMENTS, *names)))
            raise ValueError(f"`{option}={name!r}` is unknown; choose from {known}.")
    directions = [each for each in found.values() if each.size]
    if not directions:
        raise ValueError(f"`{option}` names nothing: give 'y0', 'args', or names of arguments.")
    return directions


def _general(args):
    return [f"args[{i}]" for i in range(len(args))]


def _names(fun, args):
    """The names of the arguments of `fun` after t and y."""
    names = _general(args)
    try:
        parameters = list(inspect.signature(fun).parameters.values())[2:]
    except (TypeError, ValueError):
        return names
    for i, parameter in enumerate(parameters[: len(names)]):
        if parameter.kind not in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            break
        if parameter.name not in (START, ARGUMENTS):
            names[i] = parameter.name
    return names


def _of_argument(name, position, args, option):
    value = args[position - 1]
    number = isinstance(value, float | int | np.floating | np.integer)
    if isinstance(value, bool) or not (
        number or (isinstance(value, np.ndarray) and value.dtype == float)
    ):
        raise TypeError(
            f"`{option}` with respect to {name!r} needs a number or an array of floats; got "
            f"{type(value).__name__}"
            + (f" of {value.dtype}." if isinstance(value, np.ndarray) else ".")
        )
    return Direction(name, position, np.asarray(value, float))


def check_method(asked, method):
    """Refuse methods, states and options without sensitivities."""
    if method is None:
        raise ValueError(
            f"`sensitivity` is for fastdyn's own methods, not for {asked.method!r}; take DOP853 "
            "or Vern9."
        )
    acts = [asked.options.get(name) is not None for name in ("on_event", "at", "every")]
    if method.second_order and any(acts):
        raise ValueError(
            f"{method.name} has no `sensitivity` with events that act; RK4, Gauss8 and the "
            "adaptive methods do."
        )
    if asked.y0.dtype.kind == "c":
        raise ValueError("`sensitivity` is for real states: split a complex one into its parts.")
    for name, reason in refused_among(asked.options, "sensitivity"):
        raise ValueError(
            f"`sensitivity` and `{name}` do not go together{f': {reason}' if reason else ''}."
        )


def check_adjoint(asked, method):
    """Refuse methods, states and options without an adjoint."""
    if method is None or not method.is_pair:
        name = repr(asked.method) if method is None else method.name
        pairs = [m.name for m in METHODS.values() if m.is_pair]
        raise ValueError(
            "`adjoint` goes back over the steps of an embedded explicit pair "
            f"({', '.join(pairs)}), and {name} is none: take one of these, or `sensitivity`."
        )
    if asked.y0.dtype.kind == "c":
        raise ValueError("`adjoint` is for real states: split a complex one into its parts.")
    if not asked.y0.size or asked.t0 == asked.tf or abs(asked.tf) == float("inf"):
        raise ValueError("`adjoint` needs a state, and a span that is finite and not empty.")
    if asked.t_eval is not None and not len(asked.t_eval):
        raise ValueError("`adjoint` differentiates outputs, and `t_eval` is empty.")
    others = [(name, reason) for name, reason in NOT_WITH_ADJOINT.items() if getattr(asked, name)]
    acts = "derivatives through what acts on the state are those of `sensitivity`"
    others += [(name, acts) for name in ACTIONS if asked.options.get(name) is not None]
    for name, reason in [*others, *refused_among(asked.options, "adjoint")]:
        raise ValueError(
            f"`adjoint` and `{name}` do not go together{f': {reason}' if reason else ''}."
        )


def longer_tolerances(problem, sizes):
    """`rtol` and `atol` of y followed by S; `sizes` are those of the values of the directions."""
    p, n, m = problem, len(problem.y0), len(sizes)
    share = 1.0 if p.method.like_matlab else 1.0 / math.sqrt(1 + m)
    own = np.broadcast_to(p.atol, n)
    least = np.minimum(own, p.rtol) if np.any(p.rtol) else own
    atol = share * np.concatenate([own, (least[:, None] / np.maximum(1.0, sizes)).ravel()])
    return share * (p.rtol if np.ndim(p.rtol) == 0 else np.r_[p.rtol, np.repeat(p.rtol, m)]), atol


def with_sensitivities(problem, directions):
    """The problem for y followed by S, row by row, from a problem for y.

    The error norm is taken of each block by itself, so that y is as exact as without sensitivities.
    The absolute tolerance of a column of S is that of y per unit of the direction, or per value of
    the direction if the value is above 1.
    """
    p, n_start = problem, len(problem.y0)
    parts = 2 if p.method.second_order else 1
    n, m = n_start // parts, sum([d.size for d in directions])
    positions = tuple([d.position for d in directions])
    equations = Variational(p.fun, p.mode, n, positions, m, n_start)
    starts = [np.eye(n_start) if j == 0 else np.zeros((n_start, d.size))
              for j, d in zip(positions, directions, strict=True)]  # fmt: skip
    y0 = joined(p.y0, np.hstack(starts), parts)
    rtol, atol = p.rtol, p.atol
    if p.method.error_order:
        rtol, atol = longer_tolerances(
            p, np.concatenate([abs(d.value).ravel() for d in directions])
        )
    own = of_own if parts == 1 else _of_halves
    events = p.events and [(own(event, n), *how) for event, *how in p.events]

    def longer(event, jump):
        return jump and Saltation(p.fun, event, jump, n, positions, m)

    jumps = [longer(e[0], jump) for e, jump in zip(p.events or (), p.on_event, strict=False)]
    schedules = [each._replace(jump=longer(None, each.jump)) for each in p.schedules]
    return p._replace(
        fun=equations, mode=SENSITIVITIES, y0=y0, rtol=rtol, atol=atol, events=events, jac=None,
        on_event=tuple(jumps), schedules=tuple(schedules),
    )  # fmt: skip


def joined(y, columns, parts):
    """The extended state of y and S, shape (len(y), m): each part of y, followed by its rows of S.

    There is one part, or, for q'' = a(t, q), two: q and v.
    """
    halves = zip(np.split(y, parts), np.split(columns, parts), strict=True)
    return np.concatenate([part for own, rows in halves for part in (own, rows.ravel())])


def separated(numbers, n, parts):
    """y, shape (..., parts n), and S, shape (..., parts n, m), of extended states (..., N)."""
    before = numbers.shape[:-1]
    each = numbers.reshape(*before, parts, numbers.shape[-1] // parts)
    m = each.shape[-1] // n - 1
    y, columns = each[..., :n], each[..., n:].reshape(*before, parts, n, m)
    return y.reshape(*before, parts * n), columns.reshape(*before, parts * n, m)


def _of_halves(event, n):
    """An event function of [q, v] as one of the extended state, whose halves begin with q and v."""

    def watched(t, z, *args):
        half = len(z) // 2
        return event(t, np.concatenate((z[:n], z[half : half + n])), *args)

    watched.__name__ = getattr(event, "__name__", "event")
    watched.__qualname__ = getattr(event, "__qualname__", "event")
    return watched
