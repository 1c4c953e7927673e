"""The times at which F switches, as breakpoints of a DAE; in ensembles, as limits of the steps."""

from typing import Any

import numpy as np

from fastdyn.compile import budget
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import RESIDUAL
from fastdyn.compile.traced.make import Near
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.run.functions.timed import switches_of, with_trace
from fastdyn.trace.reads.reads import flat

from .functions import of_vector

SHARE = 0.5  # of the least distance of two switching times, of the longest step: one ends between


def with_breakpoints(given):
    """A problem.DaeArguments whose `breakpoints` have the times at which F switches.

    Steps end there by every method: at a jump of F, algebraic components jump, and behind the jump
    the state is made consistent.  Where there are too many times, those of a first part of the span
    are breakpoints, and no step is longer than half the shortest distance between them.
    """
    near = off_the_solution(np.concatenate([given.y0, given.yp0]))
    with budget.limited(0.0):
        bound = bind(
            of_vector(given.F, given.n), given.args, RESIDUAL, 2 * given.n,
            Near(given.t0, given.tf, near, True),
        )  # fmt: skip
    bound = with_trace(bound, 2 * given.n)
    switches = switches_of(bound)
    if switches is None:
        return given
    found = switches.times(flat(bound.given), given.t0, given.tf)
    options = dict(given.options)
    if not len(found.t):
        return given
    asked: Any = options.get("breakpoints")
    if np.ndim(asked) > 1:  # refused with the other mistakes
        return given
    if options.get("checkpoint") is None:  # which keeps no breakpoints
        options["breakpoints"] = np.r_[found.t, () if asked is None else np.asarray(asked, float)]
    if len(found.t) > 1 and (found.end != given.tf or options.get("checkpoint") is not None):
        _limit(options, np.diff(found.t))
    return given._replace(options=options)


def with_short_steps(problem, members, bounds):
    """The Problem of an ensemble, of whose steps one ends between any two switching times.

    `bounds` are those of F and of the event functions.  The trajectories take their steps in
    compiled code, where no state is made consistent behind a jump; a step from one switching time
    to beyond the next one could miss what lies between.
    """
    p = problem
    for bound in bounds:
        bound = with_trace(bound, len(p.y0))
        switches = switches_of(bound)
        if switches is None:
            continue
        groups = bound.function.traced.trace.reads.groups
        varying = {}
        for j, column in members.varying.items():
            if bound.at[j] is not None:
                varying[groups[bound.at[j]].first] = np.asarray(column, float)
        count = members.count if varying else 1
        found = switches.times(flat(bound.given), p.t0, p.tf, count, varying)
        apart = np.diff(found.t)[np.diff(found.member) == 0]
        apart = apart[apart > 0.0]
        if len(apart):
            p = p._replace(h_max=min(p.h_max, SHARE * float(apart.min())))
    return p


def _limit(options, apart):
    """Limit the steps in options to the least of some distances."""
    least = SHARE * float(apart.min())
    asked = options.get("max_step")
    options["max_step"] = least if asked is None else min(asked, least)
