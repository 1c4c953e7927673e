"""Compiles the variational equations of a traced function: y' = f, S' = df/dy S + df/dp.

S has a row for each component of y and a column for each direction.  In the state, S follows y row
by row.
"""

from typing import Any

import numpy as np

from fastdyn.trace.graph.derivatives import jacobian, parameter_derivatives
from fastdyn.trace.graph.jumps import decisions, first_jump
from fastdyn.trace.graph.refusal import Untraceable, refused_as
from fastdyn.trace.reads.reads import flat

from ..bound import with_code
from ..callables.diagnostics import Uncompilable
from ..derivatives.jacobian import GROWING
from ..mode import SENSITIVITIES
from ..traced.code import Traced
from ..traced.known_traces import why
from ..traced.make import traced_function

DECISIONS = "decisions"  # a key of a Function's notes


def bind_variational(equations, args, near, refused=None):
    """The Bound of the equations of a state and its sensitivities.

    Parameters
    ----------
    equations : problem.sensitivities.Variational
    args : tuple
    near : traced.make.Near
        The region of the state, without sensitivities.
    refused : str, optional
        The reason why the function must run in Python.

    Raises
    ------
    Uncompilable
        If `fun` has no trace, or a derivative is missing.
    """
    if refused:
        raise Uncompilable(refused)
    return bind_extended(equations.fun, args, equations.mode, near, equations, _function)


def bind_extended(fun, args, mode, near, extended, compiled, untraced="it cannot be traced"):
    """The Bound of a function extended by sensitivities.

    Parameters
    ----------
    fun, args, mode, near
        The function that is traced.
    extended : callable
        ``extended(t, z, *args)`` in Python, with `n`, `directions` and `n_directions`.
    compiled : callable
        ``compiled(function, groups)`` makes the extended Function of the traced Function; `groups`
        has the group of parameters of each direction, None for the initial state.
    untraced : str
        The reason of the refusal if no other reason is known.
    """
    n = len(near.y0)
    positions = tuple(sorted({j for j in extended.directions if j}))
    found = traced_function(fun, args, mode, n, near, positions)
    if found is None:
        raise Uncompilable(why(fun, args, mode, n, positions) or untraced)
    base, values, at = found
    try:
        function = compiled(base, [at[j - 1] if j else None for j in extended.directions])
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    size = extended.n * (1 + extended.n_directions)

    keepalive = [fun, args]

    def as_written(t, z):  # later solves replace the content of keepalive
        own, given = keepalive[:2]
        return (extended if own is fun else extended._replace(fun=own))(t, z, *given)

    return with_code(function, as_written, keepalive, values, function.mode, size, at)


def decides(bound):
    """Whether decisions of a function depend on the state or on a differentiated parameter."""
    return bool(bound.function.notes[DECISIONS][1])


def jump_of(bound, times, solution):
    """The first time at which a decision makes the function jump: see `jumps.first_jump`."""
    trace, nodes = bound.function.notes[DECISIONS]
    values = flat([value for _, value in bound.values])
    return first_jump(trace.graph, trace.outputs, nodes, times, solution, values)


def _function(base, groups):
    with GROWING:
        place = "variational", tuple(groups)
        found = base.notes.get(place)
        if found is None:
            found = base.notes[place] = _compiled(base, groups)
        return found


def _too_many(reason):
    return Untraceable(f"the equations of its sensitivities: {reason}", final=True)


@refused_as(_too_many)
def _compiled(base, groups):
    traced = base.traced
    graph, stored = traced.trace.graph, traced.stored
    n, columns = len(stored), list(columns_of(traced, groups, len(stored)))
    trace = traced.trace._replace(outputs=[*stored, *_rates(graph, stored, columns)])
    function = extended_function(trace, SENSITIVITIES, base, n, columns)
    own = traced.trace._replace(outputs=stored)
    slots = {column for column in columns if column is not None}
    function.notes[DECISIONS] = own, decisions(graph, stored, slots)
    return function


def extended_function(trace, mode, base, n, columns):
    """The Function of a trace that extends the Function `base` of n numbers by sensitivities."""
    found: Any = Traced(trace, mode, n * (1 + len(columns)))
    return found.compiled(base.seconds * (1 + 2 * len(columns)))


def columns_of(traced, groups, n):
    """Yield the direction of each column: a parameter's slot; None, n times, for the start."""
    for group in groups:
        if group is None:
            yield from [None] * n
        else:
            first, shape = traced.trace.reads.groups[group][1:3]
            yield from range(first, first + (1 if shape is None else int(np.prod(shape))))


def _rates(graph, stored, columns):
    n, m = len(stored), len(columns)
    terms: list = [[] for _ in range(n * m)]
    rows, others, nodes = jacobian(graph, stored, n)
    state = [graph.make("y", (), n + i) for i in range(n * m)]
    for i, k, node in zip(rows, others, nodes, strict=True):
        for j in range(m):
            terms[i * m + j].append(graph.mul(node, state[k * m + j]))
    slots = [column for column in columns if column is not None]
    rows, others, nodes = parameter_derivatives(graph, stored, slots)
    places = [j for j, column in enumerate(columns) if column is not None]
    for i, k, node in zip(rows, others, nodes, strict=True):
        terms[i * m + places[k]].append(node)
    return [graph.sum(each) for each in terms]
