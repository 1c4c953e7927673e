"""REBOUND, for bodies that attract one another: IAS15 and Gragg-Bulirsch-Stoer."""

import functools

import numpy as np
import rebound

from .. import equations


def solvers(problem):
    """IAS15, whose `epsilon` is no tolerance, for what it is at each; BS."""
    bodies = _bodies(problem)
    if bodies is None:
        return {}
    methods = {"REBOUND IAS15": _ias15, "REBOUND BS": _bs}
    return {
        name: functools.partial(_prepare, problem, bodies, choose)
        for name, choose in methods.items()
    }


def _bodies(problem):
    """Masses, positions and velocities, softening, and how many have no mass; None for others."""
    y = np.array(problem.y0, dtype=float)
    if problem.terms is equations.satellite:
        places = np.array([[0.0, 0.0, 0.0], [*y[:2], 0.0]])
        rates = np.array([[0.0, 0.0, 0.0], [*y[2:], 0.0]])
        return np.array([problem.args[0], 0.0]), places, rates, 0.0
    if problem.terms is equations.pleiades:
        zero = np.zeros(7)
        columns = np.array([[y[:7], y[7:14], zero], [y[14:21], y[21:], zero]])
        return np.arange(1.0, 8.0), columns[0].T.copy(), columns[1].T.copy(), 0.0
    if problem.into is equations.bodies_into:
        places, rates = y.reshape(2, -1, 3)
        return np.full(len(places), 1.0 / len(places)), places, rates, equations.SOFTENING
    return None


def _ias15(sim, tol):
    sim.integrator = "ias15"
    sim.integrator.epsilon = tol


def _bs(sim, tol):
    sim.integrator = "bs"
    sim.integrator.eps_rel = sim.integrator.eps_abs = tol


def _prepare(problem, bodies, choose, tol, times=None):
    masses, places, rates, softening = bodies
    end, size = problem.t_span[1], (len(masses), 3)

    def run():
        sim = rebound.Simulation()
        for m, (x, y, z), (vx, vy, vz) in zip(masses, places, rates, strict=True):
            sim.add(m=m, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
        sim.softening = softening
        sim.N_active = np.count_nonzero(masses)
        choose(sim, tol)
        for t in (end,) if times is None else times:
            sim.integrate(t)
        q, v = np.empty(size), np.empty(size)
        sim.serialize_particle_data(xyz=q, vxvyvz=v)
        if problem.terms is equations.satellite:
            return np.r_[q[1, :2], v[1, :2]]
        if problem.terms is equations.pleiades:
            return np.r_[q[:, 0], q[:, 1], v[:, 0], v[:, 1]]
        return np.r_[q.ravel(), v.ravel()]

    return run
