"""A solve by one method: Arguments become a Problem, which runs; SciPy solves what is left."""

from fastdyn.compile.sentences import WritesToState
from fastdyn.problem import validate
from fastdyn.problem.complex_states import on_pairs
from fastdyn.problem.mass import refuse
from fastdyn.problem.second_order_and_pairs import mode_for
from fastdyn.problem.sensitivities import check_adjoint, check_method
from fastdyn.run.enough_memory import KeepsBands
from fastdyn.run.solve_problem import solve_problem

from . import repeated
from .scipy_methods import begun_again, by_scipy
from .sensitivities import solve_with_sensitivities


def kind_of(asked, name):
    """The method of this name in the keys of calls."""
    if asked.method == "auto":  # steps end at switching times, and large functions have no series
        return "auto", name, asked.reaction
    return name


def solved(asked, name):
    """The result of Arguments by the method of this name, which may be a class of SciPy's.

    `discrete` and `error_estimate` are not for this function.
    """
    kind = kind_of(asked, name)
    result = repeated.asked_before(asked, kind)
    if result is not None:
        return result
    method = validate.method_named(name)
    if asked.sensitivity is not None:
        check_method(asked, method)
    if asked.adjoint is not None:
        check_adjoint(asked, method)
    refuse(asked.options, method, asked.y0)
    problem = _problem(asked, method)
    if problem is None:
        return by_scipy(asked, name)
    try:
        if asked.adjoint is not None:
            from .adjoint.solve import solve_with_adjoint  # imports Numba

            result = solve_with_adjoint(problem, asked.adjoint)
        elif asked.sensitivity is None:
            result = solve_problem(problem)
        else:
            result = solve_with_sensitivities(problem, asked.sensitivity)
    except (KeepsBands, WritesToState) as reason:
        if asked.sensitivity is not None or asked.adjoint is not None:
            raise
        begun_again(problem, reason)
        return by_scipy(asked, name)
    repeated.note(asked, kind, problem)
    return result


def _problem(asked, method):
    """The Problem of Arguments; None if SciPy solves, or nothing is to be solved."""
    if method is None or not asked.y0.size or asked.t0 == asked.tf:
        return None
    asked = _observed(asked)
    if asked.y0.dtype.kind == "c":
        return on_pairs(asked, method)
    return validate.problem(asked, method, mode_for(asked, method))


def _observed(asked):
    """The Arguments, with the user's `callback` as a function that a Run calls."""
    if asked.options.get("callback") is None:
        return asked
    return asked.with_options(callback=observed(asked.options["callback"]))


def observed(callback, function=None, follow=None):
    """The function that a Run calls after each step, for a `callback` of the user.

    ``follow(run)`` is the solver that `callback` gets, by default a Stepper.
    """
    from .stepper import Stepper  # imports SciPy

    found: list = []

    def after_step(run):
        if not found or found[0]._run is not run:
            found[:] = [(follow or Stepper.of_run)(run)]
        found[0].look()
        return callback(found[0])

    vars(after_step)["function"] = function or callback  # may change values that `fun` uses
    return after_step
