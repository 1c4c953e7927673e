"""Compares the code of an ensemble with its functions, and its vectors with single solves."""

import numpy as np

from fastdyn.compile.callables import codes
from fastdyn.compile.compare import Different, compare_along
from fastdyn.compile.derivatives.compare import compare_jacobian, compare_sensitivities
from fastdyn.kernels.state.record import FINISHED, Y
from fastdyn.run.functions import compared
from fastdyn.run.solve_problem import run_of

from .times import of_member
from .workers import functions_of

FEW = 4  # trajectories that are compared
SOLVES = "ensembles that were solved"  # a key of a Function's notes
SHARE, FEWEST = 50, 1000  # steps of a single solve: 1 / SHARE of all steps, at least FEWEST
ROUNDINGS = 1e3
EPS = np.finfo(float).eps
APART = 100.0  # allowed difference of a single solve, in tolerances, as rounding moves steps


def compare_trajectories(ensemble, results):
    """Raise Different if functions, or a single solve, differ from the trajectories of an ensemble.

    Ensembles 1, 2, 4, 8, ... of a function are compared, at states of the results and at the ends
    of steps of single solves.  The results of the first ensemble are compared with a single solve.
    """
    p = ensemble.problem
    members = ensemble.members
    if compared.WHEN == "never" or not members.count:
        return
    chosen = np.unique(np.linspace(0, members.count - 1, FEW).astype(int)).tolist()
    chosen = [i for i in chosen if np.isfinite(results.y_end[i]).all()]
    count = _due(_bound(members, p, *functions_of(p)[0], members.usual)) if chosen else 0
    for i in chosen if count else ():
        times, states = _states(p, results, i, -(-count // FEW))
        for j, (fun, mode, n) in enumerate(functions_of(p)):
            bound = _bound(members, p, fun, mode, n, i) if callable(fun) else None
            if mode.sensitivities:
                compare_sensitivities(bound, fun, members.args(i), times, states)
            if bound is None or bound.function is None or not mode.compared:
                continue
            compare_along(bound, times, compared.parts(bound, states))
            if j == 0 and (run := _alone(ensemble, results, i)) is not None:
                run.begin(run.problem.y0, run.problem.max_steps, run.compared.most_places)
                compared.compare(run, -(-count // FEW), {})
                run.tell_jumps()
            if j == 0 and count == compared.AT_FIRST:
                if p.method.n_matrices:
                    compare_jacobian(bound, times, states)
                if ensemble.vector and i == chosen[0]:
                    _compare_alone(ensemble, results, i, bound)


def _bound(members, problem, fun, mode, n, i):
    """The Bound of a function for a trajectory; all trajectories share its code."""
    return members.bound(fun, members.args(i), mode, n, members.near(problem, n))


def _due(bound):
    """The number of states to compare after one more ensemble of a function."""
    function = bound.function
    if function is None:
        return 0
    own = codes(bound.held.fun, bound.held.args)  # functions may share machine code
    place = SOLVES, compared.WHEN, own
    return function.notes.setdefault(place, compared.Schedule(compared.WHEN)).after_one()


def _states(problem, results, i, count):
    """Times and states of a trajectory, at most `count`, the last among them."""
    times = [float(results.t_end[i])]
    states = [np.array(results.y_end[i])]
    y = results.y_eval[i]  # empty if a store has the states
    known = min(len(y), int(results.counts["n_times"][i]))
    for k in np.unique(np.linspace(0, known - 1, count - 1).astype(int)) if known else ():
        if np.isfinite(y[k]).all():
            times.append(float(problem.t_eval[k]))
            states.append(np.array(y[k]))
    return times, states


def _alone(ensemble, results, i):
    """A Run of few steps of a trajectory, which stores the end only.

    None if the trajectory took no step, or if a function runs in Python.
    """
    p = ensemble.problem
    members = ensemble.members
    counts = results.counts
    if not counts["n_accepted"][i]:
        return None
    n_steps = int(counts["n_accepted"].sum() + counts["n_rejected"].sum())
    most = max(FEWEST, n_steps // SHARE)
    start = members.state(i)
    p = of_member(p, members, i)._replace(y0=start, args=members.args(i), compile="shared")
    p = p._replace(t_eval=np.array([p.tf]), max_steps=int(min(p.max_steps, most)))
    run = run_of(p)
    return None if any(each.callback for each in run.bounds) else run


def _compare_alone(ensemble, results, i, bound):
    """Raise Different if a trajectory alone ends elsewhere than in the lanes of a vector.

    The allowed difference includes the difference to which a rounding of the start grows.
    """
    run = _alone(ensemble, results, i)
    ends = []
    if run is None or results.status[i] != FINISHED:
        return
    p = run.problem
    start = run.problem.y0
    constant = not p.method.error_order  # the last step may pass the end, which is interpolated
    mine = np.array(results.y_end[i])
    rounding = EPS * np.maximum(np.abs(start), np.abs(mine))  # also of a start at zero
    for sign in (0.0, 1.0, -1.0):
        if run.solve(start + sign * rounding) != FINISHED:
            return
        ends.append((run.view("output.y")[0] if constant else run.view("solve.work")[Y]).copy())
    alone, *others = ends
    spread = max(float(np.max(np.abs(other - alone))) for other in others)
    size = np.max(np.abs(alone), initial=0.0)
    atol = np.broadcast_to(p.atol, alone.shape)
    counts = np.isfinite(atol)  # components in the error of a step
    largest = np.max(atol, where=counts, initial=0.0)
    allowed = APART * (np.max(p.rtol) * size + largest) + ROUNDINGS * spread + 1e-9 * size
    if not (np.abs(mine - alone) <= allowed)[counts].all():
        raise Different(bound, float(results.t_end[i]), start, alone, mine)
