"""A solve by one method: Arguments become a Problem, which runs; SciPy solves what is left."""

from fastdyn.compile.callables.diagnostics import LeftToSciPy, WritesToState
from fastdyn.problem import validate
from fastdyn.problem.complex_states import on_pairs
from fastdyn.problem.mass import refuse
from fastdyn.problem.second_order_and_pairs import mode_for
from fastdyn.problem.sensitivities import check_method
from fastdyn.run.solve_problem import solve_problem

from .callbacks import with_observed
from .entry import again
from .scipy_methods import begun_again, by_scipy
from .sensitivities import solve_with_sensitivities


def solved(asked):
    """The result of Arguments by their method; without `discrete` and `error_estimate`."""
    method = validate.method_named(asked.method)
    if asked.sensitivity is not None:
        check_method(asked, method)
    refuse(asked.options, method, asked.y0)
    problem = _problem(asked, method)
    if problem is None:
        return by_scipy(asked)
    if asked.sensitivity is not None:
        return solve_with_sensitivities(problem, asked.sensitivity)
    try:
        result = solve_problem(problem)
        again.note(problem, asked.method, asked.options, result)
        return result
    except (LeftToSciPy, WritesToState) as reason:
        begun_again(problem, reason)
        return by_scipy(asked)


def _problem(asked, method):
    """The Problem of Arguments; None if SciPy solves, or nothing is to be solved."""
    if method is None or not asked.y0.size or asked.t0 == asked.tf:
        return None
    if asked.y0.dtype.kind != "c":
        return validate.problem(with_observed(asked), method, mode_for(asked, method))
    return None if asked.vectorized else on_pairs(asked, method)
