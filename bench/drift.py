"""Kepler orbits for long: microseconds an orbit, and what became of the energy, beside others."""

import math
import time

import numpy as np

import fastdyn
from fastdyn.systems import SYSTEMS

# Steps an orbit by eccentricity: as few as keep the truncation below rounding.
GAUSS16 = {0.0: 12, 0.3: 20, 0.6: 56, 0.9: 300}
TRANSFORMED = {0.6: 24, 0.9: 30, 0.99: 100}  # by the clock dt = r ds
VERLET, WHFAST = 400, 10


LOOKS = 1000  # of each run


def rows(quick):
    """Time an orbit, and the largest relative energy error up to 10^2, 10^3, ... orbits."""
    missing = set()
    for e in (0.0, 0.3, 0.6, 0.9, 0.99):
        orbits = 1000 if quick else 10_000 if e == 0.99 else 100_000
        orbit = SYSTEMS["satellite"](V=math.sqrt(1.0 + e))
        runs = []
        if e in GAUSS16:
            for method in ("GaussNystrom16", "Gauss16"):
                runs.append((f"fastdyn {method}", fastdyns(orbit, method, GAUSS16[e], orbits)))
        if e in TRANSFORMED:
            runs.append(("fastdyn Gauss16, dt = r ds", transformed(orbit, TRANSFORMED[e], orbits)))
        if e < 0.9:
            for method, steps in (("BlanesMoan6", 91), ("VelocityVerlet", VERLET)):
                runs.append((f"fastdyn {method}", fastdyns(orbit, method, steps, orbits)))
        for name, make in RIVALS.items():
            try:
                if e < 0.9 or name != "REBOUND leapfrog":
                    runs.append((name, make(orbit, orbits)))
            except ImportError:
                missing.add(name.split()[0])
        ours = runs[0][1][0]
        for name, (seconds, errors, phase) in runs:
            found = {f"energy_1e{k}": None for k in range(2, 6)}
            for k in range(2, 6):
                if 10**k <= orbits:
                    found[f"energy_1e{k}"] = float(errors[: 10**k * LOOKS // orbits].max())
            yield {
                "e": e,
                "solver": name,
                "us_an_orbit": seconds / orbits * 1e6,
                **found,
                "phase": phase,
                "of_first": seconds / ours,
            }
    for name in sorted(missing):
        print(f"skipped {name}: not installed")


def fastdyns(orbit, method, steps, orbits):
    """By `energy_drift`, a look an orbit; the second of two runs."""
    for periods in (LOOKS, orbits):
        study = fastdyn.energy_drift(
            orbit, method, steps_per_period=steps, periods=periods, samples=LOOKS, every=steps,
            tier="specialised",
        )  # fmt: skip
    return study.seconds, _largest(study), float(abs(study.phase[-1]))


def _largest(study):
    """The largest change of the energy in each bin."""
    energy = study.drifts["energy"]
    return np.maximum(abs(energy.low), abs(energy.high))


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
    for periods in (LOOKS, orbits):
        study = fastdyn.energy_drift(
            fun, "Gauss16", step=step, n_steps=steps * periods, samples=LOOKS, every=steps,
            y0=[*orbit.initial_state(), 0.0], args=orbit.args, invariants={"energy": energy},
            tier="specialised",
        )  # fmt: skip
    exact = orbit.exact(study.y[4, -1:])[:, 0]
    rate = np.array(orbit.rhs(0.0, exact, *orbit.args))
    phase = abs((study.y[:4, -1] - exact) @ rate / (rate @ rate))
    return study.seconds, _largest(study), float(phase)


def _looked(orbit, orbits, go):
    """Time ``go(t)``, which returns the state at t, over the looks."""
    times = orbit.period * np.linspace(0.0, orbits, LOOKS + 1)[1:]
    states, seconds = [], 0.0
    for t in times:
        begun = time.perf_counter()
        state = go(t)
        seconds += time.perf_counter() - begun
        states.append(state)
    y = np.array(states).T
    energy = orbit.along(orbit.invariants["energy"], times, y)
    start = orbit.invariants["energy"](0.0, orbit.initial_state(), *orbit.args)
    exact = orbit.exact(times[-1:])[:, 0]
    rate = np.array(orbit.rhs(0.0, exact, *orbit.args))
    phase = abs((y[:, -1] - exact) @ rate / (rate @ rate))
    return seconds, abs(energy / start - 1.0), float(phase)


def _rebound(orbit):
    import rebound

    sim = rebound.Simulation()
    x, y, vx, vy = orbit.initial_state()
    sim.add(m=1.0)
    sim.add(m=0.0, x=x, y=y, vx=vx, vy=vy)
    sim.N_active = 1
    return sim


def _particle(sim):
    p, star = sim.particles[1], sim.particles[0]
    return [p.x - star.x, p.y - star.y, p.vx - star.vx, p.vy - star.vy]


def ias15(orbit, orbits):
    """REBOUND's adaptive method of order 15."""
    sim = _rebound(orbit)
    sim.integrator = "ias15"

    def go(t):
        sim.integrate(t, exact_finish_time=1)
        return _particle(sim)

    return _looked(orbit, orbits, go)


def leapfrog(orbit, orbits):
    """REBOUND's leapfrog, with as many steps as velocity Verlet."""
    sim = _rebound(orbit)
    sim.integrator = "leapfrog"
    sim.dt = orbit.period / VERLET

    def go(t):
        sim.integrate(t, exact_finish_time=0)
        return _particle(sim)

    return _looked(orbit, orbits, go)


def whfast(orbit, orbits):
    """REBOUND's splitting, whose exact part the orbit is: what is left is rounding."""
    sim = _rebound(orbit)
    sim.integrator = "whfast"
    sim.integrator.safe_mode = 0
    sim.dt = orbit.period / WHFAST

    def go(t):
        sim.integrate(t, exact_finish_time=1)
        sim.dt = orbit.period / WHFAST
        return _particle(sim)

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
        return integrator.state.copy()

    return _looked(orbit, orbits, go)


RIVALS = {
    "REBOUND IAS15": ias15,
    "REBOUND leapfrog": leapfrog,
    "REBOUND WHFast": whfast,
    "heyoka high_accuracy": heyokas,
}
