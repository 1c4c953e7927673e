"""Compiles the effect of an event on a state and its sensitivities: the saltation matrix.

At a zero of g, R(t, y) is the new state, and y' changes from f to f+.  The sensitivities S become
dR/dy (S + f s) + dR/dt s + dR/dp - f+ s, where s = -(dg/dy S + dg/dp) / (dg/dt + dg/dy f) is the
derivative of the event's time.  At a time of a schedule, s = 0.  P. C. Mueller, "Calculation of
Lyapunov exponents for dynamic systems with discontinuities", Chaos, Solitons & Fractals 5(9), 1995.
"""

import functools

import numpy as np

from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.refusal import Untraceable, refused_as

from ..mode import DERIVATIVE, SALTATION
from ..traced.make import Near
from .variational import bind_extended, columns_of, extended_function


def bind_saltation(saltation, args, near):
    """The Bound of a change of a state and its sensitivities.

    Parameters
    ----------
    saltation : problem.sensitivities.Saltation
    args : tuple
    near : traced.make.Near
        The region of the state with its sensitivities.

    Raises
    ------
    Uncompilable
        If a function has no trace, or a derivative is missing.
    """
    n, more = saltation.n, saltation.n_together() - saltation.n
    near = Near(near.t0, near.tf, np.r_[near.y0[:n], np.zeros(more)])
    compiled = functools.partial(_compiled, n=n, located=saltation.event is not None)
    return bind_extended(
        saltation.together(), args, DERIVATIVE, near, saltation, compiled,
        "`on_event` cannot be traced",
    )  # fmt: skip


def _too_many(reason):
    return Untraceable(f"the change of its sensitivities at an event: {reason}", final=True)


@refused_as(_too_many)
def _compiled(base, groups, n, located):
    traced = base.traced
    graph, columns = traced.trace.graph, list(columns_of(traced, groups, n))
    outputs = _outputs(graph, traced.stored, columns, n, located)
    return extended_function(traced.trace._replace(outputs=outputs), SALTATION, base, n, columns)


def _outputs(graph, stored, columns, n, located):
    """The nodes of the state and of the sensitivities behind the change, row by row.

    `stored` has the nodes of the new state; for an event, also the nodes of f, f+ and g.
    """
    m, g = len(columns), graph
    slots = sorted({column for column in columns if column is not None})
    inputs = [g.make("y", (), i) for i in range(n)] + [g.make("t")]
    inputs += [g.make("par", (), slot) for slot in slots]
    found = partials(g, stored, inputs)
    places = {slot: n + 1 + k for k, slot in enumerate(slots)}
    state = [[g.make("y", (), n + i * m + j) for j in range(m)] for i in range(n)]

    def along(row, j):
        """The terms of the derivative by direction j at a fixed time."""
        terms = [g.mul(d, state[i][j]) for i, d in row.items() if i < n]
        place = places.get(columns[j])
        return terms if place not in row else [*terms, row[place]]

    changed = stored[:n]
    if not located:
        return [*changed, *(g.sum(along(found[i], j)) for i in range(n) for j in range(m))]
    rate, behind, row_of_event = stored[n : 2 * n], stored[2 * n : 3 * n], found[3 * n]

    def by_time(row):
        """The derivative by time along the motion."""
        terms = [g.mul(d, rate[i]) for i, d in row.items() if i < n]
        return g.sum(terms if n not in row else [*terms, row[n]])

    crossing = by_time(row_of_event)
    later = [g.neg(g.div(g.sum(along(row_of_event, j)), crossing)) for j in range(m)]
    outputs = list(changed)
    for i in range(n):
        drift = g.sub(by_time(found[i]), behind[i])
        outputs += [g.sum([*along(found[i], j), g.mul(drift, later[j])]) for j in range(m)]
    return outputs
