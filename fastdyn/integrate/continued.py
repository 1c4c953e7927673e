"""A run of LSODA that goes on from one time of output to the next."""

import contextlib
import math
from typing import Any

import numpy as np

from fastdyn.compile.bind import leave_to_python, numpy_errors_are_heard, or_in_python
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.compile.traced.known import N_LEFT
from fastdyn.kernels.calls.block import SIDES
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.lsoda.past import ORDER, Z
from fastdyn.kernels.state.record import FINISHED, RUNNING, Y
from fastdyn.problem import lsoda
from fastdyn.problem.step_options import NO_SEGMENTS
from fastdyn.problem.validate import Problem
from fastdyn.run.functions.compared import Compared
from fastdyn.run.functions.readers import reader_of
from fastdyn.run.loop import announce
from fastdyn.run.outcome import outcome
from fastdyn.run.solve_problem import in_time

from .messages import DONE, ILLEGAL, MANY_STEPS, istate_of

NUMBERS = {float, int, np.float64}
EXPONENTS = np.arange(14.0)
BEFORE = 100 * 2.2e-16  # of a step, before its start: as in ODEPACK


class Continued:
    """Steps of LSODA that pass the times of output, where the state is interpolated.

    Parameters
    ----------
    functions : tuple
        The function, and the Jacobian or None.
    span : tuple of float
        The start, and the first time of output.
    y0 : ndarray, shape (n,)
    args : tuple
    tolerances : tuple
    limits : tuple of float
        The first, the longest and the shortest step; 0: any.
    orders : tuple of int
        The highest orders of the families; 0: the family is not taken.
    band : tuple of int or None
    most : int
        Most steps of one call.
    """

    def __init__(self, functions, span, y0, args, tolerances, limits, orders, band, most):
        self._fun, jac = functions
        self._given = args
        self._most = most
        self._t = float(span[0])
        t0, t1 = map(float, span)
        first, longest, shortest = map(float, limits)
        rtol, atol = [np.asarray(one, float) if np.ndim(one) else float(one) for one in tolerances]
        problem = Problem(
            fun=self._fun, t0=t0, tf=t1, y0=y0, method=METHODS[lsoda.NAME], t_eval=np.array([t1]),
            dense_output=False, events=None, args=tuple(args), mode=DERIVATIVE, rtol=rtol,
            atol=atol, h_max=longest or math.inf, h=abs(first), segments=NO_SEGMENTS, project=None,
            differences=jac is None, h_least=shortest, band=band or lsoda.NO_BAND, orders=orders,
            limit=math.inf, ends_at_switches=False,
        )  # fmt: skip
        if jac is not None:
            jac = lsoda.unpacked(jac, band, problem) if band else jac
        self._problem = problem._replace(jac=jac)
        self._run: Any = None
        self._state: Any = None
        self._work: Any = None
        self._plain: Any = None
        self._is_ahead = True  # of what the PlainSteps know

    def goes_on(self, fun, args, t):
        """Whether a call with this function and these arguments goes on from a time."""
        return fun is self._fun and args is self._given and t == self._t

    def counts(self):
        """Steps, evaluations and Jacobians."""
        s = self._state
        return (0, 0, 0) if s is None else (s["n_accepted"], s["n_extra"], s["n_jacobians"])

    def at(self, t1):
        """The state at t1, which needs no new code, comparison or sentence; None for `advance`.

        Takes 3 us, and `advance` 15: loops over `ode.integrate` have many short calls.
        """
        plain = self._plain
        if plain is None or t1.__class__ not in NUMBERS:
            return None
        if self._is_ahead:
            plain.look()
            self._is_ahead = False
        if plain.is_reached(t1):
            y = plain.interpolated(t1)
        else:
            y = plain.stepped(t1, self._problem.args, self._most)
        if y is not None:
            self._t = float(t1)
        return y

    def advance(self, how, t1):
        """``(y, t, istate, because)`` of a call "run", "run_relax" or "step" to the time t1."""
        t1 = float(t1)
        self._is_ahead = True
        n_steps = 1 if how == "step" else self._most
        if self._state is None:
            status = or_in_python(lambda: self._begun(n_steps))
        elif how != "step" and self._state["direction"] * (self._state["t"] - t1) >= 0.0:
            return self._at_step(DONE) if how == "run_relax" else self._interpolated(t1)
        else:
            status = self._step(t1, n_steps)
        if status == FINISHED and how == "run":
            self._t = t1
            return self._run.view("output.y")[0].copy(), t1, DONE, ""
        if status == FINISHED or (status == RUNNING and how == "step"):
            return self._at_step(DONE)
        if status == RUNNING:
            return self._at_step(MANY_STEPS, f"{self._most} steps do not lead to t = {t1:.10g}.")
        run = self._run
        state = run.view("solve.state")
        because = outcome(status, state, self._work, run.problem, run.bounds[0])[1]
        return self._at_step(istate_of(status, float(state["error"][0])), because)

    def _at_step(self, istate, because=""):
        """The end of the last step."""
        self._t = float(self._state["t"])
        return self._work[Y].copy(), self._t, istate, because

    def _interpolated(self, t1):
        """The state at a time of the last step, by the polynomial of the next order."""
        s = self._state
        h = s["direction"] * s["h_old"]
        x = (t1 - s["t"]) / h if h else 0.0
        if x < -1.0 - BEFORE:
            before = f"t = {t1:.10g} lies before the last step, which begins at t = "
            before += f"{s['t_old']:.10g}: call set_initial_value to go back."
            return self._work[Y].copy(), self._t, ILLEGAL, before
        self._t = t1
        rows = nordsieck(self._work)
        return x ** EXPONENTS[: len(rows)] @ rows, t1, DONE, ""

    def _new_run(self, memory=None):
        """A new Run, which goes on with the memory of another."""
        self._run = run = in_time(self._problem)
        run.compared = Compared(run, of="steps")
        if memory is not None:
            run.go_on_from(memory)
            self._take_views()

    def _take_views(self):
        run = self._run
        (self._state,) = run.view("solve.state")
        (self._record,) = run.view("output.record")
        self._work = run.view("solve.work")
        functions = [f for f in (run.problem.fun, run.problem.jac) if f is not None]
        self._plain = None
        if run.is_plain() and len(functions) == len(run.bounds):
            with contextlib.suppress(Uncompilable):
                self._plain = PlainSteps(run, functions, self._state, self._work, self._record)

    def _begun(self, n_steps):
        self._new_run()
        status = self._run.begin(self._problem.y0, n_steps)
        self._take_views()
        self._look(status)
        announce(self._run.bounds)
        return status

    def _look(self, status):
        """Raise what the function raised, and compare its code."""
        self._run.check(status)
        self._run.compared.after(self._run)

    def _step(self, t1, n_steps):
        """Take at most `n_steps` steps on the way to t1."""
        while True:
            if not self._run.holds():  # new outside values need other code
                self._new_run(self._run.memory)
            run = self._run
            before = run.memory.copy()
            self._state["t_end"] = t1
            self._record["i_eval"] = 0
            run._t_eval[0] = t1
            try:
                status = run.step(n_steps)
                self._look(status)
                return status
            except GaveUp as reason:  # the code raises, but the Python function may not
                leave_to_python(reason.bound, reason)
                self._new_run(before)


class PlainSteps:
    """Steps of a Run that is plain: no Python code is called, and nobody watches.

    As `ReadyRun.go`: a check may be too strict, and has no message.
    """

    def __init__(self, run, functions, state, work, record):
        p = run.problem
        self._run = run
        self._state = state
        self._work = work
        self._record = record
        self._end = run.view("solve.state")["t_end"]
        self._y = run.view("output.y")[0]
        self._readers = [
            (reader_of(run, bound, fun, p.args), fun, bound.block)
            for bound, fun in zip(run.bounds, functions, strict=True)
        ]
        self._sides = [(memoryview(block), i) for i, block in enumerate(run.compared.deciding)]
        self._n_left = N_LEFT[0]

    def look(self):
        """Take the last step from the record of the run."""
        s = self._state
        self._t = float(s["t"])
        self._direction = float(s["direction"])
        self._h = self._direction * float(s["h_old"])
        self._rows: Any = None  # of the polynomial of the step

    def is_reached(self, t1):
        return self._direction * (self._t - t1) >= 0.0

    def interpolated(self, t1):
        """The state at a time within the last step; None for other times."""
        if not self._h:
            return None
        x = (t1 - self._t) / self._h
        if x < -1.0:
            return None
        if self._rows is None:
            self._rows = nordsieck(self._work)
            self._exponents = EXPONENTS[: len(self._rows)]
        return x**self._exponents @ self._rows

    def stepped(self, t1, args, most):
        """The state at a time behind the last step, after at most so many steps; or None."""
        run = self._run
        left = run.compared.left
        if left[0] <= 1 or N_LEFT[0] != self._n_left or numpy_errors_are_heard():
            return None
        for read, function, block in self._readers:
            if read(function, args, block) is None:
                return None
        before = run.memory.copy()
        self._end[0] = run._t_eval[0] = t1
        self._record["i_eval"] = 0
        status = run.step(most)
        is_known = status == FINISHED
        for block, i in self._sides:
            if block[SIDES] & ~run.compared.sides[i]:
                is_known = False
        if not is_known:  # the same steps again, with sentences
            run.memory[:] = before
            return None
        left[0] -= 1
        self.look()
        return self._y.copy()


def nordsieck(work):
    """The rows of the polynomial of the last step, in powers of its share before the end."""
    return work[Z : Z + int(abs(work[ORDER, 0])) + 1]
