"""Derivatives of the solution: `sensitivity` and `adjoint`, checked, and the extended problem."""

import contextlib
import inspect
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import DERIVATIVE, JUMP, SENSITIVITIES, Mode
from fastdyn.compile.python_callback import called_with, evaluate
from fastdyn.compile.traced.known import Attempt
from fastdyn.kernels.methods import METHODS

from .events import of_own
from .options.table import refused_among

START = "y0"
ARGUMENTS = "args"
NEEDS = "`{}` needs a function that can be traced and differentiated: {}."

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

    def own(self, z):
        """The numbers that the function is given, of the state with its sensitivities."""
        return z[: self.n]

    def parts(self, z):
        """(The numbers that the function is given, their derivatives, a column a direction)."""
        n = self.n
        m = self.n_directions
        return z[:n], z[n : n + n * m].reshape(n, m)

    def joined(self, own, columns):
        """The inverse of `parts`."""
        return np.concatenate([own, columns.ravel()])

    def positions(self):
        """The positions of the arguments among the directions."""
        return tuple(sorted({j for j in self.directions if j}))

    def as_traced(self):
        """The traced function: function, mode, length of the state, arguments that vary."""
        return self.fun, self.mode, self.n, self.positions()

    def varied(self, args, steps) -> contextlib.AbstractContextManager:
        """A context in which whatever else the function reads moves along the directions, too."""
        return contextlib.nullcontext()

    def __call__(self, t, z, *args):
        """Call the function alone, which may raise: Python cannot compute the sensitivities."""
        own = evaluate(called_with(self.fun, args), self.mode, t, self.own(z))[: self.n]
        return np.concatenate([own, np.zeros(len(z) - self.n)])


class VariationalResidual(Variational):
    """A residual of [y, y'], followed by dF/dy S + dF/dy' S' + dF/dp; the state is [y, S, y', S'].

    `n` and `n_start` are the length of y; S and S' have a row for each component.
    """

    def own(self, z):
        half = len(z) // 2
        return np.concatenate([z[: self.n], z[half : half + self.n]])

    def parts(self, z):
        rows = z.reshape(2, -1)[:, self.n :]
        return self.own(z), rows.reshape(2 * self.n, self.n_directions)

    def joined(self, own, columns):
        return joined(own, columns, 2)

    def as_traced(self):
        """The traced function: function, mode, length of its vector, arguments that vary."""
        return self.fun, self.mode, 2 * self.n, self.positions()


class Saltation(NamedTuple):
    """``jump``, extended to the sensitivities.

    `event` is None for a schedule, `jump` for an event that does not act.
    """

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
        if self.jump is None:
            return self.n + 1
        return self.n if self.event is None else 3 * self.n + 1

    def as_traced(self):
        """The traced function: function, mode, length of the state, arguments that vary."""
        positions = tuple(sorted({j for j in self.directions if j}))
        return self.together(), DERIVATIVE, self.n_together(), positions

    def together(self):
        """One function, for one trace: the new state, f before and behind, the event."""
        fun = self.fun
        event = self.event
        jump = self.jump
        n = self.n

        def seen(t, w, *args):
            return [*fun(t, w[:n], *args), event(t, w[:n], *args)]

        def changed(t, w, *args):
            found = jump(t, np.array(w[:n]), *args)
            new = list(found) if hasattr(found, "__len__") else [found]
            if event is None:
                return new
            before = fun(t, w[:n], *args)
            behind = fun(t, np.array(new), *args)
            return [*new, *before, *behind, event(t, w[:n], *args)]

        return seen if jump is None else changed

    def __call__(self, t, z, *args):
        """Call the function alone, which may raise: Python cannot compute the sensitivities."""
        own = evaluate(called_with(self.jump, args), JUMP, t, z[: self.n])
        return np.concatenate([own, np.zeros(len(z) - self.n)])


def directions_of(wanted, fun, y0, args, option="sensitivity", first=2, start=START):
    """The Directions that an option names; `first` is the place of the first of `args`.

    `start` is the name of the initial state.
    """
    given = (wanted,) if isinstance(wanted, str) else wanted
    try:
        given = list(given)
    except TypeError:
        given = [wanted]
    names = _names(fun, args, first)
    general = _general(args)
    found = {}
    for name in given:
        if name == start:
            found[start] = Direction(start, 0, y0)
        elif name == ARGUMENTS:
            found |= {n: _of_argument(n, j, args, option) for j, n in enumerate(names, 1)}
        elif name in names or name in general:
            j = (names if name in names else general).index(name) + 1
            found[names[j - 1]] = _of_argument(names[j - 1], j, args, option)
        else:
            known = ", ".join(map(repr, (start, ARGUMENTS, *names)))
            raise ValueError(f"`{option}={name!r}` is unknown; choose from {known}.")
    directions = [each for each in found.values() if each.size]
    if not directions:
        raise ValueError(
            f"`{option}` names nothing: give {start!r}, 'args', or names of arguments."
        )
    return directions


def _general(args):
    return [f"args[{i}]" for i in range(len(args))]


def _names(fun, args, first):
    """The names of the arguments of `fun` from place `first` on."""
    names = _general(args)
    try:
        parameters = list(inspect.signature(fun).parameters.values())[first:]
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
    if method is None or not method.backward:
        name = repr(asked.method) if method is None else method.name
        known = [m.name for m in METHODS.values() if m.backward]
        raise ValueError(
            f"`adjoint` goes back over the steps of {', '.join(known)}, and not over those of "
            f"{name}: take one of these, or `sensitivity`."
        )
    if asked.y0.dtype.kind == "c":
        raise ValueError("`adjoint` is for real states: split a complex one into its parts.")
    if not asked.y0.size or asked.t0 == asked.tf or abs(asked.tf) == float("inf"):
        raise ValueError("`adjoint` needs a state, and a span that is finite and not empty.")
    if asked.t_eval is not None and not len(asked.t_eval):
        raise ValueError("`adjoint` differentiates outputs, and `t_eval` is empty.")
    others = [(name, reason) for name, reason in NOT_WITH_ADJOINT.items() if getattr(asked, name)]
    for name, reason in [*others, *refused_among(asked.options, "adjoint")]:
        raise ValueError(
            f"`adjoint` and `{name}` do not go together{f': {reason}' if reason else ''}."
        )


class Tolerances:
    """`rtol` and `atol` of y followed by S, for a problem and m directions.

    The square of the error norm becomes that of y alone and the mean of those of the columns.
    """

    def __init__(self, problem, m):
        p = problem
        n = len(problem.y0)
        own = np.broadcast_to(p.atol, n)
        rtol = np.broadcast_to(p.rtol, n)
        least = np.minimum(own, rtol) if np.any(rtol) else own
        largest = p.method.largest_as_norm
        of_y, of_s = (1.0, 1.0) if largest else np.sqrt([1.0 / (1.0 + m), m / (1.0 + m)])
        self.rtol = p.rtol
        if not largest or np.ndim(p.rtol):
            self.rtol = np.concatenate([of_y * rtol, of_s * np.repeat(rtol, m)])
        self._of_y = of_y * own
        self._least = of_s * least[:, None]

    def of_columns(self, sizes):
        """`atol` of S, of shape (..., n, m), for the sizes (..., m) of the directions."""
        return self._least / np.maximum(1.0, sizes)[..., None, :]

    def atol(self, sizes):
        """`atol` of y and S for the m sizes of the values of the directions."""
        return np.concatenate([self._of_y, self.of_columns(sizes).ravel()])


def with_sensitivities(problem, directions):
    """The problem for y followed by S, row by row, from a problem for y.

    The square of the error norm is that of y and the mean of those of the columns of S: y is as
    exact as without S.  On eight problems at 1e-4, 1e-6 and 1e-8, by RK45, S is then off by 2.7
    times the error of y alone, each in its tolerance and S in its worst column (geometric mean; at
    most 7.8).  By the largest of the norms, as in CVODES, 1.8 (7.5), but steps at 30 directions are
    shorter by a fifth; by the sum of all squares 1.2 (6.6), shorter by 30 %; by y alone 18 (545).
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
    rtol = p.rtol
    atol = p.atol
    if p.method.error_order:
        tolerances = Tolerances(p, m)
        sizes = np.concatenate([abs(d.value).ravel() for d in directions])
        rtol = tolerances.rtol
        atol = tolerances.atol(sizes)
    own = of_own if parts == 1 else _of_halves

    def longer(event, jump):
        return jump and Saltation(p.fun, event, jump, n, positions, m)

    events = p.events and [own(e, n).changed(act=longer(e.function, e.act)) for e in p.events]
    schedules = [each._replace(jump=longer(None, each.jump)) for each in p.schedules]
    return p._replace(
        fun=equations, mode=SENSITIVITIES, y0=y0, rtol=rtol, atol=atol, events=events, jac=None,
        schedules=tuple(schedules),
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
    y = each[..., :n]
    columns = each[..., n:].reshape(*before, parts, n, m)
    return y.reshape(*before, parts * n), columns.reshape(*before, parts * n, m)


def _of_halves(event, n):
    """An Event of [q, v] as one of the extended state, whose halves begin with q and v."""
    given: Any = event.function

    def watched(t, z, *args):
        half = len(z) // 2
        return given(t, np.concatenate((z[:n], z[half : half + n])), *args)

    return event.form(watched)


def by_name(columns, directions):
    """The parts of (..., m, k) by the names of the directions, each in the shape of its value."""
    *before, _, k = columns.shape
    if len(directions) == 1:
        (d,) = directions
        return {d.name: columns.reshape(*before, *d.value.shape, k)}
    found = {}
    begin = 0
    for d in directions:
        end = begin + d.size
        found[d.name] = columns[..., begin:end, :].reshape(*before, *d.value.shape, k)
        begin = end
    return found


def not_differentiable(option, problem, reason):
    """The exception of a problem without derivatives: the function's own at the start, if any."""
    p = problem
    try:
        evaluate(called_with(p.fun, p.args), p.mode, p.t0, p.y0.copy())
    except Exception as error:
        return error
    return not_traced(option, p, reason)


def not_traced(option, problem, reason):
    """The ValueError of a problem without derivatives, whose function the next call tries again."""
    p = problem
    Attempt(p.fun, p.args, p.mode, len(p.y0)).forget_refusals()
    return ValueError(NEEDS.format(option, reason))
