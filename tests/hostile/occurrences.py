"""Pulses of event functions, by many solvers and ways: an action counts the crossings of a level.

Each way returns the count, which is 1 with a direction.
"""

import itertools
import types

import numpy as np

from fastdyn import (
    Phase,
    Stepper,
    prepare,
    solve_dae,
    solve_dae_ensemble,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)

LINES = itertools.count(200_000)
SPAN = (0.0, 10.0)
BEGIN = np.array([0.0, 1.0])


def fresh(fun):
    """A copy of a function of which nobody was told yet: on a line of its own."""
    code = fun.__code__.replace(co_firstlineno=next(LINES))
    return types.FunctionType(code, fun.__globals__, "pulsed", None, fun.__closure__)


def explicit(method):
    """The method, or one that other solvers than solve_ivp take."""
    return "Tsit5" if method == "auto" else method


def decays(t, y):
    """A count, and a component that lets the steps grow."""
    return [0.0 * y[0], -y[1]]


def decays_anyway(t, y, *values):
    return [0.0 * y[0], -y[1]]


def counts(t, y, *values):
    return [y[0] + 1.0, y[1]]


def implicit(t, y, yp, *values):
    return [yp[0], yp[1] + y[1]]


def directed(event, direction):
    event = fresh(event)
    event.direction = direction
    return event


def drawn_event(u, rng):
    """The functions of t and y, with and without a shift of the time, and the level."""
    height = max(float(u(t)) for t in np.linspace(*SPAN, 2001))  # each pulse is longer than 0.005
    level = height * rng.uniform(0.1, 0.7)
    direction = int(rng.choice([1, -1]))
    return (
        directed(lambda t, y: u(t) - level, direction),
        directed(lambda t, y, a: u(t + a) - level, direction),
    )


def once(events, method):
    return solve_ivp(decays, SPAN, BEGIN, method, events=events[0], on_event=counts).y[0, -1]


def noted(events, method):
    """Without an action."""
    return len(solve_ivp(decays, SPAN, BEGIN, method, events=events[0]).t_events[0])


def noted_at_times(events, method):
    run = solve_ivp(decays, SPAN, BEGIN, method, np.array([0.0, 10.0]), events=events[0])
    return len(run.t_events[0])


def precisely(events, method):
    given = {"events": events[0], "on_event": counts, "rtol": 1e-8, "dense_output": True}
    return solve_ivp(decays, SPAN, BEGIN, method, **given).sol(10.0)[0]


def backwards(events, method):
    """The direction is that of the steps."""
    fun = fresh(lambda t, y: [0.0 * y[0], y[1]])
    given = {"events": events[0], "on_event": counts}
    return solve_ivp(fun, SPAN[::-1], BEGIN, method, **given).y[0, -1]


def again(events, method):
    given = {"events": events[1], "on_event": counts, "args": (0.0,)}
    return [solve_ivp(decays_anyway, SPAN, BEGIN, method, **given).y[0, -1] for _ in range(4)][-1]


def noted_again(events, method):
    """With values that the times of the pulse depend on."""
    for a in (-1.0, 1.0, -0.5, 0.0):
        run = solve_ivp(decays_anyway, SPAN, BEGIN, method, events=events[1], args=(a,))
    return len(run.t_events[0])


def prepared(events, method):
    given = {"events": events[1], "on_event": counts, "args": (1.0,)}
    solver = prepare(decays_anyway, SPAN, BEGIN, explicit(method), **given)
    return [solver(args=(a,)).y[0, -1] for a in (1.0, -1.0, 0.0)][-1]


def noted_by_prepared(events, method):
    solver = prepare(decays_anyway, SPAN, BEGIN, explicit(method), events=events[1], args=(1.0,))
    return [len(solver(args=(a,)).t_events[0]) for a in (1.0, -1.0, 0.0)][-1]


def many(events, method):
    given = {"events": events[1], "on_event": counts, "args": (1.0,)}
    solver = prepare(decays_anyway, SPAN, BEGIN, explicit(method), **given)
    return solver.many(args=(np.array([1.0, 0.0, -1.0]),)).y[1, 0]


def in_an_ensemble(events, method):
    shifts = np.array([1.0, 0.0, -1.0])
    given = {"method": explicit(method), "events": events[1], "on_event": counts}
    return solve_ensemble(decays_anyway, SPAN, BEGIN, (shifts,), **given).y_end[1, 0]


def noted_in_an_ensemble(events, method):
    shifts = np.array([1.0, 0.0, -1.0])
    given = {"method": explicit(method), "events": events[1]}
    run = solve_ensemble(decays_anyway, SPAN, BEGIN, (shifts,), **given)
    return len(run.t_events[0][1])


def by_phases(events, method):
    """The event is the edge of both phases."""
    events[0].terminal = True
    first = Phase(decays, events[0], lambda t, y: ("b", counts(t, y)))
    second = Phase(decays, events[0], lambda t, y: ("a", counts(t, y)))
    given = (0.0, 10.0), BEGIN, explicit(method)
    return solve_phases({"a": first, "b": second}, "a", *given).y[0, -1]


def by_phases_that_only_go_on(events, method):
    events[0].terminal = True
    same = {"a": Phase(decays, events[0], lambda t, y: ("a", y))}
    return len(solve_phases(same, "a", SPAN, BEGIN, explicit(method)).phases) - 1


def from_its_edge(events, method):
    """The span begins at the time of the occurrence, at which the function may jump."""
    t = float(solve_ivp(decays, SPAN, BEGIN, method, events=events[0]).t_events[0][0])
    given = {"events": events[0], "on_event": counts, "atol": 1e-9}
    run = solve_ivp(decays, (t, SPAN[1]), BEGIN, method, **given)
    near = np.abs(run.t_events[0] - t) < 1e-12
    return 1 if near.all() else run.t_events[0]


def by_a_stepper(events, method):
    given = {"method": explicit(method), "events": events[0], "on_event": counts}
    found = Stepper(decays, 0.0, BEGIN, 10.0, **given)
    while found.status == "running":
        found.step()
    return found.y[0]


def by_a_stepper_with_args(events, method):
    given = {"method": explicit(method), "events": events[1], "on_event": counts, "args": (-1.0,)}
    found = Stepper(decays_anyway, 0.0, BEGIN, 10.0, first_step=0.1, **given)
    found.step()
    found.args = (0.0,)
    while found.status == "running":
        found.step()
    return found.y[0]


def by_discrete(events, method):
    """The action counts in a discrete state, whose other number shifts the time."""
    event = directed(lambda t, y, d: events[1](t, y, d[1]), events[1].direction)
    fun = fresh(lambda t, y, d: [d[0], -y[1]])
    given = {"discrete": [0.0, 0.0], "on_event": lambda t, y, d: (y, [d[0] + 1.0, d[1]])}
    return solve_ivp(fun, SPAN, BEGIN, method, events=event, **given).discrete[0, -1]


def of_a_component(events, method):
    """The time is shifted by a component that stays."""
    event = directed(lambda t, y: events[1](t, y, y[1]), events[1].direction)
    fun = fresh(lambda t, y: [0.0 * y[0], 0.0])
    given = {"events": event, "on_event": counts}
    return solve_ivp(fun, SPAN, [0.0, 0.0], method, **given).y[0, -1]


def of_an_implicit_equation(events, method):
    method = method if method in ("BDF", "Radau", "Rodas5P") else "Radau"
    given = {"events": events[0], "on_event": counts, "method": method}
    return solve_dae(implicit, SPAN, BEGIN, **given).y[0, -1]


def noted_of_an_implicit_equation(events, method):
    method = method if method in ("BDF", "Radau", "Rodas5P") else "Radau"
    return len(solve_dae(implicit, SPAN, BEGIN, events=events[0], method=method).t_events[0])


def of_many_implicit_equations(events, method):
    method = method if method in ("BDF", "Radau", "Rodas5P") else None
    shifts = np.array([1.0, 0.0, -1.0])
    given = {"args": (shifts,), "events": events[1], "method": method}
    return len(solve_dae_ensemble(implicit, SPAN, BEGIN, **given).t_events[0][1])


def actions_of_many_implicit_equations(events, method):
    method = method if method in ("BDF", "Radau", "Rodas5P") else None
    shifts = np.array([1.0, 0.0, -1.0])
    given = {"args": (shifts,), "events": events[1], "on_event": counts, "method": method}
    return solve_dae_ensemble(implicit, SPAN, BEGIN, **given).y_end[1, 0]


OF_EVENTS = (
    once, noted, noted_at_times, precisely, backwards, again, noted_again, prepared,
    noted_by_prepared, many, in_an_ensemble, noted_in_an_ensemble, by_phases,
    by_phases_that_only_go_on, from_its_edge, by_a_stepper, by_a_stepper_with_args, by_discrete,
    of_a_component, of_an_implicit_equation, noted_of_an_implicit_equation,
    of_many_implicit_equations, actions_of_many_implicit_equations,
)  # fmt: skip
