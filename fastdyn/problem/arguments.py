"""The arguments of a solve, checked once; the method decides about the rest."""

import copy
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from fastdyn.words import kinds

from . import mass, schedules, validate
from .events import Event
from .options.table import OPTIONS, check_kinds, refused_by
from .step_options import warn_of_breakpoints

NAMES = {"prepare": "a prepared solver", "Stepper": "a Stepper"}  # in messages


class Arguments(NamedTuple):
    """The arguments of a solver; those that no method changes are checked.

    `validate.problem` makes a Problem of them, for one method.  `options` has the options that end
    in the Problem; the four that change the problem as a whole are fields.
    """

    fun: Any
    t0: float
    tf: float
    y0: Any  # of float64 or complex128, finite
    method: Any = None  # as the user gave it: a name, or a class of SciPy's
    t_eval: Any = None
    dense_output: bool = False
    events: Any = None
    vectorized: bool = False
    args: tuple = ()
    options: Mapping[str, Any] = {}
    discrete: Any = None
    sensitivity: Any = None
    adjoint: Any = None
    error_estimate: Any = None
    reaction: validate.Reaction = validate.Reaction()
    given_y0: Any = None  # as the user gave it: SciPy calls events with this object

    def reacting(self, **how):
        """The arguments, with another Reaction of the solve."""
        return self._replace(reaction=self.reaction._replace(**how))

    def with_options(self, **options):
        """The arguments, with other values of some options."""
        return self._replace(options={**self.options, **options})


def checked(fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options):
    """The Arguments of `solve_ivp`; `options` is not used by anyone else.

    Raises
    ------
    ValueError, TypeError
    """
    numbers = isinstance(method, np.ndarray | list | tuple | range)
    if numbers and np.asarray(method).dtype.kind in "fiu":
        raise TypeError(
            f"`method` is the name of a method; got {kinds.shown(method)}: times of output are "
            "`t_eval`, solve_ivp(fun, (t0, tf), y0, t_eval=...)."
        )
    automatic = isinstance(method, str) and method == "auto"
    ours = None if automatic else validate.method_named(method, automatic=True)
    state = validate.initial_state(y0)
    kinds.flag("dense_output", dense_output)
    kinds.flag("vectorized", vectorized)
    if automatic or ours is not None:
        check_kinds(options)
    if "callback" in options:
        OPTIONS["callback"].check(options["callback"])
    try:
        t0, tf = validate.time_span(t_span)
    except (TypeError, ValueError) as error:
        if is_exchanged(state):
            error.add_note(EXCHANGED)
        raise
    if automatic or ours is not None:
        warn_of_breakpoints(options.get("breakpoints"), t0, tf)
    pop = options.pop
    return Arguments(
        fun=fun, t0=t0, tf=tf, y0=state, method=method, t_eval=t_eval, dense_output=dense_output,
        events=events, vectorized=vectorized, args=validate.extra_arguments(args), options=options,
        discrete=pop("discrete", None), sensitivity=pop("sensitivity", None),
        adjoint=pop("adjoint", None), error_estimate=pop("error_estimate", None), given_y0=y0,
    )  # fmt: skip


def own(given):
    """The arguments of a solver that solves later, apart from what the user changes meanwhile.

    `given` has the arguments by their names.  Arrays and lists are copied, but for those in `args`,
    which functions read at each solve as they read other values from outside.  The rules of events,
    which are attributes of functions, are read now.
    """
    found = {name: value if name == "args" else _copied(value) for name, value in given.items()}
    if given.get("events") is not None:
        found["events"] = [*map(_with_rules, schedules.listed(given["events"], {}))]
    return found


def _with_rules(event):
    """An event function as an Event, a schedule as a copy."""
    return copy.deepcopy(event) if isinstance(event, schedules.Schedule) else Event.of(event)


def _copied(value):
    if type(value) is list or type(value) is tuple:
        return type(value)(map(_copied, value))
    copy = getattr(value, "copy", None) if hasattr(value, "dtype") else None
    return value if copy is None or callable(value) else copy()


EXCHANGED = "Are they exchanged? The order is fun, t_span, y0; times of output are `t_eval`."


def is_exchanged(state):
    """Whether a state looks like times of output: three numbers or more, which rise evenly."""
    steps = np.diff(state.real)
    return len(steps) > 1 and bool((steps > 0).all() and np.ptp(steps) < 1e-9 * abs(state).max())


def refuse(who, options):
    """Raise TypeError for an option that `prepare` or a Stepper does not take."""
    for name in refused_by(who):
        if name in options:
            raise TypeError(f"{NAMES[who]} takes no `{name}`.")


def compiled_method(who, asked, otherwise=""):
    """The Facts of the method of Arguments for `prepare` or a Stepper.

    These take compiled methods alone, a real state, and a span that is not empty; `otherwise` is
    the alternative, for the ValueError.
    """
    method = validate.method_named(asked.method)
    if method is None or asked.y0.dtype.kind == "c" or not asked.y0.size or asked.t0 == asked.tf:
        raise ValueError(
            f"{NAMES[who]} takes one of fastdyn's methods, a real state and a span that is not "
            f"empty{otherwise}."
        )
    mass.refuse(asked.options, method, asked.y0)
    return method
