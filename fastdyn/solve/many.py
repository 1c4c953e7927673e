"""Many solves by a prepared solver, `Prepared.many`: few one by one, more as an ensemble."""

import math

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble
from fastdyn.kernels.state.record import RAISED
from fastdyn.run.result import FOLLOWING, OdeResult

# Up to so many solves a loop is as fast as an ensemble, whose fixed part is 1 ms: a solve of the
# loop takes 8 us more than a solve of the ensemble.
FEW = 128
INTERRUPTED = -2  # SciPy's status
UNCOUNTED = {"njev", "nlu"}


def one_by_one(solver, problem, members):
    """The result of many solves, by a loop over calls; an interrupted solve is the last."""
    m = members.count
    n = members.n
    times = problem.t_eval
    done = []
    for i in range(m):
        done.append(solver(members.state(i), members.args(i)))
        if done[-1].status == INTERRUPTED:
            break
    k = len(done)
    numbers = {}
    for name in [name for name in FOLLOWING if name not in UNCOUNTED]:
        values = [one[name] for one in done]
        numbers[name] = np.array([*values, *[0] * (m - k)])
    status = np.full(m, INTERRUPTED)
    status[:k] = [one.status for one in done]
    if times is None:
        t = np.full(m, math.nan)
        y = np.full((m, n), math.nan)
        t[:k] = [one.t[-1] for one in done]
        y[:k] = np.reshape([one.y[:, -1] for one in done], (k, n))
    else:
        t = times.copy()
        y = np.full((m, n, len(times)), math.nan)
        for row, one in zip(y, done, strict=False):
            row[:, : len(one.t)] = np.reshape(one.y, (n, len(one.t)))
    return OdeResult(t=t, y=y, status=status, success=status >= 0, **numbers)


def as_ensemble(solver, asked, members):
    """The result of many solves of Arguments, by an ensemble on one thread.

    The exception of the first solve that raises one is raised.
    """
    a = asked
    count = members.count
    options = {name: value for name, value in a.options.items() if name != "compile"}
    states = np.broadcast_to(members.y0, (count, members.n))
    done = solve_ensemble(
        a.fun, (a.t0, a.tf), states, a.args, a.method, a.t_eval, a.events,
        threads=1, simd=False, **options,
    )  # fmt: skip
    raised = np.flatnonzero(done.ends_with(RAISED))
    if len(raised):
        solver(members.state(raised[0]), members.args(raised[0]))
    return OdeResult(
        t=done.t, y=done.y, status=done.status, success=done.success, **done.following()
    )
