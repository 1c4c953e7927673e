"""MATLAB's ode15i, bvp4c and bvp5c, on `solve_dae` and `solve_bvp`; odeplot."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.plot.needed import needed
from fastdyn.problem.options.table import TOLERANCES
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong, takes

from .options import chosen
from .solution import AtTimes, Refined, Request, Solution
from .solve import PARAMETERS, Solver, options_of, times_of

IMPLICIT = Solver("ode15i", "BDF")


@shown_when_wrong(PARAMETERS)
def ode15i(odefun, tspan, y0, yp0, options=None) -> Solution:
    """
    Solve f(t, y, y') = 0, as MATLAB's ode15i.

    Solved by `solve_dae`: BDF of orders 1 to 5, as in MATLAB, with other steps.  Of the options
    RelTol, AbsTol, MaxStep and InitialStep have an effect, and Events, Mass, NonNegative, OutputFcn
    and their like are refused; the Jacobians are exact, if `odefun` can
    be traced.

    Parameters
    ----------
    odefun : callable
        ``odefun(t, y, yp)`` returns the residual, n numbers.
    tspan : array_like
        As in `ode45`.
    y0, yp0 : array_like, shape (n,)
        A consistent start.
    options : Options or dict, optional

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        If `y0` and `yp0` are not consistent.
    """
    from fastdyn.dae.solve import solve_dae

    takes("odefun", odefun, "t, y, yp", PARAMETERS)
    given = options_of("ode15i", options)
    times = times_of(tspan)
    limits = {"max_step": abs(times[-1] - times[0]) / 10.0, **chosen(given)}
    result: Any = solve_dae(
        odefun, (times[0], times[-1]), np.ravel(y0), np.ravel(yp0), dense_output=True, **limits
    )
    if not result.success:
        warn(f"Failure in ode15i: {result.message}")
    output = Refined(given.Refine or 1) if len(times) == 2 else AtTimes(times, False)
    return Solution(Request(IMPLICIT, odefun, given), result, output, None)


class BoundaryInterpolant(NamedTuple):
    """The spline of `solve_bvp`, with its derivative, as `deval` asks for both."""

    spline: Any

    def __call__(self, t) -> Any:
        return self.spline(t)

    def derivative(self, t):
        """The derivative at times t."""
        return self.spline(t, 1)


class BoundarySolution(Solution):
    """
    The result of `bvp4c`, for `deval`: ``sol.x``, ``sol.y``, ``sol.yp`` and ``sol.parameters``.

    Attributes
    ----------
    yp : ndarray, shape (n, n_points)
    parameters : ndarray
        Empty without unknown parameters.
    """

    def __init__(self, name, result):
        self.solver = name
        self.interpolant = BoundaryInterpolant(result.sol)
        self.x = result.x
        self.y = result.y
        self.yp = result.yp
        self.parameters = np.empty(0) if result.p is None else result.p
        self.xe: Any = None
        self.ye: Any = None
        self.ie: Any = None
        self.stats = {"nmeshpoints": len(result.x), "maxres": float(result.rms_residuals.max())}
        self._output = lambda _: (self.x, self.y.T)


def _guess(name, value):
    """The kind of `solinit`."""
    if not isinstance(value, dict | Solution):
        kinds.refuse(name, "a result of `bvpinit`, or an earlier solution", value)


def numbers_or_function(name, value):
    """The kind of what may depend on its place."""
    if not callable(value):
        kinds.numbers(name, value)


OF_BOUNDARIES = {
    "odefun": kinds.function_of("(x, y)"), "bcfun": kinds.function_of("(ya, yb)"),
    "solinit": _guess,
}  # fmt: skip


@shown_when_wrong(x=kinds.times, yinit=numbers_or_function)
def bvpinit(x, yinit, parameters=None) -> dict:
    """The guess for `bvp4c`, as MATLAB's bvpinit.

    Parameters
    ----------
    x : array_like, shape (m,)
        The first mesh, from one end to the other.
    yinit : array_like, shape (n,), or callable
        The state, the same everywhere, or ``yinit(x)``.
    parameters : array_like, optional
        Guesses of unknown parameters.

    Returns
    -------
    dict
        With the keys x, y and parameters.
    """
    x = np.ravel(np.asarray(x, float))
    guess: Any = yinit
    columns = [_numbers(guess(each) if callable(yinit) else guess) for each in x]
    return {"x": x, "y": np.array(columns, float).T, "parameters": parameters}


@shown_when_wrong(**OF_BOUNDARIES)
def bvp4c(odefun, bcfun, solinit, options=None) -> BoundarySolution:
    """
    Solve y' = odefun(x, y) with bcfun(ya, yb) = 0, as MATLAB's bvp4c.

    Solved by `solve_bvp`, collocation of order 4 with control of the residual, as in MATLAB; the
    meshes are SciPy's.

    Parameters
    ----------
    odefun : callable
        ``odefun(x, y)`` or, with unknown parameters, ``odefun(x, y, parameters)``: n numbers.
    bcfun : callable
        ``bcfun(ya, yb)`` or ``bcfun(ya, yb, parameters)`` returns as many numbers as there are
        unknowns.
    solinit : dict
        A result of `bvpinit`, or an earlier solution.
    options : Options or dict, optional
        RelTol, by default 1e-3, has an effect.

    Returns
    -------
    BoundarySolution

    Warns
    -----
    UserWarning
        If the tolerance is not reached.
    """
    return _solve_boundary("bvp4c", odefun, bcfun, solinit, options)


@shown_when_wrong(**OF_BOUNDARIES)
def bvp5c(odefun, bcfun, solinit, options=None) -> BoundarySolution:
    """As `bvp4c`: the order is 4, where MATLAB's bvp5c has 5; the tolerance is kept."""
    return _solve_boundary("bvp5c", odefun, bcfun, solinit, options)


def _numbers(found):
    """The numbers of a list, one behind the other, as of MATLAB's ``[a; b]``.

    A single unknown parameter is an array of one number, and so is a formula with it.
    """
    if isinstance(found, list | tuple):
        return np.concatenate([np.ravel(each) for each in found])
    return np.ravel(found)


def _solve_boundary(name, odefun, bcfun, solinit, options):
    from fastdyn.solve.boundary.solve import solve_bvp

    given = options_of(name, options)
    if isinstance(solinit, Solution):
        solinit = vars(solinit)
    parameters = solinit.get("parameters")
    p = None if parameters is None or not np.size(parameters) else np.ravel(parameters)

    def fun(x, y, *p):
        columns = [_numbers(odefun(x[i], y[:, i], *p)) for i in range(len(x))]
        return np.stack(columns, axis=1)

    def bc(ya, yb, *p):
        return _numbers(bcfun(ya, yb, *p))

    tol = given.get("RelTol", TOLERANCES["rtol"])
    result: Any = solve_bvp(fun, bc, solinit["x"], solinit["y"], p, tol=tol)
    if not result.success:
        warn(f"Failure in {name}: {result.message}")
    return BoundarySolution(name, result)


class _Pictures:
    """The lines of `odeplot` while a solver runs, and the points so far."""

    axes: Any = None
    lines: Any = None
    t: Any = None
    y: Any = None


def odeplot(t, y, flag):
    """The OutputFcn that draws the components against time, as MATLAB's odeplot.

    ``odeset("OutputFcn", odeplot, "OutputSel", [0])`` draws the component of index 0.

    Parameters
    ----------
    t, y : ndarray
    flag : {"init", "", "done"}
    """
    own = _Pictures
    if flag == "init":
        own.t = [np.array(t[:1])]
        own.y = [np.array(y)[:, None]]
        own.axes = needed("matplotlib.pyplot").figure().add_subplot()
        own.axes.set_xlim(sorted(t))
        own.lines = own.axes.plot(np.full((1, len(y)), t[0]), [y], marker=".")
    elif flag == "":
        own.t.append(t)
        own.y.append(y)
        whole = np.concatenate(own.t), np.concatenate(own.y, axis=1)
        for line, values in zip(own.lines, whole[1], strict=True):
            line.set_data(whole[0], values)
        own.axes.relim()
        own.axes.autoscale_view(scalex=False)
    else:
        own.axes.figure.canvas.draw_idle()
    return False
