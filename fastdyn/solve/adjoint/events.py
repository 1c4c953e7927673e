"""The events of a solve with `adjoint`: their products, and code for solves without Python."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.derivatives.transposed_saltation import bind_transposed
from fastdyn.compile.derivatives.vjp import frozen
from fastdyn.compile.function_convention import call, code_at
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.problem.schedules import in_order
from fastdyn.problem.sensitivities import Saltation


class OfEvents(NamedTuple):
    """The events of a sweep, each at its place among event functions and schedules.

    Attributes
    ----------
    acting : tuple of vjp.Product or None
        Those of the events that act.
    passive : tuple of vjp.Product, str or None
        Those of times of events, and of states at these; a reason why there is none; None for the
        times of schedules, which are fixed.
    order : tuple of int
        The places in the order of `t_events`.
    others : tuple of Bound
        All functions that are called between steps, with copies of their outside values.
    """

    acting: tuple = ()
    passive: tuple = ()
    order: tuple = ()
    others: tuple = ()

    @property
    def acts(self):
        """Whether an event acts."""
        return any(self.acting)


NO_EVENTS = OfEvents()
NO_DERIVATIVE = "The occurrences of event {} have no derivative: {}."


def of_events(problem, run, positions):
    """The OfEvents of a problem, whose Run has compiled all functions.

    Raises
    ------
    Uncompilable
        If an event or its action has no trace, or a derivative is missing.
    """
    p = problem
    n = len(problem.y0)
    events = p.events or ()
    near = Near(p.t0, p.tf, p.y0)
    if not (events or p.schedules):
        return NO_EVENTS
    functions = [*[event.function for event in events], *[None] * len(p.schedules)]
    acting = []
    passive = []
    for event, jump in zip(functions, p.jumps, strict=True):
        given = Saltation(p.fun, event, jump, n, (), 0)
        acting.append(jump and bind_transposed(given, p.args, near, positions))
        try:
            own: Any = event and bind_transposed(given._replace(jump=None), p.args, near, positions)
        except Uncompilable as reason:
            own = str(reason)
        passive.append(own)
    places = range(len(functions))
    n_events = len(p.events or ())
    order = in_order(places[:n_events], p.schedules, places[n_events:])
    others = [frozen_of(bound, n) for bound in run.bounds[1:]]
    return OfEvents(tuple(acting), tuple(passive), tuple(order), tuple(others))


def frozen_of(bound, n, given=None):
    """A Bound with copies of its outside values, or of those that are `given`."""
    values = zip([kind for kind, _ in bound.values], given or bound.given, strict=True)
    return frozen(bound.function, None, values, bound.mode, n, bound.at)


def back_over(product, occurrence, derivatives, by_time=0.0):
    """The derivatives by the state before an event, and by the parameters.

    `derivatives` are those by the state behind it, or, for a passive product, by the state at the
    time of the event.
    """
    n = product.n
    z = np.zeros(product.bound.n)
    z[:n] = occurrence.y
    z[-n - 1 : -1] = derivatives
    z[-1] = by_time
    found = np.zeros(n + product.m)
    function = code_at(product.bound.function.address)
    call(function, occurrence.t, z, product.bound.block.copy(), found)
    return found[:n], found[n:]


def by_occurrence(events, legs, n, t_events, y_events):
    """{(place, number): (derivatives by the state at an occurrence, derivative by its time)}.

    `t_events` and `y_events` are the arguments of `vjp`; n is the length of a state.
    """
    if t_events is None and y_events is None:
        return {}
    counts = counts_of(legs, len(events.order))
    found = {}
    given = listed("t_events", t_events, len(counts)), listed("y_events", y_events, len(counts))
    for i, (place, *parts) in enumerate(zip(events.order, *given, strict=True)):
        k = counts[place]
        of_time, of_state = parts
        if (of_time is None and of_state is None) or not k:
            continue
        if isinstance(events.passive[place], str):
            raise ValueError(NO_DERIVATIVE.format(i, events.passive[place]))
        c = np.zeros(k)
        rows = np.zeros((k, n))
        if of_time is not None:
            c = checked(f"t_events[{i}]", f"t_events[{i}]", of_time, (k,))
        if of_state is not None:
            rows = checked(f"y_events[{i}]", f"y_events[{i}]", of_state, (k, n))
        found |= {(place, j): (rows[j], c[j]) for j in range(k)}
    return found


def counts_of(legs, n_places):
    """The number of occurrences of each event."""
    found = [0] * n_places
    for leg in legs:
        for each in (*leg.seen, *leg.ends):
            found[each.place] += 1
    return found


def checked(name, of, given, shape):
    """Derivatives by the field `of` as an array of floats of a shape."""
    found = np.asarray(given)
    if found.dtype.kind not in "fiub":
        raise TypeError(f"`{name}` must be real numbers; got an array of {found.dtype}.")
    if found.shape != shape:
        raise ValueError(
            f"`{name}` has the derivatives by `{of}` and so its shape, {shape}; got {found.shape}."
        )
    if not np.isfinite(found).all():
        raise ValueError(f"`{name}` contains nan or inf.")
    return found.astype(float)


def listed(name, given, n):
    """One entry for each of n events."""
    if given is None:
        return [None] * n
    if not isinstance(given, list | tuple) or len(given) != n:
        raise ValueError(
            f"`{name}` has an entry for each event, None or the derivatives by its occurrences: "
            f"there are {n} events."
        )
    return list(given)
