"""OdeResult, the result of a solve."""

import textwrap
from collections.abc import Callable
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from fastdyn.plot.displayed import display
from fastdyn.plot.needed import needed
from fastdyn.words.near import did_you_mean


class Ended(NamedTuple):
    """The counts of a solve and the size of its next step; or those of many solves, as arrays.

    The names are those of STATE.  `n_extra` are evaluations beside those of the steps; None stands
    for a number that is not counted.
    """

    n_accepted: Any
    n_rejected: Any
    n_extra: Any
    h: Any
    n_jacobians: Any = None
    n_factorised: Any = None

    @classmethod
    def of(cls, state):
        """That of a record of STATE."""
        return cls(*[state[name].item() for name in cls._fields])


class Field(NamedTuple):
    """One field of a result: the entry in the docstring of OdeResult.

    A field without a type shares the entry of the field before.  A number that follows from the end
    of a solve has `of_end`, a function of the Facts of the method and an Ended.  Steppers,
    ensembles, and solves of many or of parts have these fields, too: `joined` makes one number of
    the list of those of all parts, as `sum`; without it, the last holds.  A field that only some
    solves have tells them in `only`.
    """

    name: str
    type: str
    text: str
    of_end: Callable[[Any, Ended], Any] | None = None
    joined: Callable[[list], Any] = itemgetter(-1)
    only: str = ""


ALL_FIELDS = (
    Field("t", "ndarray, shape (n_points,)", "Times, in the unit of `t_span`."),
    Field("y", "ndarray, shape (n, n_points)", "States at these times."),
    Field(
        "sol", "OdeSolution or None", "The continuous solution, with ``dense_output=True``."
    ),
    Field(
        "t_events", "list of ndarray or None",
        "For each event, its times (k,) and the states there (k, n).",
    ),
    Field("y_events", "", ""),
    Field(
        "nfev", "int", "Numbers of evaluations of `fun`, of Jacobians, of factorisations.",
        lambda method, c: c.n_extra + method.n_stages * (c.n_accepted + c.n_rejected), sum,
    ),
    Field("njev", "", "", lambda method, c: c.n_jacobians, sum),
    Field("nlu", "", "", lambda method, c: c.n_factorised, sum),
    Field(
        "status", "int",
        "0: the end was reached; 1: a terminal event, or `callback`; -1: failure; -2: interrupted; "
        "-3: the border of `domain`.",
    ),
    Field("message", "str", "The reason of the end, in a sentence."),
    Field("success", "bool", "True if `status` is 0 or 1."),
    Field(
        "n_accepted", "int", "Numbers of steps (compiled methods only).",
        lambda method, c: c.n_accepted, sum,
    ),
    Field("n_rejected", "", "", lambda method, c: c.n_rejected, sum),
    Field("method", "str", "The method that was chosen, and the reason.", only='"auto"'),
    Field("reason", "", "", only='"auto"'),
    Field(
        "sensitivity", "dict of str to ndarray",
        'By "y0" and the names of arguments: entry [i, ..., k] is the derivative of y_i(t_k) with '
        "respect to component ... of the initial state or argument, in units of y per unit of that "
        'component.  The shape is (n, n, n_points) for "y0", (n, n_points) for a number, '
        "(n, ..., n_points) for an array.",
        only="`sensitivity`",
    ),
    Field(
        "event_sensitivity", "list of EventSensitivity or None",
        "For each event, the derivatives of its k times, `t`, and of the states there before "
        "`on_event` acts, `y`: dicts by the names of `sensitivity`, of shapes (..., k) and "
        "(n, ..., k).  None for an event that cannot be traced or differentiated; inf or nan where "
        "the event function touches zero without crossing it.",
        only="`sensitivity` and events",
    ),
    Field(
        "vjp", "callable",
        "``vjp(g)`` returns the derivatives of a number by the initial state and by arguments, as "
        "a dict, from the derivatives `g` of the number by `y`, of shape (n, n_points).  "
        "``vjp(g, t_events=None, y_events=None)`` also takes derivatives by the times of events "
        "and by the states there: for each event None, or shape (k,) and (k, n).  ValueError if a "
        "shape is wrong, a derivative is not finite, or the problem is too stiff for the method.",
        only="`adjoint`",
    ),
    Field(
        "error_estimate", "ndarray, shape (n, n_points)",
        "An estimate of y minus the exact solution.", only="`error_estimate`",
    ),
    Field(
        "discrete", "ndarray, shape (m, n_points)", "Discrete states at the times of `t`.",
        only="`discrete`",
    ),
    Field(
        "discrete_events", "list of ndarray", "For each event, the discrete states there (k, m).",
        only="`discrete`",
    ),
)  # fmt: skip
FIELDS = {field.name: field for field in ALL_FIELDS if not field.only}  # of each compiled solve
FOLLOWING = {name: field.of_end for name, field in FIELDS.items() if field.of_end}


def made(method, ended, **parts) -> Any:
    """The OdeResult with all FIELDS: from `parts`, from `ended`, which is an Ended, or None.

    `success` follows from `status`.
    """
    found = OdeResult(dict.fromkeys(FIELDS))
    found.update(following(method, ended))
    found.update(parts, success=parts["status"] >= 0)
    return found


def following(method, ended, names=FOLLOWING):
    """The fields that follow from an Ended, by name; None for a number that is not counted."""
    return {name: FOLLOWING[name](method, ended) for name in names}


def of_parts(parts, names=FOLLOWING):
    """The fields that follow from Endeds of parts of a solve, dicts with them, by name.

    A number that a part has not counted stands for the whole.
    """
    found = {}
    for name in names:
        numbers = [part[name] for part in parts]
        found[name] = None if None in numbers else FIELDS[name].joined(numbers)
    return found


def _attributes():
    """The section Attributes of a docstring."""
    parts: list = []
    for field in ALL_FIELDS:
        if field.type:
            parts.append(([field.name], field))
        else:
            parts[-1][0].append(field.name)
    lines = []
    for names, field in parts:
        text = field.text + f"  With {field.only}." * bool(field.only)
        lines.append(f"{', '.join(names)} : {field.type}")
        lines.append(textwrap.fill(text, 96, initial_indent=INDENT, subsequent_indent=INDENT))
    return "\n".join(["", "Attributes", "----------", *lines])


INDENT = "    "


ACTIONS = ("both", "before", "after")  # states of a time at which `on_event` has acted, in tables


class NoField(KeyError, AttributeError):
    """A result has no field of this name, asked for as a key or as an attribute.

    The first argument is the name, the second has the names that there are.
    """

    def __str__(self):
        name, known = self.args
        asked = [field.only for field in ALL_FIELDS if field.name == name and field.only]
        if asked:
            return f"the result has no {name!r}; a result of a solve with {asked[0]} has one."
        said = did_you_mean(name, known) or f"it has {', '.join(sorted(map(str, known)))}."
        return f"the result has no {name!r}; {said}"


class OdeResult(dict):
    """A dict with attribute access: SciPy's fields and more, those of FIELDS."""

    t: np.ndarray
    y: np.ndarray
    sol: Any
    t_events: Any
    y_events: Any
    nfev: int
    njev: int
    nlu: int
    status: int
    message: str
    success: bool
    n_accepted: int
    n_rejected: int

    def __missing__(self, name):
        raise NoField(name, tuple(self))

    __getattr__: Any = dict.__getitem__
    __setattr__: Any = dict.__setitem__
    __delattr__: Any = dict.__delitem__

    def __dir__(self):
        return {*super().__dir__(), *self}

    def __repr__(self):
        from scipy.optimize import OptimizeResult  # 0.1 s, for those who print

        like_scipy: Any = OptimizeResult.__repr__
        return like_scipy(self)

    def to_pandas(self, actions="both"):
        """The states as a pandas.DataFrame: a row for each time, a column for each component.

        The columns have the names of the system's components, else ``y[0]``, ``y[1]``, ...; the
        units of a system are in ``attrs["units"]``.

        Parameters
        ----------
        actions : {"both", "before", "after"}
            Which states a time has at which `on_event` has acted, and so `t` has twice.  With one
            of them, each time is there once, as ``reindex`` and ``interp`` need.
        """
        return _frame(self, self._components(), _rows(self.t, actions))

    def to_xarray(self, actions="both"):
        """The states as an xarray.Dataset: ``y`` by component and time, and the counts.

        Sensitivities are ``dy_dk`` for an argument k, and ``dy_dy0``, with axes ``y0_0``, ...
        Needs xarray, which ``fastdyn[cluster]`` installs.

        Parameters
        ----------
        actions : {"both", "before", "after"}
            As in `to_pandas`.
        """
        counts = [name for name in FOLLOWING if name in self]
        return _dataset(self, self._components(), counts, _rows(self.t, actions))

    def _components(self):
        """(name, unit, meaning) of each component."""
        return [(f"y[{i}]", "", "") for i in range(len(self.y))]

    def _repr_html_(self):
        return display(self)

    def plot(self, **options) -> Any:
        """Draw the components over time; the result of a system draws the figure of the system.

        Parameters
        ----------
        **options
            Options of `fastdyn.plot.solution.plot`, or of the figure of the system.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.solution import plot

        return plot(self, **options)


def _rows(t, actions):
    """Which times of a result a table has: see `OdeResult.to_pandas`."""
    if actions not in ACTIONS:
        known = ", ".join(map(repr, ACTIONS))
        raise ValueError(f"`actions={actions!r}` is unknown; choose from {known}.")
    again = np.diff(np.asarray(t, float)) == 0.0
    rows = np.ones(len(t), bool)
    if actions == "before":
        rows[1:] &= ~again
    elif actions == "after":
        rows[:-1] &= ~again
    return rows


def _frame(result, components, rows):
    """The DataFrame of `OdeResult.to_pandas`; `components` are (name, unit, meaning) of each."""
    pandas = needed("pandas", "`to_pandas` needs")
    names = [name for name, *_ in components]
    times = pandas.Index(np.asarray(result.t, float)[rows], name="t")
    found = pandas.DataFrame(_states(result, components).T[rows], times, names)
    units = {name: unit for name, unit, *_ in components if unit}
    if units:
        found.attrs["units"] = units
    return found


def _dataset(result, components, counts, rows):
    """The Dataset of `OdeResult.to_xarray`.

    `components` are (name, unit, meaning) of each, `counts` the names of fields that count.
    """
    xarray = needed("xarray", "`to_xarray` needs")
    names, units, meanings = (list(each) for each in zip(*components, strict=True))
    coordinates = {"component": names, "time": np.asarray(result.t, float)[rows]}
    if any(units):
        coordinates |= {"unit": ("component", units), "meaning": ("component", meanings)}
    facts = {name: result[name] for name in ("status", "message", *counts)}
    facts = {name: value for name, value in facts.items() if value is not None}
    values: Any = {"y": (("component", "time"), _states(result, components)[:, rows])}
    for name, slopes in (result.get("sensitivity") or {}).items():
        axes = tuple([f"{name}_{k}" for k in range(np.ndim(slopes) - 2)])
        values[f"dy_d{name}"] = ("component", *axes, "time"), slopes[..., rows]
    return xarray.Dataset(values, coordinates, facts)


def _states(result, components):
    """The states, shape (n, n_points); SciPy's empty output is a list."""
    return np.reshape(result.y, (len(components), len(result.t)))


for name in FIELDS:  # a seventh of the time of `__getattr__`, which is called after a failed search
    setattr(OdeResult, name, property(itemgetter(name), doc=""))
OdeResult.__doc__ = "A dict with attribute access: SciPy's fields and more.\n" + _attributes()
