"""The history of a run: choices of states, singularities, kinks of constraints."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from fastdyn.compile.functions import GROWING
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.jumps import first_jump
from fastdyn.trace.operations import OPERATIONS

from ..structure.choice import growth, signs
from ..structure.start import Unsolved
from .trajectory import MANY, orders

PARTS = 32  # of a step within which states are chosen anew
ROOM = 100.0  # growth, in that at the choice, at which states are chosen anew

LEAST = 1e-3  # in the unit of a constraint: jumps below a millionth of this are rounding


def along(reduction, found, kinks, t, cuts=()):
    """(Choices along a result, the last step end before a singularity or None, jump or None).

    `kinks` are the `decisions`, `t` the times of the states.  Between two actions of `on_event`,
    which store their time twice, and other `cuts`, the solution is smooth; `jump` is the first time
    at which a constraint jumps by itself.
    """
    cuts = np.union1d(np.flatnonzero(np.diff(t) == 0) + 1, cuts).astype(int)
    log: list = []
    for first, end in zip([0, *cuts], [*cuts, len(t)], strict=True):
        part = slice(first, end)
        more, last = history(reduction, t[part], found.y[:, part])
        log += more if not log or more[0][1] != log[-1][1] else more[1:]
        last = None if last is None or last + 1 == end - first else int(first + last)
        jump = _jump_of(reduction.system, kinks, found.sol, t[part]) if kinks else None
        if last is not None or jump is not None:
            return log, last, jump
    return log, None, None


def history(reduction, t, x, whole=True):
    """(Choices along the ends of steps, the number of the last step before a singularity or None).

    The choices are a list of (time, states).  Within a step, the states of a choice have to
    determine what follows from them: a determinant that changes its sign for every choice tells
    that the equations are singular within the step.  A `whole` step is looked at in parts before.
    """
    log = []
    start = 0
    end = len(t) - 1
    while True:
        try:
            chosen = reduction.choice(t[start], orders(reduction.system, x[:, start]))
        except Unsolved:
            return log, max(start - 1, 0)
        if not log or chosen.states != log[-1][1]:
            log.append((float(t[start]), chosen.states))
        for k in range(start, end, MANY - 1):
            part = slice(k, k + MANY)
            bad, broken = _first(reduction.system, chosen, t[part], x[:, part])
            if bad is not None:
                break
        else:
            return log, None
        if broken and k + bad == start + 1:
            step = slice(start, start + 2)
            within, last = _within(reduction, t[step], x[:, step]) if whole else ([], 0)
            if last is not None:
                return log, start
            log += within[1:]
            start += 1
            continue
        start = k + bad - 1 if broken else k + bad


def _within(reduction, t, x):
    """The history within one step, with the cubic polynomial of its ends and slopes."""
    sign = np.sign(t[1] - t[0])
    slopes = [
        sign * np.array(reduction.motion(at, state, reduction.parameters))
        for at, state in zip(t, x.T, strict=True)
    ]
    states = CubicHermiteSpline(sign * t, x.T, slopes)
    times = np.linspace(t[0], t[1], PARTS + 1)
    return history(reduction, times, states(sign * times).T, whole=False)


def _first(system, chosen, t, x):
    """(The first point at which a choice is bad, or None; whether a sign has changed there)."""
    matrices = system.matrices(t, orders(system, x))
    found = signs(matrices, chosen.depths)
    broken = (found != found[:, :1]).any(axis=0)
    sizes = growth(matrices, chosen.depths)
    bad = np.flatnonzero(broken | ~(sizes <= ROOM * max(1.0, sizes[0])))
    bad = bad[bad > 0]
    return (int(bad[0]), bool(broken[bad[0]])) if len(bad) else (None, False)


def decisions(reduced):
    """The nodes that change discontinuously and on which constraints of the states depend."""
    found = {}
    for node in live(_constraints(reduced)):
        if node.op == "select" or OPERATIONS[node.op].whole:
            decides = node.args[0] if node.op == "select" else node
            found[decides.key] = decides
    return list(found.values())


def _jump_of(reduced, nodes, states, times):
    """The first time of a smooth part of a result at which a constraint jumps, or None."""
    graph = reduced.given.graph
    values = reduced.given.values
    with GROWING:
        outputs = [*_constraints(reduced), graph.const(LEAST)]
        outputs += [reduced.node(*place) for place in reduced.states]  # the measure of a jump
    begin = np.nextafter(times[0], times[-1])  # of two polynomials, the later

    def solution(t):
        late = np.maximum if times[-1] >= times[0] else np.minimum
        return orders(reduced, np.asarray(states(late(t, begin))))

    return first_jump(graph, outputs, nodes, times, solution, values)


def _constraints(reduced):
    """The equations and derivatives that hold for the reduced state: all but the last ones."""
    return [node for each in reduced.orders for node in each[:-1]]
