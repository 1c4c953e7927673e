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


def solved(asked, name):
    """The result of Arguments by the method of this name, which may be a class of SciPy's.

    `discrete` and `error_estimate` are not for this function.
    """
    known = asked.looked_up and name is asked.method
    if not (known or asked.events or asked.dense_output or asked.vectorized):
        found = again.solved(
            asked.fun, (asked.t0, asked.tf), asked.y0, name, asked.t_eval, asked.args,
            asked.options,
        )  # fmt: skip
        if found is not None and asked.sensitivity is None:
            return found
    method = validate.method_named(name)
    if asked.sensitivity is not None:
        check_method(asked, method)
    refuse(asked.options, method, asked.y0)
    problem = _problem(asked, method)
    if problem is None:
        return by_scipy(asked, name)
    if asked.sensitivity is not None:
        return solve_with_sensitivities(problem, asked.sensitivity)
    try:
        result = solve_problem(problem)
        again.note(problem, name, asked.options, result)
        return result
    except (LeftToSciPy, WritesToState) as reason:
        begun_again(problem, reason)
        return by_scipy(asked, name)


def _problem(asked, method):
    """The Problem of Arguments; None if SciPy solves, or nothing is to be solved."""
    if method is None or not asked.y0.size or asked.t0 == asked.tf:
        return None
    if asked.y0.dtype.kind != "c":
        return validate.problem(with_observed(asked), method, mode_for(asked, method))
    return None if asked.vectorized else on_pairs(asked, method)
