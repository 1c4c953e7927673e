"""The building's lesson: resonance, and what the printed script forgets (course 3.3.3, 3)."""

import math

import numpy as np

from fastdyn import plot, solve_ivp
from fastdyn.course.tolerances import ATOL, RTOL, TIGHT, tolerated
from fastdyn.systems.building import STIFFNESS, Building


def printed(t, w, k, m, omega, d, L, g):
    """The right-hand side as printed, without -g for the lower floor."""
    y1, y2, v1, v2 = w
    s = d * math.sin(omega * t)
    lower = 2.0 * k * (y1 - s - L)
    upper = 2.0 * k * (y2 - y1 - L)
    return [v1, v2, (upper - lower) / m, -upper / m - g]


def lesson(board):
    _frequencies(board)
    _sweep(board)
    _erratum(board)
    _samples(board)


def _frequencies(board):
    board.say(
        """Linear, so there is a closed form: two modes, each a forced oscillator. The course
        speaks of two resonant frequencies without printing them; they are 8.74 and 22.88 rad/s,
        and near them the building shakes severely. Tolerated: each step adds its rtol and atol, and
        free vibration makes at most 2 (1 + w) of an error, w the upper frequency."""
    )
    runs = {}
    low, high = Building().frequencies
    for name, w in (("lower", low), ("upper", high)):  # det(K - m w² I) = 0, from K itself
        matrix = STIFFNESS * Building().k - w**2 * Building().m * np.eye(2)
        left = np.linalg.det(matrix) / Building().k ** 2
        board.check(f"{name} frequency {w:.3f} rad/s: det(K - m w²)/k²", left, 0.0, 1e-13)
    for omega in (4.0, 9.0, 15.0, low, high):
        building = Building(omega=omega)
        run = building.solve(**TIGHT, method="DOP853", dense_output=True)
        allowed = tolerated(run) * 2.0 * (1.0 + high)
        board.zero(f"ω = {omega:.4g} rad/s: error of the state", run.error(), allowed)
        if omega in (4.0, 9.0, 15.0):
            runs[f"ground at ω = {omega:g} rad/s"] = building.solve((0.0, 10.0), **TIGHT)
    board.figure("building", plot.plot(runs))


def _sweep(board):
    omega = np.linspace(1.0, 30.0, 2901)
    swept = Building().ensemble(omega=omega, reduce=("max", "min"), rtol=1e-8, atol=1e-10)
    travel = (swept.reduced["max"] - swept.reduced["min"])[:, 1] / 2.0
    board.say(
        """The sweep: 2901 frequencies of the ground in one call, of each the largest deflection,
        found while it is solved. Tolerated: the distance of two frequencies, and what 40001 times
        of the exact motion may miss of a peak, (w dt)² / 8 of it."""
    )
    frequencies = Building().frequencies
    t = np.linspace(0.0, 20.0, 40001)
    chosen = [300, 800, 1400, *(round((w - 1.0) * 100) for w in frequencies)]
    exact = [np.ptp(Building(omega=omega[i]).exact(t)[1]) / 2.0 for i in chosen]
    for i, largest in zip(chosen, exact, strict=True):
        missed = largest * (omega[i] * t[1]) ** 2 / 8.0 + 1e-5 * largest
        board.check(f"ω = {omega[i]:.4g} rad/s: largest deflection (m)", travel[i], largest, missed)
    for i, frequency in zip((0, 1700), frequencies, strict=True):
        at = omega[i : i + 1200][np.argmax(travel[i : i + 1200])]
        board.check("the largest of all is at w (rad/s)", at, frequency, 0.02)
    with board.panel("building-resonance", (11, 6.2)) as axes:
        axes.plot(omega, travel, label="from rest, 20 s: 2901 runs")
        axes.plot(omega[chosen], exact, "o", color=plot.COLOURS[1], label="exact")
        steady = np.abs([Building(omega=w).steady_amplitudes[1] for w in omega])
        steady = np.where(steady > travel.max(), np.nan, steady)
        axes.plot(omega, steady, "k--", lw=1.4, label="steady motion alone")
        for frequency in frequencies:
            axes.axvline(frequency, color="0.6", ls=":", lw=1.5)
            axes.annotate(f"{frequency:.2f} rad/s", (frequency, 1.02 * travel.max()), xytext=(6, 0),
                          textcoords="offset points", va="top")  # fmt: skip
        tooth = int(np.argmin(np.abs(omega - 11.0)))
        about = "teeth: in 20 s the peaks of forced and\nfree vibrations need not come together"
        axes.annotate(about, (omega[tooth], travel[tooth]), xytext=(11.2, 3.2), fontsize=12,
                      arrowprops={"arrowstyle": "->", "color": "0.3"})  # fmt: skip
        axes.set(xlabel="frequency of the ground ω (rad/s)", yscale="log")
        axes.set_ylabel("largest deflection of the\nupper floor in 20 s (m)")


def _erratum(board):
    still = Building(d=0.0)
    run = still.solve(**TIGHT)
    board.say(
        """Without an earthquake nothing may move. The script as printed leaves -g out of the
        lower floor's equation: its building is thrown upwards at the start, by m g / k, and
        vibrates for ever."""
    )
    moved = np.ptp(run.y[:2], axis=1).max()
    board.check("d = 0: largest movement (m)", moved, 0.0, ATOL + RTOL * run.y[1, 0])
    args = still.args[:6]
    wrong = solve_ivp(printed, (0.0, 20.0), still.initial_state(), **TIGHT, args=args)
    shift = still.m * still.g / (2.0 * still.k)
    middle = wrong.y[0].mean() - still.initial_state()[0]
    board.check("as printed: mean shift of the lower floor (m)", middle, shift, 0.1 * shift)


def _samples(board):
    times = np.linspace(0.0, 20.0, 801)
    shape = np.exp(-(((times - 8.0) / 3.0) ** 2)) * np.sin(7.0 * times + np.sin(3.0 * times))
    shaking = _at_rest_again(times, 0.05 * np.gradient(np.gradient(shape, times), times))
    building = Building.sampled(times, accelerations=shaking)
    run = building.solve(**TIGHT, dense_output=True)
    tight = building.solve(method="DOP853", rtol=1e-12, atol=1e-14, t_eval=[20.0])
    board.say(
        """Ground motion given by samples: accelerations every 25 ms, joined by straight lines and
        integrated twice, exactly. Steps end at the samples, so that no step has a kink inside."""
    )
    missed = np.setdiff1d(times, run.t).size
    board.check("samples at which no step ends", missed, 0, 0)
    allowed = tolerated(run) * 2.0 * (1.0 + building.upper_frequency)
    error = run.y[:, -1] - tight.y[:, -1]
    board.zero("end of the run, RK45 less DOP853", error, 2.0 * allowed)
    board.figure("building-accelerogram", run.plot(label="what the floors and the ground do"))


def _at_rest_again(times, accelerations):
    """Accelerations less the least that leaves the ground at the end where it was, and at rest."""

    def left(samples):
        ground = Building.sampled(times, accelerations=samples).ground
        place = float(ground(times[-1]))
        near = float(ground(times[-1] - 1e-3))
        return np.array([place, (place - near) / 1e-3])

    window = np.exp(-(((times - 8.0) / 3.0) ** 2))
    shapes = np.array([window, window * (times - 8.0)])
    effects = np.array([left(one) for one in shapes]).T
    amounts = np.linalg.solve(effects, left(accelerations))
    return accelerations - amounts @ shapes
