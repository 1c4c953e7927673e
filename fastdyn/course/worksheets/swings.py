"""Exercises on what swings: suspension, building, pendulums, cable."""

import math

import numpy as np

from fastdyn.course.tolerances import TIGHT
from fastdyn.systems.building import Building
from fastdyn.systems.cable import Cable
from fastdyn.systems.pendulum import Pendulum
from fastdyn.systems.pendulum_xy import PendulumXY
from fastdyn.systems.suspension import Suspension

from .exercise import Answer, Exercise, close


def measured_period(run, n=1):
    """Time between passages of an event, n of them a period."""
    times = run.t_events[0]
    return n * (times[-1] - times[0]) / (len(times) - 1)


def _heavier():
    light = Suspension()
    heavy = Suspension(m=4.0 * light.m, k=light.k)
    runs = [one.solve((0.0, 20.0), **TIGHT, events="turning") for one in (light, heavy)]
    ratio = measured_period(runs[1]) / measured_period(runs[0])
    sag = heavy.static_deflection / light.static_deflection
    return Answer(
        f"The period becomes {ratio:.4g} times as long, the static deflection {sag:.4g} times as "
        "large: the period is 2 pi sqrt(deflection / g).",
        close(ratio, 2.0) and close(sag, 4.0),
    )


def _at_rest():
    still = Suspension(x0=Suspension().equilibrium)
    moved = np.ptp(still.solve(**TIGHT).y[0])
    return Answer(
        f"Released at its equilibrium of {still.x0:.4g} m the vehicle stays there, to a nanometre.",
        bool(moved <= 1e-9),
    )


def _stiffer():
    found = []
    for k in (100.0, 200.0):
        omega = np.linspace(5.0, 15.0, 2001)
        many = Building(k=k).ensemble(omega=omega, reduce=("max", "min"))
        found.append(omega[np.argmax((many.reduced["max"] - many.reduced["min"])[:, 1])])
    return Answer(
        f"The lower resonance moves from {found[0]:.3g} to {found[1]:.4g} rad/s, by "
        f"{found[1] / found[0]:.3g}: frequencies go as the root of the stiffness.",
        close(found[1] / found[0], math.sqrt(2.0), 1e-2),
    )


def _fast_ground():
    moves = []
    for omega in (9.0, 60.0):
        run = Building(omega=omega).solve(rtol=1e-8, atol=1e-10, dense_output=True)
        moves.append(0.5 * np.ptp(run.sol(np.linspace(0.0, 20.0, 8001))[1]))
    return Answer(
        f"The upper floor moves by {moves[0]:.2g} m at 9 rad/s and by {moves[1]:.2g} m at 60 "
        "rad/s, less than the ground's 0.1 m: the building is too lazy to follow.",
        bool(moves[1] < 0.1 < moves[0]),
    )


def _long_swing():
    V0 = 2.0 * math.sqrt(9.81) * math.sin(0.25 * math.pi)
    run = Pendulum(V0=V0).solve(**TIGHT, events="bottom")
    longer = measured_period(run, 2) / (2.0 * math.pi / math.sqrt(9.81)) - 1.0
    return Answer(
        f"At an amplitude of 90° the period is longer than that of small swings by "
        f"{100 * longer:.3g} %; A²/16 says {100 * (0.5 * math.pi) ** 2 / 16:.3g} %.",
        close(longer, 0.180340599, 1e-6),  # 2 K(1/2) / pi - 1
    )


def _around():
    least = math.sqrt(5.0 * 9.81)
    tensions = []
    for V0 in (0.999 * least, 1.001 * least):
        tensions.append(Pendulum(V0=V0).solve((0.0, 5.0), **TIGHT, events="slack").status)
    return Answer(
        f"V0 = sqrt(5 g l) = {least:.4g} m/s: a thousandth below it the cable goes slack, a "
        "thousandth above it does not.",
        tensions == [1, 0],
    )


def _impact():
    V0 = math.sqrt(3.0 * 9.81)
    cable = Cable(V0=V0)
    run = cable.solve((0.0, 3.0), **TIGHT)
    energy = run.quantities()["energy"]
    lost = 1.0 - energy[-1] / energy[0]
    _, begin, end = run.phases[1]
    a = cable.slack_angle
    x = math.sin(a)
    y = math.cos(a)
    v = math.sqrt(-9.81 * math.cos(a))
    fall = 9.81 * (end - begin)
    vx, vy = v * math.cos(a), fall - v * math.sin(a)  # a parabola from the slack to the impact
    x = x + vx * (end - begin)
    y = y + (vy - 0.5 * fall) * (end - begin)
    outwards = (x * vx + y * vy) / math.hypot(x, y)
    where = math.degrees(cable.taut_angle)
    return Answer(
        f"It hits the end of its cable {where:.3g}° from the bottom and loses {100 * lost:.3g} % "
        "of its energy, all that was in the velocity along the cable.",
        close(lost, (outwards / V0) ** 2) and close(math.degrees(math.atan2(x, y)), where),
    )


def _drift():
    off = []
    for rtol in (1e-4, 1e-6, 1e-8):
        run = PendulumXY(V0=4.0).solve(rtol=rtol, atol=1e-3 * rtol)
        off.append(np.abs(run.residuals()["circle"]).max())
    held = PendulumXY(V0=4.0).solve(project=True).residuals()["circle"]
    return Answer(
        f"It leaves the circle by {off[0]:.1e} m, {off[1]:.1e} m and {off[2]:.1e} m at rtol 1e-4, "
        f"1e-6, 1e-8; with --project by less than {1e-15:.0e} m at any of them.",
        bool(off[0] > 10 * off[1] > 100 * off[2] and np.abs(held).max() < 1e-15),
    )


def _two_pendulums():
    by_angle = Pendulum(V0=4.0).solve(method="DOP853", rtol=1e-11, atol=1e-12)
    in_plane = PendulumXY(V0=4.0).solve(method="DOP853", rtol=1e-11, atol=1e-12, project=True)
    angle = by_angle.y[0, -1]
    x, y = in_plane.y[:2, -1]
    off = math.hypot(x - math.sin(angle), y - math.cos(angle))
    return Answer(
        "By the angle and by x and y it is in the same place after 20 s, to a hundred-millionth "
        "of its length: the constraint is the same equation in other words.",
        off < 1e-8,
    )


EXERCISES = {
    "suspension": [
        Exercise("Make the vehicle four times as heavy. What becomes of period and deflection?",
                 "run suspension --m 1000 --t-end 20", _heavier),
        Exercise("Release the vehicle at its equilibrium. What happens?",
                 f"run suspension --x0 {Suspension().equilibrium:.12g}", _at_rest),
    ],
    "building": [
        Exercise("Double the stiffness of the walls. Where is the lower resonance?",
                 "sweep building --k 200 --omega 5:15:2001 --reduce max", _stiffer),
        Exercise("Shake the ground at 60 rad/s, far above both resonances. How far does the upper "
                 "floor rise and sink?",
                 "sweep building --omega 9,60 --reduce max min", _fast_ground),
    ],
    "pendulum": [
        Exercise("Let it swing to 90°. By how much is the period longer than that of small swings?",
                 "run pendulum --V0 4.42944691806", _long_swing),
        Exercise("How fast must it be pushed to go around on a cable that never goes slack?",
                 "run pendulum --V0 7.01 --events slack", _around),
    ],
    "cable": [
        Exercise("Launched with V0² = 3 g l: where is the cable taut again, and what does the "
                 "impact cost?", "run cable --V0 5.42494239601 --t-end 3", _impact),
    ],
    "pendulum_xy": [
        Exercise("V0 = 4 m/s. How far does it leave the circle in 20 s at rtol 1e-4, 1e-6, 1e-8?",
                 "run pendulum_xy --V0 4 --rtol 1e-4 --atol 1e-7", _drift),
        Exercise("Compare with the pendulum by its angle. Are they in one place after 20 s?",
                 "run pendulum_xy --V0 4 --project --rtol 1e-11 --atol 1e-12", _two_pendulums),
    ],
}  # fmt: skip
