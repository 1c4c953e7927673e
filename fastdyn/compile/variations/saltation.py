"""Compiles what an event does to a state and its sensitivities: the saltation matrix.

Behind a change R of the state at the zero of g, with f before and f+ behind the change, S becomes
dR/dy (S + f s) + dR/dt s + dR/dp - f+ s, where s = -(dg/dy S + dg/dp) / (dg/dt + dg/dy f) is the
derivative of the event's time; s is 0 at a time of a schedule.  P. C. Mueller, "Calculation of
Lyapunov exponents for dynamic systems with discontinuities", Chaos, Solitons & Fractals 5(9), 1995.
"""

import functools
from typing import Any

import numpy as np

from fastdyn import code_store
from fastdyn.kernels.calls.block import FAULT, FIRST
from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.refusal import Untraceable, refused_as

from ..bind import Bound
from ..callables.compiled import Function
from ..callables.diagnostics import Uncompilable
from ..mode import DERIVATIVE, SALTATION
from ..parameters import n_words, pack_all
from ..traced.code import Traced
from ..traced.make import Near, traced_function
from ..traced.met import why
from .variational import columns_of


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
    n, together = saltation.n, saltation.together()
    positions = tuple(sorted({j for j in saltation.directions if j}))
    size = saltation.n_together()
    near = Near(near.t0, near.tf, np.r_[near.y0[:n], np.zeros(size - n)])
    found = traced_function(together, args, DERIVATIVE, size, near, positions)
    if found is None:
        raise Uncompilable(
            why(together, args, DERIVATIVE, size, positions) or "`on_event` cannot be traced"
        )
    base, values, at = found
    try:
        groups = [None if not j else at[j - 1] for j in saltation.directions]
        function = _compiled(base, groups, n, saltation.event is not None)
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    keepalive = [together, args, function]
    end, whole = FIRST + function.n_words, n * (1 + saltation.n_directions)
    block = np.zeros(end + whole, np.int64)
    block[0], block[FAULT] = function.address, end
    pack_all(values, block, keepalive)

    def as_written(t, z):
        return saltation(t, z, *args)

    return Bound(function, block, as_written, keepalive, None, values, SALTATION, (), {}, at)


def _too_many(reason):
    return Untraceable(f"the change of its sensitivities at an event: {reason}", final=True)


@refused_as(_too_many)
def _compiled(base, groups, n, located):
    traced = base.traced
    graph, columns = traced.trace.graph, list(columns_of(traced, groups, n))
    outputs = _outputs(graph, traced.stored, columns, n, located)
    size = n * (1 + len(columns))
    found: Any = Traced(traced.trace._replace(outputs=outputs), SALTATION, size)
    key = found.key()
    code = code_store.assembled(key, found.text)
    return Function(
        key, code.address, sum(map(n_words, found.kinds)), functools.cache(found.dispatcher),
        code, SALTATION, found.vector_text, base.seconds * (1 + 2 * len(columns)),
        None, found,
    )  # fmt: skip


def _outputs(graph, stored, columns, n, located):
    """The nodes of the state and of the sensitivities behind the change, row by row.

    `stored` are the new state, and for an event also f, f+ and g.
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
