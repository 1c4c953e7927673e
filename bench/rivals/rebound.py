"""REBOUND, for bodies that attract one another: IAS15 and Gragg-Bulirsch-Stoer."""

import functools
import time

import numpy as np
import rebound

from ..problems import equations, outer_planets
from . import LEAPFROG_STEPS

WHFAST_STEPS = 10  # an orbit: what the steps leave is rounding


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
        return _satellite(problem.args[0], y)
    if problem.terms is equations.pleiades:
        zero = np.zeros(7)
        columns = np.array([[y[:7], y[7:14], zero], [y[14:21], y[21:], zero]])
        return np.arange(1.0, 8.0), columns[0].T.copy(), columns[1].T.copy(), 0.0
    if problem.into is equations.bodies_into:
        places, rates = y.reshape(2, -1, 3)
        return np.full(len(places), 1.0 / len(places)), places, rates, equations.SOFTENING
    return None


def _satellite(GM, y):
    """The planet at rest in the middle, and the satellite, which has no mass."""
    places = np.array([[0.0, 0.0, 0.0], [*y[:2], 0.0]])
    rates = np.array([[0.0, 0.0, 0.0], [*y[2:], 0.0]])
    return np.array([GM, 0.0]), places, rates, 0.0


def _simulation(masses, places, rates, softening):
    sim = rebound.Simulation()
    for m, (x, y, z), (vx, vy, vz) in zip(masses, places, rates, strict=True):
        sim.add(m=m, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    sim.softening = softening
    sim.N_active = np.count_nonzero(masses)
    return sim


def _ias15(sim, tol):
    sim.integrator = "ias15"
    sim.integrator.epsilon = tol


def _bs(sim, tol):
    sim.integrator = "bs"
    sim.integrator.eps_rel = sim.integrator.eps_abs = tol


def _prepare(problem, bodies, choose, tol, times=None):
    end, size = problem.t_span[1], bodies[1].shape

    def run():
        sim = _simulation(*bodies)
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


def orbits(orbit):
    """IAS15; WHFast, whose exact part the orbit is; the leapfrog unless the orbit is eccentric."""
    methods = {"REBOUND IAS15": _start_ias15, "REBOUND WHFast": _start_whfast}
    if orbit.eccentricity < 0.8:
        methods["REBOUND leapfrog"] = _start_leapfrog
    return {name: functools.partial(start, orbit) for name, start in methods.items()}


def _started(orbit, integrator):
    sim = _simulation(*_satellite(orbit.GM, orbit.initial_state()))
    sim.integrator = integrator
    return sim


def _state(sim):
    p, star = sim.particles[1], sim.particles[0]
    return [p.x - star.x, p.y - star.y, p.vx - star.vx, p.vy - star.vy]


def _start_ias15(orbit):
    sim = _started(orbit, "ias15")

    def go(t):
        sim.integrate(t, exact_finish_time=1)
        return _state(sim)

    return go


def _start_leapfrog(orbit):
    sim = _started(orbit, "leapfrog")
    sim.dt = orbit.period / LEAPFROG_STEPS

    def go(t):
        sim.integrate(t, exact_finish_time=0)
        return _state(sim)

    return go


def _start_whfast(orbit):
    sim = _started(orbit, "whfast")
    sim.integrator.safe_mode = 0
    sim.dt = orbit.period / WHFAST_STEPS

    def go(t):
        sim.integrate(t, exact_finish_time=1)
        sim.dt = orbit.period / WHFAST_STEPS
        return _state(sim)

    return go


PLANET_STARTS = {"REBOUND IAS15": 2, "REBOUND WHFast, corrector 17": 8}  # a minute each; 15 s
WHFAST_YEARS = 0.25  # a step: a 47th of Jupiter's period
LAZY_DAYS = (40, 100)  # in a step


def planets(times):
    """IAS15, and WHFast with its corrector of order 17: states at the steps next to the times.

    WHFast's kernel "lazy" is of order 4 in the step for errors of second order in the masses.
    """
    chosen = [*zip(PLANET_STARTS.items(), (_long_ias15, _long_whfast), strict=True)]
    for days in LAZY_DAYS:
        name = f"REBOUND WHFast, corrector 17, lazy, {days} days"
        chosen.append(((name, 2), functools.partial(_lazy, days)))
    return {name: functools.partial(_planets, times, *how, most) for (name, most), *how in chosen}


def _long_ias15(sim):
    sim.integrator = "ias15"


def _long_whfast(sim):
    sim.integrator = "whfast"
    sim.integrator.safe_mode, sim.integrator.corrector, sim.dt = 0, 17, WHFAST_YEARS


def _lazy(days, sim):
    _long_whfast(sim)
    sim.integrator.kernel, sim.dt = "lazy", days / outer_planets.YEAR


def _planets(times, choose, most):
    def go(y0):
        sim = _simulation(outer_planets.MASSES, *y0.reshape(2, -1, 3), 0.0)
        sim.G = outer_planets.G
        choose(sim)
        states = np.empty((len(times), 2, outer_planets.N, 3))
        begun = time.perf_counter()
        for t, (q, v) in zip(times, states, strict=True):
            sim.integrate(t, exact_finish_time=0)
            sim.synchronize()
            sim.serialize_particle_data(xyz=q, vxvyvz=v)
        spent = time.perf_counter() - begun
        return spent, states.reshape(len(times), -1), sim.steps_done

    return go, most
