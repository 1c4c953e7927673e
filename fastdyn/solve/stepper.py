"""Stepper: one step at a time, in the shape of SciPy's OdeSolver."""

from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from fastdyn.compile.bind import leave_to_python, or_in_python
from fastdyn.compile.sentences import GaveUp
from fastdyn.kernels.state.record import EVENT, FINISHED, RUNNING, STEP_TOO_SMALL, Y
from fastdyn.problem import validate
from fastdyn.problem.arguments import checked, compiled_method, own, refuse
from fastdyn.problem.discrete import longer
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.names import ARGUMENTS
from fastdyn.problem.options.table import OPTIONS
from fastdyn.problem.second_order_and_pairs import mode_for
from fastdyn.problem.step_options import within
from fastdyn.run.dense_output import PiecewisePolynomial, floors_of
from fastdyn.run.functions.switching import goes_on, rest_of
from fastdyn.run.loop import counters
from fastdyn.run.outcome import end_of, occurrences_of
from fastdyn.run.output import as_components, occurrences_in
from fastdyn.run.result import FOLLOWING, Ended, following, of_parts
from fastdyn.run.resume import put_tables
from fastdyn.run.solve_problem import begun, run_of_steps
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

NO_OUTPUT = np.empty(0)
ENDLESS = 2**62
WATCHED = ("on_event", "at", "every", "discrete", "breakpoints")
# Arrays of the memory of a Run that a copy takes over; those of tables hold addresses.
KEPT = ("solve.state", "solve.work", "output.record", "events.table", "events.schedules")
STATE = "t y fun t_bound direction n discrete t_events y_events step_size".split()
# Attributes that are not copied.
OF_RUN = ("_run", "_sol", "_given", "_asked", "_problem", "_method", "fun")


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
    events : callable or sequence of callable, optional
        As in `solve_ivp`.  A step ends where an event ends the run, or acts by `on_event`; `y` is
        then the state behind the event, and `interpolate` has the states before.
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
    t_events, y_events : list of ndarray or None
        For each event so far, its times (k,) and the states there (k, n); None without events.
    discrete : ndarray, shape (m,)
        With `discrete`: the present discrete states.
    args : tuple
        The arguments of `fun`, which may be set between two steps: inputs of a controller. The next
        step begins at the present state with the new arguments, without what a method keeps of the
        steps before; give control times as `breakpoints`, so that steps end there.
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
    _watches = False  # whether events, schedules or breakpoints lie between the steps
    _before: Any = None  # what follows from the end before `args` were set
    _n_own: Any = None  # the length of y, with `discrete`

    @shown_when_wrong()
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
        for name, value in (("t0", t0), ("t_bound", t_bound)):
            kinds.number(name, value)
        given: Any = {"y0": y0, "vectorized": vectorized, "method": method, "args": args}
        given = own({**given, **options})
        y0 = given.pop("y0")
        self._given = (fun, t0, y0, t_bound), given
        refuse("Stepper", options)
        options = {"max_steps": ENDLESS, **{name: given[name] for name in options}}
        events = options.pop("events", None)
        self._watches = events is not None or any(options.get(name) is not None for name in WATCHED)
        asked = checked(
            fun, (t0, t_bound), y0, method, NO_OUTPUT, self._watches, events, vectorized, args,
            options,
        )  # fmt: skip
        validate.function(fun)
        if asked.discrete is not None:
            asked, self._n_own = longer(asked)
        ours = compiled_method("Stepper", asked)
        self._asked, self._method = asked, ours
        self._problem = validate.problem(asked, ours, mode_for(asked, ours))
        vars(self).update(vectorized=vectorized, fun=fun)
        self._found: list = []  # (index, t, y) of the events of each step
        self._follow(self._started(), asked.t0, asked.y0)
        if self._watches:
            self._take_over(self._run.step(0))  # a schedule may act at the start

    def __repr__(self):
        method = self._run.problem.method.name
        return f"<Stepper: {method}, t = {self.t:g} on the way to {self.t_bound:g}, {self.status}>"

    args: Any = property(lambda self: self._run.problem.args)

    def _take_args(self, args):
        """Go on with other arguments, from the present time and state."""
        if self._given is None:
            raise AttributeError("`args` cannot be set within a `callback`: make a Stepper.")
        if self.status != "running":
            raise AttributeError(f"`args` cannot be set: this Stepper has {self.status}.")
        args, run = validate.extra_arguments(args), self._run
        if run.problem.schedules:
            raise AttributeError(
                "`args` cannot be set beside `at` and `every`, whose times count from the start: "
                "give the inputs as `discrete` states."
            )
        h = min(abs(float(run.view("solve.state")["h"][0])), abs(self.t_bound - self.t))
        y = run.view("solve.work")[Y].copy()
        asked = self._asked._replace(t0=self.t, y0=as_components(run.problem, y), args=args)
        if asked.options.get("breakpoints") is not None:
            left = within(asked.options["breakpoints"], self.t, self.t_bound)
            asked = asked.with_options(breakpoints=left)
        if self._method.error_order and h > 0:
            asked = asked.with_options(first_step=h)
        problem, mode = self._problem, run.problem.mode
        self._problem = validate.problem(asked, self._method, mode)
        before = self._ended()
        first, given = self._given
        try:
            new = self._started()
        except BaseException:
            self._problem = problem
            raise
        own = vars(self)
        own["_run"], own["_sol"], own["_before"] = new, None, before
        own["_given"] = (first[0], self.t, self.y.copy(), first[3]), {**given, "args": args}
        if self._watches:
            self._take_over(new.step(0))

    def _started(self):
        """A Run before its first step; steps that end at switching times are watched."""
        run = or_in_python(lambda: begun(self._problem))
        if self._watches or run.switching is None or not run.switching.ends:
            return run
        self._watches = True
        self._asked = self._asked._replace(dense_output=True)
        self._problem = self._problem._replace(dense_output=True)
        return or_in_python(lambda: begun(self._problem))

    def _other_run(self, before):
        """A Run with other code, or in Python, that goes on with the memory `before`."""
        p = self._problem
        self._run = run_of_steps(p._replace(ends_at_switches=p.ends_at_switches and self._watches))
        self._run.go_on_from(before)
        segments = rest_of(p.segments, self.t, p.tf)
        goes_on(self._run, segments, self._run.problem.h_max)

    def __setattr__(self, name, value):
        if name == "args":
            self._take_args(value)
            return
        if name in STATE:
            raise AttributeError(
                f"`{name}` of a Stepper cannot be set: begin anew, Stepper(fun, stepper.t, y, "
                "stepper.t_bound), or change the state by `on_event`, at an event or a time."
            )
        if name in OPTIONS or name in ARGUMENTS:
            raise AttributeError(
                f"`{name}` is given when a Stepper is made, Stepper(fun, t0, y0, t_bound, "
                f"{name}=...); it cannot be set later."
            )
        object.__setattr__(self, name, value)

    def __reduce__(self):
        """Pickle arguments and state: a copy goes on bit for bit, in another process, too."""
        if self._given is None:
            raise TypeError("what a `callback` is given cannot be pickled or copied; a Stepper can")
        run = self._run
        arrays = {name: run.view(name).copy() for name in KEPT}
        arrays["segments"] = run.segments
        if run.switching is not None:
            arrays["switching"] = run.switching.place
        kept = {name: value for name, value in vars(self).items() if name not in OF_RUN}
        kept["y"] = self.y.copy()
        return _resumed, (type(self), *self._given, arrays, kept)

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
        vars(self).update(n=len(y0), t_bound=p.tf, direction=1.0 if p.tf > p.t0 else -1.0)
        self.t_old: Any = None
        vars(self)["t"], self.status = t0, "running"
        self._put(y0.copy())

    def _put(self, y):
        """Take a state of the Run, whose end may be the discrete states."""
        own = vars(self)  # `__setattr__` is for users
        own["y"] = y if self._n_own is None else y[: self._n_own]
        if self._n_own is not None:
            own["n"], own["discrete"] = self._n_own, y[self._n_own :]

    t_events: Any = property(lambda self: self._occurrences()[0])
    y_events: Any = property(lambda self: self._occurrences()[1])

    def _occurrences(self):
        p = self._run.problem
        if p.events is None:
            return None, None
        none = np.empty(0, int), np.empty(0), np.empty((0, len(p.y0)))
        t, y = occurrences_of(p, *map(np.concatenate, zip(none, *self._found, strict=True)))
        own = slice(self._n_own)
        return t, [each[:, own] if each.size else each for each in y]

    nstep: Any = property(lambda self: self.n_accepted)

    def __getattr__(self, name) -> Any:
        if name not in FOLLOWING:
            raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")
        return self._ended((name,))[name]

    def _ended(self, names=FOLLOWING):
        """The fields of a result that follow from the end of a solve, by name."""
        run = self._run
        found = following(run.problem.method, Ended.of(run.view("solve.state")[0]), names)
        return of_parts([self._before, found], names) if self._before else found

    def interpolate(self, t):
        """The state at a time of the last step, shape (n,), or (n, k) at k times."""
        return self.dense_output()(t)

    def look(self):
        """Take over time and state of the Run after a step."""
        run, self._sol, self.t_old = self._run, None, self.t
        state = run.view("solve.state")[0]
        vars(self)["t"] = float(state["t"])
        if self.direction * (self.t - self.t_bound) > 0:  # a constant step, beyond the end
            d, start, end = run.interpolant()
            self._sol, vars(self)["t"] = self._piece(d, start, end), self.t_bound
            self._put(self._piece(d, start, end, slice(None))(self.t))
        else:
            self._put(as_components(run.problem, run.view("solve.work")[Y].copy()))
        if self.direction * (self.t - self.t_bound) >= 0:
            self.status = "finished"

    def _step_impl(self):
        while True:
            if not self._run.holds():  # new outside values need other code
                self._other_run(self._run.memory)
            run = self._run
            if run.switching is not None:
                run.switching.follow(run)
            before = run.memory.copy()
            try:
                status = run.step()
                run.check(status)
                run.compared.after(run)
                run.tell_jumps()
                done = counters(run.memory)[0]
                taken = done > counters(before)[0]
                if status == RUNNING and taken and run.looks.end(done):
                    status = STEP_TOO_SMALL
                if status != RUNNING or taken:  # else the step was taken back, at a border
                    break
            except GaveUp as reason:  # the code raises, but the Python function may not
                leave_to_python(reason.bound, reason)
                self._other_run(before)
        if status not in (RUNNING, FINISHED, EVENT):
            return False, end_of(run.problem, status, run)[1]
        self.look()
        if self._watches:
            self._take_over(status)
        return True, None

    def _take_over(self, status):
        """Take the polynomial and the events of a step out of the memory of the Run."""
        run, before = self._run, self._sol
        run.check(status)
        record: Any = run.view("output.record")[0]
        index, t, y = (each.copy() for each in occurrences_in(run.plan, run.memory))
        if len(t):
            self._found.append((index, t, y))
        if record["n_dense"] > 0 and self.t_old is not None:
            d = run.view("output.d")[record["n_dense"] - 1].copy()
            start, h = run.view("output.spans")[record["n_dense"] - 1]
            before = self._piece(d, start, start + h)
        record["n_events"] = record["n_dense"] = 0
        if status == EVENT:  # the Run has taken the step to its end
            vars(self)["t"], self.status = float(t[-1]), "finished"
            self._put(as_components(run.problem, y[-1]))
        elif self.t_old is None:
            self._put(as_components(run.problem, run.view("solve.work")[Y].copy()))
        vars(self)["t"] = self._named(self.t)
        self._sol = before

    def _named(self, t):
        """A breakpoint in the place of the start of its segment, a few roundings behind."""
        segments = self._run.segments
        at = np.flatnonzero(segments[1:, 0] == t)
        return float(segments[at[0], 2]) if len(at) else t

    def _polynomial(self):
        return self._piece(*self._run.interpolant())

    def _piece(self, d, start, end, components=None):
        of_these = slice(self._n_own) if components is None else components
        d = as_components(self._run.problem, d)[:, of_these]
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


def _resumed(cls, arguments, options, arrays, kept):
    """A Stepper with the state of the pickled Stepper."""
    stepper = cls(*arguments, **options)
    run = stepper._run
    for name in KEPT[:3]:
        run.view(name)[:] = arrays[name]
    put_tables(run, *[arrays[name] for name in KEPT[3:]])
    if run.switching is not None and "switching" in arrays:
        run.switching.place = arrays["switching"]
    run.lay_segments(arrays["segments"])
    vars(stepper).update(kept)
    return stepper
