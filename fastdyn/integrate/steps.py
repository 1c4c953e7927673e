"""The run of `odeint`: its rows of output, and what `infodict` tells of each row."""

import math

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.kernels.state.record import ATOL, FINISHED, RTOL, STEP_LIMIT, Y
from fastdyn.run.outcome import outcome
from fastdyn.run.output import points_in
from fastdyn.run.solve_problem import in_time

from .messages import TOO_ACCURATE, istate_of

EPS = float(np.finfo(float).eps)
MOST_ACCURATE = 0.01  # share of rounding errors in the tolerance, as in ODEPACK
COUNTS = "nst", "nfe", "nje", "nqu", "mused"
FAMILIES = "Adams' formulas", "BDF"


def solved(problem, watcher):
    """The Run of a Problem, its rows, the `istate`, and why it failed."""

    def solve():
        run = in_time(problem)
        return run, run.solve(problem.y0)

    run, status = or_in_python(solve)
    state = run.view("solve.state")
    work = run.view("solve.work")
    istate = istate_of(status, float(state["error"][0]))
    rows = points_in(run.plan, run.memory)[1]
    because = ""
    if watcher is not None and watcher.istate:
        istate = watcher.istate
        because = watcher.because
    elif status == STEP_LIMIT:
        p = problem
        t = float(state["t"][0])
        because = (
            f"More than {p.most_between} steps lead from t = {[p.t0, *p.t_eval][len(rows)]:.10g} "
            f"to the next time of output; the last ends at t = {t:.10g}: raise `mxstep`, loosen "
            "`rtol` and `atol`, or look whether the solution blows up."
        )
    elif status != FINISHED:
        because = outcome(status, state, work, problem, run.bounds[0])[1]
    return run, rows, istate, because


def too_accurate(y, rtol, atol):
    """ODEPACK's `tolsf`: the factor by which tolerances must grow; 0 if they need not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = EPS * np.max(np.abs(y) / (rtol * np.abs(y) + atol), initial=0.0)
    return 200.0 * share if share > MOST_ACCURATE else 0.0


class Watcher:
    """Looks at each step, for `tcrit`, `ixpr`, and tolerances near rounding errors.

    Parameters
    ----------
    t : ndarray
        The times of output behind the start.
    tcrit : array_like or None
    prints : bool

    Attributes
    ----------
    istate : int
        Why the watcher ended the run, or 0.
    tolsf : float
        See `too_accurate`.
    """

    def __init__(self, t, tcrit, prints):
        self._times = t
        self._prints = prints
        self._tcrit = () if tcrit is None else np.atleast_1d(np.asarray(tcrit, dtype=float))
        self.istate = 0
        self.because = ""
        self.tolsf = 0.0
        self._run = None
        self._done = self._critical = 0

    def limit(self):
        """The time that steps do not pass on the way to the next time of output.

        As in SciPy, a critical time counts only up to a time of output before it; infinite if there
        is none.
        """
        critical = self._tcrit
        k = self._critical
        if self._done < len(self._times) and k < len(critical):
            self._critical += self._times[self._done] > critical[k]
        if self._critical < len(critical):
            return critical[self._critical]
        return math.inf

    def __call__(self, run):
        if run is not self._run:
            self._run = run
            self._done = 0
            self._critical = 0
            views = [run.view(name) for name in ("solve.state", "output.record", "solve.work")]
            (self._state,), (self._record,), self._work = views
            self.limit()  # on the way to the first time of output, as the Problem has it
        s = self._state
        if self._prints and s["stiff"] != s["was_stiff"]:
            to = FAMILIES[int(s["stiff"])]
            print(f"lsoda: at t = {s['t']:.10g} the method changes to {to}.")
        while self._done < self._record["i_eval"]:
            self._done += 1
            s["t_limit"] = self.limit()
        work = self._work
        self.tolsf = too_accurate(work[Y], work[RTOL], work[ATOL])
        if not self.tolsf or self._done == len(self._times):
            return False
        self.istate = TOO_ACCURATE
        self.because = f"Tolerances {self.tolsf:.3g} times as large are possible."
        return True


class Information:
    """The states of the solver at the times of output, and of a failure.

    Attributes
    ----------
    told : array of STATE
    tolsf : ndarray
    imxer : int
    """

    def __init__(self, told):
        self.told, self.tolsf, self.imxer = told, np.zeros(len(told)), -1

    def fail(self, run, k, istate, tolsf):
        """Take the state of a run that failed on the way to row k."""
        self.told[k] = run.view("solve.state")[0]
        self.tolsf[k] = tolsf
        if istate in (-4, -5):
            from fastdyn.kernels.methods.lsoda.past import CHANGE, WEIGHT  # imports Numba

            work = run.view("solve.work")
            self.imxer = int(np.argmax(np.abs(work[CHANGE] * work[WEIGHT])))


def infodict_of(information, n, orders, band, message):
    """The `infodict`: SciPy's names; `lenrw` and `leniw` are those of ODEPACK."""
    s = information.told
    adams, bdf = orders
    found = {
        "hu": s["direction"] * s["h_old"], "tcur": s["t"].copy(), "tolsf": information.tolsf,
        "tsw": s["t_switched"].copy(), "nst": s["n_accepted"], "nfe": s["n_extra"],
        "nje": s["n_jacobians"], "nqu": s["n_equal"], "mused": s["was_stiff"] + 1,
    }  # fmt: skip
    found |= {name: found[name].astype(np.int32) for name in COUNTS}
    of_matrix = (n if band is None else 2 * band[0] + band[1] + 1) * n + 2
    length = max(20 + n * (adams + 4), 20 + n * (bdf + 4) + of_matrix)
    more = {"imxer": information.imxer, "lenrw": length, "leniw": 20 + n, "message": message}
    return found | more
