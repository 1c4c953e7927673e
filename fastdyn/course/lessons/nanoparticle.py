"""The nanoparticle's lesson: gravity is weak at small scales (course 3.3.2, example 1)."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn import plot, solve_langevin
from fastdyn.course.tolerances import tolerated
from fastdyn.systems.nanoparticle import BOLTZMANN, Nanoparticle

RTOL = 1e-9
ATOL = 1e-15
TRAP, GAS = 2 * math.pi * 100e3, 2 * math.pi * 10e3  # natural frequency, friction, 1/s
PATHS, RECORD, STEPS = 4096, 256, 4096  # paths for the moments; paths and samples of the spectrum
SAMPLE = 1e-6  # s, between two samples: a tenth of the period of the trap
STEP = SAMPLE / 4  # s
DEVIATIONS = 5.0  # of a mean over paths, which chance exceeds in one case of two million


def lesson(board):
    particle = Nanoparticle()
    run = particle.solve(rtol=RTOL, atol=ATOL, events="apex", dense_output=True)
    board.say(
        """A sphere of silicon, 20 nm in radius, leaves a surface upwards at its thermal speed.
        The course prints "10 mm or so". Its formula for the speed is lost; the root mean square
        sqrt(3kT/m) gives 7.9 mm, the mean speed sqrt(8kT/(pi m)) 6.7 mm (our numbers)."""
    )
    allowed = tolerated(run, RTOL, ATOL) * (1.0 + run.t[-1])
    apex = run.t_events[0][0]
    height, _ = run.y_events[0][0]
    board.check("time of the apex (s)", apex, particle.apex_time, allowed / particle.g)
    board.check("height of the apex (m)", height, particle.apex_height, allowed)
    board.check("the same in mm; printed: 10 or so", 1e3 * height, 10.0, 5.0)
    slow = dataclasses.replace(particle, T=particle.T * 8.0 / (3.0 * math.pi))
    finely: dict[str, Any] = {"rtol": RTOL, "atol": ATOL, "dense_output": True}
    mean = slow.solve((0.0, 0.1), events=["apex", "ground"], **finely)
    exact = particle.apex_height_at_mean_speed
    board.check("at the mean speed (m)", mean.y_events[0][0][0], exact, allowed)
    whole = particle.solve((0.0, 0.1), events="ground", **finely)
    shown = {"at the root mean square speed": whole, "at the mean speed": mean}
    board.figure("nanoparticle", plot.plot(shown))
    _in_a_bath(board, particle)


def _in_a_bath(board, particle):
    """The thermal motion itself: Langevin's equation of the particle in a trap, in gas."""
    noise = math.sqrt(2.0 * GAS * BOLTZMANN * particle.T / particle.mass)
    board.say(
        """Where does the thermal speed come from? A laser holds the particle, as a spring does, and
        the gas pushes and brakes it: x'' = -w^2 x - c x' + s dW/dt with s^2 = 2 c k T / m, in three
        directions. After some 1/c, the speed is the one above, whatever c is."""
    )

    def held(t, q):
        return -(TRAP**2) * q

    options: dict[str, Any] = {"friction": GAS, "sigma": noise, "step": STEP, "rng": 1}
    start = np.zeros(3), np.zeros(3)
    bath = solve_langevin(held, (0.0, 256 * SAMPLE), *start, paths=PATHS, **options).y_end
    squared = (bath[:, 3:] ** 2).sum(axis=1)
    spread = DEVIATIONS * squared.std() / math.sqrt(PATHS)
    # BAOAB leaves a share (w h / 2)^2 of the mean square of velocities out.
    missed = (TRAP * STEP / 2) ** 2 * particle.rms_speed**2
    board.check(
        "mean square speed in the bath (m2/s2)", squared.mean(), particle.rms_speed**2,
        spread + missed,
    )  # fmt: skip
    square = bath[:, :3] ** 2
    exact = BOLTZMANN * particle.T / (particle.mass * TRAP**2)
    spread = DEVIATIONS * square.std() / math.sqrt(square.size)
    board.check("mean square of a position (m2)", square.mean(), exact, spread)
    times = SAMPLE * np.arange(STEPS + 1)
    record = solve_langevin(
        held, (0.0, times[-1]), [0.0], [0.0], paths=RECORD, t_eval=times, **options
    )
    frequency, density, exact = _spectrum(record.y[:, 0, 1024:], noise)  # without the approach
    near = (frequency > 20e3) & (frequency < 200e3)
    ratio = (density / exact)[near]
    spread = DEVIATIONS * math.sqrt(1.5 / (RECORD * ratio.size))  # 1.5: the window's correlation
    board.check("spectrum over the exact one, mean", ratio.mean(), 1.0, spread)
    board.figure("nanoparticle-bath", _bath_figure(record, frequency, density, exact))


def _spectrum(x, noise):
    """(frequency, density of x^2, exact density 2 s^2 / ((w^2 - f^2)^2 + c^2 f^2)) of paths."""
    window = np.hanning(x.shape[1])
    power = (np.abs(np.fft.rfft(window * x)) ** 2).mean(axis=0)
    density = 2.0 * SAMPLE * power / (window**2).sum()
    frequency = np.fft.rfftfreq(x.shape[1], SAMPLE)
    turn = 2.0 * math.pi * frequency
    exact = 2.0 * noise**2 / ((TRAP**2 - turn**2) ** 2 + (GAS * turn) ** 2)
    return frequency, density, exact


def _bath_figure(record, frequency, density, exact):
    """A path, and the spectrum of all paths beside the exact one."""
    t = record.t
    shown = (frequency > 0.0) & (frequency < 400e3)
    with plot.slides():
        figure, (path, spectrum) = plot.column(2, sharex=False, figsize=(10, 8))
        path.plot(1e6 * t[:400], 1e9 * record.y[0, 0, :400])
        path.set(xlabel="t (µs)", ylabel="x (nm)", title="one particle in the trap")
        spectrum.loglog(1e-3 * frequency[shown], 1e18 * density[shown], label="256 paths")
        spectrum.loglog(1e-3 * frequency[shown], 1e18 * exact[shown], "k--", label="exact")
        spectrum.set(xlabel="f (kHz)", ylabel="density of x² (nm²/Hz)")
        spectrum.legend()
    return figure
