"""Kepler orbits for long: microseconds an orbit, and what became of the energy, beside others."""

import math
import time

import numpy as np

import fastdyn
from fastdyn.systems import SYSTEMS

# Steps an orbit by eccentricity: as few as keep the truncation below rounding.
GAUSS16 = {0.0: 12, 0.3: 20, 0.6: 56, 0.9: 300}
TRANSFORMED = {0.6: 24, 0.9: 30, 0.99: 100}  # by the clock dt = r ds
VERLET = 400
WHFAST = 20  # as many steps for any e: a planet's motion about its star is in the method


def rows(quick):
    """Time an orbit, RMS and largest relative energy error over the whole run."""
    orbits = 100 if quick else 10_000
    missing = set()
    for e in (0.0, 0.3, 0.6, 0.9, 0.99):
        orbit = SYSTEMS["satellite"](V=math.sqrt(1.0 + e))
        runs = []
        if e in GAUSS16:
            for method in ("GaussNystrom16", "Gauss16"):
                runs.append((f"fastdyn {method}", fastdyns(orbit, method, GAUSS16[e], orbits)))
        if e in TRANSFORMED:
            runs.append(("fastdyn Gauss16, dt = r ds", transformed(orbit, TRANSFORMED[e], orbits)))
        if e < 0.9:
            runs.append(("fastdyn BlanesMoan6", fastdyns(orbit, "BlanesMoan6", 91, orbits)))
        runs.append(("fastdyn VelocityVerlet", fastdyns(orbit, "VelocityVerlet", VERLET, orbits)))
        for name, make in (
            ("REBOUND IAS15", ias15),
            ("REBOUND leapfrog", leapfrog),
            ("REBOUND WHFast", whfast),
            ("heyoka high_accuracy", heyokas),
        ):
            try:
                runs.append((name, make(orbit, orbits)))
            except ImportError:
                missing.add(name.split()[0])
        ours = runs[0][1][0]
        for name, (seconds, rms, largest, phase) in runs:
            yield {
                "e": e,
                "solver": name,
                "orbits": orbits,
                "us_an_orbit": seconds / orbits * 1e6,
                "energy_rms": rms,
                "energy_largest": largest,
                "phase": phase,
                "of_first": seconds / ours,
            }
    for name in sorted(missing):
        print(f"{name} is not installed: no rows for it")


def fastdyns(orbit, method, steps, orbits):
    """By `energy_drift`, a look an orbit; the second of two runs."""
    for _ in range(2):
        study = fastdyn.energy_drift(
            orbit, method, steps_per_period=steps, periods=orbits, samples=100, every=steps,
            tier="specialised",
        )  # fmt: skip
    energy = study.drifts["energy"]
    return study.seconds, energy.rms, energy.largest, float(abs(study.phase[-1]))


def distance(t, w, GM, R, V):
    """The density of time for an eccentric orbit."""
    return math.sqrt(w[0] * w[0] + w[1] * w[1])


def energy(t, w, GM, R, V):
    """Of [x, y, vx, vy, t]."""
    return 0.5 * (w[2] * w[2] + w[3] * w[3]) - GM / np.sqrt(w[0] * w[0] + w[1] * w[1])


def transformed(orbit, steps, orbits):
    """Gauss16 in the time s with dt = r ds; an orbit takes 2 pi sqrt(a / GM) of it."""
    step = 2.0 * math.pi * math.sqrt(orbit.semi_major_axis / orbit.GM) / steps
    fun = fastdyn.time_transformed(orbit.rhs, distance)
    for _ in range(2):
        study = fastdyn.energy_drift(
            fun, "Gauss16", step=step, n_steps=steps * orbits, samples=100, every=steps,
            y0=[*orbit.initial_state(), 0.0], args=orbit.args, invariants={"energy": energy},
            tier="specialised",
        )  # fmt: skip
    exact = orbit.exact(study.y[4, -1:])[:, 0]
    rate = np.array(orbit.rhs(0.0, exact, *orbit.args))
    phase = abs((study.y[:4, -1] - exact) @ rate / (rate @ rate))
    found = study.drifts["energy"]
    return study.seconds, found.rms, found.largest, float(phase)


def _looked(orbit, orbits, go):
    """Time ``go(t)``, which returns the time reached and the state there, over 100 looks."""
    times, states, seconds = [], [], 0.0
    for t in orbit.period * np.linspace(0.0, orbits, 101)[1:]:
        begun = time.perf_counter()
        reached, state = go(t)
        seconds += time.perf_counter() - begun
        times.append(reached)
        states.append(state)
    times, y = np.array(times), np.array(states).T
    energy = orbit.along(orbit.invariants["energy"], times, y)
    start = orbit.invariants["energy"](0.0, orbit.initial_state(), *orbit.args)
    change = energy / start - 1.0
    exact = orbit.exact(times[-1:])[:, 0]
    rate = np.array(orbit.rhs(0.0, exact, *orbit.args))
    phase = abs((y[:, -1] - exact) @ rate / (rate @ rate))
    return seconds, float(np.sqrt(np.mean(change**2))), float(np.abs(change).max()), float(phase)


def _rebound(orbit):
    import rebound

    sim = rebound.Simulation()
    x, y, vx, vy = orbit.initial_state()
    sim.add(m=1.0)
    sim.add(m=0.0, x=x, y=y, vx=vx, vy=vy)
    sim.N_active = 1
    return sim


def _reached(sim):
    p, star = sim.particles[1], sim.particles[0]
    return sim.t, [p.x - star.x, p.y - star.y, p.vx - star.vx, p.vy - star.vy]


def ias15(orbit, orbits):
    """REBOUND's adaptive method of order 15."""
    sim = _rebound(orbit)
    sim.integrator = "ias15"

    def go(t):
        sim.integrate(t, exact_finish_time=1)
        return _reached(sim)

    return _looked(orbit, orbits, go)


def leapfrog(orbit, orbits):
    """REBOUND's leapfrog, with as many steps as velocity Verlet."""
    sim = _rebound(orbit)
    sim.integrator = "leapfrog"
    sim.dt = orbit.period / VERLET

    def go(t):
        sim.integrate(t, exact_finish_time=0)
        return _reached(sim)

    return _looked(orbit, orbits, go)


def whfast(orbit, orbits):
    """REBOUND's Wisdom-Holman method: Kepler's equation solved in each step, so exact for two."""
    sim = _rebound(orbit)
    sim.integrator = "whfast"
    getattr(sim, "ri_whfast", sim.integrator).safe_mode = 0  # REBOUND 4, and later
    sim.dt = orbit.period / WHFAST

    def go(t):
        sim.integrate(t, exact_finish_time=0)
        return _reached(sim)

    return _looked(orbit, orbits, go)


def heyokas(orbit, orbits):
    """heyoka's Taylor method with compensated summation."""
    import heyoka as hy

    x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
    r3 = (x * x + y * y) ** 1.5
    equations = [(x, vx), (y, vy), (vx, -x / r3), (vy, -y / r3)]
    integrator = hy.taylor_adaptive(equations, list(orbit.initial_state()), high_accuracy=True)

    def go(t):
        integrator.propagate_until(t)
        return t, integrator.state.copy()

    return _looked(orbit, orbits, go)
