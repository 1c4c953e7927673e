"""The delays of a traced function, and the points at which a derivative of the solution jumps."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.functions import BASE
from fastdyn.problem.step_options import segments_of_span
from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.reads.reads import flat

MERGED = 16.0 * np.finfo(float).eps  # points closer than their roundings are one point
SHORTEST = 1e-4  # share of the span below which a constant delay does not bound the steps
MOST_POINTS = 2**17  # followed points; k delays to order p have up to C(k + p, p)
# Jumps are not followed to an order with more points than FEW, and this share of their starts: five
# delays are followed to order 9.  Of 30 delays all points to order 5 were 25 000 steps.
FEW = 4096
OF_STARTS = 16
PASTS = {"past", "of_past", "of_slope"}  # operations
STATES = {"y", *PASTS}


class Delays(NamedTuple):
    """The constant delays in rising order, whether other delays vary, and the neutral ones.

    A neutral delay is a constant one at which the derivative is read; `derivatives` tells whether
    the derivative is read at any delay, `decides` whether the function may jump or have a kink,
    `of_state` whether a delay depends on the state.
    """

    constant: tuple
    varying: bool
    neutral: tuple = ()
    derivatives: bool = False
    decides: bool = False
    of_state: bool = False


def delays_of(bound, t0, y0):
    """The Delays of a Bound by its trace; None if the function has no trace."""
    traced, known = _known(bound)
    if known is None:
        return None
    times, fixed, orders, decides = known
    graph = traced.trace.graph
    t = np.array([t0])
    values, _ = evaluate(graph, times, t, y0[:, None], flat(bound.given))
    found = [
        (float(t0 - v), order)
        for (v,), is_fixed, order in zip(values, fixed, orders, strict=True) if is_fixed
    ]  # fmt: skip
    constant = {tau for tau, _ in found}
    neutral = {tau for tau, order in found if order}
    of_state = bool(STATES & {node.op for node in live(times)})
    neutral = tuple(sorted(neutral))
    return Delays(tuple(sorted(constant)), not all(fixed), neutral, any(orders), decides, of_state)


def read_at(bound, t, y):
    """The times for which a function asks at times (m,) and states (n, m); None if not known."""
    traced, known = _known(bound)
    if known is None or PASTS & {node.op for node in live(known[0])}:
        return None
    found, _ = evaluate(traced.trace.graph, known[0], t, y, flat(bound.given))
    return np.array([np.broadcast_to(each, t.shape) for each in found])


def _known(bound) -> tuple[Any, Any]:
    """The trace of a Bound, and what `_times` tells of it; None without a trace."""
    function = traced_base(bound)
    if function is None:
        return None, None
    return function.traced, function.derived("delays", lambda: _times(function.traced))


def traced_base(bound):
    """The Function of a Bound, without sensitivities; None without a trace."""
    function = bound.function and bound.function.notes.get(BASE, bound.function)
    return None if function is None or function.traced is None else function


def _times(traced):
    """The times at which a trace reads the past, whether each is at a fixed distance, and orders.

    The order of a time is 1 if the derivative is read, else 0.  Last, whether jumps may occur.
    """
    graph = traced.trace.graph
    if traced.in_batches:  # whose times may be numbers of rows: those of the trace itself
        operations = {*[row.op for row in traced.program.order]}
        operations |= {node.op for node in traced.program.nodes}
        nodes = [node for node in list(graph.nodes.values()) if node.op == "past"]
    else:
        all_nodes = live([*traced.stored, traced.trace.raising])
        operations = {node.op for node in all_nodes}
        nodes = [node for node in all_nodes if node.op == "past"]
    decides = may_jump(operations)
    by_time: dict = {}
    for node in nodes:
        by_time.setdefault(node.args[0], []).append(node.data[2])
    orders = [max(each) for each in by_time.values()]
    times = [_single(graph, time) for time in by_time]
    inputs = [graph.make("t"), *[graph.make("y", (), i) for i in range(traced.n)]]
    fixed = []
    for time in times:
        try:
            (found,) = partials(graph, [time], inputs)
        except Untraceable:
            found = {}
        alone = set(found) == {0} and found[0].op == "const"
        fixed.append(alone and found[0].data == 1.0)
    return times, fixed, orders, decides


def may_jump(operations):
    """Whether a function of these operations may jump or have a kink."""
    records = [OPERATIONS[op] for op in operations]
    return any(r.name == "select" or r.kinked or r.decision is not None for r in records)


def _single(graph, node):
    """A node without numbers of rows below, as far as the rows are operations on numbers."""
    if node.op != "item":
        args = [_single(graph, each) for each in node.args]
        if args == list(node.args):
            return node
        return graph.call(node.op, *args, data=node.data)
    row = graph.row_of(node.data)
    if OPERATIONS[row.op].value is None or any(np.size(a) not in (1, row.size) for a in row.args):
        return node
    k = node.data - row.first
    ids = [a if type(a) is int else int(a.reshape(-1)[k]) for a in row.args]
    return graph.call(row.op, *[_single(graph, graph.node(i)) for i in ids], data=row.data)


def followed(starts, delays, t0, tf, order, neutral=()):
    """The times in (t0, tf) at which a derivative up to `order` jumps; whether these are all.

    They are not if many delays make more than FEW of them, of higher derivatives.  Each of `starts`
    is a jump of a low derivative; a delay carries a jump on, one derivative higher each time; a
    `neutral` one carries the derivative itself on, to the end of the span.

    Raises
    ------
    ValueError
        If there are more than MOST_POINTS.
    """
    new = np.unique(np.asarray(starts, float))
    points = new = _repeated(new, neutral, tf)
    most = FEW + OF_STARTS * len(new)
    whole = True
    for _ in range(order):
        if len(new) * len(delays) > most:
            whole = False
            break
        new = _repeated(_carried(new, delays, tf), neutral, tf)
        points = _few(_merged(np.concatenate([points, new])), delays)
        if not len(new):
            break
    return points[(points > t0) & (points < tf)], whole


def shorter_than_steps(delays, problem):
    """Whether steps may be longer than the shortest of constant delays in rising order.

    A delay bounds the steps unless it is far shorter than the span.  It does where events act,
    whose jumps no step may pass before they are carried on.
    """
    p = problem
    return bool(delays) and not p.acts and delays[0] < SHORTEST * (p.tf - p.t0)


class Carried:
    """The jumps of a solution, which constant delays carry on; those of actions as they occur.

    Attributes
    ----------
    starts : list of float
        The times of all jumps so far.
    whole : bool
        Whether the jumps are followed to the order of the method.
    """

    def __init__(self, problem, known, starts):
        p = problem
        switching = p.segments[:, 2].tolist() if len(p.segments) else []
        scheduled = [t for each in p.schedules if each.jump is not None for t in times_of(each, p)]
        self.starts = [*starts, *scheduled]
        self._delays = known.constant
        self._neutral = known.neutral
        self._order = p.method.order
        self._tf = p.tf
        self._points, self.whole = self._from([*self.starts, *switching], p.t0)
        self._acting = [i for i, each in enumerate(p.events or ()) if each.act is not None]
        self._last = np.full(len(self._acting), np.nan)

    def _from(self, starts, t):
        return followed(starts, self._delays, t, self._tf, self._order, self._neutral)

    def taken(self, problem):
        """The problem with steps that end at the jumps, and are no longer than a delay."""
        p = problem
        bounds = self._delays and not shorter_than_steps(self._delays, p)
        h_max = min(p.h_max, *self._delays) if bounds else p.h_max
        segments = segments_of_span(self._points, p.t0, p.tf)
        return p._replace(segments=segments, ends_at_switches=False, h_max=h_max)

    def begin(self, y0):
        """Begin a solve: no event has acted."""
        self._last[:] = np.nan

    def follow(self, run):
        """Let the steps end where the delays carry the jumps of the last step's actions.

        No step passes such a time before: a step is no longer than the shortest delay.
        """
        last = run.view("events.table")["t_last"][self._acting]
        new = last[~np.isnan(last) & (last != self._last)]
        if not new.size:
            return
        self._last = last
        self.starts += new.tolist()
        state = run.view("solve.state")[0]
        t = float(state["t"])
        more, _ = self._from(new, t)
        self._points = _merged(np.concatenate([self._points[self._points > t], more]))
        segments = segments_of_span(self._points, t, self._tf)
        run.lay_segments(segments)
        state["t_end"] = state["t_stop"] = segments[0, 1]
        run.view("output.record")["i_segment"] = 0


def times_of(schedule, problem):
    """The times of a Scheduled within the span of a problem."""
    if schedule.times is not None:
        return schedule.times[schedule.first : schedule.end].tolist()
    last = int((problem.tf - schedule.start) / schedule.period)
    if last - schedule.first > MOST_POINTS:
        raise ValueError(
            f"`every={schedule.period:g}` acts more than {MOST_POINTS} times within the span, and "
            "delays carry each action on: end the span before."
        )
    k = np.arange(schedule.first, last + 1)
    return (schedule.start + k * schedule.period).tolist()


def _carried(points, delays, tf):
    """The points one delay later, before tf."""
    later = _merged(np.add.outer(points, np.asarray(delays, float)).ravel())
    return later[later < tf]


def _repeated(points, neutral, tf):
    """The points, and all that neutral delays make of them before tf."""
    new = points
    while neutral and len(new):
        known = points
        points = _few(_merged(np.concatenate([points, _carried(new, neutral, tf)])), neutral)
        at = np.searchsorted(known, points)
        near = np.minimum(at, len(known) - 1)
        new = points[(at == len(known)) | (known[near] != points)]
    return points


def _few(points, delays):
    if len(points) > MOST_POINTS:
        raise ValueError(
            f"the delays {delays} carry jumps to more than {MOST_POINTS} times within the span: "
            "end the span earlier, or give jumps that are followed by `delays=`."
        )
    return points


def _merged(points):
    points = np.sort(points)
    later = points[1:]
    earlier = points[:-1]
    apart = later - earlier > MERGED * np.maximum(np.abs(later), np.abs(earlier))
    if apart.all():
        return points
    return points[np.concatenate([[True], apart])]
