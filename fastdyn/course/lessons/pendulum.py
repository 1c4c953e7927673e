"""The pendulum's lesson: swinging, whirling and what lies between (course 3.3.2, example 4)."""

import math

import numpy as np

from fastdyn import plot
from fastdyn.course.tolerances import TIGHT, tolerated
from fastdyn.plot.pendulums import small_angle
from fastdyn.systems.pendulum import Pendulum


def lesson(board):
    _regimes(board)
    _small_angle(board)
    _slack(board)


def _regimes(board):
    edge = 2.0 * math.sqrt(9.81)
    board.say(
        f"""Pushed off at V0, the pendulum swings below 2 sqrt(g l) = {edge:.4f} m/s, whirls above
        it, and exactly there climbs for ever. Exact solutions in Jacobi's functions, on a rigid
        rod. Tolerated: every step adds its rtol and atol, which grow in proportion to time, faster
        near the edge, and exponentially on it."""
    )
    runs = {}
    for V0, t_end in ((0.1, 20.0), (5.0, 20.0), (edge, 2.5), (8.0, 5.0)):
        pendulum = Pendulum(V0=V0)
        run = pendulum.solve((0.0, t_end), **TIGHT, events="bottom", dense_output=True)
        name = f"V0 = {V0:.4g} m/s, {pendulum.regime}"
        allowed = allowance(run)
        board.zero(f"{name}: angle (rad)", run.error()[0], allowed)
        energy = plot.relative_changes(run)["energy"]
        board.zero(f"{name}: energy, relative", energy, _energy_allowance(run))
        passages = run.t_events[0][1:]  # the first is the launch
        if len(passages) > 1:
            per_period = 2 if pendulum.regime == "swinging" else 1
            period = per_period * passages[-1] / len(passages)
            tolerance = per_period * allowed / (V0 / pendulum.l) / len(passages)
            board.check(f"{name}: period (s)", period, pendulum.period, tolerance)
        if V0 > 1.0:
            runs[f"V₀ = {V0:.4g} m/s: {pendulum.regime}"] = pendulum.solve(
                (0.0, 2.5), dense_output=True
            )
    board.figure("pendulum-regimes", plot.plot(runs))


def _small_angle(board):
    board.say(
        """The solution for small angles, V0/sqrt(g l) sin(w0 t), has the wrong period: the true
        one is longer by the fraction A²/16 at amplitude A. So its error grows as A³/16 w0 t, to
        first order in A², and peaks twice a period, so that the last peak is up to pi ago."""
    )
    t = np.linspace(0.0, 20.0, 4001)
    with plot.slides():
        figure, axes = small_angle(with_amplitude(60.0), t[: len(t) // 2])
        for degrees in (2.0, 10.0, 30.0):
            A = math.radians(degrees)
            pendulum = with_amplitude(degrees)
            phase = pendulum.natural_frequency * t
            error = np.abs(pendulum.small_angle(t) - pendulum.exact(t))[0]
            error = np.maximum.accumulate(error)
            axes.plot(phase, np.degrees(error), label=f"amplitude {degrees:g}°")
            axes.plot(phase, np.degrees(A**3 / 16.0 * phase), "k--", lw=1.2)
            if A**2 / 16.0 * phase[-1] < 0.25:  # later the two are out of step
                name = f"amplitude {degrees:g}°: error / (A³/16 w0 t)"
                growth = error[-1] / (A**3 / 16.0 * phase[-1])
                board.check(name, growth, 1.0, A**2 + math.pi / phase[-1])
        axes.lines[-1].set_label("A³/16 ω₀ t")
        axes.set(xscale="log", yscale="log", xlim=(1.0, phase[-1]), ylim=(1e-4, 1e2))
        axes.set(xlabel="ω₀ t (rad)", ylabel="largest error of\nthe angle so far (°)")
        turns = (1, 2, 4, 8, 16)
        axes.set_xticks([math.pi * n for n in turns], [f"{n if n > 1 else ''}π" for n in turns])
        axes.minorticks_off()
        axes.legend(loc="upper left", ncols=2)
    board.figure("pendulum-small-angle", figure)


def with_amplitude(degrees):
    """The pendulum that swings so far."""
    return Pendulum(V0=2.0 * math.sqrt(9.81) * math.sin(0.5 * math.radians(degrees)))


def _slack(board):
    pendulum = Pendulum(V0=math.sqrt(3.5 * 9.81))
    run = pendulum.solve(**TIGHT, events="slack", dense_output=True)
    board.say(
        """On a cable, tension must stay above zero. Launched with V0² between 2 g l and 5 g l the
        cable goes slack on the way up; an event stops the run there. Energy gives the angle, and
        the second integral of the motion the time."""
    )
    allowed = allowance(run)
    time = run.t_events[0][0]
    angle, omega = run.y_events[0][0]
    board.check("status: stopped by the event", run.status, 1, 0)
    board.check("angle at which the cable goes slack (rad)", angle, pendulum.slack_angle, allowed)
    board.check("time (s)", time, pendulum.slack_time, 2.0 * allowed / omega)
    rod = pendulum.solve((0.0, 2.0), dense_output=True)
    board.figure("pendulum-slack", plot.plot({"rigid rod": rod, "cable, until slack": run}))


def allowance(run, system=None):
    """
    Error of the angle that a run may show, in rad, from the tolerances TIGHT.

    `system` is the pendulum by angle, that of the run unless given.

    Each step may add its tolerance to angle and angular velocity. An error of the velocity also
    changes the period, and the angle goes on running ahead for the time that is left, half the
    run on average; on the separatrix neighbouring motions part as exp(w0 t).
    """
    system = system or run.system
    seconds = run.t[-1]
    w0 = math.sqrt(system.g / system.l)
    angle, velocity = tolerated(run, axis=1)[[0, -1]]
    if system.regime == "separatrix":
        return (angle + velocity / w0) * math.exp(w0 * seconds)
    nearby = Pendulum(V0=system.V0 * (1.0 + 1e-6))
    lengthening = abs(nearby.period / system.period - 1.0) / 1e-6
    return angle + velocity * (1.0 / w0 + 0.5 * lengthening * seconds)


def _energy_allowance(run):
    """Relative change of the energy by the same tolerances, through both terms of dE/E."""
    system = run.system
    angle, velocity = tolerated(run, axis=1)
    steepest = system.g / system.l * np.abs(np.sin(run.y[0])).max()
    launch = system.V0 / system.l
    return (launch * velocity + steepest * angle) / (0.5 * launch**2)
