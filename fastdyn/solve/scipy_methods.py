"""Solves by SciPy: its solver classes, functions that write to the state between steps, trivial
problems (no component, no span)."""

import numpy as np

from fastdyn.compile.bind import bind, rebind
from fastdyn.compile.function_convention import call, code_at
from fastdyn.compile.mode import COLUMN, DERIVATIVE
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.sentences import CompileWarning, warn, warn_once
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.problem import step_options, validate
from fastdyn.problem.events import between_steps, endless, event_list, for_scipy
from fastdyn.problem.jacobian import DIFFERENCES
from fastdyn.problem.options.table import OPTIONS, refused_among, value_of
from fastdyn.problem.schedules import refuse_schedules
from fastdyn.run.functions.crawling import SENTENCES, Samples, crawl
from fastdyn.run.loop import stops
from fastdyn.run.result import OdeResult
from fastdyn.run.stiffness import StiffnessWarning

KNOWN = validate.SHARED_METHODS
REAL_ONLY = "Radau", "LSODA"  # of these, the methods that take no complex state in SciPy


def python_callable(fun, args, mode, near, others=()):
    """``f(t, y)`` for SciPy: the compiled function, or the user's own.

    `others` are functions of this solve that run in Python: values that they may change are read
    again before each evaluation.
    """
    n = len(near.y0)
    bound = bind(fun, args, mode, n, near)
    if bound.function is None:
        return _checked_at_first(bound, mode)
    given, out = np.empty((2, n))
    left = np.zeros(1, np.int64)  # room for an exception of Numba's code
    block, function = bound.block, code_at(bound.function.address)

    def f(t, y):
        if others and not rebind(bound, fun, args):
            return evaluate(bound.python, mode, t, np.array(y))
        given[:] = y
        if call(function, t, given, block, out, left.ctypes.data):
            return evaluate(bound.python, mode, t, given.copy())
        return out.copy()

    return f


def _checked_at_first(bound, mode):
    """The Python function, whose first value is checked."""
    pending = [True]

    def f(t, y):
        if pending:
            found = evaluate(bound.python, mode, t, y)
            pending.clear()
            if bound.callback is not None:
                bound.callback.announce()
            return found
        return bound.python(t, y)

    return f


def by_scipy(asked, method):
    """The OdeResult of Arguments by `scipy.integrate.solve_ivp` and a method."""
    from scipy.integrate import solve_ivp

    fun, t0, tf, y0, args = asked.fun, asked.t0, asked.tf, asked.y0, asked.args
    t_eval, events, vectorized, options = (
        asked.t_eval, asked.events, asked.vectorized, asked.options
    )  # fmt: skip
    given = asked.given_y0
    numbers = isinstance(given, np.ndarray) and given.dtype.kind in "fiubc"
    given = given.copy() if numbers else y0.tolist()  # SciPy's solver writes to an array
    callback = options.get("callback")
    stopped = []
    refused = refused_among(options, "SciPy")
    refused += [each for each in refused_among(options, f"SciPy's {method}") if options[each[0]]]
    for name, _ in refused if t0 != tf else ():
        raise ValueError(
            f"`{name}` is for compiled methods and real states; this solve is SciPy's."
        )
    refuse_schedules(events, "take a compiled method, a real state and a span that is not empty")
    options = {k: v for k, v in options.items() if k not in OPTIONS or OPTIONS[k].scipys}
    scipys_events = for_scipy(events, args)
    if isinstance(options.get("jac"), str) and options["jac"] == DIFFERENCES:
        del options["jac"]
    if y0.size:
        endless(tf, event_list(events), None)
    validate.output_times(t_eval, t0, tf)
    if y0.dtype == complex or y0.size == 0:
        if y0.size:
            warn_once(fun, "its state is complex; SciPy solves it")
        derivative = fun if not args else lambda t, y: fun(t, y, *args)
    else:
        step_options.tolerances(value_of(options, "rtol"), value_of(options, "atol"), y0)
        mode = COLUMN if vectorized else DERIVATIVE
        near = Near(t0, tf, y0)
        others = [event.function for event in event_list(events) or ()]
        others += [options["jac"]] if callable(options.get("jac")) else []
        derivative = python_callable(fun, args, mode, near, others)
        vectorized = False
        state = y0.copy()
        f0 = derivative(t0, state)
        if not np.isfinite(f0).all():
            return _not_finite(t0, y0, t_eval)
        derivative = _known_at_first(derivative, f0, state)
    if getattr(method, "compiles", False):  # a Stepper compiles `fun` itself
        derivative = fun if not args else lambda t, y: fun(t, y, *args)
    jac = options.get("jac")
    if callable(jac) and args:
        options["jac"] = lambda t, y: jac(t, y, *args)
    if isinstance(method, str):
        method = _scipys(method, y0, no_step=t0 == tf or not y0.size)
    if not getattr(method, "compiles", False) and t0 != tf and y0.size:
        method = _watched(method, derivative)
    if callback is not None:
        method = _observed(method, callback, stopped)
    result = solve_ivp(
        derivative, (t0, tf), given, method, t_eval, asked.dense_output, scipys_events, vectorized,
        **options,
    )  # fmt: skip
    if stopped and result.status == 0:
        result.status = 1
        result.message = f"`callback` stopped the integration at t = {stopped[0]:.10g}."
    return OdeResult(result)


def _scipys(name, y0, no_step):
    """The name of SciPy's method; ValueError if SciPy does not have the method, and steps."""
    known = [each for each in KNOWN if y0.dtype != complex or each not in REAL_ONLY]
    if name in known:
        return name
    if no_step:
        return "RK45"
    raise ValueError(
        "`fun` writes to the state that it is given, which changes the state at the end of each "
        f"step; with events, `t_eval` or `dense_output` take one of {', '.join(known)}."
    )


def begun_again(problem, reason):
    """Warn before a solve begins anew by SciPy because a function writes to the state.

    Raises ValueError if an event has had effects, which cannot be undone.
    """
    if not getattr(reason, "begun", False):
        return
    p = problem
    n = len(problem.y0)
    events = [Attempt(f, p.args, mode, n) for f, mode in between_steps(p) if mode.one_number]
    if any(attempt.facts().effect for attempt in events):
        raise ValueError(
            "A function writes to the state that it is given, which only SciPy's solvers can take, "
            "and an event has changed other things meanwhile: take scipy.integrate.solve_ivp, or "
            "let `on_event` return the new state."
        )
    if Attempt(p.fun, p.args, p.mode, n).facts().effect:
        warn(
            "`fun` writes to the state that it is given, and SciPy's solver took over from the "
            "start: what `fun` counts or keeps includes the calls before.",
            CompileWarning,
        )


def _observed(method, callback, stopped):
    """SciPy's solver class that calls `callback` after each step; `stopped` gets the end time."""
    import scipy.integrate

    base = getattr(scipy.integrate, method) if isinstance(method, str) else method

    class Observed(base):
        nstep = 0

        def step(self):
            message = super().step()
            if self.status == "failed":
                return message
            self.nstep += 1
            if stops(callback, self) and self.status == "running":
                self.status = "finished"
                stopped.append(self.t)
            return message

    return Observed


def _watched(method, derivative):
    """SciPy's solver class whose steps are told of if they crawl."""
    import scipy.integrate

    base = getattr(scipy.integrate, method) if isinstance(method, str) else method

    class Watched(base):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            self._done = 0
            self._samples = Samples(self._tells)

        def step(self):
            message = super().step()
            self._done += 1
            self._samples.take(self._done, self.t, self.y)
            return message

        def _tells(self, times, states):
            scale = getattr(self, "atol", 0.0) + getattr(self, "rtol", 0.0) * np.abs(states[-1])
            scale = np.where(scale > 0.0, scale, np.inf)
            if not crawl(times, states, scale, lambda y: derivative(times[-1], y)):
                return False
            said = SENTENCES["crawls"].format(t=times[-1])
            warn(f"{base.__name__} took {self._done} steps. {said}", StiffnessWarning)
            return True

    return Watched


def _known_at_first(derivative, f0, state):
    """The derivative as a function that returns `f0` at its first call, which is at the start.

    `state` is the initial state as the function left it.
    """
    known = [f0]

    def f(t, y):
        if not known:
            return derivative(t, y)
        y[...] = state.reshape(y.shape)
        return known.pop()

    return f


def _not_finite(t0, y0, t_eval):
    message = f"`fun` returned nan or inf at the start, t = {t0:.10g}."
    t, y = ([], []) if t_eval is not None else (np.array([t0]), y0[:, None])
    return OdeResult(
        t=t, y=y, sol=None, t_events=None, y_events=None, nfev=1, njev=0, nlu=0,
        status=-1, message=message, success=False,
    )  # fmt: skip
