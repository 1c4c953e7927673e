"""Exercises on what goes round: rod, satellite, and the car, which may skid here."""

import itertools
import math

import numpy as np

from fastdyn.course.tolerances import TIGHT
from fastdyn.solve.ivp import solve_ivp
from fastdyn.systems.rod import Rod
from fastdyn.systems.satellite import Satellite
from fastdyn.systems.vehicle import Vehicle, steady, tight

from .exercise import Answer, Exercise, close

SLIDING = 0.02  # m/s sideways, at which a wheel has most of its grip


def _faster_rod():
    slow, fast = (Rod(omega=w).solve((0.0, 4.0 / w), **TIGHT).y[0, -1] for w in (2.0, 4.0))
    return Answer(
        f"After the same angle the block is {slow / fast:.4g} times nearer to the axis: it had "
        "half the time, and r = (V/w) f(wt).",
        close(slow / fast, 2.0, 1e-5),
    )


def _rough_rod():
    rods = [Rod(mu=mu) for mu in (0.3, 3.0, 30.0)]
    rates = []
    for rod in rods:
        t_end = 8.0 / rod.growth_rate
        run = rod.solve((0.0, t_end), **TIGHT)
        rates.append(run.y[1, -1] / run.y[0, -1])
    return Answer(
        f"r grows at {rates[0]:.3g}/s, {rates[1]:.3g}/s and {rates[2]:.3g}/s in the end for mu = "
        "0.3, 3 and 30: slower, as w/(2 mu), but never not at all.",
        all(close(rate, rod.growth_rate, 1e-4) for rate, rod in zip(rates, rods, strict=True)),
    )


def _kepler():
    satellites = [Satellite(V=V) for V in (1.0, 1.1, 1.2, 1.3)]
    ratios = []
    for one in satellites:
        run = one.solve((0.0, 2.5 * one.period), **TIGHT, events="revolution")
        laps = run.t_events[0][run.t_events[0] > 0.5 * one.period]
        ratios.append((laps[-1] / len(laps)) ** 2 / one.semi_major_axis**3)
    return Answer(
        f"T²/a³ is {ratios[0]:.6g}, {ratios[1]:.6g}, {ratios[2]:.6g} and {ratios[3]:.6g} s²/m³ for "
        "V = 1, 1.1, 1.2 and 1.3 m/s: Kepler's third law, 4 pi² / GM.",
        all(close(ratio, 4.0 * math.pi**2) for ratio in ratios),
    )


def _tolerances():
    losses = []
    for rtol in (1e-3, 1e-4, 1e-5, 1e-6):
        energy = Satellite().solve(method="ode45", rtol=rtol).invariants()["energy"]
        losses.append(100.0 * (energy[0] - energy[-1]) / abs(energy[0]))
    said = ", ".join(f"{loss:.2g} %" for loss in losses)
    return Answer(
        f"ode45 loses {said} of the energy at RelTol 1e-3, 1e-4, 1e-5, 1e-6.",
        all(a > 5.0 * b for a, b in itertools.pairwise(losses)),
    )


def _tighter():
    radii = []
    for driver in (steady, tight):
        y = Vehicle(driver=driver).solve((0.0, 300.0), **TIGHT, project=True).y[:, -1]
        radii.append(math.hypot(y[3], y[4]) / abs(y[5]))
    return Answer(
        f"From {radii[0]:.4g} m to {radii[1]:.4g} m: L / tan(alpha), beside half a wheelbase.",
        close(radii[0], Vehicle().circle_radius(0.1), 1e-5)
        and close(radii[1], Vehicle().circle_radius(0.2), 1e-5),
    )


def _grip():
    run = Vehicle().solve(rtol=1e-8, atol=1e-10, dense_output=True)
    t = np.linspace(0.0, 120.0, 24001)
    along = run.system.along
    forces = [along(run.system.quantities[n], t, run.sol(t)) for n in ("front_force", "rear_force")]
    needed = np.abs(forces).max() / (0.5 * run.system.m * 9.81)
    return Answer(
        f"Each wheel carries half the weight, and the front one needs {needed:.2g} of it sideways: "
        "so much friction is enough. The drunk driver is slow.",
        bool(0.0 < needed < 0.1),
    )


def skidding(t, w, m, L, c, mu, g, alpha, P):
    """
    The car on wheels that hold sideways with friction only, as a body of its own inertia.

    A wheel that slides sideways at s is pushed back by mu m g / 2, smoothed over SLIDING. The
    moment of inertia is m L²/12, as a chassis without mass has no motion of its own once the
    wheels slide. State and signs are those of `Vehicle`.
    """
    _, _, th, vx, vy, omega = w
    s = math.sin(th)
    cs = math.cos(th)
    sf = math.sin(th + alpha)
    cf = math.cos(th + alpha)
    ca = math.cos(alpha)
    front = sf * vx + cf * vy - 0.5 * L * ca * omega
    rear = s * vx + cs * vy + 0.5 * L * omega
    hold = 0.5 * mu * m * g
    R1 = -hold * front / math.sqrt(front * front + SLIDING * SLIDING)
    R2 = -hold * rear / math.sqrt(rear * rear + SLIDING * SLIDING)
    v = math.sqrt(vx * vx + vy * vy)
    ax = (P * cs - c * v * vx + R1 * sf + R2 * s) / m
    ay = (-P * s - c * v * vy + R1 * cf + R2 * cs) / m
    return [vx, vy, omega, ax, ay, 0.5 * L * (R2 - R1 * ca) / (m * L * L / 12.0)]


def skid_circles(thrusts, mu=0.3, alpha=0.1):
    """Speed and radius of the path that the skidding car ends on, for each thrust in N."""
    car = Vehicle()
    found = []
    for P in thrusts:
        args = (car.m, car.L, car.c, mu, 9.81, alpha, P)
        run = solve_ivp(skidding, (0.0, 300.0), np.zeros(6), args=args, rtol=1e-8, atol=1e-10)
        vx, vy = run.y[3:5, -1]
        ax, ay = skidding(300.0, run.y[:, -1], *args)[3:5]
        speed = math.hypot(vx, vy)
        found.append((speed, speed**3 / abs(vx * ay - vy * ax)))
    return found


def _skid():
    rolling = Vehicle().circle_radius(0.1)
    edge = math.sqrt(0.3 * 9.81 * rolling)
    (slow, near), (fast, wide) = skid_circles((0.2, 6.0))
    return Answer(
        f"At P = 0.2 N it drives at {slow:.3g} m/s on a circle of {near:.3g} m; wheels that cannot "
        f"slip have {rolling:.3g} m. They need v²/r sideways, and have mu g: beyond "
        f"sqrt(mu g r) = {edge:.3g} m/s they cannot hold it. At P = 6 N it slides: {fast:.3g} m/s "
        f"and a radius of {wide:.3g} m.",
        close(near, rolling, 0.02) and wide > 1.2 * rolling and fast > edge,
    )


EXERCISES = {
    "rod": [
        Exercise("Turn the rod twice as fast. Where is the block after the same angle?",
                 "run rod --omega 4 --t-end 1", _faster_rod),
        Exercise("Is there a friction that holds the block? Try mu = 0.3, 3 and 30.",
                 "run rod --mu 30 --t-end 100 --method Rodas5P", _rough_rod),
    ],
    "satellite": [
        Exercise("Launch at V = 1, 1.1, 1.2, 1.3 m/s. How go period and semi-major axis together?",
                 "run satellite --V 1.2 --t-end 50 --events revolution", _kepler),
        Exercise("How much energy does ode45 lose in 100 s at RelTol 1e-3, 1e-4, 1e-5, 1e-6?",
                 "run satellite --method ode45 --rtol 1e-5", _tolerances),
    ],
    "vehicle": [
        Exercise("Hold the wheel at 0.1 rad (the driver `steady`), then at 0.2 rad (`tight`). What "
                 "circles does the car drive? The radius is speed / omega at the end.",
                 "run vehicle --driver tight --project --t-end 300", _tighter),
        Exercise("The chapter's car cannot skid. What friction does the drunk driver count on, at "
                 "g = 9.81 m/s²?", "run vehicle", _grip),
        Exercise("Let it skid: give each wheel the friction mu = 0.3 of half the weight, and no "
                 "more. Hold the wheel at 0.1 rad. What happens at P = 0.2 N, and at 6 N? (The "
                 "equations: `fastdyn.course.worksheets.turns.skidding`.)", "", _skid),
    ],
}  # fmt: skip
