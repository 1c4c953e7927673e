"""Compiles the variational equations of a traced function: y' = f, S' = df/dy S + df/dp.

S has a row for each component of y and a column for each direction.  In the state, S follows y row
by row.
"""

import functools
from typing import Any

import numpy as np

from fastdyn import code_store
from fastdyn.kernels.calls.block import FAULT, FIRST
from fastdyn.trace.graph.derivatives import jacobian, parameter_derivatives
from fastdyn.trace.graph.jumps import decisions, first_jump
from fastdyn.trace.graph.refusal import Untraceable, refused_as
from fastdyn.trace.reads.reads import flat

from ..bind import Bound
from ..callables.compiled import Function
from ..callables.diagnostics import Uncompilable
from ..derivatives.jacobian import GROWING
from ..mode import SENSITIVITIES
from ..parameters import n_words, pack_all
from ..traced.code import Traced
from ..traced.make import traced_function
from ..traced.met import why

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
    fun, mode, n = equations.fun, equations.mode, len(near.y0)
    positions = tuple(sorted({j for j in equations.directions if j}))
    found = traced_function(fun, args, mode, n, near, positions)
    if found is None:
        raise Uncompilable(why(fun, args, mode, n, positions) or "it cannot be traced")
    base, values, at = found
    groups = [None if not j else at[j - 1] for j in equations.directions]
    try:
        function = _function(base, groups)
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    keepalive = [fun, args, function]
    end = FIRST + function.n_words
    size = n * (1 + equations.n_directions)
    block = np.zeros(end + size, np.int64)
    block[0], block[FAULT] = function.address, end
    pack_all(values, block, keepalive)

    def as_written(t, z):
        return equations(t, z, *args)

    return Bound(
        function, block, as_written, keepalive, None, values, SENSITIVITIES, (), {}, at
    )  # fmt: skip


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
    rates = _rates(graph, stored, columns)
    size = n * (1 + len(columns))
    found: Any = Traced(traced.trace._replace(outputs=[*stored, *rates]), SENSITIVITIES, size)
    key = found.key()
    own = traced.trace._replace(outputs=stored)
    decided = own, decisions(graph, stored, {c for c in columns if c is not None})
    code = code_store.assembled(key, found.text)
    return Function(
        key, code.address, sum(map(n_words, found.kinds)), functools.cache(found.dispatcher),
        code, SENSITIVITIES, found.vector_text, base.seconds * (1 + 2 * len(columns)),
        code_store.first_kept(found.series), found, {DECISIONS: decided},
    )  # fmt: skip


def columns_of(traced, groups, n):
    """Yield each column's direction: a parameter's slot, None for the n numbers of the start."""
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
