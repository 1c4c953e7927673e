"""Repeated calls of `solve_ivp`: the same function, method and options, other values.

State, span, times of output, arguments, closure and outside values may change from call to call.
"""

import functools
import math
import types as python
from typing import Any

import numpy as np

from fastdyn.compile import memory
from fastdyn.compile.callables import is_jitted
from fastdyn.compile.derivatives.sensitivities import decides
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.kernels.methods.taylor.accuracy import order_for
from fastdyn.problem.events import Event, asked_of, bare, of_own
from fastdyn.problem.options.table import OPTIONS
from fastdyn.problem.sensitivities import Tolerances, directions_of, with_sensitivities
from fastdyn.run.ready import ReadyRun, Solver
from fastdyn.run.solve_problem import WORDS, in_time, run_of
from fastdyn.run.stiffness import notice, watch

from .sensitivities import at_events, parted

FUNCTION = python.FunctionType
LARGEST, SMALLEST = 2.0**60, 2.0**-60  # sizes of a state
_recent = memory.Table()  # by the kind of a call


def solved(fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options):
    """The result of a call of `solve_ivp` like an earlier one; None for the long way."""
    if args is None:
        args = ()
    elif args.__class__ is list:
        args = tuple(args)
    sensitivity = adjoint = None
    if "sensitivity" in options or "adjoint" in options:
        options = dict(options)
        sensitivity = options.pop("sensitivity", None)
        adjoint = options.pop("adjoint", None)
        if sensitivity.__class__ is list:  # as `_hashable` does, which comes after an exception
            sensitivity = (list, *sensitivity)
    try:
        others = () if events is None else _listed(events)
        kind = _kind(
            fun, y0, method, t_eval, dense_output, others, vectorized, args, options,
            sensitivity, adjoint,
        )  # fmt: skip
        try:
            found = _recent.get(kind)
        except TypeError:  # lists and arrays have no hash
            found = _recent.get(_hashable(kind))
    except (AttributeError, TypeError):  # a callable without code, or values without a hash
        return None
    if found is None or args.__class__ is not tuple:
        return None
    if others:
        if found.asked != [asked_of(event) for event in others]:
            return None
        others = [each.function if isinstance(each, Event) else each for each in others]
    return found.solve(fun, y0, args, others, t_span, t_eval)


def asked_before(asked, method):
    """The result of Arguments like those of an earlier call, by the same method; or None."""
    a = asked
    return solved(
        a.fun, (a.t0, a.tf), a.y0, method, a.t_eval, a.dense_output, a.events, a.vectorized, a.args,
        {**a.options, "sensitivity": a.sensitivity, "adjoint": a.adjoint},
    )  # fmt: skip


def note(asked, method, problem):
    """After the solve of Arguments the long way, prepare for more calls of the kind."""
    a = asked
    if not may_come_again(problem, a.options):
        return
    try:
        others = () if a.events is None else _listed(a.events)
        kind = _hashable(_kind(
            a.fun, a.y0, method, a.t_eval, a.dense_output, others, a.vectorized, a.args, a.options,
            a.sensitivity, a.adjoint,
        ))  # fmt: skip
        found = _recent.get(kind)
    except (AttributeError, TypeError):
        return
    if found is None:
        kept = problem, a.options
        new = Repeated(*kept)
        if a.sensitivity is not None:
            new = WithSensitivities(*kept, a.sensitivity)
        elif a.adjoint is not None:
            new = WithAdjoint(*kept, a.adjoint)
        found = _recent.put(kind, new, 1 + len(problem.y0) // WORDS)
    found.count(problem)


def _listed(events):
    """The event functions as a list or tuple; TypeError for what calls again do not take.

    These are what can be read once, and events that have occurred before the run: their rules are
    not those of their functions.
    """
    if callable(events) or events.__class__ is Event:
        events = (events,)
    if events.__class__ is not list and events.__class__ is not tuple:
        raise TypeError
    for event in events:
        if isinstance(event, Event) and event.has_occurred:
            raise TypeError
    return events


def _kind(fun, y0, method, t_eval, dense_output, others, vectorized, args, options, *derivatives):
    """The key of a call: its functions' code, lengths, and options."""
    kind = (
        fun.__class__, id(fun.__code__ if fun.__class__ is FUNCTION else _code(fun)), len(y0),
        method, None if t_eval is None else len(t_eval), dense_output, vectorized, len(args),
        others and tuple([id(_code(event)) for event in others]), *derivatives,
    )  # fmt: skip
    return (*kind, *options, *options.values()) if options else kind


def _hashable(kind):
    """A key with the contents of lists, and of arrays of numbers, which may change in place."""
    return tuple([
        (value.dtype.str, value.shape, value.tobytes())
        if value.__class__ is np.ndarray and value.dtype.kind in "fiu"
        else (list, *value) if value.__class__ is list
        else value
        for value in kind
    ])  # fmt: skip


def _code(fun):
    """The code of a callable: of a partial that of its function, of an object that of its class."""
    kind = fun.__class__
    if kind is FUNCTION or kind is python.MethodType or is_jitted(fun):
        return fun.__code__
    if kind is Event:
        return _code(fun.function)
    return _code(fun.func) if kind is functools.partial else kind.__call__.__code__


def may_come_again(problem, options):
    """Whether a ready run takes other spans and times of a problem with these options."""
    p = problem
    times = problem.t_eval
    known = [OPTIONS[name] for name in options if name in OPTIONS]
    if len(known) < len(options) or not math.isfinite(p.tf):
        return False
    if not all(option.in_key and option.methods(p.method) for option in known):
        return False
    if p.mode.second_order or p.mode.complex_numbers or p.schedules:
        return False  # the form q'' = a(t, q) is checked at each call
    if times is not None and not (times.dtype.kind in "fiu" and len(times)):
        return False
    if len(p.segments) == 1 and np.size(options["breakpoints"]):  # none is within: a warning
        return False
    if p.rtol.__class__ is not float:  # an rtol that is raised is an array
        return False
    if not p.method.error_order or p.atol.__class__ is float:
        return not p.method.error_order or p.atol > 0
    return bool(np.all(p.atol > 0))


class Repeated(Solver):
    """Calls of one kind; `codes` are kept alive, because their ids are in the key.

    `asked` are the attributes of the event functions, which later calls must have, too.
    """

    make: Any = None  # in place of `outcome.results`

    def __init__(self, problem, options):
        super().__init__()
        self.asked: list | None = None
        self.codes = [_code(f) for f in (problem.fun, *_functions(problem))]
        self._options = options

    def ready(self, problem):
        p = self.problem = stripped(problem)
        return self._ready(problem, in_time, p, None)

    def _ready(self, problem, run_of, common, check):
        """A ReadyRun for a problem; `common` is the problem without the values of one call."""
        self.asked = [event.asked for event in problem.events or ()]
        try:
            run = run_of(problem)
        except (GaveUp, Uncompilable):
            return []
        if not run.is_plain() or (problem.mode.sensitivities and decides(run.bounds[0])):
            return []
        fun = problem.fun.fun if problem.mode.sensitivities else problem.fun
        functions = fun, *_functions(problem)
        if len(functions) < len(run.bounds):  # functions that act between steps
            return []
        sizes = _sizes(problem) if problem.method.series else None
        given = functions, problem.args, self.finish, check, sizes, self._options
        return [ReadyRun(run, common, *given, self.make)]

    def present(self, ready, fun, args, others):
        p = self._with_events(others) if others else self.problem
        y0 = ready.room[: len(p.y0)].copy()
        return p._replace(fun=fun, args=args, y0=y0, **ready.taken())

    def _with_events(self, others):
        """The problem with the event functions of one call."""
        p = self.problem
        events = [event.like(f) for f, event in zip(others, p.events, strict=True)]
        return p._replace(events=events)

    def goes_on(self, problem, run):
        watch(problem, run)

    def ended(self, problem, run):
        notice(problem, run)


class WithAdjoint(Repeated):
    """Calls of one kind with the option `adjoint`."""

    def __init__(self, problem, options, names):
        super().__init__(problem, options)
        from .adjoint.solve import Again  # imports Numba

        self._adjoint = Again(names)
        self.make = self._adjoint.results

    def ready(self, problem):
        p = self.problem = stripped(problem)
        return [] if p.events else self._ready(problem, self._adjoint.run_of, p, self._suits)

    def solve(self, fun, y0, args, others=(), t_span=None, t_eval=None):
        try:
            ready = self.idle.pop()
        except IndexError:
            return None
        try:
            result = ready.go(fun, y0, args, others, t_span, t_eval)
            if result is not None:
                result = self._adjoint.finished(result, self.problem, ready, fun, args)
        except GaveUp:
            return None
        self.idle.append(ready)
        if self._misses and result is not None:
            self._misses = 0
        return result

    def ended(self, problem, run):
        super().ended(problem, run)
        self._adjoint.keep(run)

    def _suits(self, ready, y0, args, events):
        return self._adjoint.suits(args)


class WithSensitivities(Repeated):
    """Calls of one kind with the option `sensitivity`."""

    def __init__(self, problem, options, sensitivity):
        super().__init__(problem, options)
        self._sensitivity = sensitivity

    def solve(self, fun, y0, args, others=(), t_span=None, t_eval=None):
        own: Any = ()
        if others:
            if not self.idle:
                return None
            own = [of_own(Event(event), len(self.problem.y0)).function for event in others]
        whole = super().solve(fun, y0, args, own, t_span, t_eval)
        if whole is None:
            return None
        result = parted(whole, len(self.problem.y0), self._directions)
        if others:
            p = self._with_events(others)
            t0, tf = (p.t0, p.tf) if t_span is None else map(float, t_span)
            p = p._replace(fun=fun, t0=t0, tf=tf, y0=np.array(y0, float), args=args)
            result["event_sensitivity"] = at_events(p, whole, self._directions)
        return result

    def ready(self, problem):
        p = problem
        if p.method.series or p.method.second_order:
            return []
        found = directions_of(self._sensitivity, p.fun, p.y0, p.args)
        self._directions = [d._replace(value=np.zeros(d.value.shape)) for d in found]
        self.problem, longer = stripped(p), with_sensitivities(p, found)
        check = None
        self._m = sum([d.size for d in found])
        if p.method.error_order:
            check = self._take_sizes
            self._tolerances = Tolerances(p, self._m)
        return self._ready(longer, run_of, stripped(longer), check)

    def present(self, ready, fun, args, others):
        p = super().present(ready, fun, args, others)
        longer = with_sensitivities(p, directions_of(self._sensitivity, fun, p.y0, args))
        return longer._replace(events=p.events)  # whose functions are those of the longer state

    def _take_sizes(self, ready, y0, args, events):
        """Take the tolerances of the sensitivities, which depend on values above 1."""
        sizes = []
        try:
            for d in self._directions:
                value = y0 if d.position == 0 else args[d.position - 1]
                values = value if d.value.ndim else (value,)
                if value.__class__ is np.ndarray:
                    values = value.ravel().tolist()
                sizes += [1.0 if abs(v) <= 1.0 else abs(v) for v in map(float, values)]
        except (TypeError, ValueError, OverflowError):
            return False
        if sizes != ready.sizes:
            if len(sizes) != self._m:
                return False
            ready.take_atol(self._tolerances.atol(np.array(sizes)))
            ready.sizes = sizes
        return True


def stripped(problem):
    """A problem without the values of one call, which must not be kept; `y0` keeps its size."""
    p = problem
    fun = None
    if p.mode.sensitivities:
        fun = p.fun._replace(fun=None)
    return p._replace(
        fun=fun, args=(), y0=np.full(len(p.y0), np.abs(p.y0).max(initial=0.0)),
        t_eval=None if p.t_eval is None else p.t_eval.copy(),
        events=bare(p.events),
    )  # fmt: skip


def _functions(problem):
    """The functions of the events of a problem."""
    return [event.function for event in problem.events or ()]


def _sizes(problem):
    """The least and the largest size of a state for which the order of the series is unchanged."""
    p = problem

    def order(size):
        return order_for(p.rtol, p.atol, np.array([size]))

    size = np.abs(p.y0).max() or 1.0
    least = most = size
    while least > SMALLEST and order(least / 2) == order(size):
        least /= 2
    while most < LARGEST and order(2 * most) == order(size):
        most *= 2
    return least, most
