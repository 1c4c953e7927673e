"""A delay equation solved again, with another history and other arguments."""

import contextlib
from typing import Any

import numpy as np

from fastdyn.compile.bind import leave_to_python, numpy_errors_are_heard, rebind
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.kernels.output.arguments import PAST_BEGINS, SHORT
from fastdyn.kernels.state.record import Y
from fastdyn.problem.events import called_between
from fastdyn.run.again import FEWEST_MISSES, MOST_MISSES
from fastdyn.run.outcome import result_of
from fastdyn.run.ready import ReadyRun
from fastdyn.run.result import Ended

from .equation import EXPLICIT, Equation, longer_function, looks_at, with_past

NUMBERS = {float, int, bool}
STATES = {list, tuple, np.ndarray}


class RepeatedEquation(Equation):
    """An Equation that solves again with other values, most of the time by a ReadyRun."""

    def __init__(self, given):
        super().__init__(given)
        self._values: Any = None  # of the parameters, if numbers, for which steps end as they do
        self._ready: Any = None
        self._seen: Any = None  # values of the parameters that suit the ReadyRun
        self._over: Any = None  # the memory of the last solve, if not that of all
        self._misses = 0  # solves in a row without the ReadyRun
        self._most = FEWEST_MISSES

    @property
    def may_come_again(self):
        """Whether `again` may solve.

        That is without actions, sensitivities, Python and matrices, and with delays of which no
        step contains its own past: such a step begins with the slope of the start.
        """
        run = self.run
        if run is None or run.follower() is not None or run.watched or self._looks & SHORT:
            return False
        if self.problem.method.name not in EXPLICIT:
            return False
        return all(bound.function is not None for bound in run.bounds)

    def again(self, fun, history, args):
        """The result with another history and other arguments; None for the long way.

        The long way is a new Equation.  The code, the layout of the memory, and, for the same
        delays, the times at which steps end are those of the solve before.  A ReadyRun makes plain
        solves.
        """
        if self._ready is not None:
            result = self._plain(fun, history, args)
            if result is not None:
                return result
            self._ready = None  # the Run will be laid out otherwise
        result = self._taken(fun, history, args)
        if result is not None:
            self._over = self.run.memory
            self._misses += 1
            if self._misses >= self._most:
                self._make_ready()
        return result

    def _taken(self, fun, history, args):
        """As `again`, without the ReadyRun."""
        run = self.run
        heard = numpy_errors_are_heard()
        if not self.may_come_again or heard or not self.history.take(history, args):
            return None
        before = self.history
        given = before.laid_out, *args
        p = self.problem
        if fun is not self.fun:
            self.fun = fun
            p = p._replace(fun=with_past(fun))
        for bound, function in zip(run.bounds, (p.fun, *self._others()), strict=True):
            if not rebind(bound, function, given):
                return None
        self.args = args
        self.problem = p = p._replace(y0=before.y0, args=given)
        try:
            with before:
                if not self._follow_delays(run.bounds[0].given, p):
                    return None
                run.problem = run.problem._replace(fun=p.fun, y0=p.y0, args=given)
                result = self._ended()
        except GaveUp as reason:
            leave_to_python(reason.bound, reason)
            return None
        self._complete(result)
        return result

    def _follow_delays(self, given, problem):
        """Let the steps end where present delays carry present jumps; False if one is not positive.

        `given` are the values of the parameters of the equations, which are read.
        """
        run = self.run
        values = [value for value in given if value.__class__ is not np.ndarray]
        plain = len(values) == len(given) - 1  # the words are an array
        plain = plain and NUMBERS.issuperset(map(type, values))
        alone = len(run.bounds) == 1  # no events, whose delays are others
        if plain and values == self._values and alone:
            return True
        known = self._delays(run)
        if not all(delay > 0.0 for delay in known.constant):
            return False
        switching = run.switching
        if known != self._known or switching is not None:
            if looks_at(problem, known) & SHORT:
                return False
            if switching is not None:  # whose times the delays carry on, too
                problem = switching.taken(problem, run.bounds)
            run.begin_with(*self._begun(run, problem, known))
            self._known = known
        elif not alone:
            run.longest = self._longest(run, known)
        self._values = values if plain else None
        return True

    def _make_ready(self):
        """Lay out a ReadyRun for plain solves, which follow no switching times."""
        run = self.run
        self._misses = 0
        self._seen = None
        self._most = min(2 * self._most, MOST_MISSES)
        if run.switching is not None or not run.is_plain():
            return
        p = run.problem
        functions = p.fun, *self._others()
        common = p._replace(fun=None, args=(), dense_output=self.dense_output)
        run.suits = self._suits
        with contextlib.suppress(Uncompilable):
            self._ready = ReadyRun(run, common, functions, p.args, self._go_on)
            self.history.begin_at(self._ready.room)

    def _others(self):
        return called_between(self.problem)

    def _plain(self, fun, history, args):
        """As `again`, by the ReadyRun; None where that does not solve."""
        before = self.history
        y0 = history
        if not before.is_constant or history.__class__ not in STATES:
            if not before.take(history, args):
                return None
            y0 = before.y0
        p = self.problem
        self.args = args
        self._over = None
        function = p.fun if fun is self.fun else longer_function(fun)
        before.words[PAST_BEGINS] = 0
        others = () if p.events is None else self._others()
        try:
            result = self._ready.go(function, y0, (before.laid_out, *args), others)
            if result is not None:
                before.check()
                self._complete(result)
        except GaveUp as reason:
            leave_to_python(reason.bound, reason)
            return None
        finally:
            before.words[PAST_BEGINS] = 1
        return result

    def _suits(self, given):
        """Whether the ReadyRun may solve with these values; other delays move the ends of steps."""
        if given == self._seen:
            return True
        run = self.run
        known = self._known
        run.bounds[0].held.take(None, (), given)
        if not self._follow_delays(given, self.problem._replace(fun=None, args=())):
            return False
        if self._known is not known:
            run.stepping()
            self._ready.problem = run.problem._replace(dense_output=self.dense_output)
        numbers_only = self._values is not None and len(run.bounds) == 1
        self._seen = given if numbers_only else None  # arrays change in place
        return True

    def _go_on(self, ready, memory, status, fun, args, events):
        """The result of a solve after its first chunk of steps, as `again.Solver.finish`."""
        run = self.run
        before = self.history
        for bound, function in zip(run.bounds, (fun, *events), strict=True):
            if not rebind(bound, function, args):  # which notes the values, delays among them
                return None
        p = ready.problem._replace(fun=fun, args=args, y0=before.y0.copy(), dense_output=True)
        run.longest = self._longest(run, self._known)
        with before:
            before.still(False)
            status = ready.go_on(p, memory, status)
            before.check()
            result = self._result(p, status)
        ready.lay()
        self._over = memory
        return result

    def end(self):
        """The Ended of the last solve, and the time and the state there."""
        run = self.run
        memory = run.memory if self._over is None else self._over
        if memory is None:
            memory = self._ready.last
        (state,) = run.plan.view(memory, "solve.state")
        return Ended.of(state), float(state["t"]), run.plan.view(memory, "solve.work")[Y].copy()

    def let_go(self):
        """Hold nothing of the user's, and no memory of the last solve."""
        run = self.run
        self.history.let_go()
        self.args = ()
        self._over = None
        if self._ready is not None:
            self._ready.forget()
        if self.fun is None:  # a ReadyRun has solved, which holds nothing else
            return
        self.fun = None
        self.problem = self.problem._replace(fun=None, args=())
        run.problem = run.problem._replace(fun=None, args=())
        run.make_room()
        run.memory = None
        run.hold_nothing()

    def _ended(self):
        run = self.run
        before = self.history
        before.still(False)
        status = run.solve(run.problem.y0)
        before.check()
        return self._result(run.problem, status)

    def _result(self, problem, status):
        result = result_of(problem._replace(dense_output=self.dense_output), status, self.run)
        self._tell_vanishing(result, problem)
        return result

    def _complete(self, result):
        result["delays"] = np.array(self._known.constant)
        result["jumps"] = self._jumps.copy()
        if self.dense_output:
            self.history.completed(result)
