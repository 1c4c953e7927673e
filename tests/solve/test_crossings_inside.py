"""Crossings of zero between the ends of a step, of which the ends show nothing."""

import numpy as np
import pytest
from scipy import integrate

from fastdyn import solve_ensemble, solve_ivp

OWN = ("Tsit5", "Vern7", "Vern9", "Rodas5P", "Taylor", "auto")
TIGHT = {"rtol": 1e-6, "atol": 1e-6}
ARC = np.arccos(0.99)
PEAKS = np.arange(1, 16) * 2 * np.pi
CROSSINGS = np.sort(np.r_[ARC, PEAKS - ARC, PEAKS + ARC])  # of cos(t) = 0.99, to t = 100


def turning(t, y):
    return [y[1], -y[0]]


def peak(t, y):
    return y[0] - 0.99


def around_the_sun(t, y):
    r3 = (y[0] * y[0] + y[1] * y[1]) ** 1.5
    return [y[2], y[3], -y[0] / r3, -y[1] / r3]


def lorenz(t, y):
    return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]


@pytest.mark.parametrize("method", OWN)
def test_own_methods_find_both_crossings_of_a_peak(method):
    for _ in range(3):
        found = solve_ivp(turning, (0, 100), [1.0, 0.0], method, events=peak, **TIGHT)
        assert len(found.t_events[0]) == len(CROSSINGS)
        assert np.abs(np.diff(found.t_events[0]) - np.diff(CROSSINGS)).max() < 1e-3


@pytest.mark.parametrize("direction", [1, -1])
def test_a_direction_takes_one_of_two_crossings(direction):
    def one_way(t, y):
        return y[0] - 0.99

    one_way.direction = direction
    found = solve_ivp(turning, (0, 100), [1.0, 0.0], "Vern9", events=one_way, **TIGHT)
    expected = np.sort(PEAKS - ARC) if direction > 0 else np.sort(np.r_[ARC, PEAKS + ARC])
    assert found.t_events[0] == pytest.approx(expected, abs=1e-3)


def test_the_second_crossing_in_a_step_ends_a_run_or_acts():
    def limited(t, y):
        return y[0] - 0.99

    limited.terminal = 3
    found = solve_ivp(turning, (0, 100), [1.0, 0.0], "Vern9", events=limited, **TIGHT)
    assert found.status == 1 and found.t[-1] == pytest.approx(CROSSINGS[2], abs=1e-4)
    acts = solve_ivp(
        turning, (0, 100), [1.0, 0.0], "Vern9", events=peak, on_event=lambda t, y: [y[0], y[1]],
        **TIGHT,
    )  # fmt: skip
    assert len(acts.t_events[0]) == len(CROSSINGS)


@pytest.mark.few
@pytest.mark.parametrize("simd", [True, False])
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P"])
def test_members_of_an_ensemble_lose_none(method, simd):
    def pulled(t, y, k):
        return [y[1], -k * y[0]]

    def its_peak(t, y, k):
        return y[0] - 0.99

    k = np.linspace(0.9, 1.1, 9)
    many = solve_ensemble(
        pulled, (0, 100), [1.0, 0.0], (k,), method, events=its_peak, simd=simd, **TIGHT
    )
    for found, one in zip(many.t_events[0], k, strict=True):
        w = np.sqrt(one)
        n = int((100 * w + ARC) // (2 * np.pi)) * 2
        assert abs(len(found) - (n + 1)) <= 1 and len(found) >= n


SCIPYS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


@pytest.mark.parametrize("method", SCIPYS)
def test_scipys_methods_keep_scipys_occurrences_and_evaluations(method):
    given = turning, (0, 50), [1.0, 0.0], method
    ours = solve_ivp(*given, events=peak, rtol=1e-5, atol=1e-5)
    scipys = integrate.solve_ivp(*given, events=peak, rtol=1e-5, atol=1e-5)
    assert len(ours.t_events[0]) == len(scipys.t_events[0])
    assert ours.t_events[0] == pytest.approx(scipys.t_events[0], rel=1e-9)
    assert ours.nfev <= scipys.nfev if method == "LSODA" else ours.nfev == scipys.nfev


WIDTH = 0.25  # of a step, above which no pair of crossings is lost


@pytest.mark.hunt
@pytest.mark.parametrize("seed", range(4))
def test_no_pair_of_crossings_of_random_functions_is_lost(seed):
    several = 0
    draw = np.random.default_rng(seed)
    systems = (around_the_sun, [1.0, 0, 0, 1.2], 40.0, 1.0), (turning, [1.0, 0.0], 60.0, 1.0), (
        lorenz, [1.0, 1.0, 1.0], 10.0, 20.0,
    )  # fmt: skip
    for trial in range(250):
        fun, y0, end, size = systems[trial % 3]
        method, tol = OWN[draw.integers(4)], 10.0 ** -draw.uniform(3, 9)
        weights = (draw.normal(size=(2, len(y0))) * draw.uniform(0.5, 2.5) / size).tolist()
        phases = draw.uniform(0, 6, 2).tolist()

        def near(t, y, level=0.0, weights=weights, phases=phases):
            total = -level
            for row, phase in zip(weights, phases, strict=True):
                angle = phase
                for j in range(len(row)):
                    angle = angle + row[j] * y[j]
                total = total + np.sin(angle)
            return total

        given = {"rtol": tol, "atol": 1e-2 * tol, "dense_output": True}
        base = solve_ivp(fun, (0, end), y0, method, **given)
        places = np.linspace(0, 1, 201)
        times = base.t[:-1, None] + np.diff(base.t)[:, None] * places
        states = base.sol(times.ravel())
        values = near(times.ravel(), states)
        turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
        level = values[draw.choice(turns)]
        level = float(level + draw.choice([-1, 1]) * 10.0 ** -draw.uniform(0.5, 3) * np.ptp(values))
        found = solve_ivp(
            fun,
            (0, end),
            y0,
            method,
            events=lambda t, y, near=near, c=level: near(t, y, c),
            **given,
        )
        signs = np.sign(near(times.ravel(), states, level)).reshape(times.shape)
        for i, row in enumerate(signs[:-1]):
            k = np.flatnonzero(row[1:] * row[:-1] < 0)
            if len(k) < 2:
                continue
            several += 1
            a, b = found.t[i], found.t[i + 1]
            mine = ((found.t_events[0] >= a) & (found.t_events[0] <= b)).sum()
            assert mine >= len(k) or np.diff(places[k]).min() < WIDTH, (trial, method, tol, i)
    assert several > 100
