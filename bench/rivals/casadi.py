"""CVODES of SUNDIALS through CasADi, which has its sensitivity equations exactly."""

import functools

import casadi
import numpy as np

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
