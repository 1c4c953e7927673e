"""Exercises on what flies: projectile, nanoparticle, tower, ball with drag."""

import math

import numpy as np

from fastdyn.course.tolerances import TIGHT
from fastdyn.systems.drag import Drag
from fastdyn.systems.nanoparticle import Nanoparticle
from fastdyn.systems.projectile import Projectile
from fastdyn.systems.tower import MILE_PER_HOUR, Tower

from .exercise import Answer, Exercise, close

PITCH = 90.0 * MILE_PER_HOUR
ANGLES = np.radians(np.arange(0.0, 80.0, 0.25))


def landed(system, t_end=100.0, **options):
    """A run that ends on the ground."""
    return system.solve((0.0, t_end), **TIGHT, events=["ground", "apex"], **options)


def _twice_as_fast():
    runs = [landed(Projectile(vx0=s * 10.0, vy0=s * 10.0, vz0=s * 20.0)) for s in (1.0, 2.0)]
    time, reach, height = (
        f(runs[1]) / f(runs[0])
        for f in (lambda r: r.t[-1], lambda r: r.y[0, -1], lambda r: r.y_events[1][0][2])
    )
    return Answer(
        f"The flight takes {time:.4g} times as long; range and height are {reach:.4g} and "
        f"{height:.4g} times as large: v² / g.",
        close(time, 2.0) and close(reach, 4.0) and close(height, 4.0),
    )


def _on_the_moon():
    earth, moon = (float(np.hypot(*landed(Projectile(g=g)).y[:2, -1])) for g in (9.81, 1.62))
    return Answer(
        f"The range grows from {earth:.4g} m to {moon:.4g} m, by {moon / earth:.4g} = 9.81 / 1.62.",
        close(moon / earth, 9.81 / 1.62),
    )


def _larger_particle():
    small = Nanoparticle()
    large = Nanoparticle(radius=2e-6)
    heights = []
    for particle in (small, large):
        atol = 1e-6 * particle.apex_height
        run = particle.solve((0.0, 3.0 * particle.apex_time), rtol=1e-9, atol=atol, events="apex")
        heights.append(run.y_events[0][0][0])
    ratio = heights[0] / heights[1]
    return Answer(
        f"It reaches {heights[1]:.3g} m, {ratio:.3g} times less: the height is 3kT / (2mg), and "
        "the mass grows with the cube of the radius. Dust does not dance.",
        close(ratio, 1e6, 1e-5),
    )


def _hotter_particle():
    cold, hot = (
        landed(Nanoparticle(T=T), 1.0, dense_output=True).y_events[1][0][0] for T in (293.0, 586.0)
    )
    return Answer(
        f"From {1e3 * cold:.3g} mm to {1e3 * hot:.3g} mm: twice the temperature is twice the "
        "energy, and twice the height.",
        close(hot / cold, 2.0),
    )


def _best_angles():
    found = []
    for h in (0.001, 71.0, 1000.0):
        many = Tower(h=h).ensemble((0.0, 100.0), events="ground", angle=ANGLES, **TIGHT)
        found.append(math.degrees(ANGLES[np.argmax(many.y_end[:, 0])]))
    exact = [math.degrees(Tower(h=h).best_angle) for h in (0.001, 71.0, 1000.0)]
    return Answer(
        f"{found[0]:.4g}° from the ground, {found[1]:.4g}° from 71 m, {found[2]:.4g}° from a "
        "kilometre: the longer the fall, the flatter the throw.",
        bool(np.abs(np.subtract(found, exact)).max() <= 0.25),
    )


def _baseball():
    fast = Tower(V=PITCH)
    best = Tower(V=fast.V, angle=fast.best_angle)
    ranges = [landed(one).y[0, -1] for one in (fast, best)]
    return Answer(
        f"{ranges[0]:.4g} m at 45°, and {ranges[1]:.4g} m at its best angle of "
        f"{math.degrees(fast.best_angle):.3g}°: at high speed the tower hardly counts.",
        close(ranges[0], fast.range) and close(ranges[1], fast.best_range),
    )


def _lost_to_the_air():
    ranges = [landed(Drag(c=c, vy0=0.0)).y[0, -1] for c in (0.0, 0.05, 0.5)]
    free, thin, thick = ranges
    return Answer(
        f"{free:.4g} m without air, {thin:.4g} m with c = 0.05/m, {thick:.4g} m with c = 0.5/m: "
        f"thick air takes {100 * (1 - thick / free):.3g} % of the range.",
        close(free, Projectile(vy0=0.0).range) and free > thin > thick,
    )


def _denser_air():
    speeds = [-Drag(c=c, z0=2e3).solve((0.0, 60.0), **TIGHT).y[5, -1] for c in (0.5, 2.0)]
    return Answer(
        f"From {speeds[0]:.4g} m/s to {speeds[1]:.4g} m/s: the terminal speed is sqrt(g/c).",
        close(speeds[0] / speeds[1], 2.0),
    )


EXERCISES = {
    "projectile": [
        Exercise("Throw it twice as fast. What becomes of flight time, range and height?",
                 "run projectile --vx0 20 --vy0 20 --vz0 40 --t-end 20", _twice_as_fast),
        Exercise("Throw it on the Moon, g = 1.62 m/s². How much farther does it go?",
                 "run projectile --g 1.62 --t-end 100", _on_the_moon),
    ],
    "nanoparticle": [
        Exercise("Make the radius a hundred times larger, 2 µm. How high does it jump?",
                 "run nanoparticle --radius 2e-6", _larger_particle),
        Exercise("Double the absolute temperature. What becomes of the height?",
                 "run nanoparticle --T 586 --t-end 1", _hotter_particle),
    ],
    "tower": [
        Exercise("At which angle does it go farthest: from the ground, from 71 m, from 1 km?",
                 "sweep tower --angle 0deg:80deg:321 --h 71 --t-end 100", _best_angles),
        Exercise(f"A pitcher throws at 90 mph, {PITCH:.6g} m/s. How far from the tower, and how "
                 "best?", f"run tower --V {PITCH:.6g}", _baseball),
    ],
    "drag": [
        Exercise("How far does the ball go, thrown forwards at 10 m/s and upwards at 20 m/s, for "
                 "c = 0, 0.05 and 0.5 /m?", "sweep drag --c 0,0.05,0.5 --vy0 0 --t-end 100",
                 _lost_to_the_air),
        Exercise("Make the drag four times as strong. What becomes of the terminal speed?",
                 "run drag --c 2 --z0 1000 --t-end 100", _denser_air),
    ],
}  # fmt: skip
