"""CVODES of SUNDIALS through CasADi, which has its sensitivity equations exactly."""

import functools

import casadi
import numpy as np
from numba import TypingError

MOST = 10**6  # steps


def gradients(given):
    """Adams' method: the adjoint equations backward, the sensitivity equations forward."""
    ways = {
        "backward": casadi.gradient,
        "forward": lambda end, by: casadi.jtimes(end, by, casadi.DM.eye(len(given.p))),
    }
    return {
        f"CVODES, {name}": functools.partial(_gradient, given, derivatives)
        for name, derivatives in ways.items()
    }


def _gradient(given, derivatives, tol):
    y, t = casadi.SX.sym("y", len(given.y0)), casadi.SX.sym("t")
    p, by = casadi.SX.sym("p", len(given.p)), casadi.MX.sym("by", len(given.p))
    rates = given.terms(t, casadi.vertsplit(y), casadi.vertsplit(p))
    dae = {"x": y, "p": p, "t": t, "ode": casadi.vertcat(*rates)}
    options = {
        "abstol": tol, "reltol": tol, "max_num_steps": MOST,
        "linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional",
    }  # fmt: skip
    run = casadi.integrator("run", "cvodes", dae, 0.0, given.end, options)
    end = casadi.DM(given.weights).T @ run(x0=casadi.DM(given.y0), p=by)["xf"]
    solve = casadi.Function("solve", [by], [derivatives(end, by)])
    return lambda: np.array(solve(given.p)).ravel()


def stiff(given):
    """CVODE's BDF without a call of Python: formulas, their exact Jacobian, sparse elimination.

    Components are measured in their floors, because the absolute tolerance is one number.
    """
    p = given.problem
    if given.mass is not None or np.iscomplexobj(p.y0):
        return {}
    n, floor = len(p.y0), np.ones(len(p.y0)) * given.floor
    scaled, t = casadi.SX.sym("y", n), casadi.SX.sym("t")
    try:
        rates = _rates(p, t, casadi.vertsplit(scaled * floor), [casadi.SX(0)] * n)
    except (TypeError, RuntimeError, TypingError):  # not in arithmetic
        return {}
    slopes = casadi.vertcat(*rates) / floor
    start = casadi.DM(np.array(p.y0) / floor)
    at_start = casadi.Function("rates", [t, scaled], [slopes])(p.t_span[0], start)
    if not np.isfinite(np.array(at_start)).all():  # functions of `math` make a symbol a NaN
        return {}
    dae = {"x": scaled, "t": t, "ode": slopes}

    def prepare(tol):
        options = {"abstol": tol, "reltol": tol, "max_num_steps": MOST, "linear_solver": "qr"}
        run = casadi.integrator("run", "cvodes", dae, *p.t_span, options)
        return lambda: np.array(run(x0=start)["xf"]).ravel() * floor

    return {"CVODE BDF, formulas, exact sparse Jacobian (CasADi)": prepare}


def _rates(problem, t, y, slopes):
    if problem.into is None:
        return problem.fun(t, y)
    problem.into(t, y, slopes)
    return slopes
