"""First passages: their share and their times beside exact laws, at any step."""

import numpy as np
import pytest
from scipy import stats

from fastdyn import solve_langevin, solve_sde

N = 100_000


# Tests share these functions, and so their kernels: a kernel with passages takes 2 to 5 s of LLVM.


def moving(drift=0.0):
    return lambda t, y: drift + 0.0 * y


def ends(g):
    g.terminal = True
    return g


def level(a, direction=None):
    def passed(t, y):
        return y[0] - a

    if direction is not None:
        passed.direction = direction
    return passed


def passage_law(t, distance, drift, sigma):
    """The share of paths of drift t + sigma W that pass `distance` by time t."""
    root = sigma * np.sqrt(t)
    far = np.exp(2 * drift * distance / sigma**2) * stats.norm.sf((distance + drift * t) / root)
    return stats.norm.sf((distance - drift * t) / root) + far


@pytest.mark.parametrize("step", [0.5, 0.05])
@pytest.mark.parametrize("drift, sigma", [(0.0, 1.0), (0.8, 0.7), (-0.5, 1.3)])
def test_times_of_passage_have_the_exact_law(step, drift, sigma):
    """Kolmogorov's distance at chance 1e-6: sqrt(log(2e6) / 2 / N)."""
    found = solve_sde(
        moving(drift), sigma, (0, 2), [0.0], step=step, paths=N, rng=1, events=level(1.0)
    )
    times = np.sort(found.t_events[0])
    n = int(np.isfinite(times).sum())
    law = passage_law(times[:n], 1.0, drift, sigma)
    far = max(np.abs(np.arange(k, n + k) / N - law).max() for k in (0, 1))
    assert far < np.sqrt(np.log(2e6) / 2 / N)


def test_two_sources_add_their_variances():
    """y_0 + y_1 with two sources is a motion of variance 0.5; g is not linear in time alone."""
    diffusion = np.array([[0.5, 0.0], [0.3, 0.4]])
    found = solve_sde(
        lambda t, y: 0.0 * y, diffusion, (0, 1), [0.0, 0.0], step=0.25, paths=N, rng=2,
        events=lambda t, y: y[0] + y[1] - 1.0,
    )  # fmt: skip
    share = np.isfinite(found.t_events[0]).mean()
    exact = passage_law(1.0, 1.0, 0.0, np.hypot(0.8, 0.4))
    assert abs(share - exact) < 5 * np.sqrt(exact / N)


def test_directions_and_terminal_events():
    falls = ends(level(0.5, -1))
    rises = level(1.5, 1)
    found = solve_sde(
        moving(), 1.0, (0, 1), [1.0], step=1 / 32, paths=2000, rng=3,
        events=[falls, ends(level(99.0)), rises], t_eval=np.arange(33) / 32,
    )  # fmt: skip
    ended, never, _ = found.t_events
    assert np.isnan(never).all()
    for path in range(2000):
        if np.isnan(ended[path]):
            continue
        done = int(np.ceil(ended[path] * 32))
        assert (found.y[path, 0, done:] == found.y_end[path, 0]).all()
        assert (found.t_events[2, path] > ended[path]) == False  # noqa: E712  # NaN is no time
    below = found.y[:, 0] <= 0.5  # every state beyond the barrier was noticed
    assert np.isfinite(ended[below.any(axis=1)]).all()
    up, first = [
        solve_sde(moving(), 1.0, (0, 1), [2.0], step=1 / 32, paths=2000, rng=3, events=event)
        for event in (rises, level(1.5))
    ]
    both = np.isfinite(up.t_events[0])
    assert both.any()
    assert (first.t_events[0][both] < up.t_events[0][both]).all()  # from above, then from below


def test_langevin_events_lie_between_the_ends_of_steps():
    found = solve_langevin(
        lambda t, q: -q, (0, 10), [1.0], [0.0], friction=0.0, sigma=0.0, step=0.01, paths=9,
        events=lambda t, y: y[0],
    )  # fmt: skip
    np.testing.assert_allclose(found.t_events[0], np.pi / 2, rtol=0, atol=0.01**2)


def test_nothing_comes_behind_the_end_of_a_path():
    """An ended path rests at its barrier, and passes no other one, however near."""
    barriers = [ends(level(0.5, -1)), ends(level(1.5)), level(0.48, -1)]
    found = solve_sde(moving(), 1.0, (0, 1), [1.0], step=1 / 16, paths=4000, rng=3, events=barriers)
    low, high, beyond = found.t_events
    at_low, at_high = np.isfinite(low), np.isfinite(high)
    assert at_low.sum() > 1000 < at_high.sum()
    assert not (at_low & at_high).any()
    np.testing.assert_allclose(found.y_end[at_low, 0], 0.5, rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.y_end[at_high, 0], 1.5, rtol=0, atol=1e-15)
    assert not (beyond > np.fmin(low, high)).any()


def test_barriers_are_passed_one_behind_the_other():
    """From one barrier to the next, the time is that of a motion that starts anew, at any step."""
    levels = [1.5, 0.8, 1.0, -0.8, -0.6]
    found = solve_sde(
        lambda t, y: 0.0 * y, 1.0, (0, 2), [0.0], step=0.5, paths=N, rng=6,
        events=[lambda t, y, a=a: (y[0] - a) * np.sign(a) for a in levels],
    )  # fmt: skip
    far, near, middle, low, least = np.where(np.isnan(found.t_events), np.inf, found.t_events)
    assert ((middle < far) | np.isinf(far)).all()
    assert ((near < middle) | np.isinf(middle)).all()
    assert ((least < low) | np.isinf(low)).all()
    for before, after, way in ((near, middle, 0.2), (middle, far, 0.5), (least, low, 0.2)):
        early = before < 1.0
        share = (after[early] - before[early] < 1.0).mean()
        exact = passage_law(1.0, way, 0.0, 1.0)
        assert abs(share - exact) < 5 * np.sqrt(exact * (1 - exact) / early.sum())
    for times, level in ((far, 1.5), (middle, 1.0), (low, 0.8)):
        exact = passage_law(2.0, level, 0.0, 1.0)
        assert abs(np.isfinite(times).mean() - exact) < 5 * np.sqrt(exact * (1 - exact) / N)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_the_place_of_a_passage_has_the_exact_law(scale):
    """A motion in the plane is, where it leaves a half plane at time T, normal of variance T along.

    The second noise has a part of the first: y_1 = W_1, y_2 = W_1 + scale W_2.
    """
    found = solve_sde(
        lambda t, y: 0.0 * y, np.array([[1.0, 0.0], [1.0, scale]]), (0, 2), [0.0, 0.0], step=0.5,
        paths=20_000, rng=5, events=ends(lambda t, y: y[0] - 1.0),
    )  # fmt: skip
    times = found.t_events[0]
    there = np.isfinite(times)
    first, second = found.y_end[there].T
    np.testing.assert_allclose(first, 1.0, rtol=0, atol=1e-14)
    z = (second - 1.0) / (scale * np.sqrt(times[there]))
    assert stats.kstest(z, "norm").pvalue > 1e-6


@pytest.mark.parametrize(
    ("attributes", "words"),
    [
        ({"terminal": 3}, "asks for `terminal=3`: a"), ({"wait": 0.1}, "asks for `wait=0.1`: a"),
        ({"terminal": 3, "wait": 0.1}, "`terminal=3` and `wait=0.1`"),
        ({"direction": "up"}, "could not convert string to float"),
    ],
)  # fmt: skip
def test_rules_that_a_first_passage_does_not_have_are_refused(attributes, words):
    def falls(t, y):
        return y[0]

    vars(falls).update(attributes)
    with pytest.raises(ValueError, match=words):
        solve_sde(lambda t, y: -y, 0.1, (0, 1), [1.0], step=0.1, events=falls)
