"""Kepler orbits for long: microseconds an orbit, and what became of the energy, beside others."""

import functools
import math
import time

import numpy as np

import fastdyn
from fastdyn.drift.phase import phase
from fastdyn.planets import Planets
from fastdyn.systems import SYSTEMS

from .. import rivals

# Steps an orbit by eccentricity: as few as keep the truncation below rounding.
GAUSS16 = {0.0: 12, 0.3: 20, 0.6: 56, 0.9: 300}
TRANSFORMED = {0.6: 24, 0.9: 30, 0.99: 100}  # by the clock dt = r ds
SPLITTINGS = {"BlanesMoan6": 91, "VelocityVerlet": rivals.LEAPFROG_STEPS}
EXACT = 10  # steps an orbit of a method whose exact part the orbit is
GRAZING = 1.0 - 1e-6  # a comet's: the speed at its slowest is a millionth of that at its fastest
LOOKS = 1000  # of each run
EPS = 2.3e-16


def rows(quick):
    """Time an orbit, and the largest relative energy error up to 10^2, 10^3, ... orbits."""
    for e in (0.0, 0.3, 0.6, 0.9, 0.99, GRAZING):
        orbits = 1000 if quick or e == GRAZING else 10_000 if e == 0.99 else 100_000
        orbit = SYSTEMS["satellite"](V=math.sqrt(1.0 + e))
        runs = ours(orbit, e, orbits)
        for name, make in rivals.orbits(orbit).items():
            runs[name] = _looked(orbit, orbits, make())
        first = next(iter(runs.values()))[0]
        for name, (seconds, errors, off) in runs.items():
            found = {f"energy_1e{k}": None for k in range(2, 6)}
            for k in range(2, 6):
                if 10**k <= orbits:
                    found[f"energy_1e{k}"] = float(errors[: 10**k * LOOKS // orbits].max())
            yield {
                "e": e,
                "solver": name,
                "us_an_orbit": seconds / orbits * 1e6,
                **found,
                "phase": off,
                "of_first": seconds / first,
            }


def ours(orbit, e, orbits):
    """{name: (seconds, largest energy errors, phase)} of fastdyn's methods that suit e."""
    atol = EPS * (1.0 - e) if e == GRAZING else EPS
    runs = {"fastdyn Taylor, rtol 2.3e-16": studied(orbit, orbits, "Taylor", rtol=EPS, atol=atol)}
    if e in GAUSS16:
        for method in ("GaussNystrom16", "Gauss16"):
            runs[f"fastdyn {method}"] = by_steps(orbit, orbits, method, GAUSS16[e])
    if e in TRANSFORMED:
        runs["fastdyn Gauss16, dt = r ds"] = transformed(orbit, TRANSFORMED[e], orbits)
    if e < 0.9:
        for method, steps in SPLITTINGS.items():
            runs[f"fastdyn {method}"] = by_steps(orbit, orbits, method, steps)
    if e != GRAZING:
        runs[f"fastdyn WisdomHolman, {EXACT} steps"] = exactly(orbit, orbits)
    return runs


def by_steps(orbit, orbits, method, steps):
    """A method with so many equal steps an orbit."""
    return studied(orbit, orbits, method, steps_per_period=steps, every=steps, compile="inlined")


def studied(orbit, orbits, method, **options):
    """By `energy_drift`, a look an orbit or a step; the second of two runs."""
    for periods in (LOOKS, orbits):
        study = fastdyn.energy_drift(orbit, method, periods=periods, samples=LOOKS, **options)
    return study.seconds, _largest(study), float(abs(study.phase[-1]))


def exactly(orbit, orbits):
    """WisdomHolman, for which two bodies are no approximation; the second of two runs."""
    star = Planets(
        [orbit.GM, 0.0], [[0, 0, 0], [orbit.R, 0, 0]], [[0, 0, 0], [0, orbit.V, 0]]
    )  # fmt: skip
    for periods in (LOOKS, orbits):
        times = np.linspace(0.0, periods * orbit.period, LOOKS + 1)
        begun = time.perf_counter()
        run = star.solve((0.0, times[-1]), step=orbit.period / EXACT, t_eval=times)
        seconds = time.perf_counter() - begun
    w = run.y.reshape(2, 2, 3, -1)[:, 1, :2].reshape(4, -1)
    changes = energy(times, w, orbit.GM) / energy(0.0, w[:, 0], orbit.GM) - 1.0
    return seconds, np.abs(changes[1:]), _phase(orbit, times[-1], w[:, -1])


def _largest(study):
    """The largest change of the energy in each bin."""
    energy = study.drifts["energy"]
    return np.maximum(abs(energy.low), abs(energy.high))


def distance(t, w, GM):
    """The density of time for an eccentric orbit."""
    return math.sqrt(w[0] * w[0] + w[1] * w[1])


def energy(t, w, GM):
    """Of [x, y, vx, vy, t]."""
    return 0.5 * (w[2] * w[2] + w[3] * w[3]) - GM / np.sqrt(w[0] * w[0] + w[1] * w[1])


def transformed(orbit, steps, orbits):
    """Gauss16 in the time s with dt = r ds; an orbit takes 2 pi sqrt(a / GM) of it."""
    step = 2.0 * math.pi * math.sqrt(orbit.semi_major_axis / orbit.GM) / steps
    fun = fastdyn.solve.time_transformed(orbit.rhs, distance)
    for periods in (LOOKS, orbits):
        study = fastdyn.energy_drift(
            fun, "Gauss16", step=step, n_steps=steps * periods, samples=LOOKS, every=steps,
            y0=[*orbit.initial_state(), 0.0], args=orbit.args, invariants={"energy": energy},
            compile="inlined",
        )  # fmt: skip
    return study.seconds, _largest(study), _phase(orbit, study.y[4, -1], study.y[:4, -1])


def _phase(orbit, t, y):
    """How far in time a state is from where it ought to be at t."""
    rate = functools.partial(_rate, orbit)
    return float(
        abs(phase(orbit.exact, rate, np.array([t]), np.array(y)[:, None], orbit.period)[0])
    )


def _rate(orbit, t, y):
    return orbit.rhs(t, y, *orbit.args)


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
    return seconds, abs(energy / start - 1.0), _phase(orbit, times[-1], y[:, -1])
