"""The plan of an ensemble: arguments checked, functions compiled, lanes or one at a time."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import ACCELERATION, COMPLEX_NUMBERS, DERIVATIVE
from fastdyn.compile.python_callback import called_with, evaluate
from fastdyn.compile.sentences import Uncompilable
from fastdyn.kernels.methods.taylor.accuracy import order_of_many
from fastdyn.problem import mass, validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.complex_states import on_pairs
from fastdyn.problem.members import Members
from fastdyn.problem.options.names import refuse_unknown
from fastdyn.problem.options.table import OPTIONS, refused_among, refused_by
from fastdyn.problem.schedules import SHORTHANDS, listed
from fastdyn.problem.second_order_and_pairs import check_second_order
from fastdyn.run.begin import counts_inside
from fastdyn.run.functions.switching import switching_of_members

from . import reductions, times
from .longer import sensitive

SIMD = ("auto", True, False)
OWN = {"t_eval", "events", "reduce", "threads", "progress", "simd", "client", "store", "block"}
BEFORE = ("fun", "t_span", "y0", "args", "method")
FEW = 8  # most starts at which a function is tried
ORDERED = ("final", "first_event")  # reductions of complex states


class Ensemble(NamedTuple):
    """A checked ensemble; `vector` is None if each trajectory runs alone, for the `reason`.

    `directions` are those of `sensitivity`, empty without it.
    """

    members: Members
    problem: validate.Problem
    vector: Any
    reason: str
    wanted: tuple
    directions: Any


def sizes(ensemble):
    """Arguments of `Results`."""
    members = ensemble.members
    p = ensemble.problem
    wanted = ensemble.wanted
    n_times = 0 if p.t_eval is None else len(p.t_eval)
    return (
        members.count, members.n, n_times, len(p.events or ()) + len(p.schedules),
        reductions.extrema(wanted), "first_event" not in wanted, len(reductions.folds(wanted)),
    )  # fmt: skip


def planned(fun, t_span, y0, args, method, t_eval, events, reduce, simd, options):
    """The arguments of `solve_ensemble` as an Ensemble, its functions compiled."""
    wanted = reductions.wanted(reduce, listed(events, options))
    ours = validate.method_named(method)
    if ours is None:
        raise ValueError(f"`method={method!r}` is SciPy's; ensembles take fastdyn's own methods.")
    if simd not in SIMD:
        raise ValueError(f"`simd={simd!r}` is unknown; choose from auto, True, False.")
    for name in (*refused_by("solve_ensemble"), "dense_output"):
        if name in options:
            raise TypeError(f"an ensemble takes no `{name}`.")
    refuse_unknown("an ensemble", options, OPTIONS.keys() | OWN, BEFORE)
    validate.function(fun)
    t0, tf = validate.time_span(t_span)
    if t0 == tf:
        raise ValueError("`t_span` must not be empty.")
    members = Members(y0, validate.extra_arguments(args))
    if members.n == 0:
        raise ValueError("`y0` has no components.")
    usual = members.y0[members.finite]
    smallest = abs(usual).min(axis=0) if len(usual) else np.ones(members.n)
    events, members.times = times.common(events, options, t0, tf, members.count)
    sensitivity = options.get("sensitivity")
    options = {k: value for k, value in options.items() if k not in (*SHORTHANDS, "sensitivity")}
    mass.refuse(options, ours, members.y0)
    asked = Arguments(
        fun=fun, t0=t0, tf=tf, y0=smallest, t_eval=t_eval, events=events, args=members.first,
        options=options,
    )  # fmt: skip
    if callable(options.get("mass")) and members.count:
        asked = _with_mass_in_fun(asked, ours, members)
    fun = asked.fun
    mode = COMPLEX_NUMBERS if members.complex else DERIVATIVE
    n = members.n
    if ours.second_order and not members.complex:
        mode = ACCELERATION
        n = members.n // 2
        if members.count:
            check_second_order(fun, t0, members.state(members.usual), members.first, ours.name)
    complex_states = members.complex
    problem = (
        _on_pairs(asked, ours, wanted) if complex_states else validate.problem(asked, ours, mode)
    )
    acts = problem.acts or any(each.jump is not None for each in problem.schedules)
    begins_anew = not ours.error_order and (acts or problem.schedules)
    if acts or begins_anew:
        reductions.check_jumps(wanted)
    if moments := reductions.moments(wanted):
        problem = reductions.extended(problem, moments, members)
        mode = moments
        n = members.n

    def probe():
        _probe(members, lambda i: called_with(fun, members.args(i)), mode, t0, n)

    if reductions.folds(wanted) and members.finite.any():
        i = int(np.flatnonzero(np.broadcast_to(members.finite, members.count))[0])
        reductions.check_folds(wanted, t0, members.state(i)[: members.n], members.args(i))
    if sensitivity is None:
        directions = ()
        bound, _ = members.bind(problem.fun, mode, n, members.near(problem, n), probe)
    else:
        directions, problem, bound = sensitive.bound(asked, problem, members, sensitivity, wanted)
    problem, members.segments = switching_of_members(problem, members, bound)
    vector, reason = _lanes(simd, problem, members, wanted, begins_anew)
    return Ensemble(members, problem, vector, reason, wanted, directions)


def _lanes(simd, problem, members, wanted, begins_anew):
    """The kernel for vectors, or None, and why trajectories, or events and folds, run alone."""
    if simd is False:
        return None, "`simd` is False"
    try:
        if begins_anew:
            raise Uncompilable("constant steps begin anew after each jump and scheduled time")
        if members.complex:
            raise Uncompilable("complex states have no form for vectors")
        if problem.mode.sensitivities:
            raise Uncompilable("a state with sensitivities has no form for vectors")
        return _vector_kernel(problem, members, wanted)
    except Uncompilable as error:
        if simd is True:
            raise ValueError(f"`fun` has no form for vectors: {error}.") from error
        return None, str(error)


def _with_mass_in_fun(asked, method, members):
    """The Arguments of a problem whose `mass` is a function."""
    usual = asked._replace(y0=members.state(members.usual))
    fun, _ = mass.equations_of(usual, method, DERIVATIVE)
    return asked._replace(fun=fun).with_options(mass=None)


def _on_pairs(asked, method, wanted):
    """The Problem of complex states; refuses options and reductions for real states."""
    refused = [f"`{name}`" for name, _ in refused_among(asked.options, "complex")]
    refused += [f"`reduce={reductions.name_of(item)!r}`" for item in wanted if item not in ORDERED]
    if refused:
        raise ValueError(
            f"ensembles of complex states do not take {', '.join(refused)}: give real and "
            "imaginary parts as a state of twice the length."
        )
    return on_pairs(asked._replace(y0=asked.y0.view(complex)), method)


def _probe(members, function, mode, t0, n):
    """Raise the exception of a function if the function raises at all starts that are tried.

    A function that raises at some starts only lets these trajectories fail.  ``function(i)`` has
    the arguments of member i.
    """
    finite = np.flatnonzero(np.broadcast_to(members.finite, members.count))
    errors = []
    tried = np.unique(np.linspace(0, len(finite) - 1, FEW).astype(int)) if len(finite) else []
    for i in finite[np.array(tried, int)]:
        try:
            evaluate(function(i), mode, t0, members.state(i)[:n].copy())
            return
        except Exception as error:
            errors.append(error)
    if errors:
        if members.count > 1 and _runs_transposed(members, function, mode, t0):
            m, n = members.y0.shape
            errors[0].add_note(
                f"`y0` has a state in each row, {m} states of {n} numbers here. Is it transposed? "
                f"y0.T has {n} states of {m}."
            )
        raise errors[0]


def _runs_transposed(members, function, mode, t0):
    """Whether a function that fails for each row of the states takes their columns."""
    try:
        evaluate(function(0), mode, t0, np.ascontiguousarray(members.y0[:, 0]))
    except Exception:
        return False
    return True


def _vector_kernel(problem, members, wanted):
    """The kernel for vectors, and the reason if events or folds run one trajectory at a time."""
    from fastdyn.specialise.vector import kernel, series_kernel

    p = problem
    of_mass = {}
    if p.mass is not None:
        if reductions.extrema(wanted):
            raise Uncompilable("with `mass` the slopes of components are not in the lanes")
        of_mass["mass"] = tuple([each.tolist() for each in np.nonzero(p.mass.T)[::-1]])
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
        of_method = functools.partial(kernel, p.method.name, *given, **of_mass)
    events = [(event.function, counts_inside(p.method, event)) for event in p.events or ()]
    folds = reductions.folds(wanted)
    others = [fold.of_state(members.n, reductions.n_copies(wanted)) for fold in folds]
    reason = ""
    if (events or others) and p.project is None:
        try:
            return of_method((events, others)), ""
        except Uncompilable as error:
            reason = f"events and folds one by one: {error}"
    return of_method(), reason
