"""Rodas5P with a trajectory in each lane: every member is the single solve."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from fastdyn.ensemble import Fold
from fastdyn.kernels.methods.rodas5p.table import GAMMA
from support.stiff import hires, van_der_pol

RTOL, ATOL = 1e-6, 1e-9
OPTIONS = {"rtol": RTOL, "atol": ATOL}
COUNT, SHARE = 11, 1e-2


def robertson(t, y, k):
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - k * b * b, k * b * b]


def follow(t, y, rate):
    """Prothero and Robinson's problem: df/dt counts, and there are sines."""
    return [-rate * (y[0] - math.sin(t)) + math.cos(t), rate * (y[0] - y[1])]


def rod(t, y, k):
    inner = np.concatenate([np.zeros(1), y, np.zeros(1)])
    return k * 169.0 * (inner[2:] - 2.0 * y + inner[:-2]) + 1.0 / (1.0 + y * y)


def decay(t, y, k):
    return [-k * y[0]]


class Sweep(NamedTuple):
    fun: Any
    t_span: tuple
    y0: Any
    args: tuple = ()


START_OF_HIRES = np.zeros((COUNT, 8))
START_OF_HIRES[:, 0], START_OF_HIRES[:, 7] = np.linspace(0.8, 1.2, COUNT), 0.0057
SWEEPS = {
    "Robertson": Sweep(robertson, (0, 1e4), [1.0, 0.0, 0.0], (np.geomspace(1e7, 1e8, COUNT),)),
    "van der Pol": Sweep(van_der_pol, (0, 3), [2.0, 0.0], (np.geomspace(10, 1000, COUNT),)),
    "HIRES": Sweep(hires, (0, 321.8), START_OF_HIRES),
    "in time": Sweep(follow, (0, 3), [1.0, 0.0], (np.geomspace(1.0, 1e5, COUNT),)),
    "backwards": Sweep(follow, (2, 0), [1.0, 0.0], (np.linspace(-1e3, -1.0, COUNT),)),
    "rod": Sweep(rod, (0, 1), np.ones(12), (np.linspace(0.5, 2.0, COUNT),)),
}


def solved(sweep, **options):
    fun, t_span, y0, args = sweep
    return solve_ensemble(fun, t_span, y0, args, "Rodas5P", **OPTIONS | options)


def near(a, b):
    """Whether two solutions by the same steps differ by rounding alone.

    Stages are combined by numbers up to 150, which changes an estimated error by 150 eps / rtol =
    3e-8 of what is accepted.  Steps grow tenfold at most: where the estimate is 6e-6 of that and
    less.  So they change by 0.2 x 5e-3 of themselves, and the solution by this share of its error.
    """
    return (abs(a - b) <= SHARE * (ATOL + RTOL * abs(b))).all()


@pytest.mark.few(1)
@pytest.mark.parametrize("name", SWEEPS)
def test_each_member_is_the_single_solve(name):
    sweep = SWEEPS[name]
    t_eval = np.linspace(*sweep.t_span, 7)
    many = solved(sweep, simd=True, t_eval=t_eval)
    assert many.width > 1 and many.success.all()
    for i in range(COUNT):
        args, y0 = tuple(a[i] for a in sweep.args), np.atleast_2d(sweep.y0)
        one = solve_ivp(
            sweep.fun, sweep.t_span, y0[i if len(y0) > 1 else 0], "Rodas5P", args=args,
            t_eval=t_eval, **OPTIONS,
        )  # fmt: skip
        assert many.nfev[i] == one.nfev and near(many.y[i], one.y)
        assert many.n_accepted[i] == one.n_accepted and many.n_rejected[i] == one.n_rejected


def low(t, y, k):
    return y[0] - 0.5


def counted(value, t, y, k):
    return value + 1.0 + 0.0 * y[0]


def same_times(a, b):
    """Whether events where y[0] = 0.5 are `near`: t |dy/dt| > 0.1 there."""
    return len(a) == len(b) and np.allclose(a, b, rtol=SHARE * RTOL * 0.5 / 0.1, atol=0)


low.terminal = False


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "options",
    [
        {"reduce": ["max", "min", "final"]},
        {"reduce": ["mean", "rms"]},
        {"reduce": Fold(counted, start=0.0)},
        {"events": low},
        {"events": low, "reduce": "first_event"},
        {"events": low, "on_event": lambda t, y, k: [1.0, y[1], y[2]]},
        {"breakpoints": [10.0, 500.0]},
        {"max_step": 300.0, "first_step": 1e-5},
        {"project": lambda t, y, k: [y[0], y[1], 1.0 - y[0] - y[1]]},
    ],
    ids=lambda options: " ".join(options) + str(options.get("reduce", "")).partition("(")[0],
)
def test_what_is_gathered_is_that_of_single_solves(options):
    many, alone = (solved(SWEEPS["Robertson"], simd=s, **options) for s in (True, False))
    assert many.width > 1 and alone.width == 1 and many.success.all()
    assert np.array_equal(many.nfev, alone.nfev) and near(many.y, alone.y)
    for key, values in (alone.reduced or {}).items():
        compare = same_times if key == "first_event" else near
        assert compare(many.reduced[key], values)
    for times, others in zip(many.t_events or [], alone.t_events or [], strict=True):
        assert all(map(same_times, times, others))
    if "events" in options and "reduce" not in options:
        assert all(map(len, alone.t_events[0]))


def test_a_terminal_event_ends_its_lane_alone():
    def gone(t, y, k):
        return y[0] - 0.5

    gone.terminal = True
    many, alone = (
        solve_ensemble(decay, (0, 1), [1.0], (np.geomspace(0.1, 1e3, COUNT),), "Rodas5P",
                       events=gone, simd=simd, **OPTIONS)
        for simd in (True, False)
    )  # fmt: skip
    assert set(many.status) == {0, 1} and np.array_equal(many.status, alone.status)
    assert near(many.t_end, alone.t_end) and near(many.y, alone.y)


def test_threads_order_and_neighbours_change_no_bit():
    k = np.geomspace(1e7, 1e8, 40)
    sweep = SWEEPS["Robertson"]._replace(args=(k,))
    first = solved(sweep, threads=1)
    assert np.array_equal(solved(sweep, threads=3).y, first.y)
    order = np.random.default_rng(1).permutation(40)
    mixed = solved(sweep._replace(args=(k[order],)))
    assert np.array_equal(mixed.y, first.y[order]) and np.array_equal(mixed.nfev, first.nfev[order])


FIRST = 0.5
# What k, p and y0 do to a lane in which y' = k root(y) + p y.
HOSTILE = {
    "a singular matrix": (0.0, 1.0 / (FIRST * GAMMA), 1.0),
    "no number": (math.nan, 1.0, 1.0),
    "an exception": (-2.0, 0.0, 1.0),
    "an infinite Jacobian": (1.0, 1.0, 0.0),
    "finished at once": (0.0, 0.0, 1.0),
    "too many steps": (0.0, 1e4, 1.0),
}
ENDS = dict.fromkeys(HOSTILE, 0) | dict.fromkeys(
    ("no number", "an exception", "too many steps"), -1
)


def rooted(t, y, k, p):
    return [k * math.sqrt(y[0]) + p * y[0]]


@pytest.mark.parametrize("what", HOSTILE)
def test_what_befalls_a_lane_leaves_the_others_alone(what):
    bad = HOSTILE[what]
    k, p, y0 = np.linspace(0.1, 1.0, 9), np.linspace(-3.0, -0.5, 9), np.linspace(1.0, 2.0, 9)
    options: Any = {"first_step": FIRST, "max_steps": 300, "method": "Rodas5P", **OPTIONS}
    healthy = solve_ensemble(rooted, (0, 1), y0[:, None], (k, p), simd=True, **options)
    assert healthy.success.all()
    k[4], p[4], y0[4] = bad
    run = solve_ensemble(rooted, (0, 1), y0[:, None], (k, p), simd=True, **options)
    assert run.width > 1
    others = np.arange(9) != 4
    assert np.array_equal(run.y[others], healthy.y[others])
    assert np.array_equal(run.nfev[others], healthy.nfev[others])
    one = solve_ensemble(rooted, (0, 1), y0[:, None], (k, p), simd=False, **options)
    assert run.status[4] == one.status[4] == ENDS[what]
    assert run.message(4).partition(" t = ")[0] == one.message(4).partition(" t = ")[0]
    if what != "an exception":  # where y is 0, up to which steps shrink to rounding
        assert run.nfev[4] == one.nfev[4] and run.n_rejected[4] == one.n_rejected[4]
    if what == "a singular matrix":
        assert run.n_rejected[4] > 0


def test_an_infinite_entry_of_the_jacobian_is_no_zero_stage():
    """The slope of the cube root at 0: there the lane takes differences, as a single solve."""

    def slow(t, y, k):
        return [-k * np.cbrt(y[0]) + t]

    y0, k = np.array([[0.0], [1.0], [0.0], [2.0]]), np.array([0.1, 2.0, 0.5, 3.0])
    many, alone = (
        solve_ensemble(slow, (0, 1), y0, (k,), "Rodas5P", simd=simd, **OPTIONS)
        for simd in (True, False)
    )
    assert many.width > 1 and np.array_equal(many.nfev, alone.nfev) and near(many.y, alone.y)


def full(n):
    def fun(t, y, k):
        total = sum(y[i] for i in range(n))
        return [-k * y[i] - math.exp(i - n) * total * total for i in range(n)]

    return fun


@pytest.mark.parametrize(
    "fun, y0, options, reason",
    [
        (decay, [1.0], {"jac": lambda t, y, k: [[-k]]}, "Jacobian"),
        (decay, [1.0], {"jac": "2-point"}, "Jacobian"),
        (decay, [1.0], {"method": "Radau"}, "not written for vectors"),
        (full(20), np.ones(20), {}, "elimination for 20 equations"),
    ],
)
def test_the_rest_runs_one_by_one(fun, y0, options, reason):
    given = {"method": "Rodas5P"} | OPTIONS | options
    many = solve_ensemble(fun, (0, 1), y0, (np.linspace(1, 2, 3),), **given)
    assert many.width == 1 and reason in many.reason and many.success.all()
    with pytest.raises(ValueError, match=reason):
        solve_ensemble(fun, (0, 1), y0, (np.linspace(1, 2, 3),), simd=True, **given)
