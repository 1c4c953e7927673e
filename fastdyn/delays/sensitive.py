"""Sensitivities of a delay equation: by arguments, among them delays, and by the history."""

import contextlib
from typing import Any

from fastdyn.compile.callables import Uncompilable
from fastdyn.compile.derivatives.sensitivities import decides
from fastdyn.compile.functions import BASE
from fastdyn.compile.sentences import GaveUp
from fastdyn.problem.schedules import in_order
from fastdyn.problem.sensitivities import (
    START,
    Variational,
    directions_of,
    not_traced,
    with_sensitivities,
)
from fastdyn.run.solve_problem import run_of
from fastdyn.solve.sensitivities import at_events, parted
from fastdyn.trace.graph.expressions import live

from .past import history_of
from .run import DelayRun

# Methods whose interpolant has the order of the method, and so its derivative the order less one.
# Tsit5's derivative of order 3 is 80 tolerances off at 1e-9 where these are one.
NEUTRAL = ("Vern7", "Vern9")
HISTORY = "history"  # the name of a constant history among the directions
DIFFERENCES = "Take differences of two solves by `prepare_dde`, at tight tolerances."
BOTH = (
    "`sensitivity` and `{}` do not go together in a delay equation: the jumps come back at times "
    "that vary with the directions. " + DIFFERENCES
)
OF_NEUTRAL = (
    "`sensitivity` is not computed for neutral equations (`past.derivative`), whose derivatives "
    "jump throughout the span. " + DIFFERENCES
)


class VariationalPast(Variational):
    """The equations of a state and its sensitivities, which read the past of both."""

    @contextlib.contextmanager
    def varied(self, args, steps):
        """A context in which the past moves along the directions, in Python."""
        history = history_of(args[0])
        history.varied = steps
        try:
            yield
        finally:
            history.varied = None


def asked_directions(wanted, fun, history, args):
    """The Directions of a delay equation: positions are those of (past, *args).

    Raises
    ------
    ValueError, TypeError
    """
    names = [wanted] if isinstance(wanted, str) else wanted
    names = list(names) if isinstance(names, list | tuple | set) else names
    if isinstance(names, list) and START in names:
        raise ValueError(
            f"`sensitivity={START!r}`: the state at the start is that of `history`; name "
            f"{HISTORY!r} for a constant one, or arguments, which a function of "
            "(t, *args) gets."
        )
    if isinstance(names, list) and HISTORY in names and not history.is_constant:
        raise ValueError(
            f"`sensitivity={HISTORY!r}` is for a constant history: name the arguments of the "
            "equations on which the function `history(t, *args)` depends."
        )
    found = directions_of(names, fun, history.y0, args, first=3, start=HISTORY)
    return [d._replace(position=d.position and d.position + 1) for d in found]


def _longer(problem, history, directions):
    """A DelayRun of a state and its sensitivities.

    Raises
    ------
    ValueError
        If the equations or the history have no derivatives, or jump.
    """
    p = with_sensitivities(problem, directions)
    p = p._replace(fun=VariationalPast(*p.fun))
    p = p._replace(y0=history.lengthen(p.fun, p.y0))
    run = run_of(p, DelayRun)
    if decides(run.bounds[0]):
        raise ValueError(
            "`sensitivity` is not computed where `fun` decides by the state, the past or a "
            "differentiated argument (`if`, `where`, `sign`, rounding): its derivatives may jump, "
            "and each jump comes back. Make the passage smooth, tanh(v / w) for sign(v), say."
        )
    (own, *_) = run.bounds
    nodes = live(own.function.traced.stored)
    if any(n.op == "past" and n.data[2] for n in live(own.function.notes[BASE].traced.stored)):
        raise ValueError(OF_NEUTRAL)
    if p.method.name not in NEUTRAL and any(n.op == "past" and n.data[2] for n in nodes):
        raise ValueError(
            f"`method={p.method.name!r}`: derivatives by a delay read those of the past; choose "
            f"from auto, {', '.join(NEUTRAL)}, whose interpolants have precise derivatives."
        )
    return run


def _at_events(problem, history, whole, directions):
    """The EventSensitivities; None for an event whose function reads the past."""
    p = problem
    found = at_events(p, whole, directions)
    of_schedules = [None] * len(p.schedules)
    functions: Any = in_order(
        [event.function for event in p.events or ()], p.schedules, of_schedules
    )
    for i, function in enumerate(functions):
        if function is None:
            continue
        with history.asked() as times:
            for t, y in zip(whole["t_events"][i], whole["y_events"][i], strict=True):
                function(t, y[: len(p.y0)].copy(), *p.args)
        if times:
            found[i] = None
    return found


def solved_in_parts(problem, history, directions, solved):
    """The result of ``solved(run)``, divided into the state and its sensitivities.

    Raises
    ------
    ValueError
        As `_longer`, and if the derivatives prove to be wrong.
    """
    try:
        whole = solved(_longer(problem, history, directions))
    except (Uncompilable, GaveUp) as reason:
        raise not_traced("sensitivity", problem, reason) from None
    at_times = _at_events(problem, history, whole, directions) if whole["t_events"] else None
    result = parted(whole, len(problem.y0), directions)
    if at_times is not None:
        result["event_sensitivity"] = at_times
    for name in ("delays", "jumps"):
        result[name] = whole[name]
    return result
