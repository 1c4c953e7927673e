"""ode45 and the other solvers of MATLAB, each a function of its name."""

import numpy as np

from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .options import check_options, odeset
from .solution import Solution
from .solve import PARAMETERS, Solver, solve

SOLVERS = {
    one.name: one
    for one in (
        Solver("ode45", "ode45", refine=4),
        Solver("ode23", "ode23"),
        Solver("ode78", "DOP853", refine=8),
        Solver("ode89", "Vern9", refine=8),
        Solver("ode113", "LSODA"),
        Solver("ode15s", "BDF", implicit=True, algebraic=True),
        Solver("ode23s", "Rodas5P", implicit=True),
        Solver("ode23t", "Radau", implicit=True, algebraic=True),
        Solver("ode23tb", "Radau", implicit=True),
    )
}


@shown_when_wrong(PARAMETERS)
@filled()
def ode45(odefun, tspan, y0, options=None) -> Solution:
    """
    Solve y' = odefun(t, y) as MATLAB's ode45 does: its steps, defaults, options and output.

    Parameters
    ----------
    odefun : callable
        ``odefun(t, y)`` returns the derivative, a list or a column of n numbers. A closure passes
        further parameters.
    tspan : array_like
        Start and end; or more than two times in order, which are the times of output. The times of
        output do not change the steps.
    y0 : float or array_like, shape (n,)
        Initial state.
    options : Options or dict, optional
        A result of `odeset`, or ``[]``. By default RelTol is {rtol}, AbsTol {atol},
        MaxStep a tenth of the span, Refine 4. InitialStep is the first step to try. With MinStep
        the run ends, with a warning, if shorter steps are needed.
        Events is a function ``events(t, y)`` that returns
        value, isterminal, direction. OutputFcn is ``f(t, y, flag)``, see `OutputFunction`. Mass is
        a matrix, or a function of (t, y) or t. Options that MATLAB's ode45 does not use have no
        effect.

    Returns
    -------
    Solution
        Unpacks to ``t, y``, in rows; with Events also to ``t, y, te, ye, ie``. The attributes are
        those of MATLAB's struct ``sol``, for `deval`.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and for the option NormControl.

    Warns
    -----
    UserWarning
        If the run fails; the solution up to the failure is returned.

    Notes
    -----
    As in MATLAB, an event in the first step does not end the run. Indices (events, OutputSel) count
    from 0. The interpolant is that of RK45 (Shampine 1986), which has the order of MATLAB's
    interpolant; the two differ by less than the tolerance. The interpolants of all steps are kept.

    Examples
    --------
    >>> t, y = ode45(lambda t, y: [y[1], -y[0]], [0, 10], [1, 0], odeset('RelTol', 1e-5))
    """
    return solve(SOLVERS["ode45"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode23(odefun, tspan, y0, options=None) -> Solution:
    """
    Solve as `ode45` does, by the Bogacki-Shampine pair of order 3(2); Refine is 1 by default.

    Parameters ``odefun``, ``tspan``, ``y0`` and ``options``, result and errors are those of
    `ode45`.
    """
    return solve(SOLVERS["ode23"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode78(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode45`, at order 8, for tight tolerances; Refine is 8 unless set.

    Solved by "DOP853", the pair of Dormand and Prince of order 8: MATLAB's is Verner's of order
    8(7). Tolerances, MaxStep and output are MATLAB's, the steps are not.
    """
    return solve(SOLVERS["ode78"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode89(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode45`, at order 9, for the tightest tolerances; Refine is 8 unless set.

    Solved by "Vern9", Verner's "most efficient" pair of order 9(8), which is MATLAB's, too; the
    choice of the steps, by SciPy's rule, is not.
    """
    return solve(SOLVERS["ode89"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode113(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode45`, by a method of several steps and variable order; Refine is 1 unless set.

    Solved by "LSODA", with Adams' methods of orders 1 to 12; MATLAB's ode113 has orders 1 to 13.
    LSODA changes to stiff methods if the problem is stiff, ode113 does not.
    """
    return solve(SOLVERS["ode113"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode15s(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode45`, for stiff problems; Refine is 1 unless set.

    Solved by "BDF", which is the method of ode15s: numerical differentiation formulas of orders 1
    to 5 (L. F. Shampine and M. W. Reichelt, SIAM J. Sci. Comput. 18 (1997) 1), by SciPy's choice of
    steps. With a constant Mass that is singular, M y' = f(t, y) has algebraic equations and is
    solved by "Rodas5P". Jacobian, a matrix or a function of (t, y), and JPattern are used; without
    them the Jacobian is exact, too, if the function can be traced. BDF and MaxOrder have no
    effect.
    """
    return solve(SOLVERS["ode15s"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode23s(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode15s`, by a Rosenbrock method.

    Solved by "Rodas5P", of order 5; MATLAB's ode23s has order 2, and takes more steps for an equal
    error.
    """
    return solve(SOLVERS["ode23s"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode23t(odefun, tspan, y0, options=None) -> Solution:
    """
    As `ode15s`, for problems that are stiff in part.

    Solved by "Radau", of order 5, and "Rodas5P" for a singular Mass. MATLAB's ode23t is the
    trapezoidal rule, which damps no oscillation; Radau damps oscillations that its steps do not
    resolve.
    """
    return solve(SOLVERS["ode23t"], odefun, tspan, y0, options)


@shown_when_wrong(PARAMETERS)
def ode23tb(odefun, tspan, y0, options=None) -> Solution:
    """As `ode15s`; solved by "Radau", where MATLAB has TR-BDF2: both damp stiff components."""
    return solve(SOLVERS["ode23tb"], odefun, tspan, y0, options)


def _function_or_empty(name, value):
    if callable(value) or np.size(value):
        kinds.function(name, value)


@shown_when_wrong(odefun=_function_or_empty, tfinal=kinds.number)
def odextend(sol, odefun=None, tfinal=None, y0=None, options=None) -> Solution:
    """
    Continue a solution, as MATLAB's odextend.

    Parameters
    ----------
    sol : Solution
        A result of any solver, which also continues the solution.
    odefun : callable, optional
        The function from the end of `sol` on; by default, or with None or ``[]``, the function of
        `sol`.
    tfinal : float
        The new end, in the direction of `sol`.
    y0 : array_like, shape (n,), optional
        The state at the end of `sol` for the continuation; by default the last state of `sol`.
    options : Options or dict, optional
        Options that replace options of `sol`.

    Returns
    -------
    Solution
        From the start of `sol` to `tfinal`. If `y0` differs from the last state, the time of the
        joint occurs twice.
    """
    if not isinstance(sol, Solution):
        raise TypeError("odextend continues what `sol = ode45(...)` returned.")
    end = float(sol.x[-1])
    if tfinal is None or (float(tfinal) - end) * (end - sol.x[0]) <= 0.0:
        raise ValueError(f"`tfinal` must lie beyond {end:g}, where the solution ends.")
    call = sol.call
    fun = odefun if callable(odefun) else call.fun
    y0 = sol.y[:, -1] if y0 is None or np.size(y0) == 0 else y0
    check_options(options)
    more = odeset(call.options, {} if options is None or not len(options) else options)
    return sol.joined(solve(call.solver, fun, [end, float(tfinal)], y0, more))
