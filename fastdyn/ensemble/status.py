"""The end of a trajectory: SciPy's status, and a sentence."""

import numpy as np

from fastdyn.compile.sentences import GaveUp
from fastdyn.kernels.state.record import (
    BAD_STATE,
    BORDER,
    EVENT,
    FINISHED,
    INTERRUPTED,
    RAISED,
    STEP_LIMIT,
    STEP_TOO_SMALL,
)
from fastdyn.run.functions.crawling import MOST, counts_beyond
from fastdyn.run.matrices.inconsistent import Inconsistent
from fastdyn.run.outcome import LEFT, OF_ACTIONS, OF_EACH, SUCCESS, TERMINATED, TOO_SMALL
from fastdyn.run.outcome import SENTENCES as IN_WORDS
from fastdyn.run.solve_problem import run_of
from fastdyn.run.stiffness import watch

from .times import of_member

TWICE = 2  # times the steps after which a run is examined, that a trajectory takes again
# SciPy's status; -1 for every other failure
CODES = {FINISHED: 0, EVENT: 1, INTERRUPTED: -2, BORDER: LEFT}


OF_RUNS = {**IN_WORDS, **OF_ACTIONS}
SENTENCES = {code: text.format(t="t = {t:.10g}", **OF_EACH) for code, text in OF_RUNS.items()} | {
    FINISHED: SUCCESS,
    EVENT: TERMINATED,
    INTERRUPTED: "Interrupted before it was done.",
    STEP_TOO_SMALL: TOO_SMALL + " At t = {t:.10g} no step is short enough for the tolerance.",
    RAISED: "Trajectory {i}: {raised} after t = {t:.10g}.",
    BAD_STATE: "Trajectory {i}: component {bad} of the initial state `y0` is not finite.",
    STEP_LIMIT: "`max_steps` was reached at t = {t:.10g}.",
}


def what_raised(members, problem, i):
    """The exception of a function in trajectory i, in words, from a solve of trajectory i alone.

    Raises GaveUp if only the compiled function raised.
    """
    p = of_member(problem, members, i)
    p = p._replace(y0=members.state(i), args=members.args(i), compile="shared")
    try:
        run_of(p).solve(p.y0)
    except GaveUp:
        raise
    except Inconsistent as error:
        return str(error).rstrip(".") + "; it ends"
    except Exception as error:
        return f"a function raised {type(error).__name__}: {error}".rstrip(": ")
    return "a function raised an exception"  # of a Fold, which a single solve does not call


def tell_crawl(members, problem, results):
    """Warn of a trajectory with wrong steps, or of that with the most steps if they crawl.

    The first steps of the trajectory are taken once more, alone.
    """
    counts = results.counts
    n_steps = counts["n_accepted"]
    wrong = counts["n_standing"] * counts_beyond(problem)
    if problem.mode.residual or not (wrong.any() or n_steps.max(initial=0) >= MOST):
        return
    i = int(np.argmax(wrong if wrong.any() else n_steps))
    if results.status[i] == RAISED:
        return
    p = of_member(problem, members, i)
    p = p._replace(y0=members.state(i), args=members.args(i), compile="shared")
    p = p._replace(t_eval=np.array([p.tf]), max_steps=int(min(p.max_steps, TWICE * MOST)))
    run = run_of(p)
    if not any(each.callback for each in run.bounds):
        watch(p, run)
        run.solve(p.y0)


def message(members, problem, results, i):
    """The reason why trajectory i ended, in a sentence."""
    status = int(results.status[i])
    if status == RAISED and i not in results.raised:
        try:
            results.raised[i] = what_raised(members, problem, i)
        except GaveUp:
            results.raised[i] = "compiled code of a function gave up"
    raised = results.raised.get(i)
    bad = np.argmin(np.isfinite(members.state(i))) // (2 if members.complex else 1)
    return SENTENCES[status].format(t=results.t_end[i], i=i, raised=raised, bad=bad)
