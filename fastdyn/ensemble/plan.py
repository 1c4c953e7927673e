"""What is asked of an ensemble, checked, and its functions compiled."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.diagnostics import Uncompilable
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.taylor.accuracy import order_of_many
from fastdyn.problem import validate
from fastdyn.problem.members import Members
from fastdyn.problem.second_order_and_pairs import check_second_order

from . import reductions

SIMD = ("auto", True, False)


class Ensemble(NamedTuple):
    """A checked ensemble; `vector` is None where each trajectory runs alone, for the `reason`."""

    members: Members
    problem: validate.Problem
    vector: Any
    reason: str
    wanted: tuple


def sizes(ensemble):
    """Arguments of `Results`."""
    members, p, wanted = ensemble.members, ensemble.problem, ensemble.wanted
    n_times = 0 if p.t_eval is None else len(p.t_eval)
    return (
        members.count, members.n, n_times, len(p.events or ()),
        reductions.extrema(wanted), "first_event" not in wanted, len(reductions.folds(wanted)),
    )  # fmt: skip


def checked(fun, t_span, y0, args, method, t_eval, events, reduce, simd, options):
    """The arguments of `solve_ensemble` as an Ensemble, its functions compiled."""
    wanted = reductions.wanted(reduce, events)
    ours = validate.method_named(method)
    if ours is None:
        raise ValueError(f"`method={method!r}` is SciPy's; ensembles take fastdyn's own methods.")
    if simd not in SIMD:
        raise ValueError(f"`simd={simd!r}` is unknown; choose from auto, True, False.")
    for name in ("callback", "checkpoint", "compile", "dense_output", *validate.OF_ONE_SOLVE):
        if name in options:
            raise TypeError(f"an ensemble takes no `{name}`.")
    t0, tf = validate.time_span(t_span)
    if t0 == tf:
        raise ValueError("`t_span` must not be empty.")
    members = Members(y0, validate.extra_arguments(args))
    if members.n == 0:
        raise ValueError("`y0` has no components.")
    smallest = abs(members.y0).min(axis=0) if len(members.y0) else np.ones(members.n)
    mode, n = "derivative", members.n
    if ours.second_order:
        mode, n = "acceleration", members.n // 2
        if members.count:
            check_second_order(fun, t0, members.state(0), members.first, ours.name)
    problem = validate.problem(
        fun, t0, tf, smallest, ours, t_eval, False, events, members.first, mode, options
    )
    if problem.on_event:
        reductions.check_jumps(wanted)
    if moments := reductions.moments(wanted):
        problem = reductions.extended(problem, moments, members)
        mode, n = moments, members.n

    def probe():
        if members.count:
            start = members.state(0)[:n].copy()
            evaluate(lambda t, y: fun(t, y, *members.first), mode, t0, start)

    members.bind(fun, mode, n, members.near(problem, n), probe)
    vector, reason = None, "`simd` is False"
    if simd is not False:
        try:
            if problem.on_event and not ours.error_order:
                raise Uncompilable("constant steps begin anew after each jump of `on_event`")
            vector, reason = _vector_kernel(problem, members, wanted)
        except Uncompilable as error:
            reason = str(error)
            if simd is True:
                raise ValueError(f"`fun` has no form for vectors: {reason}.") from error
    return Ensemble(members, problem, vector, reason, wanted)


def _vector_kernel(problem, members, wanted):
    """The kernel for vectors, and why it leaves the events or folds to one trajectory at a time."""
    from fastdyn.specialise.vector import kernel, series_kernel

    p = problem
    if p.method.n_matrices and (p.jac is not None or p.differences):
        raise Uncompilable("a Jacobian that is given, or by differences, is for one at a time")
    varying = tuple(j in members.varying for j in range(len(members.first)))
    given = (
        p.fun, members.first, varying, p.mode, members.n, members.near(p, members.n),
        reductions.extrema(wanted),
    )  # fmt: skip
    if p.method.series:
        order = order_of_many(p.rtol, p.atol)
        of_method: Any = functools.partial(series_kernel, order, *given)
    else:
        of_method = functools.partial(kernel, p.method.name, *given)
    events, folds = [event for event, _, _ in p.events or ()], reductions.folds(wanted)
    others = [fold.of_state(members.n, reductions.n_copies(wanted)) for fold in folds]
    reason = ""
    if (events or others) and p.project is None:
        try:
            return of_method(events, others), ""
        except Uncompilable as error:
            reason = f"events and folds one by one: {error}"
    return of_method(), reason
