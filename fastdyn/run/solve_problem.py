"""From a checked problem to a run: the functions are compiled and evaluated once."""

import types as python

from fastdyn.compile import budget
from fastdyn.compile.bind import or_in_python, rebind
from fastdyn.compile.derivatives.sparse_jacobian import (
    WiderPattern,
)
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.sentences import WritesToState
from fastdyn.kernels.methods.method import ON_PAIRS, SHARED_METHODS
from fastdyn.kernels.state.record import NON_FINITE
from fastdyn.problem.domains.options import check_start
from fastdyn.problem.events import called_between
from fastdyn.problem.second_order_and_pairs import (
    Pair,
    probe_equations,
)
from fastdyn.problem.validate import IMPLICIT
from fastdyn.specialise.scalar import shared_kernel

from . import again
from .begin import shape_of, watch_of
from .functions.bound import bind_functions, leave_writers_to_scipy
from .functions.compared import Compared
from .functions.python_between import of_python_between
from .loop import MANY_AHEAD, Looks, Run, announce
from .matrices.check_jacobian import check_jacobian
from .memory import plan
from .outcome import outcome, result_of
from .stiffness import notice, watch


def verify(bound, probe, n):
    """Evaluate a function in Python at its first state of length n, to report its mistakes.

    A function that runs in Python reports its mistakes itself.
    """
    if bound.function is None:
        return
    verified = bound.function.notes.setdefault("verified", set())
    if n not in verified:
        probe()
        verified.add(n)


def run_of(problem, kind: type[Run] = Run):
    """A Run with the functions of a problem compiled, and evaluated once; `kind` is its class."""
    p = problem
    n = len(p.y0)
    if p.domain is not None or p.nonnegative is not None:
        check_start(p)
    bound, others = bind_functions(p)
    p = of_python_between(p, bound, others)
    verify(bound, lambda: probe_equations(p), n)
    for each in others:
        if each.mode.probed:
            verify(each, lambda b=each: evaluate(b.python, b.mode, p.t0, p.y0.copy()), n)
    if p.jac is not None:
        check_jacobian(p, bound, others[-1])
    if _between_steps(p):
        leave_writers_to_scipy(p, bound, others)
    asked = p.mode.second_order and bound.function is None  # in `check_second_order`, twice
    return kind(p, bound, others, 2 if asked else 0)


def run_of_steps(problem):
    """A Run of a Stepper, whose code is compared after steps 1, 2, 4, 8, ..."""
    run = run_of(problem)
    run.compared = Compared(run, of="steps")
    watch(problem, run)
    run.looks = Looks(run, 0, MANY_AHEAD, MANY_AHEAD)
    return run


def begun(problem):
    """A Run before its first step."""
    try:
        run = run_of_steps(problem)
    except WritesToState:
        raise ValueError(
            "`fun` writes to the state, between the steps too: take a solver of SciPy's."
        ) from None
    if run.switching is not None:
        run.switching.begin(problem.y0)
    status = run.begin(problem.y0)
    run.check(status)
    announce(run.bounds)
    if status == NON_FINITE:
        state, work = run.view("solve.state"), run.view("solve.work")
        raise ValueError(outcome(status, state, work, problem)[1])
    return run


def in_time(problem):
    """A Run within the time budget: functions whose compilation takes too long stay in Python.

    A solve that asks for compiled code, or whose method depends on compiled code, waits.
    """
    p = problem
    if p.compile != "auto" or p.method.series or p.checkpoint is not None or p.reaction.gives_up:
        return run_of(p)
    load_kernels(p)  # first: no other thread compiles kernels meanwhile
    with budget.limited(least_in_python(p)):
        return run_of(p)


def least_in_python(problem):
    """A lower bound, in seconds, of a solve with functions in Python: the time of full matrices."""
    p = problem
    if not p.method.n_matrices or p.jac is not None or p.sparsity is not None:
        return 0.0
    return (len(p.y0) / 1000) ** 3


def load_kernels(problem):
    """Load or compile the kernels of a solve."""
    p = problem
    pair = isinstance(problem.fun, Pair)
    plan(*shape_of(p, pair), len(p.y0))
    shared_kernel(p.method.name, pair)
    watch_of(p)


def _between_steps(problem):
    """True if the solve with a method of SciPy needs states between two steps.

    A function that writes to the state changes the state at the end of a step, not within the step.
    Implicit methods evaluate the function at many trial states of a step.
    """
    p = problem
    name = problem.method.name.removesuffix(ON_PAIRS)
    asked = p.dense_output or p.events or p.schedules or p.t_eval is not None or name in IMPLICIT
    return bool(asked) and name in SHARED_METHODS


def solve_problem(problem):
    """Solve a problem; an idle run of the same code is used again."""
    while True:
        try:
            return _solved(problem)
        except WiderPattern as wider:
            problem = problem._replace(sparsity=wider.entries)


def _solved(problem):
    functions = _functions(problem)
    key = _key(problem, functions)

    def solve():
        run = _taken(key, problem, functions) or in_time(problem)
        result = followed(problem, run)
        if key is not None:
            _give_back(key, run, functions)
        return result

    return or_in_python(solve)


def followed(problem, run):
    """The result of a Run; the Run is given up, or warned of, if the problem is stiff."""
    watch(problem, run)
    result = result_of(problem, run.solve(problem.y0), run)
    notice(problem, run)
    return result


def _key(problem, functions):
    """The key of the runs that may solve a problem; None if the problem has rare options."""
    p = problem
    if (
        p.mode is not DERIVATIVE
        or p.project is not None
        or p.inside is not None
        or p.checkpoint is not None
        or p.callback is not None
        or p.told is not None
        or p.jac is not None
        or p.sparsity is not None
        or p.mass is not None
        or len(p.segments)
    ):
        return None
    key: list = ["run", shape_of(p, False), p.differences, p.ends_at_switches]
    if p.acts:
        key += [event.act is None for event in p.events]
    for function in functions:
        if function.__class__ is not python.FunctionType:
            return None
        key.append(id(function.__code__))
    return tuple(key)


def _functions(problem):
    """The functions of a problem, in the order of the bounds of its Run."""
    if not problem.events:
        return (problem.fun,)
    return problem.fun, *called_between(problem)


def _taken(key, problem, functions):
    """An idle run whose code is valid for the present functions and arguments, or None."""
    run = None if key is None else again.taken(again.calls.get(key))
    if run is None:
        return None
    for bound, fun in zip(run.bounds, functions, strict=True):
        if not rebind(bound, fun, problem.args):
            return None
    run.take(problem)
    return run


def _give_back(key, run, functions):
    """Keep a run for the next solve, one for each piece of code, without data of the last solve."""
    for bound in run.bounds:
        if bound.function is None:
            return
    run.let_go()
    run.hold_nothing()
    kind = again.kept(key, lambda: again.Kind([f.__code__ for f in functions]), run.plan.n)
    kind.give_back(run)
