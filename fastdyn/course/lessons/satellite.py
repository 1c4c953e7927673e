"""The satellite's lesson: do we believe this result? (course 3.3.3, example 2)"""

from typing import Any

import numpy as np

from fastdyn import plot
from fastdyn.course.tolerances import tolerated
from fastdyn.drift.compare import Comparison
from fastdyn.drift.energy import energy_drift
from fastdyn.plot import orbits
from fastdyn.plot.studies import plot_studies
from fastdyn.systems.satellite import Satellite

# Accepted steps, r at the end, and the changes of energy and angular momentum in per cent as
# printed, for the course's run under ode45's step control: an independent implementation.
ODE45 = {
    1e-3: (169, 0.7103238831871562, "-40.39", "-15.60"),
    1e-4: (213, 0.990228304639257, "-0.980", "-0.487"),
    1e-5: (346, 0.9997323860025205, "-0.0265", "-0.0133"),
    1e-6: (468, 0.999988067261381, "-0.00119", "-0.000597"),
}


def lesson(board):
    satellite = Satellite()
    runs = {
        f"ode45, RelTol {power(rtol)}": satellite.solve(
            method="ode45", rtol=rtol, atol=1e-6, dense_output=True
        )
        for rtol in ODE45
    }
    spiral, _, repaired, _ = runs.values()
    _spiral(board, spiral)
    fallen = satellite.solve(method="RK45", rtol=1e-3, atol=1e-6, dense_output=True)
    _fall(board, satellite, spiral, fallen)
    _repair(board, satellite, list(runs.values()))
    verlet = _verlet(board, satellite, repaired)
    _side_by_side(board, satellite, spiral, fallen, repaired, verlet)
    _ellipse(board)
    _long(board)


def _spiral(board, spiral):
    board.say(
        """The course's script: ode45 with its default tolerance, RelTol 1e-3. The orbit spirals
        inward, which satellites do not do. The course draws it and prints no number; an
        independent implementation of ode45's step control gives r = 0.710 at t = 100."""
    )
    board.check("r at t = 100", _radius(spiral), 0.710, 0.5e-3)


def _fall(board, satellite, spiral, fallen):
    rates = [_first_revolution(satellite, run) for run in (spiral, fallen)]
    (n_spiral, loss_spiral), (n_fallen, loss_fallen) = rates
    sums = [satellite.period / (1.0 - (1.0 + loss) ** -1.5) for loss in (loss_spiral, loss_fallen)]
    board.say(
        f"""The same pair of formulas and the same numbers 1e-3 and 1e-6 under SciPy's step
        control: the satellite falls onto the planet and the run stops (status -1). SciPy
        averages the error over the components and aims at 0.9 of the step that the tolerance
        allows; MATLAB takes the worst component and aims at 0.8. So SciPy takes {n_fallen} steps
        for the first revolution where ode45 takes
        {n_spiral}, and binds the satellite more tightly by {100 * loss_fallen:.1f} % instead of
        {100 * loss_spiral:.1f} %. A tolerance relative to |y| then loses the same fraction in
        every revolution. The revolutions shorten in proportion to |E|^(-3/2), a geometric series:
        all of them together take about {sums[1]:.0f} s under SciPy's control and
        {sums[0]:.0f} s under ode45's. One sum is less than the 100 s of the run."""
    )
    board.check("status of RK45 at rtol 1e-3", fallen.status, -1, 0)
    board.check("time at which it stops, SciPy 1.17: 80.42 s", fallen.t[-1], 80.42, 0.5e-2)


def _repair(board, satellite, runs):
    board.say(
        """Is the tolerance good enough? Energy and angular momentum must be constant. RelTol 1e-5
        repairs the picture: the course prints changes "of order 0.01 %", and they are 0.027 % of
        the energy and 0.013 % of the momentum. Tighter is better. Beside them the numbers of an
        independent implementation: the changes may differ by half a unit of their last digit, r
        by rounding, eps for every pair of steps, since rounding early on shifts all later steps."""
    )
    for run, (rtol, (n_steps, radius, energy, momentum)) in zip(runs, ODE45.items(), strict=True):
        name = f"ode45, RelTol {power(rtol)}"
        eps = np.finfo(float).eps
        board.check(f"{name}: steps", run.n_accepted, n_steps, 0)
        board.check(f"{name}: r at t = 100", _radius(run), radius, eps * n_steps**2)
        changes = [100.0 * values[-1] for values in plot.relative_changes(run).values()]
        printed = {"energy": energy, "momentum": momentum}
        for (what, text), change in zip(printed.items(), changes, strict=True):
            board.check(f"{name}: {what} change, %", change, float(text), _half_unit(text))
    for rtol in (1e-8, 1e-11):
        run = satellite.solve(method="DOP853", rtol=rtol, atol=rtol)
        name = f"DOP853, rtol {power(rtol)}: error against the circle"
        board.zero(name, run.error(), allowance(run, rtol, rtol))


def _verlet(board, satellite, repaired):
    step = 100.0 / repaired.nfev
    verlet = satellite.solve(method="VelocityVerlet", step=step, dense_output=True)
    long = satellite.solve((0.0, 1000.0), method="VelocityVerlet", step=step)
    board.say(
        f"""Velocity Verlet with as many evaluations as ode45 at 1e-5 (step {step:.3g} s). Its
        energy error swings back and forth, of the order of (step times angular frequency)
        squared, and does not grow: ten times as long, the last revolution is no worse than the
        first, to within one step of a revolution. Angular momentum it keeps to rounding."""
    )
    energy, momentum = plot.relative_changes(long).values()
    in_first = np.abs(energy[long.t <= satellite.period]).max()
    in_last = np.abs(energy[long.t >= long.t[-1] - satellite.period]).max()
    angle = 2.0 * np.pi / satellite.period * step
    board.zero("largest relative energy error in 1000 s", energy, angle**2)
    board.check("energy error, last against first revolution", in_last / in_first, 1.0, angle)
    rounding = np.finfo(float).eps * long.n_accepted
    board.zero("relative change of momentum in 1000 s", momentum, rounding)
    return verlet


def _side_by_side(board, satellite, spiral, fallen, repaired, verlet):
    """The orbit by six solvers, in one table and in figures."""
    tighter = satellite.solve(method="RK45", rtol=1e-5, atol=1e-6)
    conserving = satellite.solve(method="EnergyConserving4", step=0.5)
    shown = {
        "ode45, RelTol 1e-3": spiral,
        "ode45, RelTol 1e-5": repaired,
        "velocity Verlet": verlet,
        "RK45 (SciPy), rtol 1e-3": fallen,
        "RK45 (SciPy), rtol 1e-5": tighter,
        "energy-conserving": conserving,
    }
    board.say(
        f"""Side by side: what a solver costs, and what it does to energy and angular momentum
        until t = 100 s. ode45 at RelTol 1e-5 is "of order 0.01 %" off, SciPy's control at the same
        rtol more. The energy-conserving method of order 4 takes steps of 0.5 s, a twelfth of a
        revolution, and keeps the energy to rounding; where the satellite is on its circle is
        another question: it is {_lag(satellite, conserving):.2f} rad off."""
    )
    board.table("solver", ("steps", "evaluations", "r at the end", "energy, %", "momentum, %"), {
        name: (run.n_accepted, run.nfev, *(f"{x:.6g}" for x in (
            _radius(run), *(100.0 * change for change in _changes(run)))))
        for name, run in shown.items()
    })  # fmt: skip
    energy, _ = _changes(conserving)
    rounding = 64.0 * np.finfo(float).eps * conserving.n_accepted**0.5
    board.check("energy-conserving: change of the energy", energy, 0.0, rounding)
    t = np.linspace(0.0, satellite.period, 361)
    board.figure("satellite-orbits", orbits.side_by_side(shown, satellite.exact(t)[:2]))
    board.figure("satellite-drift", orbits.energies(shown, zoom=0.25))


def _changes(run):
    """Relative changes of energy and angular momentum."""
    return [values[-1] for values in plot.relative_changes(run).values()]


def _lag(satellite, run):
    """Angle between the satellite and where it should be, at the end."""
    x, y = run.y[:2, -1]
    u, v = satellite.exact(run.t[-1])[:2]
    return abs(np.arctan2(x * v - y * u, x * u + y * v))


def _ellipse(board):
    satellite = Satellite(V=1.2)
    rtol = 1e-9
    run = satellite.solve(rtol=rtol, atol=rtol, events="revolution", dense_output=True)
    board.say(
        f"""Launched at V = 1.2 the satellite flies an ellipse of eccentricity
        {satellite.eccentricity:.2f}, exact by Kepler's equation; an event counts revolutions."""
    )
    allowed = allowance(run, rtol, rtol)
    board.zero("ellipse: largest error of the state", run.error(), allowed)
    laps = run.t_events[0][run.t_events[0] > 0.5 * satellite.period]
    period = laps[-1] / len(laps)
    tolerance = allowed / satellite.V / len(laps)
    board.check(f"period from {len(laps)} revolutions (s)", period, satellite.period, tolerance)
    about = f"RK45, rtol {power(rtol)}, eccentricity {satellite.eccentricity:.2f}"
    board.figure("satellite-ellipse", run.plot(label=about))


def _long(board):
    """Ten thousand revolutions, by methods that conserve energy and one that does not."""
    satellite = Satellite(V=1.14)  # eccentricity 0.3
    revolutions = 10_000
    studies = Comparison()
    choice: dict[str, Any]
    for method, choice in (
        ("RK45", {"rtol": 1e-6, "atol": 1e-9}),
        ("VelocityVerlet", {"steps_per_period": 400}),
        ("BlanesMoan6", {"steps_per_period": 91}),
        ("EnergyConserving4", {"steps_per_period": 40}),
        ("Gauss16", {"steps_per_period": 20}),
    ):
        studies[method] = energy_drift(satellite, method, periods=revolutions, **choice)
    board.say(
        f"""Most solvers lose a little energy, says the course, and some uses cannot bear it.
        {revolutions} revolutions of eccentricity 0.3: RK45 at rtol 1e-6 loses energy in
        proportion to time. Symplectic methods (velocity Verlet, Blanes and Moan's of order 6)
        swing and lose none; Gauss16 is at rounding, which grows as the square root of the number
        of steps (Brouwer's law, 2^-53 sqrt(steps)); the energy-conserving method keeps the energy,
        and not the rest."""
    )
    for method, study in studies.items():
        energy = study.drifts["energy"]
        law = 2.0**-53 * np.sqrt(study.n_steps)
        tolerance = {
            "RK45": study.n_steps * 1e-6,
            "VelocityVerlet": (2.0 * np.pi / 400) ** 2,
            "BlanesMoan6": (2.0 * np.pi / 91) ** 6,
            "EnergyConserving4": 64.0 * law,
            "Gauss16": 8.0 * law,
        }[method]
        name = f"{method}: energy, {energy.growth.verdict}"
        board.check(name, energy.rms, 0.0, tolerance)
    figure = plot_studies({
        f"{method}, {study.n_steps / revolutions:.0f} steps a revolution": study
        for method, study in studies.items()
    })  # fmt: skip
    figure.axes[0].title.set_text(f"change of energy, e = {satellite.eccentricity:.1f}")
    board.figure("satellite-long", figure)


def allowance(run, rtol, atol):
    """
    Error that a run may show: each step adds its tolerance, and the orbit magnifies it.

    An error of the energy by a fraction d makes the satellite lead or lag by 3/2 d times the
    angle covered, half of it on average over the steps; on an ellipse the near end counts more,
    by the factors of the speed there. Observed errors are some hundred times smaller, since the
    tolerance is for the fourth-order formula of the pair and the fifth-order one goes on.
    """
    system = run.system
    e = system.eccentricity
    angle = 2.0 * np.pi / system.period * run.t[-1]
    return tolerated(run, rtol, atol) * (1.0 + 0.75 * angle) * (1.0 + e) / (1.0 - e) ** 2


def power(rtol):
    """A power of ten as a program writes it, 1e-9."""
    return f"{rtol:.0e}".replace("e-0", "e-")


def _first_revolution(satellite, run):
    """Steps taken in the first revolution, and the fraction by which it raised |E|."""
    n_steps = int(np.searchsorted(run.t, satellite.period))
    energy = run.invariants()["energy"]
    return n_steps, energy[n_steps] / energy[0] - 1.0


def _radius(run):
    return float(np.hypot(run.y[0, -1], run.y[1, -1]))


def _half_unit(printed):
    """Half a unit of the last digit of a printed decimal."""
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])
