"""Crossings of zero between the ends of a step, of which the ends show nothing."""

import types
import warnings

import numpy as np
import pytest
from scipy import integrate

from fastdyn import (
    Phase,
    Stepper,
    SwitchingWarning,
    prepare,
    solve_dae,
    solve_ensemble,
    solve_ivp,
    solve_phases,
)
from support.steppers import ended

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


def apsis(name):
    """A fresh event function, whose zeros are the apsides of an orbit."""

    def event(t, y):
        return y[0] * y[2] + y[1] * y[3]

    return types.FunctionType(event.__code__.replace(co_name=name), globals(), name)


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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SwitchingWarning)
        ours = solve_ivp(*given, events=peak, rtol=1e-5, atol=1e-5)
    scipys = integrate.solve_ivp(*given, events=peak, rtol=1e-5, atol=1e-5)
    assert len(ours.t_events[0]) == len(scipys.t_events[0])
    assert ours.t_events[0] == pytest.approx(scipys.t_events[0], rel=1e-9)
    assert ours.nfev <= scipys.nfev if method == "LSODA" else ours.nfev == scipys.nfev


SPAN = (0.0, 20.0)


def crossing(name, level=0.99):
    """A fresh event function, of which nobody was told yet: its code has a name of its own."""

    def event(t, y, *args):
        return y[0] - level

    code = event.__code__.replace(co_name=name)
    return types.FunctionType(code, globals(), name, None, event.__closure__)


def crossing_in_time(name):
    def event(t, y, *args):
        return np.sin(5.0 * t) - 0.9

    code = event.__code__.replace(co_name=name)
    return types.FunctionType(code, globals(), name)


def slowly(t, y):
    return [-0.1 * y[0]]


def told_by(solve):
    """The warnings of lost crossings."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        solve()
    assert all(issubclass(each.category, SwitchingWarning) for each in said)
    return [str(each.message) for each in said]


@pytest.mark.parametrize("method", [*SCIPYS, "ode45"])
def test_a_method_that_loses_two_crossings_tells_it_once(method):
    def solve(name=f"a_{method}"):
        return solve_ivp(slowly, SPAN, [1.0], method, events=events[name])

    events = {name: crossing_in_time(name) for name in (f"a_{method}", f"b_{method}")}
    (said,) = told_by(solve)
    assert f"`a_{method}` crosses zero at t = " in said and f"within one step of {method}," in said
    assert "'Tsit5', 'Vern9' or 'Rodas5P'" in said and "max_step=" in said
    assert not told_by(solve) and not told_by(solve) and not told_by(solve)
    assert told_by(lambda: solve(f"b_{method}"))


def test_the_step_that_is_proposed_finds_both():
    event = crossing("proposed")
    given = turning, SPAN, [1.0, 0.0], "DOP853", None, False, event
    (said,) = told_by(lambda: solve_ivp(*given))
    step = float(said.split("max_step=")[1].rstrip("`."))
    found = solve_ivp(*given, max_step=step).t_events[0]
    first, second = (float(said.split("t = ")[k].split()[0].rstrip(",")) for k in (1, 2))
    for each in (first, second):
        assert np.abs(found - each).min() < 1e-2


def test_the_same_method_with_a_level_that_is_not_reached_says_nothing():
    for level in (1.01, -1.01, 0.5, 0.0):
        assert not told_by(
            lambda level=level: solve_ivp(
                turning, SPAN, [1.0, 0.0], "DOP853", events=crossing("not_reached", level)
            )
        )


@pytest.mark.parametrize("e", [0.0, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("method", [*SCIPYS, "ode45", "ode23"])
def test_apsides_of_a_circle_which_are_noise_are_not_told(method, e):
    """Without the look at the depth of the dips, most of these orbits are."""
    y0 = [1.0, 0.0, 0.0, np.sqrt(1.0 + e)]
    for rtol in (1e-3, 1e-6):
        event = apsis(f"apsis_{method}_{e}_{rtol}")
        given = around_the_sun, (0, 40 * np.pi), y0, method
        assert not told_by(
            lambda given=given, event=event, rtol=rtol: solve_ivp(
                *given, events=event, rtol=rtol, atol=1e-2 * rtol
            )
        )


@pytest.mark.parametrize("method", ["Tsit5", "Vern7", "Vern9", "Rodas5P"])
def test_noise_within_steps_makes_no_events(method):
    """Each step may cross zero at its ends; the pairs within made 183 more of Rodas5P's 1281."""
    y0 = [1.0, 0.0, 0.0, 1.0 + 5e-10]
    given = {"rtol": 1e-6, "atol": 1e-8, "dense_output": True}
    found = solve_ivp(around_the_sun, (0, 40 * np.pi), y0, method, events=apsis("noise"), **given)
    at_ends = np.sign([apsis("noise")(0, y) for y in found.y.T])
    assert len(found.t_events[0]) == (at_ends[1:] * at_ends[:-1] <= 0.0).sum()


def test_a_peak_of_more_than_its_noise_counts_and_is_told():
    """The level is four tolerances of g below the peak; at half a tolerance nothing is told."""
    tolerance = TIGHT["rtol"] + TIGHT["atol"]
    for height, told in ((4.0, 1), (0.5, 0)):
        event = crossing(f"high_{height:g}", 1.0 - height * tolerance)
        given = turning, (0, 12), [-1.0, 0.0]
        ours = solve_ivp(*given, "Vern9", events=event, rtol=1e-9, atol=1e-9)
        assert len(ours.t_events[0]) == 4
        said = told_by(lambda event=event, given=given: solve_ivp(
            *given, "RK45", events=event, max_step=1.3, **TIGHT
        ))  # fmt: skip
        assert len(said) == told


def test_values_that_rest_move_no_event_function():
    """A component that stays the same decides between two functions: it makes no noise."""

    def chosen(t, y):
        return y[0] - 0.99 if y[2] == 1.0 else -1.0

    def with_a_mode(t, y):
        return [y[1], -y[0], 0.0]

    given = with_a_mode, SPAN, [-1.0, 0.0, 1.0], "DOP853"
    assert len(told_by(lambda: solve_ivp(*given, events=chosen, **TIGHT))) == 1


@pytest.mark.parametrize(("t_end", "n_told"), [(6.0, 0), (6.2, 1), (7.0, 1)])
def test_crossings_behind_the_end_of_a_run_are_not_lost(t_end, n_told):
    """The only crossings of the solution in the step are at 2 pi - ARC and 2 pi + ARC."""
    event = crossing(f"before_{10 * t_end:g}")

    def end(t, y):
        return t - t_end

    end.terminal = True
    run = []
    given = turning, (5.9, 20.0), [np.cos(5.9), -np.sin(5.9)], "DOP853", None, False, [event, end]
    said = told_by(lambda: run.append(solve_ivp(*given, first_step=1.2, rtol=1e-3)))
    assert run[0].status == 1 and run[0].n_accepted == 1 and not len(run[0].t_events[0])
    assert len(said) == n_told


def moving(t, y, w):
    return [y[1], -w * w * y[0]]


def by_again(event):
    for w in (0.3, 0.3, 0.3, 0.3, 1.0):
        solve_ivp(moving, (0, 9.0), [-1.0, 0.0], "DOP853", events=event, args=(w,), rtol=1e-6)


def by_prepared(event):
    solver = prepare(moving, (0, 9.0), [-1.0, 0.0], "DOP853", events=event, args=(0.3,), rtol=1e-6)
    for w in (0.3, 0.3, 1.0, 1.0):
        solver(args=(w,))


def by_stepper(event):
    stepper = Stepper(turning, 0.0, [-1.0, 0.0], 20.0, method="DOP853", events=event, rtol=1e-6)
    ended(stepper)


def by_an_ensemble(event):
    w = np.linspace(0.9, 1.0, 9)
    solve_ensemble(moving, (0, 20), [-1.0, 0.0], (w,), "DOP853", events=event, rtol=1e-6)


def by_phases(event):
    end = crossing("ends", 2.0)
    end.terminal = True
    phase = Phase(turning, end, lambda t, y: ("one", y))
    solve_phases({"one": phase}, "one", (0, 20), [-1.0, 0.0], "DOP853", events=event, rtol=1e-6)


def by_dae(event):
    def implicit(t, y, yp):
        return [yp[0] + 0.1 * y[0], y[1] - y[0]]

    event = crossing_in_time(event.__name__)
    solve_dae(implicit, SPAN, [1.0, 1.0], method="Radau", events=event)


def by_mass(event):
    event = crossing_in_time(event.__name__)
    solve_ivp(slowly, SPAN, [1.0], "Radau", events=event, mass=np.array([[2.0]]))


def by_sensitivities(event):
    given = {"args": (1.0,), "sensitivity": ["w"], "rtol": 1e-3}
    solve_ivp(moving, (0, 20), [-1.0, 0.0], "DOP853", events=event, **given)


@pytest.mark.parametrize(
    "way",
    [
        by_again, by_prepared, by_stepper, by_an_ensemble, by_phases, by_dae, by_mass,
        by_sensitivities,
    ],
)  # fmt: skip
def test_each_way_of_a_solve_tells_of_lost_crossings(way):
    event = crossing(way.__name__, 0.98)
    said = told_by(lambda: way(event))
    assert len(said) == 1 and f"`{way.__name__}` crosses zero" in said[0]


def test_crossings_that_end_phases_count_by_each_method():
    """What follows depends on them, and SciPy has no phases."""

    def ended(method):
        end = crossing("ends", 0.98)
        end.terminal = True
        phase = Phase(turning, end, lambda t, y: ("one", y))
        found = solve_phases({"one": phase}, "one", (0, 20), [-1.0, 0.0], method, rtol=1e-6)
        return len(found.phases)

    assert ended("DOP853") == ended("RK45") == ended("Vern9") > 6


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
