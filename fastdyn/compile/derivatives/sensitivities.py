"""Compiles functions of a state and its sensitivities: equations of motion, and events.

The state is y, followed by S row by row: S has a row for each component of y and a column for each
direction.  The variational equations are y' = f, S' = df/dy S + df/dp; those of a residual
F(t, y, y') = 0 are dF/dy S + dF/dy' S' + dF/dp = 0.

At a zero of g, R(t, y) is the new state, and y' changes from f to f+.  S becomes
dR/dy (S + f s) + dR/dt s + dR/dp - f+ s, where s = -(dg/dy S + dg/dp) / (dg/dt + dg/dy f) is the
derivative of the event's time: the saltation matrix.  At a time of a schedule, s = 0.  P. C.
Mueller, "Calculation of Lyapunov exponents for dynamic systems with discontinuities", Chaos,
Solitons & Fractals 5(9), 1995.
"""

import math

import numpy as np

from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.jumps import decisions, first_jump
from fastdyn.trace.graph.refusal import Untraceable, refused_as
from fastdyn.trace.graph.substitute import substituted
from fastdyn.trace.reads.reads import flat

from ..callables import Uncompilable
from ..compare import seconds_of
from ..functions import BASE, with_code
from ..mode import DERIVATIVE, RESIDUAL_SENSITIVITIES, SALTATION, SENSITIVITIES
from ..python_callback import Held
from ..traced.known import Attempt
from ..traced.make import Near, traced_function
from .columns import Columns
from .crossings import crossing_number
from .past import outputs_of_past

MOST_STRAIGHT = 16  # numbers, up to which kernels inline the function
DECISIONS = "decisions"  # a key of a Function's notes


def bind_variational(equations, args, near, varying=()):
    """The Bound of the equations of a state and its sensitivities.

    Parameters
    ----------
    equations : problem.sensitivities.Variational
    args : tuple
    near : traced.make.Near
        The region of the state, without sensitivities.
    varying : tuple of int
        As in `bind`.

    Raises
    ------
    Uncompilable
        If `fun` has no trace, or a derivative is missing.
    """
    said = "it cannot be traced", "the equations of its sensitivities"
    own = equations.fun, args, equations.mode, near
    as_mode = RESIDUAL_SENSITIVITIES if equations.mode.residual else SENSITIVITIES
    return _bound(*own, equations, as_mode, False, said, varying)


def bind_saltation(saltation, args, near, varying=()):
    """The Bound of a change of a state and its sensitivities.

    Parameters
    ----------
    saltation : problem.sensitivities.Saltation
    args : tuple
    near : traced.make.Near
        The region of the state with its sensitivities.
    varying : tuple of int
        As in `bind`.

    Raises
    ------
    Uncompilable
        If a function has no trace, or a derivative is missing.
    """
    n = saltation.n
    more = saltation.n_together() - saltation.n
    near = Near(near.t0, near.tf, np.r_[near.y0[:n], np.zeros(more)])
    said = "`on_event` cannot be traced", "the change of its sensitivities at an event"
    located = saltation.event is not None
    own = saltation.together(), args, DERIVATIVE, near
    return _bound(*own, saltation, SALTATION, located, said, varying)


def _bound(fun, args, mode, near, extended, as_mode, located, said, varying):
    """The Bound of a function that is traced in `mode` and extended by sensitivities.

    `extended` is called ``extended(t, z, *args)`` in Python.  `said` has the reason of a refusal if
    no other reason is known, and what needs too many operations.
    """
    n = len(near.y0)
    directions = extended.directions
    attempt = Attempt(fun, args, mode, n, sorted({j for j in (*directions, *varying) if j}))
    found = traced_function(attempt, near)
    if found is None:
        raise Uncompilable(attempt.why() or said[0])
    base, values, at = found
    groups = tuple([at[j - 1] if j else None for j in directions])

    @refused_as(lambda reason: Untraceable(f"{said[1]}: {reason}", final=True))
    def made():
        reads = base.traced.trace.reads
        columns = [slot for group in groups for slot in slots_of(reads, group, extended.n_start)]
        return _extended(base, columns, extended.n, as_mode, located)

    try:
        function = base.derived((as_mode, groups, extended.n_start, located), made)
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    held = Held(fun, args)

    def as_written(t, z):  # of what later solves let it hold
        own = extended if held.fun is fun else extended._replace(fun=held.fun)
        return own(t, z, *held.args)

    size = (1 + as_mode.residual) * extended.n * (1 + extended.n_directions)
    bound = with_code(function, as_written, held, values, as_mode, size, at)
    if function.seconds == math.inf:
        function.seconds = seconds_of(bound, near.t0, near.y0)
    return bound


def decides(bound):
    """Whether decisions of a function depend on the state or on a differentiated parameter."""
    return bool(bound.function.notes[DECISIONS][1])


def jump_of(bound, times, solution):
    """The first time at which a decision makes the function jump: see `jumps.first_jump`."""
    trace, nodes = bound.function.notes[DECISIONS]
    values = flat([value for _, value in bound.values])
    return first_jump(trace.graph, trace.outputs, nodes, times, solution, values)


def _extended(base, columns, n, mode, located):
    """The Function that extends the Function `base` by columns, each a parameter's slot or None."""
    traced = base.traced
    size = n * (1 + len(columns))
    slots = {slot for slot in columns if slot is not None}
    graph = traced.trace.graph
    if any(node.op == "past" for node in live(traced.stored)):
        function = traced.with_outputs(outputs_of_past(graph, traced, columns, n), mode, size)
        function = function.compiled()
    elif mode.residual:
        outputs, raising = _of_residual(traced, columns, n)
        function = traced.with_outputs(outputs, mode, 2 * size, raising).compiled()
    elif mode is SALTATION or size <= MOST_STRAIGHT:
        outputs = _outputs(graph, traced.stored, columns, n, located)
        function = traced.with_outputs(outputs, mode, size).compiled()
    else:
        function = _in_columns(traced, mode, columns, n).compiled()
    function.notes[BASE] = base
    if mode.sensitivities:
        own = traced.trace._replace(outputs=traced.stored)
        function.notes[DECISIONS] = own, decisions(own.graph, own.outputs, slots)
    return function


def _of_residual(traced, columns, n):
    """The nodes of F and dF/dy S + dF/dy' S' + dF/dp, and as many zeros; the condition of raising.

    The derivative y' is at n of the traced vector, and behind [y, S] of the longer one.
    """
    g = traced.trace.graph
    m = len(columns)
    half = n * (1 + m)
    own = traced.stored[:n]
    found, places, _ = _partials(g, own, columns, 2 * n, False)
    at = [(i, k) for i, row in enumerate(found) for k in sorted(row)]
    moved = {g.make("y", (), n + i).key: g.make("y", (), half + i) for i in range(n)}
    nodes = [*own, traced.trace.raising, *[found[i][k] for i, k in at]]
    nodes = substituted(g, nodes, moved)
    outputs = nodes[:n]
    rows = [{} for _ in range(n)]
    for (i, k), node in zip(at, nodes[n + 1 :], strict=True):
        rows[i][k] = node
    for row in rows:
        for j, slot in enumerate(columns):
            terms = []
            for k in sorted(row):
                if k < 2 * n:
                    place = (k // n) * half + n + (k % n) * m + j
                    terms.append(g.mul(row[k], g.make("y", (), place)))
                elif k == places.get(slot):
                    terms.append(row[k])
            outputs.append(g.sum(terms))
    return [*outputs, *[g.const(0.0)] * half], nodes[n]


def _in_columns(traced, mode, columns, n):
    """The Columns of the variational equations of a Traced."""
    graph, own, m = traced.trace.graph, traced.stored[:n], len(columns)
    found, places, _ = _partials(graph, own, columns, n, False)
    by_state = [(i, k) for i, row in enumerate(found) for k in sorted(row) if k < n]
    by_parameter = [
        (i, j, places[slot]) for i, row in enumerate(found) for j, slot in enumerate(columns)
        if places.get(slot) in row
    ]  # fmt: skip
    elements = [found[i][k] for i, k in by_state] + [found[i][k] for i, _, k in by_parameter]
    factors = traced.with_outputs([*own, *elements], mode, n * (1 + m))
    pairs = [(i, j) for i, j, _ in by_parameter]
    return Columns(
        factors, mode, n, m, by_state, pairs, lambda: _outputs(graph, own, columns, n, False)
    )


def slots_of(reads, group, n):
    """The direction of each column of a group: a parameter's slot; None, n times, for the start."""
    if group is None:
        return [None] * n
    first, shape = reads.groups[group][1:3]
    return range(first, first + (1 if shape is None else int(np.prod(shape))))


def _partials(graph, outputs, columns, n, with_time):
    """The partial derivatives of nodes; the places in them by slots, and the place of the time."""
    slots = sorted({column for column in columns if column is not None})
    inputs = [graph.make("y", (), i) for i in range(n)]
    inputs += [graph.make("par", (), slot) for slot in slots]
    by_time = len(inputs)
    places = {slot: n + k for k, slot in enumerate(slots)}
    found = partials(graph, outputs, [*inputs, graph.make("t")] if with_time else inputs)
    return found, places, by_time


def _outputs(graph, stored, columns, n, located):
    """The nodes of the function's n numbers, and of their derivatives by directions, row by row.

    For an event, `stored` has the new state and the nodes of f, f+ and g.
    """
    m = len(columns)
    g = graph
    if located:
        stored = [*stored[:-1], crossing_number(g, stored[-1], stored[n : 2 * n])]
    found, places, by_time = _partials(g, stored, columns, n, located)
    state = [[g.make("y", (), n + i * m + j) for j in range(m)] for i in range(n)]

    def along(row, j):
        """The terms of the derivative by direction j at a fixed time."""
        terms = [g.mul(row[i], state[i][j]) for i in sorted(row) if i < n]
        place = places.get(columns[j])
        return [*terms, row[place]] if place in row else terms

    if not located:
        return [*stored[:n], *(g.sum(along(found[i], j)) for i in range(n) for j in range(m))]
    rate = stored[n : 2 * n]
    behind = stored[2 * n : 3 * n]
    row_of_event = found[3 * n]

    def along_motion(row):
        """The derivative by time along the motion."""
        terms = [g.mul(row[i], rate[i]) for i in sorted(row) if i < n]
        return g.sum([*terms, row[by_time]] if by_time in row else terms)

    crossing = along_motion(row_of_event)
    later = [g.neg(g.div(g.sum(along(row_of_event, j)), crossing)) for j in range(m)]
    outputs = stored[:n]
    for i in range(n):
        drift = g.sub(along_motion(found[i]), behind[i])
        outputs += [g.sum([*along(found[i], j), g.mul(drift, later[j])]) for j in range(m)]
    return outputs
