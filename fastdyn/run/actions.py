"""Messages of runs that end because a function of `on_event` returned a state that is refused."""

from fastdyn.kernels.state.record import BAD_JUMP, NEGATIVE, OUTSIDE
from fastdyn.problem.schedules import in_order

NOT_FINITE = "returned nan or inf"
OF_ACTIONS = {
    BAD_JUMP: f"{{action}} {NOT_FINITE} at {{t}} ({{component}}).",
    OUTSIDE: "{action} returned a state outside of `domain` at {t}: the run ends before the "
    "action. Return a state inside, or widen `domain`.",
    NEGATIVE: "{action} returned a negative number at {t} ({component}), which `nonnegative` "
    "forbids: the run ends before the action. Return 0 or more.",
}
OF_EACH = {"action": "`on_event`", "component": "in a component"}  # of many trajectories


def after_action(status, s, problem, t):
    """The sentence for a status of OF_ACTIONS; `s` is the record of the state."""
    component = f"component {s['component']}"
    return OF_ACTIONS[status].format(action=_action(s, problem), component=component, t=t)


def _action(s, problem):
    """The function of `on_event` that was called last, in words."""
    p = problem
    found, place = p.events or (), int(s["acted"])
    n = len(found)
    if place >= n:
        return f"`on_event` of event {p.schedules[place - n].place}, a schedule,"
    order = list(in_order(range(n), p.schedules, [None] * len(p.schedules)))
    name = getattr(found[place][0], "__name__", "a function")
    return f"`on_event` of event {order.index(place)}, `{name}`,"
