"""MATLAB's calls, solved by the methods of the same names or by the nearest ones."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods import METHODS
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.table import OPTIONS
from fastdyn.run.solve_problem import solve_problem
from fastdyn.solve.by_method import observed
from fastdyn.words import kinds
from fastdyn.words.calls import takes

from .events import event_functions, let_pass, occurrences
from .mass import with_mass
from .min_step import not_shorter
from .options import check_options, odeset
from .output_function import OutputFunction
from .solution import AtTimes, Refined, Request, Solution

NORM = "NormControl"  # is refused, because the error is controlled in each component
# Options that change the solution, or what is seen of it, and that only some solvers have.
OF_SOME = {"Events", "InitialY", "Jumps", "Mass", "MinStep", "NonNegative", NORM, "OutputFcn"}
OF_ODE = ("Events", "Mass", "MinStep", "NonNegative", "OutputFcn")
APART = {"Mass", "MinStep"}  # are no options of the method: `with_mass` and `not_shorter`
OF_IMPLICIT = {"Jacobian", "JPattern"}
COLUMN = "`fun` returned a column"  # the beginning of a solve's message

PARAMETERS = "Parameters go in by a closure: lambda t, y: odefun(t, y, p1)."
EXCLUSIVE_OR = ("bitwise_xor", "for ^")  # parts of a TypeError's message about y^3


class Solver(NamedTuple):
    """One of MATLAB's solvers: the method of fastdyn, Refine, and the options."""

    name: str
    method: str
    refine: int = 1
    implicit: bool = False
    algebraic: bool = False


def solve(solver, fun, tspan, y0, options):
    """The `Solution` of a solver, for the public function of the solver's name."""
    if not callable(fun):
        raise TypeError(f"`odefun` must be a function of (t, y); got {fun!r}.")
    takes("odefun", fun, "t, y", PARAMETERS)
    options = options_of(solver.name, options, OF_ODE)
    if "Events" in options:
        takes("Events", options["Events"], "t, y")
    times = times_of(tspan)
    y0 = _state(y0)
    if np.size(options.get("AbsTol", 0.0)) not in (1, len(y0)):
        raise ValueError(
            f"AbsTol must be one number, or one for each of the {len(y0)} components of y0; got "
            f"{np.size(options['AbsTol'])}."
        )
    try:
        return _solved(solver, fun, times, y0, options)
    except ValueError as error:
        if COLUMN not in str(error):
            raise
    except TypeError as error:
        if not any(sign in str(error) for sign in EXCLUSIVE_OR):
            raise
        raise TypeError(
            f"{error}: in Python `^` is the exclusive or of whole numbers; a power is y**3."
        ) from error
    return _solved(solver, _as_a_row(fun), times, y0, options)


def options_of(name, given, some=()):
    """The options of a solver; raises for others of OF_SOME than those in `some`."""
    check_options(given)
    options = odeset({} if given is None or not np.size(given) else given)
    for refused in sorted(OF_SOME.intersection(options).difference(some)):
        if options[refused] is not False:
            reason = f"of its kind there are {', '.join(some) or 'none'}"
            reason = "the error is controlled in each component" if refused == NORM else reason
            raise ValueError(f"{refused} is no option of fastdyn's {name}: {reason}.")
    return options


def _as_a_row(fun):
    """A function that returns the result of `fun` with one dimension."""

    def row(t, y):
        return np.ravel(np.array(fun(t, y)))

    return row


def _solved(solver, fun, times, y0, options):
    t0 = float(times[0])
    tf = float(times[-1])
    own = fun
    algebraic = None
    if "Mass" in options:
        fun, algebraic = with_mass(solver, fun, options, t0, y0)
    events = options.get("Events")
    functions = None if events is None else event_functions(events, t0, y0)
    refine = options.get("Refine", solver.refine)
    observer = None
    if "OutputFcn" in options:
        chosen = options.get("OutputSel")
        observer = OutputFunction(options["OutputFcn"], chosen, times, refine)
    while True:
        if observer is not None:
            observer.begin(y0)
        result = _run(solver, fun, (t0, tf), y0, functions, observer, options, algebraic)
        if functions is None or not let_pass(functions, result):
            break
    if observer is not None:
        observer.end()
    if result.status == -1:
        warn(f"Failure in {solver.name}: {result.message}")
    print_statistics(options, result)
    found = None if functions is None else occurrences(result, events)
    output = Refined(refine) if len(times) == 2 else AtTimes(times, result.status == 1)
    call = Request(solver, own, options)
    return Solution(call, result, output, found)


def _run(solver, fun, t_span, y0, functions, observer, options, mass) -> Any:
    """The OdeResult of the method that solves."""
    t0, tf = t_span
    chosen: dict[str, Any] = {
        option.name: options[option.matlab]
        for option in OPTIONS.values()
        if option.matlab in options.keys() - (APART if solver.implicit else APART | OF_IMPLICIT)
    }
    span = abs(tf - t0)
    method = METHODS[solver.method if mass is None else "Rodas5P"]
    if not method.like_matlab:
        chosen.setdefault("max_step", span / 10.0)
    if "first_step" in chosen:
        chosen["first_step"] = min(chosen["first_step"], span)
    if observer is not None:
        chosen["callback"] = observed(observer.step, observer.function)
    if mass is not None:
        chosen["mass"] = mass
    if "NonNegative" in options and "Mass" in options:
        raise ValueError("NonNegative and Mass do not go together, as in MATLAB.")
    asked = Arguments(
        fun=fun, t0=t0, tf=tf, y0=y0, dense_output=True, events=functions, options=chosen
    )
    problem = validate.problem(asked, method, DERIVATIVE)
    return not_shorter(solve_problem(problem), options.get("MinStep", 0.0))


def times_of(tspan):
    """`tspan` as an array of two or more finite times in order."""
    kinds.times("tspan", tspan)
    times = np.asarray(tspan, float)
    if times.ndim != 1 or len(times) < 2 or not np.isfinite(times).all():
        raise ValueError(f"`tspan` must be two or more finite times; got {tspan!r}.")
    if times[0] == times[-1]:
        raise ValueError("the last entry of `tspan` must be different from the first.")
    steps = np.diff(times)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError("the entries of `tspan` must strictly increase, or decrease.")
    return times


def _state(y0):
    """The initial state, given as a number, a row or a column, as a new array of shape (n,)."""
    given = np.asarray(y0)
    if (given.ndim == 2 and 1 in given.shape) or given.ndim == 0:
        given = given.reshape(-1)
    state = validate.initial_state(given)
    if state.dtype.kind == "c" or not state.size:
        raise ValueError("`y0` must be real, and hold a number; split complex states in two.")
    return state


def print_statistics(options, result):
    """Print the lines that the option Stats asks for."""
    if options.get("Stats"):
        print(f"{result.n_accepted} successful steps")
        print(f"{result.n_rejected} failed attempts")
        print(f"{result.nfev} function evaluations")
