"""The result of a solve of F(t, y, y') = 0: y and y', from the solve of [y, y']."""

import numpy as np

from fastdyn.kernels.state.record import (
    BAD_JACOBIAN,
    NO_TOLERANCE,
    NOT_CONVERGED,
    SINGULAR,
)
from fastdyn.run import outcome
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.result import OdeResult

SENTENCES = {
    SINGULAR: "The matrix dF/dy + c dF/dy' is singular at t = {t:.10g}, however short the step: "
    "the equations do not determine the solution there (two say the same, a component occurs in "
    "none, or the solution ends in a singularity).",
    NOT_CONVERGED: "Newton's iteration does not converge at t = {t:.10g}, however short the step: "
    "the solution may end there, or jump; F may be nan or not smooth there; or the index may be "
    f"above 1 from there on. {outcome.OF_JUMPS}",
    BAD_JACOBIAN: "The Jacobian of `F` is nan or inf at t = {t:.10g}: `F` is not defined there, or "
    "just beside it.",
    NO_TOLERANCE: "A component of the state is 0 at t = {t:.10g}, and so is its `atol`: no error "
    "is small enough there; give that component a positive `atol`.",
}


class DaeSolution(PiecewisePolynomial):
    """The continuous solution; ``sol(t)`` is y, ``sol.derivative(t)`` is y'."""

    def __init__(self, ts, polynomials, spans):
        n = polynomials.shape[2] // 2
        super().__init__(ts, polynomials[:, :, :n], spans)
        self._rates = PiecewisePolynomial(ts, polynomials[:, :, n:], spans)

    def derivative(self, t):
        """The derivative, (n,) at one time, (n, k) at k times."""
        return self._rates(t)

    def of_first(self, n):
        """The continuous solution of the first n components."""
        found = self.polynomials[:, :, :n]
        rates = self._rates.polynomials[:, :, :n]
        return DaeSolution(self.ts, np.concatenate([found, rates], axis=2), self.spans)


def result_of(problem, status, run, index):
    """The OdeResult of a Run that ended with this status, for equations of this index."""
    found = outcome.result_of(problem, status, run)
    n = len(problem.y0) // 2
    result = OdeResult(found)
    both = np.asarray(found.y).reshape(2 * n, -1)
    sol = found.sol
    result.y = both[:n]
    result["yp"] = both[n:]
    result["index"] = index
    result.sol = sol and DaeSolution(sol.ts, sol.polynomials, sol.spans)
    result["yp_events"] = None
    if found.y_events is not None:
        result.y_events, result["yp_events"] = (
            [each[:, part] if each.size else each for each in found.y_events]
            for part in (slice(n), slice(n, None))
        )
    if status in SENTENCES:
        result.message = SENTENCES[status].format(t=float(run.view("solve.state")["t"][0]))
    return result
