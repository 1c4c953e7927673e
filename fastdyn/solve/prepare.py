"""prepare: a solver for many short solves, set up once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.compile.sentences import Uncompilable, name_of
from fastdyn.plot.displayed import table
from fastdyn.problem import validate
from fastdyn.problem.arguments import checked, compiled_method, own, refuse
from fastdyn.problem.discrete import longer as with_discrete_states
from fastdyn.problem.domains.options import start_inside
from fastdyn.problem.events import called_between
from fastdyn.problem.members import Members
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.names import ARGUMENTS, refuse_unknown
from fastdyn.problem.options.table import OPTIONS
from fastdyn.problem.second_order_and_pairs import (
    check_second_order,
    mode_for,
    probe_equations,
)
from fastdyn.problem.sensitivities import check_adjoint, check_method
from fastdyn.run.again import Solver
from fastdyn.run.loop import announce
from fastdyn.run.ready import ReadyRun
from fastdyn.run.solve_problem import run_of, solve_problem
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.kinds import shown

from .discrete import PreparedWithDiscrete
from .repeated import WithAdjoint, WithSensitivities, may_come_again
from .sensitivities import extended, solve_with_sensitivities

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        Method,
        State,
        Times,
        TimeSpan,
    )


@shown_when_wrong()
@filled("prepare")
def prepare(
    fun: Function,
    t_span: TimeSpan,
    y0: State,
    method: Method = "RK45",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args | None = None,
    **options: Any,
) -> Prepared | PreparedWithDiscrete:
    """Make a solver of ``y' = fun(t, y, *args)``, to be called with other states and arguments.

    Most work of `solve_ivp` before and after the steps is done once, and the inlined kernel of this
    function is compiled at once.

    Parameters
    ----------
    fun, t_span, method, t_eval, dense_output, events
        As in `solve_ivp`; methods are fastdyn's own. A solve may have another `t_span`, and, with
        `t_eval`, as many other times.  Arrays and lists are copied, apart from those in `args`, and
        events keep the `terminal`, `direction` and `wait` that they have now.
    y0 : array_like, shape (n,)
    args : tuple, optional
        Default initial state and arguments of the solves.
    **options
        As in `solve_ivp`, except {refused}.  `compile` is "inlined"
        by default.  The solver of a problem with `discrete` takes, for each solve, `discrete`, too.

    Returns
    -------
    Prepared or PreparedWithDiscrete

    Raises
    ------
    ValueError, TypeError
        For wrong arguments.

    Examples
    --------
    >>> shot = prepare(lambda t, y, g: [y[1], -g], (0, 1), [0, 5], args=(9.81,))
    >>> shot([0, 6]).y[0, -1], shot(args=(1.62,)).y[0, -1]
    """
    refuse("prepare", options)
    refuse_unknown("a prepared solver", options, OPTIONS, ARGUMENTS)
    given: Any = own({
        "fun": fun, "t_span": t_span, "y0": y0, "method": method, "t_eval": t_eval,
        "dense_output": dense_output, "events": events, "args": args, **options,
    })  # fmt: skip
    options = {"compile": "inlined", **{name: given[name] for name in options}}
    asked = checked(
        fun, given["t_span"], given["y0"], method, given["t_eval"], dense_output, given["events"],
        False, args, options,
    )  # fmt: skip
    validate.function(fun)
    if asked.discrete is None:
        return _prepared(asked, given)
    longer, n = with_discrete_states(asked)
    return PreparedWithDiscrete(_prepared(longer, None), longer.y0, n, (_again, (given,)))


def _prepared(asked, given):
    method = compiled_method("prepare", asked, "; solve_ivp takes the rest")
    if asked.sensitivity is not None:
        check_method(asked, method)
    if asked.adjoint is not None:
        check_adjoint(asked, method)
    return Prepared(_problem(asked, method), given, asked, method)


def _problem(asked, method):
    return validate.problem(asked, method, mode_for(asked, method))


def _again(given):
    """Make a copy of a prepared solver, possibly in another process."""
    return prepare(**given)


class Prepared:
    """A solver of one problem: ``solver(y0, args, t_span, t_eval)`` returns an OdeResult.

    All four are optional.  Results do not share memory.  Several threads may call at once.
    """

    _moves = False  # whether a solve had another span or other times

    def __init__(self, problem, given, asked, method):
        self._problem = problem
        self._shape = problem.y0.shape
        self._given = given
        self._asked = asked
        self._method = method
        self._span = (problem.t0, problem.tf)
        self._fun = problem.fun
        self._args = problem.args
        self._others = called_between(problem)
        self._sensitivity = asked.sensitivity
        self._repeats = may_come_again(problem, asked.options)
        if asked.adjoint is not None:
            self._solve_anew(problem)  # raises if there are no derivatives
            self._solver: Solver = WithAdjoint(problem, asked.options, asked.adjoint)
        elif asked.sensitivity is None:
            self._solver = _Solver(problem, asked.options)
        else:
            extended(problem, asked.sensitivity)  # raises if there are no derivatives
            self._solver = WithSensitivities(problem, asked.options, asked.sensitivity)
        self._solver.prepare(problem)

    def __repr__(self):
        p = self._problem
        size = f"{len(p.y0)} component{'s' * (len(p.y0) != 1)}"
        return f"<Prepared: {p.method.name}, t = {p.t0:g} to {p.tf:g}, {size}>"

    def _repr_html_(self):
        p = self._problem
        accuracy = {"rtol": p.rtol, "atol": p.atol} if p.method.error_order else {"step": p.h}
        about = {"y0": p.y0, "args": p.args, **accuracy}
        return table("Prepared", [
            ("function", name_of(p.fun)), ("method", p.method.name),
            ("t", f"{p.t0:g} to {p.tf:g}"),
            *((name, shown(value)) for name, value in about.items()),
        ])  # fmt: skip

    def __reduce__(self):
        """Pickle the arguments of `prepare`: a copy is prepared anew."""
        return _again, (self._given,)

    def __call__(self, y0=None, args=None, t_span=None, t_eval=None):
        """Solve from `y0` with `args`; the defaults are those of `prepare`.

        Outside values of the functions are read anew, as in `solve_ivp`.

        Parameters
        ----------
        y0 : array_like, shape (n,), optional
        args : tuple, optional
        t_span : pair of float, optional
            Another start and end.
        t_eval : array_like, optional
            Other times of output, as many as when the solver was prepared with `t_eval`.
        """
        if y0 is None:
            y0 = self._problem.y0
        if args is None:
            args = self._args
        elif args.__class__ is not tuple:
            args = validate.extra_arguments(args)
        if self._moves or t_span is not None or t_eval is not None:
            return self._elsewhere(y0, args, t_span, t_eval)
        result = self._solver.solve(self._fun, y0, args, self._others)
        return self._solved(y0, args) if result is None else result

    def _elsewhere(self, y0, args, t_span, t_eval):
        """Solve with another span or other times, or with the first ones again."""
        p = self._problem
        result = None
        if self._repeats and (t_eval is None or p.t_eval is not None):
            self._moves = True
            times = p.t_eval if t_eval is None else t_eval
            span = t_span
            if t_span is None:
                span = self._span
            result = self._solver.solve(self._fun, y0, args, self._others, span, times)
        if result is None:
            problem = self._at(self._checked(y0), args, t_span, t_eval)
            result = self._solve_anew(problem)
            if self._repeats:
                self._solver.count(problem)
        return result

    def _checked(self, y0):
        y0 = validate.initial_state(y0)
        if y0.shape != self._shape or y0.dtype.kind == "c":
            raise ValueError(
                f"`y0` must be {self._shape[0]} real numbers, as when it was prepared."
            )
        return y0

    def _at(self, y0, args, t_span, t_eval):
        """The Problem of a solve with another span, or other times of output."""
        p = self._problem
        if t_eval is not None and p.t_eval is None:
            raise ValueError("`t_eval` of a solve needs a solver that is prepared with `t_eval`.")
        if t_eval is not None and np.shape(t_eval) != p.t_eval.shape:
            raise ValueError(
                f"`t_eval` must have {len(p.t_eval)} times, as when it was prepared; got "
                f"{shown(t_eval)}."
            )
        t0, tf = self._span if t_span is None else validate.time_span(t_span)
        if t0 == tf:
            raise ValueError("`t_span` must not be empty.")
        times = p.t_eval if t_eval is None else t_eval
        given = {"t0": t0, "tf": tf, "y0": y0, "args": args, "t_eval": times}
        return _problem(self._asked._replace(**given), self._method)

    def _solve_anew(self, problem):
        if self._asked.adjoint is not None:
            from .adjoint.solve import solve_with_adjoint  # imports Numba

            return solve_with_adjoint(problem, self._asked.adjoint)
        if self._sensitivity is None:
            return solve_problem(problem)
        return solve_with_sensitivities(problem, self._sensitivity)

    def _solved(self, y0, args):
        """Solve the long way; a state in an unusual form needs no long way."""
        p = self._problem
        y0 = self._checked(y0)
        result = self._solver.solve(self._fun, y0, args, self._others)
        if result is None:
            problem = p._replace(y0=y0, args=args)
            if p.mode.second_order:
                check_second_order(p.fun, p.t0, y0, args, p.method.name)
            result = self._solve_anew(problem)
            self._solver.count(problem)
        return result

    @filled()
    def many(self, y0s=None, args=None):
        """Solve from many initial states, with many arguments, one after the other.

        More than a hundred solves are an ensemble on one thread, which makes thousands of short
        solves in one call of a kernel.  The results equal the results of a loop over calls, to the
        last bit.  `solve_ensemble` uses all cores, and vectors.

        Parameters
        ----------
        y0s : array_like, shape (m, n) or (n,)
            Initial states, or one state for all solves; by default the state given to `prepare`.
        {many}

        Raises
        ------
        ValueError
            If lengths do not agree, or shapes do not fit the solver.
        """
        from . import many  # imports Numba

        p = self._problem
        if self._sensitivity is not None or self._asked.adjoint is not None:
            raise ValueError("`many` computes no sensitivities: call the solver in a loop.")
        if p.dense_output:
            raise ValueError("`many` keeps no interpolants: prepare without `dense_output`.")
        members = Members(p.y0 if y0s is None else y0s, p.args if args is None else tuple(args))
        if members.complex:
            raise TypeError("`y0s` must be real numbers; solve_ivp takes complex states.")
        if not members.finite.all():
            bad = np.argmin(members.finite)
            raise ValueError(f"All components of `y0s` must be finite; row {bad} is not.")
        if members.n != self._shape[0]:
            raise ValueError(f"`y0s` must have shape (m, {self._shape[0]}), or one row of it.")
        if members.count <= many.FEW:
            return many.one_by_one(self, p, members)
        given = p.args if args is None else tuple(args)
        return many.as_ensemble(self, self._asked._replace(args=given), members)


class _Solver(Solver):
    """The Solver of a Prepared, whose problem keeps its functions."""

    def __init__(self, problem, options):
        super().__init__()
        self.problem = problem
        self._options = options

    def ready(self, problem):
        run = run_of(problem)
        if run.bounds[0].function is None:
            probe_equations(problem)
        announce(run.bounds)
        if not run.is_plain():
            return []
        functions = problem.fun, *called_between(problem)
        check = None if problem.bare is None else self._begins_inside
        given = problem.args, self.finish, check, None, self._options
        try:
            return [ReadyRun(run, problem, functions, *given)]
        except Uncompilable:
            return []

    def _begins_inside(self, ready, y0, args, events):
        bare = self.problem.bare
        t0 = bare.t0 if ready.span is None else ready.span[0]
        return start_inside(bare, called_between(bare), t0, y0, args) is not None
