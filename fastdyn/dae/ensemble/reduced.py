"""Ensembles of equations whose index is reduced: the motion of the reduced states."""

import functools

import numpy as np

from fastdyn.ensemble import plan
from fastdyn.problem.events import Event
from fastdyn.problem.members import Shared
from fastdyn.problem.options.table import TOLERANCES
from fastdyn.problem.schedules import listed
from fastdyn.problem.validate import method_named

from ..functions import named
from ..problem import held_components
from ..reduced.events import watched
from ..reduced.history import decisions
from ..reduced.run import options_of
from ..reduced.solve import check_method, checked_held
from ..reduced.trajectory import MANY, places
from ..structure.eliminate import hold
from ..structure.reduction import Reduction
from ..structure.start import Unsolved, consistent_all, guess
from .guard import Guard
from .of_reduced import OfReduced, Solved
from .starts import beginning, sentences
from .trajectories import KnownOfEnsemble

KINKS = (
    "a constraint decides by the state (`if`, `where`, `abs`): an ensemble does not look for its "
    "kinks along the solutions; `solve_dae`, trajectory by trajectory, does."
)
PIVOTS = (
    "its parameters need another order of elimination than those of the first trajectory: "
    "`solve_dae` solves it"
)


def planned(asked, guesses, wanted, method, simd):
    """(The ensemble.plan.Ensemble of reduced states, the kind of its result).

    Raises
    ------
    ValueError
        If no trajectory has a consistent start, and for what `solve_reduced` refuses.
    """
    varying = sorted(guesses.varying)
    reduction = Reduction(asked, tuple([j + 1 for j in varying]))
    check_method(method, reduction)
    if decisions(reduction.system):
        raise ValueError(KINKS)
    held = checked_held(held_components(asked), reduction)
    system = reduction.system
    t0 = asked.t0
    values = np.repeat(system.given.values[:, None], guesses.count, axis=1)
    slots = dict(zip(varying, system.given.varied, strict=True))
    for j, slot in slots.items():
        values[slot] = guesses.varying[j]

    starts, failed = _starts(guesses, reduction, values, t0, held)
    guard = Guard(reduction)
    options = options_of(asked.options, system, asked.n)
    states = starts[:, places(system)]
    motion = reduction.motion
    if guard.size:
        of_all = system.with_values(values[:, : len(starts)])
        times = np.full(len(starts), t0)
        states = np.hstack([states, guard.memory(of_all, times, starts.T)])
        options = guard.tolerances({**TOLERANCES, **options}, method_named(method))
        motion = guard.motion(motion)
    if (project := guard.project()) is not None:
        options["project"] = with_arguments(project, slots)
    events = listed(asked.events, {})
    if events is not None:
        events = [_event(each, reduction, asked, slots) for each in events]
    columns = [guesses.varying.get(j, Shared(value)) for j, value in enumerate(guesses.first)]
    ensemble = plan.planned(
        with_arguments(motion, slots), (asked.t0, asked.tf), states,
        (Shared(reduction.parameters), *columns), method, asked.t_eval, events, wanted or None,
        simd, options,
    )  # fmt: skip
    solved = Solved(asked, method, guesses, reduction, values, starts, guard.size > 0)
    return ensemble, functools.partial(
        OfReduced, solved, KnownOfEnsemble(asked.F, reduction.index, failed)
    )


def _starts(guesses, reduction, values, t0, held):
    """(All orders of all components at the starts, one row each; the sentences of failures)."""
    system = reduction.system
    n = guesses.n // 2
    starts, errors, left = beginning(guesses, (system.levels() + 1) * n)
    for k in range(0, len(left), MANY):
        part = left[k : k + MANY]
        own = system.with_values(values[:, part])
        both = np.array([guesses.state(i) for i in part]).T
        z, wrong = consistent_all(own, t0, guess(own, both[:n], both[n:]), held)
        holds = hold(own.matrices(np.full(len(part), t0), z), reduction.pivots)
        for i in np.flatnonzero(~holds).tolist():
            wrong.setdefault(i, Unsolved(PIVOTS))
        good = [i for i in range(len(part)) if i not in wrong]
        starts[part[good]] = z[:, good].T
        errors |= {int(part[i]): error for i, error in wrong.items()}
    return starts, sentences(errors, left)


def with_arguments(function, slots):
    """A function of (t, x, p) whose parameters in some slots are arguments, by their positions."""

    def of_arguments(t, x, p, *args):
        numbers = [*p]
        for j, slot in slots.items():
            numbers[slot] = args[j]
        return function(t, x, numbers, *args)

    return of_arguments


def _event(event, reduction, asked, slots):
    found = watched(event, reduction, asked, [])
    if not isinstance(found, Event):
        return found
    n = len(reduction.system.states)

    def of_state(t, z, p, *args):
        return found.function(t, z[:n], p, *args)

    return found.like(named(with_arguments(of_state, slots), found.function))
