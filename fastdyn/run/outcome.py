"""The end of a run: the status, a sentence, and the result."""

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.state.record import (
    ATOL,
    BAD_JACOBIAN,
    BORDER,
    EVENT,
    FAILED_AGAIN,
    FINISHED,
    INTERRUPTED,
    NO_TOLERANCE,
    NON_FINITE,
    NOT_CONVERGED,
    RTOL,
    SINGULAR,
    STATE,
    STEP_TOO_SMALL,
    STOPPED,
    ZENO,
    K,
    Y,
)
from fastdyn.problem.domains.options import warn_of_cut
from fastdyn.problem.schedules import in_order

from .actions import OF_ACTIONS, after_action
from .dense_output import PiecewisePolynomial, floors_of
from .loop import counters
from .output import OCCURRENCES, Output, occurrences
from .result import OdeResult

SUCCESS = "The solver successfully reached the end of the integration interval."
TERMINATED = "A termination event occurred."
OF_LSODA = "Unexpected istate in LSODA."
TOO_SMALL = "Required step size is less than spacing between numbers."
LEFT = -3  # the status of a run that ends at the border of `domain`
SENTENCES = {
    BORDER: "The solution leaves `domain` at {t}: the run ends there, at the border.",
    ZENO: "An event occurs infinitely often at {t}: either ever faster up to there (Zeno), or "
    "because `on_event` leaves the state where it occurs again at once. End the run before, by "
    "the number `terminal` of the event, or go on with equations that hold in this state.",
    SINGULAR: "The matrix of the step from {t} is singular, however short the step: the algebraic "
    "equations of `mass` do not determine the algebraic variables there (the index is above 1, or "
    "two equations say the same). Differentiate constraints, or leave an equation out.",
    BAD_JACOBIAN: "The Jacobian is nan or inf at {t}: `fun` or `jac` is not defined there, or just "
    "beside it.",
    NOT_CONVERGED: "The equations of the implicit step from {t} do not converge: reduce `step`, or "
    "take Radau or BDF if the problem is stiff.",
    NO_TOLERANCE: f"{OF_LSODA} A component of the state is 0 at {{t}}, and so is its `atol`: no "
    "error is small enough there; give that component a positive `atol`.",
    NON_FINITE: "The state is not finite after {t}: the solution blows up there, or the steps are "
    "too long for it; reduce `step`.",
}
COUNT = struct.Struct("q")
_new = tuple.__new__  # half the time of a named tuple's own
BLOWN_UP = 1e8  # growth relative to the initial state that counts as a blow-up


def outcome(status, state, work, problem):
    """SciPy's status, and the message that says why the kernels stopped."""
    s = state[0]
    if status == EVENT:
        return 1, TERMINATED
    if status == INTERRUPTED:
        return -2, f"Interrupted at t = {s['t']:.10g}; the result ends there."
    t = f"t = {s['t']:.10g}"
    if status == STOPPED:
        return 1, f"`callback` stopped the integration at {t}."
    if status == STEP_TOO_SMALL:
        return -1, f"{TOO_SMALL} {_why(s, work, problem, t)}"
    if status == FAILED_AGAIN:
        return -1, f"{OF_LSODA} {_why(s, work, problem, t)}"
    if status in OF_ACTIONS:
        return -1, after_action(status, s, problem, t)
    bad = np.flatnonzero(~np.isfinite(work[K + problem.method.fsal_stage]))
    if status == NON_FINITE and s["t"] == s["t_old"] and bad.size:
        start = s["n_accepted"] == 0
        where = "the start" if start else "the state that `on_event` returned"
        outside = ", or the state lies outside of `domain`" if start and problem.domain else ""
        return -1, f"`fun` returned nan or inf at {where}, {t} (component {bad[0]}){outside}."
    if status in SENTENCES:
        return LEFT if status == BORDER else -1, SENTENCES[status].format(t=t)
    implicit = problem.method.n_matrices > 0
    return -1, (
        f"`max_steps={problem.max_steps:g}` was reached at {t}, "
        f"{abs(s['t'] - problem.t0) / abs(problem.tf - problem.t0):.1%} of the way: raise "
        f"`max_steps`, {'or ' if implicit else ''}loosen `rtol` and `atol`"
        f"{'' if implicit else ', or take Radau or BDF if the problem is stiff'}."
    )


def _why(s, work, problem, t):
    """The reason why an adaptive run stopped before the end."""
    if problem.h_max < 16 * np.spacing(abs(float(s["t"]))):
        return f"At {t}, `max_step={problem.h_max:g}` is no step."
    if problem.h_least > 0.0 and s["h"] <= 1.1 * problem.h_least:
        return f"At {t}, `min_step={problem.h_least:g}` is too long for the tolerance."
    if problem.nonnegative is not None and (work[Y][problem.nonnegative] < 0.0).any():
        return f"At {t}, a component that must not be negative is, from `y0`."
    if not np.isfinite(s["error"]):
        return f"`fun` returns nan or inf just after {t}."
    slope = ""
    if not problem.method.series:
        rate = np.abs(work[K + problem.method.fsal_stage]).max()
        slope = f" (largest derivative {rate:.1e})"
    sizes = work[ATOL] / work[RTOL]  # above this size, errors are relative
    absolute = np.max(sizes, where=np.isfinite(sizes), initial=0.0)
    growth = np.abs(work[Y]).max() / max(np.abs(problem.y0).max(), absolute, 1e-300)
    if growth > BLOWN_UP:
        return f"The solution blows up at {t}: it has grown {growth:.1e}-fold."
    return (
        f"At {t} no step is short enough for the tolerance: the solution has a singularity or a "
        f"jump there{slope}, or "
        f"rtol = {work[RTOL].max():.1e} is too loose to have kept it away from one."
    )


def n_factorised(memory):
    """The numbers of Jacobians and of factorisations, from the memory of a solve."""
    return struct.unpack_from("2q", memory, STATE.fields["n_jacobians"][1])


class Ended(NamedTuple):
    """The data from which the parts of a result are made; `grown` is the Output, or None."""

    problem: Any
    plan: Any
    memory: Any
    grown: Any
    status: int
    message: str

    def output(self):
        return self.grown or Output(self.plan, self.memory)

    def t(self):
        """Times; if no time of `t_eval` was reached, an empty list, as in SciPy."""
        t, t_eval = self._numbers(0), self.problem.t_eval
        if t_eval is None:
            return t
        return t.astype(t_eval.dtype, copy=False) if len(t) else []

    def y(self):
        """States, in columns."""
        y = self._components(self._numbers(1))
        return y.T if self.problem.t_eval is None or len(y) else []

    def _components(self, numbers):
        """Numbers along the last axis as components of the state, complex if the state is."""
        if not self.problem.mode.complex_numbers:
            return numbers
        return np.ascontiguousarray(numbers).view(complex)

    def _numbers(self, which):
        """The times, or the states (n_points, n), copied out of memory that is mostly empty."""
        if self.grown is not None:
            return self.grown.points()[which]
        plan, name = self.plan, ("output.t", "output.y")[which]
        memory: Any = self.memory
        (n_points,) = COUNT.unpack_from(
            memory, plan.count("n_out" if self.problem.t_eval is None else "i_eval")
        )
        begin, _, _, shape = plan.arrays[name]
        numbers = self.memory[begin : begin + n_points * (plan.n if which else 1)]
        if 2 * n_points < shape[0]:
            numbers = numbers.copy()
        return numbers.reshape(n_points, plan.n) if which else numbers

    def sol(self):
        """The continuous solution; None if not asked for, or without a step."""
        if not self.problem.dense_output:
            return None
        output = self.output()
        polynomials, spans = output.polynomials()
        if not len(polynomials):
            return None
        end = self.t()[-1] if self.problem.t_eval is None else spans[-1].sum()
        polynomials = self._components(polynomials)
        floors = floors_of(self.problem.nonnegative, len(spans))
        return PiecewisePolynomial(np.append(spans[:, 0], end), polynomials, spans, floors)

    def occurrences(self):
        """The fields t_events and y_events."""
        p = self.problem
        if p.events is None:
            return None, None
        index, t, y = self._found()
        n = len(p.events)
        if p.nonnegative is not None:
            y = np.where(p.nonnegative & (y < 0.0), 0.0, y)
        t, y = (
            in_order(each[:n], p.schedules, each[n:])
            for each in occurrences(index, t, y, n + len(p.schedules))
        )
        return t, [self._components(each) if each.size else each for each in y]

    def _found(self):
        """The occurrences of events: index, time, state."""
        if self.grown is not None:
            return self.grown.found_so_far()
        plan, memory = self.plan, self.memory
        (n,) = COUNT.unpack_from(memory, plan.count("n_events"))
        return [plan.view(memory, name)[:n] for name in OCCURRENCES]

    def nfev(self):
        n_accepted, n_rejected, n_extra = counters(self.memory)
        return n_extra + self.problem.method.n_stages * (n_accepted + n_rejected)


PARTS: dict[str, Callable[[Ended], Any]] = {
    "t": Ended.t,
    "y": Ended.y,
    "sol": Ended.sol,
    "t_events": lambda e: e.occurrences()[0],
    "y_events": lambda e: e.occurrences()[1],
    "nfev": Ended.nfev,
    "njev": lambda e: n_factorised(e.memory)[0],
    "nlu": lambda e: n_factorised(e.memory)[1],
    "status": lambda e: e.status,
    "message": lambda e: e.message,
    "success": lambda e: e.status >= 0,
    "n_accepted": lambda e: counters(e.memory)[0],
    "n_rejected": lambda e: counters(e.memory)[1],
}


def result_of(problem, status, run):
    """The OdeResult of a problem whose Run ended with this status."""
    if status == FINISHED:
        code, message = 0, SUCCESS
    else:
        state, work = run.view("solve.state"), run.view("solve.work")
        code, message = outcome(status, state, work, problem)
    if problem.nonnegative is not None:
        warn_of_cut(run.view("solve.state")["cut"][0])
    given = problem, run.plan, run.memory, run.grown, code, message
    return OdeResult.of_parts(PARTS, _new(Ended, given))
