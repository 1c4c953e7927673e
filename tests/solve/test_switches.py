"""Solutions that slide along a switch, where both sides of a condition point at the other."""

import math
import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.compile import memory
from fastdyn.compile.derivatives import switched
from fastdyn.run import loop
from fastdyn.solve import automatic

sign = np.sign
FINE = {"rtol": 1e-6, "atol": 1e-8}


def below(level):
    return lambda t, y: [0.1 if y[0] <= level else 0.0]


def above(level):
    return lambda t, y: [0.0 if y[0] > level else 0.1]


def thermostat(t, y):
    return [-0.1 * (y[0] - 5.0) + (3.0 if y[0] < 20.0 else 0.0)]


def relay(t, y):
    return [-sign(y[0]) + 0.5 * np.sin(t)]


def control(t, y):
    """Sliding mode control: y' = -y on the switch."""
    return [y[1], -2.0 * sign(y[0] + y[1]) + 0.3 * np.sin(3.0 * t)]


def moving(t, y):
    return [-2.0 * sign(y[0] - np.sin(t)) + 0.1 * y[0]]


def circle(t, y):
    s = sign(y[0] ** 2 + y[1] ** 2 - 1.0)
    return [y[1] - s * y[0], -y[0] - s * y[1]]


def friction(t, y):
    return [y[1], -y[0] - 0.2 * sign(y[1])]


def leaves(t, y):
    """Slides from t = 0.5635 to 2.5."""
    return [1.0, (-1.0 if y[1] > 0 else 1.0) + 0.4 * y[0]]


def two(t, y):
    """Each holds the state by its own switch."""
    return [-sign(y[0]) + 0.3 * y[1], -2.0 * sign(y[1] - 0.5) + 0.4 * np.cos(t)]


def corner(t, y):
    """The second switch holds the state by the first one: only one order of averages is sound."""
    a = y[0] + y[1]
    return [-sign(a) + 0.2 * math.sin(t), -0.5 * y[1] + 0.3 * sign(y[0] - 0.2)]


def masked(t, y):
    return np.where(y > np.array([1.0, 2.0]), -1.0, np.array([0.5, 0.6]))


def valve(t, y):
    """A condition of two comparisons: no inflow into a full tank while the pump runs."""
    return [0.3 if (y[0] < 1.0 or y[0] > 5.0) and t < 30 else -0.2]


ENDS = {
    "at 0.25": (above(0.25), 20, [0.0], [0.25]), "at 0.3": (above(0.3), 20, [0.0], [0.3]),
    "at 0.5": (below(0.5), 20, [0.0], [0.5]), "at 0.7": (below(0.7), 20, [0.0], [0.7]),
    "at 1": (below(1.0), 20, [0.0], [1.0]), "at 2": (below(2.0), 1000, [0.0], [2.0]),
    "thermostat": (thermostat, 50, [5.0], [20.0]), "relay": (relay, 10, [1.0], [0.0]),
    "control": (control, 20, [1.0, 0.0], [0.0, 0.0]), "moving": (moving, 20, [2.0], [np.sin(20)]),
    "friction": (friction, 12, [1.0, 0.0], [0.2, 0.0]),
    "leaves": (leaves, 10, [0.0, 0.5], [10.0, 11.25]), "two": (two, 10, [1.0, 2.0], [0.0, 0.5]),
    "corner": (corner, 20, [1.0, 1.0], [0.2, -0.2]),
    "masked": (masked, 20, [0.0, 0.0], [1.0, 2.0]), "valve": (valve, 20, [0.0], [1.0]),
}  # fmt: skip


@pytest.fixture(autouse=True)
def nothing_was_asked():
    memory.forget()


@pytest.mark.parametrize("name", ["at 0.5", "at 2", "thermostat", "relay", "leaves"])
def test_at_the_default_tolerance(name):
    """Tsit5 misses the switch by up to 100 tolerances."""
    fun, t_end, y0, end = ENDS[name]
    run = solve_ivp(fun, (0, t_end), y0, "auto")
    assert run.method != "Tsit5" and run.nfev < 5000
    assert np.abs(run.y[:, -1] - end).max() < 1e-4
    again = solve_ivp(fun, (0, t_end), y0, "auto")
    assert again.y.tobytes() == run.y.tobytes() and again.reason == run.reason


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ENDS)
def test_the_solution_moves_along_the_switch(name):
    """By steps across the switch, up to 5 million evaluations, or no end."""
    fun, t_end, y0, end = ENDS[name]
    run = solve_ivp(fun, (0, t_end), y0, "auto", **FINE)
    assert run.status == 0 and run.nfev < 5000 and (np.diff(run.t) > 0).all()
    assert np.abs(run.y[:, -1] - end).max() < 1e-5
    assert run.method == "Taylor" or "Filippov's average" in run.reason
    assert run.y.shape == (len(y0), len(run.t)) and run.t_events is run.y_events is run.sol is None


def filled(t, y):
    """A level that is held, and falls for some time at t = 8."""
    a, b, w = 0.950356, 0.751486, 2.162461
    flow = 0.3 * b * (1 + math.sin(w * t)) if y[0] < 1 else 0.0957659 * math.sin(w * t) - 0.05
    return [flow - 0.1 * a * y[1] * (y[0] > 0), 0.2 * (y[0] - y[1])]


def swung(t, y):
    return [-sign(y[0]) + 1.5 * np.sin(t)]


def slipping(t, y):
    a, b, c, w, m = 3.881387, 1.313454, 1.130115, 1.439001, 0.593131
    return [y[1], -a * y[0] - b * sign(y[1]) * (1 + m * abs(y[1])) + c * math.cos(w * t)]


@pytest.mark.parametrize(("fun", "y0"), [(filled, [0.1, 0]), (swung, [1.0]), (slipping, [1.0, 0])])
def test_what_happens_within_a_step_is_not_lost(fun, y0):
    """The solution leaves the switch and returns, where the ends of a step do not show it."""
    t = np.linspace(0, 12, 13)
    options = [(1e-3, 1e-6), (1e-5, 1e-8), (1e-6, 1e-7), (1e-6, 1e-8), (1e-8, 1e-8), (1e-10, 1e-10)]
    runs = [
        solve_ivp(fun, (0, 12), y0, "auto", t_eval=t, rtol=rtol, atol=atol)
        for rtol, atol in options
    ]
    for (rtol, _), run in zip(options, runs, strict=True):
        assert "Filippov" in run.reason
        assert np.abs(run.y - runs[-1].y).max() < max(1e-7, min(100 * rtol, 1e-3))


@pytest.mark.hunt
def test_random_switches():
    """Friction, a relay, two relays: two tolerances, one solution."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        a, b, c, w, m = rng.uniform([0.5, 0.3, 0.2, 0.5, 0.0], [4.0, 1.5, 2.0, 3.0, 0.6])

        def rubbing(t, y, a=a, b=b, c=c, w=w, m=m):
            return [y[1], -a * y[0] - b * sign(y[1]) * (1 + m * abs(y[1])) + c * math.cos(w * t)]

        def relayed(t, y, a=a, b=b, c=c, w=w, m=m):
            return [
                -b * sign(y[0] - m * math.sin(w * t / 2)) + c * math.sin(w * t) - 0.1 * a * y[0]
            ]

        def pair(t, y, a=a, b=b, c=c, w=w, m=m):
            return [
                -b * sign(y[0]) + m * y[1] + 0.5 * c * math.sin(w * t),
                -sign(y[1] - 0.3 * y[0]) * a + c * math.cos(w * t),
            ]

        for fun, y0 in ((rubbing, [1.0, 0.0]), (relayed, [1.0]), (pair, [1.0, -1.0])):
            t = np.linspace(0, 12, 7)
            rough, fine = (
                solve_ivp(fun, (0, 12), y0, "auto", t_eval=t, rtol=rtol, atol=rtol)
                for rtol in (1e-5, 1e-9)
            )
            assert rough.status == fine.status == 0 and rough.nfev < 100_000
            assert np.abs(rough.y - fine.y).max() < 1e-3, (seed, fun)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_short_slip_is_not_stepped_over(tolerance):
    """At rest the derivative is 0, and a step of any length would do but for its `excess`."""

    def driven(t, y):
        return [y[1], -4 * y[0] - 1.5 * sign(y[1]) * (1 + 0.1 * y[0] ** 2) + 2 * math.cos(2.3 * t)]

    t = [0.0, 15.0, 18.75, 22.5, 26.25, 30.0]
    run = solve_ivp(driven, (0, 30), [1.0, 0.0], "auto", t_eval=t, rtol=tolerance, atol=tolerance)
    exact = [1.0, 0.182180, -0.236819, 0.186810, -0.029716, -0.116112]  # by steps across the switch
    assert "Filippov" in run.reason and np.abs(run.y[0] - exact).max() < 1e-5


def test_the_clock_decides_nothing(monkeypatch):
    expected = solve_ivp(control, (0, 20), [1.0, 0.0], "auto")
    for seconds in (0.0, 1e3):
        monkeypatch.setattr(loop, "CHUNK_SECONDS", seconds)
        assert solve_ivp(control, (0, 20), [1.0, 0.0], "auto").y.tobytes() == expected.y.tobytes()


def test_output_and_events_are_those_of_the_state():
    def half(t, y, level):
        return y[0] - 0.5

    half.direction = -1
    t = np.linspace(0, 20, 41)

    def held(t, y, level):
        return [y[1], -level * sign(y[0] + y[1]) + 0.3 * np.sin(3.0 * t)]

    run = solve_ivp(
        held, (0, 20), [1.0, 0.0], "auto", t_eval=t, dense_output=True, events=half, args=(2.0,),
        **FINE,
    )  # fmt: skip
    assert "Filippov" in run.reason and "discrete" not in run and len(run.t_events) == 1
    assert np.array_equal(run.t, t) and run.y.shape == run.sol(t).shape == (2, 41)
    assert np.abs(run.sol(t) - run.y).max() < 1e-9 and run.y_events[0].shape == (1, 2)
    assert abs(run.y_events[0][0, 0] - 0.5) < 1e-9
    slides = t > 1.0
    assert np.abs(run.y[0] + run.y[1])[slides].max() < 1e-6


def test_outside_values_are_read_at_each_solve():
    level = [1.0]

    def limited(t, y):
        return [-1.0 if y[0] > level[0] else 0.5]

    ends = []
    for level[0] in (1.0, 2.0, 3.0):
        ends.append(solve_ivp(limited, (0, 10), [0.0], "auto", **FINE).y[0, -1])
    assert np.abs(np.subtract(ends, [1.0, 2.0, 3.0])).max() < 1e-5


def test_options_without_modes_leave_the_switch_to_the_steps():
    run = solve_ivp(
        thermostat, (0, 8), [5.0], "auto", nonnegative=True, rtol=1e-5, atol=1e-5
    )  # fmt: skip
    assert run.status == 0 and abs(run.y[0, -1] - 20.0) < 1e-3


@pytest.mark.hunt  # half a million steps along switches
def test_a_point_reached_ever_faster_is_left_to_the_steps_and_told():
    """Time-optimal control reaches the corner of its switches, where modes change for ever."""

    def optimal(t, y):
        return [y[1], -sign(y[0] + 0.5 * y[1] * abs(y[1]))]

    with pytest.warns(fastdyn.StiffnessWarning, match="changes sides for ever"):
        run = solve_ivp(optimal, (0, 2.1), [1.0, 0.0], "auto")
    alone = solve_ivp(optimal, (0, 2.1), [1.0, 0.0], "Tsit5")
    assert run.status == 0 and np.array_equal(run.y[:, -1], alone.y[:, -1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.StiffnessWarning)
        fine = solve_ivp(optimal, (0, 2.1), [1.0, 0.0], "auto", rtol=1e-5, atol=1e-8)
    assert fine.status == 0 and np.abs(fine.y[:, -1]).max() < 1e-2


def test_taylor_tells_it():
    run = solve_ivp(relay, (0, 10), [1.0], "Taylor", **FINE)
    assert run.status == -1 and run.n_accepted < 5000
    assert "switches back and forth" in run.message and "'auto'" in run.message


def test_other_methods_tell_it():
    with pytest.warns(fastdyn.StiffnessWarning, match="switches back and forth"):
        assert solve_ivp(relay, (0, 2), [1.0], "Tsit5", rtol=1e-5).status == 0


def test_what_only_crosses_or_bends_is_left_alone():
    for fun in (
        lambda t, y: [y[1], -sign(y[0])],
        lambda t, y: [y[1], -abs(y[0]) * y[0]],
        lambda t, y: [y[1], -max(y[0], -0.5)],
    ):
        run = solve_ivp(fun, (0, 6000), [1.0, 0.0], "auto", rtol=1e-9, atol=1e-9)
        assert run.status == 0 and "Filippov" not in run.reason and run.n_accepted > 1000


def test_many_conditions_are_left_to_the_pair(monkeypatch):
    """A limiter on a grid at rest: Taylor would take 4000 steps of no length at the start."""
    asked, solved_by = [], automatic.solved_by

    def noting(arguments, name):
        asked.append(name)
        return solved_by(arguments, name)

    monkeypatch.setattr(automatic, "solved_by", noting)

    def advected(t, u):
        a, b = u - np.roll(u, 1), np.roll(u, -1) - u
        flux = u + 0.5 * np.where(a * b > 0, np.where(abs(a) < abs(b), a, b), 0.0)
        return np.roll(flux, 1) - flux

    u0 = np.where(np.arange(20) < 5, 1.0, 0.0)
    run = solve_ivp(advected, (0, 1), u0, "auto")
    assert run.status == 0 and asked == ["Tsit5"]


def test_of_many_jumps_those_that_slide_are_followed(monkeypatch):
    """A loop that halves a number jumps at 12 conditions: 13 modes would make 3**13 formulas."""

    def held(t, y):
        x, n = abs(y[0]), 0
        while x > 1e-6 and n < 12:
            x *= 0.5
            n += 1
        return [-y[0], -y[1]] if y[0] > 5.0 else [1.0 + x, 0.1]

    followed = []
    hybrid = switched.hybrid

    def counted(graph, outputs, some, *widths):
        followed.append(len(some))
        return hybrid(graph, outputs, some[:4], *widths)

    monkeypatch.setattr(switched, "hybrid", counted)
    run = solve_ivp(held, (0, 7), [0.5, 0.0], "auto", rtol=1e-8, atol=1e-10)
    assert followed == [1] and "Filippov's average" in run.reason
    rate = 0.5**12  # of y[0], below 5
    reached = np.log((1 + 5.0 * rate) / (1 + 0.5 * rate)) / rate
    share = (1 + 5.0 * rate) / (6 + 5.0 * rate)
    rest = 0.1 * (1 - share) / share
    exact = rest + (0.1 * reached - rest) * np.exp(-share * (7 - reached))
    assert abs(run.y[0, -1] - 5.0) < 1e-6 and abs(run.y[1, -1] - exact) < 1e-6


def test_a_switch_beside_which_nothing_jumps_is_left_to_the_steps(monkeypatch):
    """Rates that point at a switch from both sides may differ by rounding alone."""
    monkeypatch.setattr("fastdyn.run.stiffness.jumping", lambda of, t, y: [])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.StiffnessWarning)
        run = solve_ivp(relay, (0, 1.5), [1.0], "auto", rtol=1e-4)
    assert run.status == 0 and abs(run.y[0, -1]) < 1e-3
