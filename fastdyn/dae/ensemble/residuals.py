"""Ensembles of equations of index 0 and 1, which BDF solves as they are."""

import functools

from fastdyn.compile.mode import RESIDUAL
from fastdyn.ensemble.plan import Ensemble
from fastdyn.problem.events import between_steps
from fastdyn.run.begin import jacobian_of
from fastdyn.run.functions.python_between import of_python_between
from fastdyn.run.solve_problem import load_kernels

from ..consistent import consistent
from ..equations import StartEquations
from ..index import HighIndexError, index_of
from ..problem import problem_of_residual
from ..switching import with_short_steps
from .starts import starts_of
from .trajectories import KnownOfEnsemble, OfResiduals

REASON = "equations F(t, y, y') = 0 have no form for vectors"


def planned(asked, guesses, wanted):
    """(The ensemble.plan.Ensemble of [y, y'], the kind of its result) for the Guesses.

    `asked` is the problem.DaeArguments of one of them.

    Raises
    ------
    HighIndexError
        If the index of the first trajectory that tells is above 1.
    ValueError
        If no trajectory has a consistent start.
    """
    problem = problem_of_residual(asked)
    n = asked.n
    load_kernels(problem)
    near = guesses.near(problem, 2 * n)

    def bound_of(fun, mode, i):
        return guesses.bound(fun, guesses.args(i), mode, 2 * n, near)

    others = [bound_of(fun, mode, guesses.usual) for fun, mode in between_steps(problem)]
    bound = bound_of(problem.fun, RESIDUAL, guesses.usual)
    watched = others[: len(problem.events or ())]
    problem = of_python_between(problem, bound, others)
    problem = with_short_steps(problem, guesses, (bound, *watched))
    indices: list[int] = []

    def start(i):
        p = problem._replace(y0=guesses.state(i), args=guesses.args(i))
        bound = bound_of(p.fun, RESIDUAL, i)
        equations = StartEquations(p, bound, jacobian_of(p, bound, others))
        both = consistent(equations, p, asked.held)
        if not indices:
            jacobian = equations.jacobian(both)
            rates = equations.rates(both)
            indices.append(index_of(jacobian, n, equations.noise, rates))
        return both

    starts, failed = starts_of(guesses, 2 * n, start, HighIndexError)
    guesses.begin_at(starts)
    problem = problem._replace(y0=guesses.state(guesses.usual), args=guesses.args(guesses.usual))
    ensemble = Ensemble(guesses, problem, None, REASON, wanted, ())
    return ensemble, functools.partial(OfResiduals, KnownOfEnsemble(asked.F, indices[0], failed))
