"""odeint: SciPy's oldest solver of differential equations, on the compiled LSODA."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.compile.python_callback import OtherMatrix, OtherShape
from fastdyn.compile.sentences import WritesToState
from fastdyn.kernels.state.record import STATE
from fastdyn.problem.lsoda import ORDERS
from fastdyn.run.enough_memory import KeepsBands
from fastdyn.run.loop import announce
from fastdyn.run.solve_problem import in_time
from fastdyn.words import kinds
from fastdyn.words.kinds import function_of, shown
from fastdyn.words.raised import argument_names, of_solve_ivp

from . import again, few, messages, steps
from .equations import highest_orders, problem_of, tolerance
from .steps import EPS, Information, Watcher, infodict_of, too_accurate


def odeint(
    func: Any,
    y0: Any,
    t: Any,
    args: Any = (),
    Dfun: Any = None,
    col_deriv: Any = 0,
    full_output: Any = 0,
    ml: int | None = None,
    mu: int | None = None,
    rtol: Any = None,
    atol: Any = None,
    tcrit: Any = None,
    h0: float = 0.0,
    hmax: float = 0.0,
    hmin: float = 0.0,
    ixpr: Any = 0,
    mxstep: int = 0,
    mxhnil: int = 0,
    mxordn: int = 12,
    mxords: int = 5,
    printmessg: Any = 0,
    tfirst: Any = False,
) -> Any:
    """Solve y' = func(y, t) from y(t[0]) = y0, with compiled code.

    Arguments, steps, results, `infodict` and warnings are those of `scipy.integrate.odeint`, as far
    as rounding allows.  `solve_ivp` does more: events, dense output, other methods.

    Parameters
    ----------
    func : callable
        ``func(y, t, *args)``, or ``func(t, y, *args)`` with `tfirst`, returns the derivative.  Any
        Python callable; a function that does not compile runs in Python, with one CompileWarning.
    y0 : float or array_like, shape (n,)
        Initial state at ``t[0]``.
    t : array_like, shape (k,)
        Times of output, rising or falling; times may be repeated.
    args : tuple, optional
        Further arguments of `func` and `Dfun`.  A single value needs no tuple.
    Dfun : callable, optional
        The Jacobian, in the order of `func`; by default differences.
    col_deriv : bool, optional
        True if `Dfun` returns the transposed Jacobian.
    full_output : bool, optional
        Return `infodict`, too.
    ml, mu : int, optional
        Numbers of diagonals of the Jacobian below and above the main diagonal.
    rtol, atol : float or array_like, shape (n,), optional
        Tolerances, by default 1.49012e-8.
    tcrit : array_like, optional
        Times that steps do not pass on the way to a time of output before them.
    h0, hmax, hmin : float, optional
        First, longest and shortest step; 0: any.
    ixpr : bool, optional
        Print where the method changes.
    mxstep : int, optional
        Most steps from one time of output to the next; 0: 500.
    mxhnil : int, optional
        Has no effect.
    mxordn, mxords : int, optional
        Highest order of Adams' formulas, and of BDF.
    printmessg : bool, optional
        Warn of the end of a successful run, too.
    tfirst : bool, optional
        The order of the first two arguments of `func` and `Dfun`.

    Returns
    -------
    y : ndarray, shape (k, n)
        The state at each time; NaN at the times that a run did not reach.
    infodict : dict
        With `full_output`: SciPy's; 0 in the rows of times that were not reached.

    Warns
    -----
    ODEintWarning
        If the run fails: SciPy's sentence, and the reason.

    Raises
    ------
    ValueError
        For times that neither rise nor fall, and for arrays of other dimensions.
    RuntimeError
        If the result of `func` or `Dfun` has another size than `y0`.

    Notes
    -----
    Steps pass the times of output, where the state is interpolated: `func` is called beyond
    ``t[-1]``.  SciPy's code calls a function in Python until the function has had 16 000
    evaluations in all its solves; then the function is compiled.  A compiled call with one of
    `full_output`, `tcrit`, `ixpr` or tolerances below 2.2e-14 takes its steps one by one, in about
    5 us each.

    Examples
    --------
    >>> def pendulum(y, t, b, c):
    ...     theta, omega = y
    ...     return [omega, -b * omega - c * np.sin(theta)]
    >>> y = odeint(pendulum, [np.pi - 0.1, 0.0], np.linspace(0, 10, 101), args=(0.25, 5.0))
    """
    if args.__class__ is not tuple:
        args = (args,)
    given = (
        func, y0, t, args, Dfun, col_deriv, full_output, ml, mu, rtol, atol, tcrit, h0, hmax, hmin,
        ixpr, mxstep, mxhnil, mxordn, mxords, tfirst,
    )  # fmt: skip
    spent = few.spent_of(func, tfirst)
    if not (spent is None or spent.ours or printmessg):
        found = few.solved(spent, given, _is_compiled)
        if found is not None:
            return found
    key: Any = None
    usual = Dfun is None and ml is None and mu is None and tcrit is None
    if usual and (mxordn, mxords) == ORDERS and not (ixpr or printmessg):
        limits = rtol, atol, h0, hmax, hmin, mxstep, bool(tfirst), bool(full_output)
        key = again.key_of(func, y0, t, args, limits)
        found = again.solved(key, func, y0, t, args, tfirst)
        if found is not None:
            rows, told = found
            if told is None:
                return rows
            shape = rows.shape[1], ORDERS, None
            return rows, infodict_of(Information(told), *shape, messages.SAID[messages.DONE])
    function_of("(t, y)" if tfirst else "(y, t)")("func", func)
    if not tfirst and (said := of_solve_ivp(argument_names(func))):
        messages.tell(said)
    call = OdeintCall(given)
    try:
        call.solve(bool(full_output), tcrit, bool(ixpr))
    except OtherShape as error:
        said = str(error).replace("`fun`", "`func`").replace("`jac`", "`Dfun`")
        raise RuntimeError(said) from error
    except (KeepsBands, WritesToState):
        from scipy.integrate import odeint as scipys

        return scipys(*given[:-1], printmessg, tfirst)
    messages.warn(call.istate, call.because, printmessg, 2)
    if key is not None and call.istate == messages.DONE:
        again.note(key, func, call.problem)
    if not full_output:
        return call.rows
    return call.rows, infodict_of(call.information, *call.shape(), messages.SAID[call.istate])


NAMES = (*inspect.signature(odeint).parameters,)
NAMES = tuple([name for name in NAMES if name != "printmessg"])
NEEDED = ("y0", "t")
KINDS = {
    **dict.fromkeys(("y0", "rtol", "atol", "tcrit"), kinds.numbers), "t": kinds.times,
    **dict.fromkeys(("ml", "mu", "h0", "hmax", "hmin", "mxstep", "mxordn", "mxords"), kinds.number),
    "Dfun": kinds.function_of("(y, t)"),
}  # fmt: skip


class OdeintCall:
    """One call of `odeint`, with its rows, and how it ended."""

    problem: Any = None
    istate = messages.NOTHING
    because = ""

    def __init__(self, given):
        for name, value in zip(NAMES, given, strict=True):
            if name in KINDS and (value is not None or name in NEEDED):
                KINDS[name](name, value)
        func, y0, t, self._args, dfun, col_deriv, _, ml, mu, rtol, atol, _, *limits = given
        h0, hmax, hmin, _, mxstep, _, mxordn, mxords, tfirst = limits
        self._functions = func, dfun, bool(tfirst), bool(col_deriv)
        self._limits = h0, hmax, hmin, mxstep
        self._band = None if ml is None and mu is None else (max(ml or 0, 0), max(mu or 0, 0))
        self._y0 = y0 = _state(y0)
        n = len(y0)
        self._tolerances = tolerance("rtol", rtol, n), tolerance("atol", atol, n)
        self._orders = highest_orders(mxordn, mxords)
        self._t = t = _times(t)
        self.rows = np.full((len(t), n), np.nan)
        later = np.flatnonzero(t != t[0]) if len(t) else t
        self._begin = int(later[0]) if len(later) else len(t)
        self.rows[: self._begin] = y0
        self.information = Information(np.zeros(max(len(t) - 1, 0), STATE))

    def shape(self):
        """The size of the state, the highest orders, and the band."""
        return len(self._y0), self._orders, self._band

    def is_possible(self):
        """Whether the state is finite, and the tolerances are more than rounding errors."""
        y0 = self._y0
        return len(y0) and np.isfinite(y0).all() and _is_possible(y0, self._tolerances)

    def problem_for(self, functions):
        """The Problem of functions (func, Dfun, tfirst, col_deriv)."""
        return problem_of(
            functions, self._y0, float(self._t[0]), self._t[self._begin :], self._args,
            self._tolerances, self._limits, self._orders, self._band,
        )  # fmt: skip

    def is_compiled(self):
        """Whether the functions have machine code, or need none; tell of one that has none."""
        if self._begin == len(self._t) or not self.is_possible():
            return True
        problem = self.problem_for(self._functions)
        run = or_in_python(lambda: in_time(problem))
        announce(run.bounds)
        return all(bound.function is not None for bound in run.bounds)

    def solve(self, full, tcrit, prints):
        """Solve, and keep the rows."""
        if self._begin == len(self._t):
            return
        if not self.is_possible():
            self.istate = messages.ILLEGAL
            self.because = (
                "`y0` must have components, which are finite, and tolerances that are more than "
                "rounding errors."
            )
            return
        functions = self._functions
        try:
            self._run(self.problem_for(functions), full, tcrit, prints)
        except OtherMatrix:  # SciPy does not look at a Jacobian that no step needs
            func, _, *orders = functions
            run = self._run(self.problem_for((func, None, *orders)), full, tcrit, prints)
            if run.view("solve.state")["n_jacobians"][0]:
                raise

    def _run(self, problem, full, tcrit, prints):
        p = problem
        begin = self._begin
        watcher = None
        if tcrit is not None or prints or np.min(p.rtol) < 100.0 * EPS:
            watcher = Watcher(p.t_eval, tcrit, prints)
            p = p._replace(callback=watcher, limit=watcher.limit())
        if full:
            p = p._replace(told=self.information.told[begin - 1 :])
        run, rows, self.istate, self.because = steps.solved(p, watcher)
        self.problem = p
        self.rows[begin : begin + len(rows)] = rows
        if full and self.istate < 0:
            tolsf = 0.0 if watcher is None else watcher.tolsf
            self.information.fail(run, begin - 1 + len(rows), self.istate, tolsf)
        return run


def _is_compiled(given):
    """Whether the function of a call has machine code, which is made, or the call is a mistake."""
    try:
        return OdeintCall(given).is_compiled()
    except (KeepsBands, WritesToState, OtherMatrix):
        return False
    except Exception:  # `odeint` has a sentence
        return True


def _is_possible(y0, tolerances):
    """Whether tolerances are positive at the start, and more than rounding errors."""
    rtol, atol = tolerances
    return bool((rtol * np.abs(y0) + atol > 0.0).all()) and not too_accurate(y0, rtol, atol)


def _state(y0):
    """The initial state, of one dimension."""
    found = np.array(y0, dtype=float)
    if found.ndim > 1:
        raise ValueError(f"Initial condition y0 must be one-dimensional; got shape {found.shape}.")
    return found.reshape(-1)


def _times(t):
    """The times of output, of one dimension, rising or falling."""
    found = np.array(t, dtype=float)
    if found.ndim != 1:
        raise ValueError(f"Output times t must be one-dimensional; got {shown(t)}.")
    gaps = np.diff(found)
    if not ((gaps >= 0).all() or (gaps <= 0).all()):
        raise ValueError(
            "The values in t must be monotonically increasing or monotonically decreasing; repeated"
            " values are allowed."
        )
    return found
