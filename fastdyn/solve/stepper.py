"""Stepper: one step at a time, in the shape of SciPy's OdeSolver."""

from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from fastdyn.compile.bind import leave_to_python, or_in_python
from fastdyn.compile.sentences import GaveUp, WritesToState
from fastdyn.kernels.state.record import EVENT, FINISHED, NON_FINITE, RUNNING, Y
from fastdyn.problem import validate
from fastdyn.problem.arguments import checked, compiled_method, refuse
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.second_order_and_pairs import mode_for
from fastdyn.run.dense_output import PiecewisePolynomial, floors_of
from fastdyn.run.functions.compared import Compared
from fastdyn.run.loop import announce, counters
from fastdyn.run.outcome import as_components, n_factorised, outcome
from fastdyn.run.result import FIELDS, Counted
from fastdyn.run.solve_problem import run_of

NO_OUTPUT = np.empty(0)
ENDLESS = 2**62
OF_RUN = ("_run", "_sol", "_given", "fun")  # attributes that are not copied


@filled("Stepper")
class Stepper(OdeSolver):
    """Integrate y' = fun(t, y) one step at a time, with compiled code.

    A Stepper has the interface of `scipy.integrate.OdeSolver`, may be given to SciPy's functions
    and to `solve_ivp` as a `method`, and takes the steps of `solve_ivp`, to the last bit.

    Parameters
    ----------
    fun, method, args, vectorized
        As in `solve_ivp`; only fastdyn's own methods.  The method may be the fifth argument, too.
    t0, t_bound : float
        Start and end; the end may be infinite, or lie before the start.
    y0 : array_like, shape (n,)
    **options
        {options}, as in `solve_ivp`.

    Attributes
    ----------
    n : int
    status : {"running", "finished", "failed"}
    t_bound, direction : float
    t, t_old : float
        Present time, and time before the last step; `t_old` is None before the first step.
    y : ndarray, shape (n,)
        Present state.
    step_size : float or None
        Length of the last step.
    nfev, njev, nlu : int
        Evaluations of `fun`, of Jacobians, and factorisations.
    nstep, n_accepted, n_rejected : int
        Accepted steps (under two names), and rejected steps.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments.

    Examples
    --------
    >>> stepper = Stepper(lambda t, y: -y, 0.0, [1.0], 10.0)
    >>> while stepper.status == "running":
    ...     stepper.step()
    """

    compiles = True  # the class compiles `fun` itself

    def __init__(
        self, fun, t0, y0, t_bound, vectorized=False, *, method="RK45", args=None, **options
    ):
        if isinstance(vectorized, str | type):  # the fifth argument is the method
            method, vectorized = _given_once(vectorized, method), False
        elif not isinstance(vectorized, bool | np.bool_ | int):
            raise TypeError(
                "a Stepper takes `fun, t0, y0, t_bound` and the method in this order, all others "
                f"by name, as `max_step=0.1`; got {vectorized!r} in the fifth place."
            )
        given = {"vectorized": vectorized, "method": method, "args": args, **options}
        self._given = (fun, t0, y0, t_bound), given
        refuse("Stepper", options)
        options = {"max_steps": ENDLESS, **options}
        asked = checked(
            fun, (t0, t_bound), y0, method, NO_OUTPUT, False, None, vectorized, args, options
        )
        validate.function(fun)
        ours = compiled_method("Stepper", asked)
        problem = validate.problem(asked, ours, mode_for(asked, ours))
        self.vectorized, self.fun = vectorized, fun
        self._follow(or_in_python(lambda: _begun(problem)), asked.t0, asked.y0)

    def __repr__(self):
        method = self._run.problem.method.name
        return f"<Stepper: {method}, t = {self.t:g} on the way to {self.t_bound:g}, {self.status}>"

    def __reduce__(self):
        """Pickle arguments and state: a copy goes on bit for bit, in another process, too."""
        if self._given is None:
            raise TypeError("what a `callback` is given cannot be pickled or copied; a Stepper can")
        state, work = self._run.view("solve.state"), self._run.view("solve.work")
        kept = {name: value for name, value in vars(self).items() if name not in OF_RUN}
        kept["y"] = self.y.copy()
        return _resumed, (type(self), *self._given, state.copy(), work.copy(), kept)

    @classmethod
    def of_run(cls, run):
        """A Stepper that follows a Run without stepping: the argument of a `callback`."""
        stepper = object.__new__(cls)
        stepper._given = None
        stepper._follow(run, run.problem.t0, run.problem.y0)
        return stepper

    def _follow(self, run, t0, y0):
        p = run.problem
        self._run, self._sol = run, None
        y0 = as_components(p, y0)
        self.n, self.t_bound = len(y0), p.tf
        self.direction = 1.0 if p.tf > p.t0 else -1.0
        self.t_old: Any = None
        self.t, self.y, self.status = t0, y0.copy(), "running"

    nstep: Any = property(lambda self: self.n_accepted)

    def __getattr__(self, name) -> Any:
        field = FIELDS.get(name)
        if field is None or field.of_counts is None:
            raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")
        memory = self._run.memory
        counts = Counted(*counters(memory), *n_factorised(memory))
        return field.of_counts(self._run.problem.method, counts)

    def interpolate(self, t):
        """The state at a time of the last step, shape (n,), or (n, k) at k times."""
        return self.dense_output()(t)

    def look(self):
        """Take over time and state of the Run after a step."""
        run, self._sol, self.t_old = self._run, None, self.t
        state = run.view("solve.state")[0]
        self.t = float(state["t"])
        if self.direction * (self.t - self.t_bound) > 0:  # a constant step, beyond the end
            self._sol = self._polynomial()
            self.t = self.t_bound
            self.y = self._sol(self.t)
        else:
            self.y = as_components(run.problem, run.view("solve.work")[Y].copy())
        if self.direction * (self.t - self.t_bound) >= 0:
            self.status = "finished"

    def _step_impl(self):
        while True:
            if not self._run.holds():  # new outside values need other code
                before, problem = self._run.memory, self._run.problem
                self._run = _run_of_steps(problem)
                self._run.go_on_from(before)
            run = self._run
            before = run.memory.copy()
            try:
                status = run.step()
                run.check(status)
                run.compared.after(run)
                run.tell_jumps()
                taken = counters(run.memory)[0] > counters(before)[0]
                if status != RUNNING or taken:  # else the step was taken back, at a border
                    break
            except GaveUp as reason:  # the code raises, but the Python function may not
                leave_to_python(reason.bound, reason)
                self._run = _run_of_steps(run.problem)
                self._run.go_on_from(before)
        if status not in (RUNNING, FINISHED, EVENT):
            state, work = self._run.view("solve.state"), self._run.view("solve.work")
            return False, outcome(status, state, work, self._run.problem)[1]
        self.look()
        return True, None

    def _polynomial(self):
        d, start, end = self._run.interpolant()
        d = as_components(self._run.problem, d)
        span = np.array([[start, end - start]])
        floors = floors_of(self._run.problem.nonnegative, 1)
        return PiecewisePolynomial(np.array([start, end]), d[None], span, floors)

    def _dense_output_impl(self):
        if self._sol is None:
            self._sol = self._polynomial()
        return Interpolant(self.t_old, self.t, self._sol)


class Interpolant(DenseOutput):
    """The interpolant of one step: ``interpolant(t)``, shape (n,) or (n, k)."""

    def __init__(self, t_old, t, sol):
        super().__init__(t_old, t)
        self._sol = sol

    def _call_impl(self, t):
        return self._sol(t)


def _given_once(first, method):
    """The method in the fifth place; TypeError if `method` is given, too."""
    if method != "RK45":
        raise TypeError(f"`method` is given twice: {first!r} and {method!r}.")
    return first


def _resumed(cls, arguments, options, state, work, kept):
    """A Stepper with the state of the pickled Stepper."""
    stepper = cls(*arguments, **options)
    stepper._run.view("solve.state")[:], stepper._run.view("solve.work")[:] = state, work
    vars(stepper).update(kept)
    return stepper


def _run_of_steps(problem):
    """A Run whose code is compared after steps 1, 2, 4, 8, ..."""
    run = run_of(problem._replace(ends_at_switches=False))
    run.compared = Compared(run, of="steps")
    return run


def _begun(problem):
    """A Run before its first step."""
    try:
        run = _run_of_steps(problem)
    except WritesToState:
        raise ValueError(
            "`fun` writes to the state, between the steps too: take a solver of SciPy's."
        ) from None
    announce(run.bounds)
    status = run.begin(problem.y0)
    run.check(status)
    if status == NON_FINITE:
        state, work = run.view("solve.state"), run.view("solve.work")
        raise ValueError(outcome(status, state, work, problem)[1])
    return run


def observed(callback, function=None):
    """The function that a Run calls after each step, for a `callback` of the user."""
    found: list = []

    def after_step(run):
        if not found or found[0]._run is not run:
            found[:] = [Stepper.of_run(run)]
        found[0].look()
        return callback(found[0])

    vars(after_step)["function"] = function or callback  # may change values that `fun` uses
    return after_step
