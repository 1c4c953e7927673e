"""From the arguments of `odeint` to a Problem of LSODA, whose steps pass the end."""

import math

import numpy as np

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.kernels.methods import METHODS
from fastdyn.problem import lsoda
from fastdyn.problem.step_options import LATEST, NO_SEGMENTS
from fastdyn.problem.validate import Problem

from .order import as_jacobian, time_first

TOLERANCE = 1.49012e-8
MOST_STEPS = 500  # from one time of output to the next


def problem_of(functions, y0, t0, times, args, tolerances, limits, orders, band):
    """The Problem of `functions`, (func, Dfun, tfirst, col_deriv), with outputs at `times`.

    `limits` are h0, hmax, hmin and mxstep; 0 stands for SciPy's value.
    """
    func, dfun, tfirst, col_deriv = functions
    h0, hmax, hmin, mxstep = [_limit(*each) for each in zip(LIMITS, limits, strict=True)]
    rtol, atol = tolerances
    problem = Problem(
        fun=time_first(func, tfirst), t0=t0, tf=_time(times[-1]), y0=y0,
        method=METHODS[lsoda.NAME], t_eval=times, dense_output=False, events=None,
        args=args, mode=DERIVATIVE, rtol=rtol, atol=atol, h_max=hmax or math.inf, h=float(h0),
        segments=NO_SEGMENTS, project=None, differences=dfun is None, h_least=float(hmin),
        band=lsoda.NO_BAND if band is None else band, orders=orders,
        limit=math.inf, most_between=int(mxstep) or MOST_STEPS,
        ends_at_switches=False,
    )  # fmt: skip
    if dfun is None:
        return problem
    n = len(y0)
    jac = as_jacobian(dfun, tfirst, col_deriv, (n, n) if band is None else (sum(band) + 1, n))
    return problem._replace(jac=jac if band is None else lsoda.unpacked(jac, band, problem))


LIMITS = "h0", "hmax", "hmin", "mxstep"


def _limit(name, value):
    """A step size or a number of steps, without the sign of a step."""
    if name == "h0":
        return abs(value)
    if not value >= 0:
        raise ValueError(f"`{name}` must not be negative; got {value}.")
    return value


def tolerance(name, given, n):
    """A tolerance, by default SciPy's, as a float or an array of n numbers."""
    if given is None:
        return TOLERANCE
    value = np.asarray(given, dtype=float)
    if value.ndim > 1 or (value.ndim == 1 and len(value) != n):
        raise ValueError(
            "Tolerances must be an array of the same length as the number of equations or a "
            f"scalar; `{name}` has shape {value.shape}, and `y0` has {n} components."
        )
    if not (value >= 0).all():
        raise ValueError(f"`{name}` must not be negative or NaN; got {given}.")
    return value if value.ndim else float(value)


def _time(t):
    """A time within the times that kernels take."""
    return math.copysign(min(abs(float(t)), LATEST), t)


def highest_orders(*given):
    """The highest orders of the two families, at most those of the formulas; 0: those."""
    found = []
    for name, order, highest in zip(("mxordn", "mxords"), given, lsoda.ORDERS, strict=True):
        if order < 0:
            raise ValueError(f"Incorrect value for {name}: {order}.")
        found.append(min(order, highest) if order else highest)
    return tuple(found)
