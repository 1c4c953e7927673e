"""Repeated calls of `solve_ivp`: the same function, method and options, other values.

State, span, times of output, arguments, closure and outside values may change from call to call.
"""

import functools
import math
from typing import Any

import numpy as np

from fastdyn.compile.derivatives.sensitivities import decides
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.kernels.methods.taylor.accuracy import order_for
from fastdyn.problem.domains.options import forms, start_inside
from fastdyn.problem.events import called_between, of_first, with_functions, without_functions
from fastdyn.problem.options.table import OPTIONS
from fastdyn.problem.sensitivities import Tolerances, directions_of, with_sensitivities
from fastdyn.run import again, ready
from fastdyn.run.again import Solver, keyed_code
from fastdyn.run.functions.readers import has_complex
from fastdyn.run.ready import ReadyRun
from fastdyn.run.solve_problem import in_time, run_of

from .keys import COMPLEX, FUNCTION, hashable, is_known, key_of, options_of, rest_of
from .sensitivities import at_events, divided, not_met, parted

LARGEST, SMALLEST = 2.0**60, 2.0**-60  # sizes of a state


def solved(fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options):
    """The result of a call of `solve_ivp` like an earlier one; None for the long way."""
    if args is None:
        args = ()
    elif args.__class__ is list:
        args = tuple(args)
    others = ()
    rest = ()
    try:
        if options or t_eval is not None or events is not None or dense_output or vectorized:
            rest, others = rest_of(t_eval, dense_output, events, vectorized, options)
        code = fun.__code__ if fun.__class__ is FUNCTION else keyed_code(fun)
        kind = (fun.__class__, id(code), len(y0), method, len(args), *rest)
        try:
            found = again.calls.get(kind)
        except TypeError:  # lists and arrays have no hash
            kind = hashable(kind)
            found = again.calls.get(kind)
    except (AttributeError, TypeError):  # a callable without code, or values without a hash
        return None
    if args.__class__ is not tuple:
        return None
    given = fun, y0, args, others, t_span, t_eval
    result = None if found is None else found.solve(*given)
    if result is None and has_complex(y0):
        found = again.calls.get((*kind, COMPLEX))
        result = None if found is None else found.solve(*given)
    return result


def asked_before(asked, method):
    """The result of Arguments like those of an earlier call, by the same method; or None."""
    a = asked
    return solved(
        a.fun, (a.t0, a.tf), a.y0, method, a.t_eval, a.dense_output, a.events, a.vectorized, a.args,
        options_of(a),
    )  # fmt: skip


def note(asked, method, problem):
    """After the solve of Arguments the long way, prepare for more calls of the kind."""
    a = asked
    if not may_come_again(problem, a.options):
        return
    try:
        key, others = key_of(a, method)
        given = a.fun, *others
        if [*map(id, _functions(problem.bare or problem))] != [*map(id, given)]:
            return  # the solve calls other forms of the given functions
        found = again.kept(key, lambda: _repeated(a, problem, given), len(problem.y0))
    except (AttributeError, TypeError):
        return
    found.count(problem)


def choose(asked, kind, by, method, make):
    """After a solve of Arguments of a kind by those of other calls: solve calls alike so.

    ``make(of)`` is the Kind of calls like `asked`, where `of` is that of calls like `by`; `kind`
    and `method` are their methods, as of `by_method.kind_of`.
    """
    try:
        of = again.calls.get(key_of(by, method)[0])
        if of is not None:
            again.calls.put(key_of(asked, kind)[0], make(of))
    except (AttributeError, TypeError):
        return


def _repeated(asked, problem, functions):
    """The Repeated for calls like those of Arguments, which have these functions."""
    a = asked
    if a.sensitivity is not None:
        made = WithSensitivities(problem, a.options, a.sensitivity)
    elif a.adjoint is not None:
        made = WithAdjoint(problem, a.options, a.adjoint)
    else:
        made = (Inside if problem.bare else Repeated)(problem, a.options)
    made.codes = [keyed_code(function) for function in functions]
    return made


def may_come_again(problem, options):
    """Whether a ready run takes other spans and times of a problem with these options."""
    p = problem
    times = problem.t_eval
    known = [OPTIONS[name] for name in options if name in OPTIONS]
    if len(known) < len(options) or not math.isfinite(p.tf):
        return False
    if not all(o.methods(p.method) and is_known(o, options[o.name]) for o in known):
        return False
    if times is not None and not (times.dtype.kind in "fiu" and len(times)):
        return False
    if len(p.segments) == 1 and np.size(
        options.get("breakpoints", ())
    ):  # none is within: a warning
        return False
    if p.rtol.__class__ is not float and not np.array_equal(p.rtol, options.get("rtol")):
        return False  # raised, with a warning in each call
    if not p.method.error_order or p.atol.__class__ is float:
        return not p.method.error_order or p.atol > 0
    return bool(np.all(p.atol > 0))


class Repeated(Solver):
    """Calls of one kind."""

    make: Any = None  # in place of `outcome.results`

    def __init__(self, problem, options):
        super().__init__()
        self._options = options

    def ready(self, problem):
        p = self.problem = stripped(problem)
        return self._ready(problem, in_time, p, None)

    def _ready(self, problem, run_of, common, check):
        """A ReadyRun for a problem; `common` is the problem without the values of one call."""
        try:
            run = run_of(problem._replace(domain=None))  # which is not called once more
            if not run.is_plain() or (problem.mode.sensitivities and decides(run.bounds[0])):
                return []
            looked_at = callable(problem.jac) or problem.domain is not None
            if looked_at and run.called[0].callback is not None:
                return []  # in Python, each new `jac` is checked, and `domain` called at the start
            functions = _functions(problem)
            if problem.mode.sensitivities:
                functions[0] = problem.fun.fun
            sizes = _sizes(problem) if problem.method.series else None
            given = functions, problem.args, self.finish, check, sizes, self._options
            return [ReadyRun(run, common, *given, self.make)]
        except (GaveUp, Uncompilable):
            return []


class Inside(Repeated):
    """Calls of one kind with `domain` or `nonnegative`, whose solves call forms of the functions.

    Each call makes these forms of its own functions, and looks at its start.
    """

    def ready(self, problem):
        self._bare = stripped(problem.bare)
        return super().ready(problem)

    def solve(self, fun, y0, args, others=(), t_span: Any = None, t_eval=None):
        if not self.idle:
            return None
        try:
            start = start_inside(self._bare, others, t_span[0], y0, args)
        except (IndexError, TypeError):  # no span
            return None
        if start is None:
            return None
        fun, others = forms(self._bare, fun, others, *start)
        return super().solve(fun, y0, args, others, t_span, t_eval)


class WithAdjoint(Repeated):
    """Calls of one kind with the option `adjoint`."""

    def __init__(self, problem, options, names):
        super().__init__(problem, options)
        from .adjoint.solve import Again  # imports Numba

        self._adjoint = Again(names)
        self.make = self._adjoint.results

    def ready(self, problem):
        p = self.problem = stripped(problem)
        acts = p.events or p.schedules
        return [] if acts else self._ready(problem, self._adjoint.run_of, p, self._suits)

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
            others = others[: len(self.problem.events or ())]  # without `jac`
            own = [of_first(event, len(self.problem.y0)) for event in others]
        whole = super().solve(fun, y0, args, own, t_span, t_eval)
        if whole is None or "sensitivity" in whole:
            return whole
        found = None
        if others and not any(map(len, whole["t_events"])):
            found = not_met(len(others), len(self.problem.y0), self._directions)
        elif others:
            p = with_functions(self.problem, others)
            t0, tf = (p.t0, p.tf) if t_span is None else map(float, t_span)
            p = p._replace(fun=fun, t0=t0, tf=tf, y0=np.array(y0, float), args=args)
            found = at_events(p, whole, self._directions)
        result = parted(whole, len(self.problem.y0), self._directions)
        if others:
            result["event_sensitivity"] = found
        return result

    def ready(self, problem):
        p = problem
        if p.method.second_order or p.acts or p.schedules:
            return []
        found = directions_of(self._sensitivity, p.fun, p.y0, p.args)
        self._directions = [d._replace(value=np.zeros(d.value.shape)) for d in found]
        self.problem, longer = stripped(p)._replace(jac=None), with_sensitivities(p, found)
        check = None
        self._m = sum([d.size for d in found])
        if p.method.error_order:
            order = order_for(longer.rtol, longer.atol, longer.y0) if p.method.series else None
            check = functools.partial(self._take_sizes, order)
            self._tolerances = Tolerances(p, self._m)
        if p.events is None and not p.dense_output:
            self.make = self._divided
        return self._ready(longer, run_of, stripped(longer), check)

    def _divided(self, problem, plan, own):
        """As `outcome.results`; the plain results are those of `parted`."""
        return ready.results(problem, plan, own, divided(len(self.problem.y0), self._directions))

    def present(self, ready, fun, args, others):
        p = super().present(ready, fun, args, others)
        longer = with_sensitivities(p, directions_of(self._sensitivity, fun, p.y0, args))
        return longer._replace(events=p.events)  # whose functions are those of the longer state

    def _take_sizes(self, order, ready, y0, args, events):
        """Take the tolerances of the sensitivities, which depend on values above 1.

        False if a series of the present tolerances may have another `order`.
        """
        sizes = []
        try:
            for d in self._directions:
                value = y0 if d.position == 0 else args[d.position - 1]
                if value.__class__ is np.ndarray:
                    value = value.ravel().tolist()
                values = value if d.value.ndim else (value,)
                sizes += [1.0 if -1.0 <= v <= 1.0 else abs(float(v)) for v in values]
        except (IndexError, TypeError, ValueError, OverflowError):
            return False
        if sizes != ready.sizes:
            if len(sizes) != self._m:
                return False
            atol = self._tolerances.atol(np.array(sizes))
            ends = ready.state_sizes if order else ()  # a larger state has no lower order
            if any(order_for(self._tolerances.rtol, atol, np.array([x])) != order for x in ends):
                return False
            ready.take_atol(atol)
            ready.sizes = sizes
        return True


def stripped(problem):
    """A problem without the values of one call, which must not be kept; `y0` keeps its size."""
    p = problem
    fun = p.fun._replace(fun=None) if p.mode.sensitivities else None
    return without_functions(p)._replace(
        fun=fun, y0=np.full(len(p.y0), np.abs(p.y0).max(initial=0.0)), bare=None,
        t_eval=None if p.t_eval is None else p.t_eval.copy(),
    )  # fmt: skip


def _functions(problem):
    """The functions of a problem, in the order of those that its run calls."""
    return [problem.fun, *called_between(problem)]


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
