"""Ensembles of DAEs whose index is reduced: each trajectory is that of `solve_dae`."""

import numpy as np
import pytest

from fastdyn import solve_dae, solve_dae_ensemble
from fastdyn.dae import reduce_index
from fastdyn.dae.ensemble import guard
from fastdyn.dae.structure.eliminate import hold
from support.mechanisms import from_angle, pendulum, slider_crank

TIGHT = {"rtol": 1e-9, "atol": 1e-9}
ALONE = {**TIGHT, "simd": False}  # without kernels of vectors, which take seconds to compile
LENGTHS = np.array([0.5, 1.0, 1.7])
STARTS = np.array([from_angle(1.2, 0.3, length, 9.81) for length in LENGTHS])
# Two solves of one problem whose numbers differ by roundings take the same steps; a rounding of the
# start grows in these 3 s by less than 100, and forces are some 50 in size.
ROUNDING = 100 * 50 * 2.3e-16 * 10


def wall(t, y, length, g):
    return y[0]


def shrinking(t, y, yp, rate):
    """A pendulum without weight whose length falls: it is singular where the length is 0."""
    x, z, u, v, force = y
    balance = [yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z]
    return [*balance, x * x + z * z - (1 - rate * t) ** 2]


@pytest.mark.parametrize("simd", ["auto", False])
def test_pendulums_of_their_lengths_are_those_of_single_solves(simd):
    times = [0.0, 0.5, 2.0, 3.0]
    given = {"events": wall, "t_eval": times, **TIGHT}
    found = solve_dae_ensemble(pendulum, (0, 3), STARTS, args=(LENGTHS, 9.81), simd=simd, **given)
    assert found.success.all() and found.index == 3 and found.differentiated[-1] == 2
    assert (found.width > 1) == (simd == "auto") and found.method == "DOP853"
    assert [label.name for label in found.argument_labels] == ["length", "g"]
    for i, length in enumerate(LENGTHS):
        single = solve_dae(pendulum, (0, 3), STARTS[i], args=(length, 9.81), **given)
        assert found.n_accepted[i] == single.n_accepted
        assert found.y[i] == pytest.approx(single.y, abs=ROUNDING)
        assert found[i].yp == pytest.approx(single.yp, abs=ROUNDING, nan_ok=True)
        assert found.t_events[0][i] == pytest.approx(single.t_events[0], abs=ROUNDING)
        assert found.y_events[0][i] == pytest.approx(single.y_events[0], abs=ROUNDING)
        assert np.hypot(*found.y[i][:2]) == pytest.approx(np.full(4, length), rel=1e-13)
    assert found.y_end == pytest.approx(found.y[:, :, -1], abs=ROUNDING)


def test_starts_follow_from_what_is_held_and_bad_ones_fail_alone():
    guesses = np.array([[0.3, -0.4, 0, 0, 0], [0.6, -0.9, 0, 0, 0], [np.nan, 0, 0, 0, 0],
                        [9.0, -1.0, 0, 0, 0]])  # fmt: skip
    lengths = np.array([0.5, 1.0, 1.0, 1.0])
    found = solve_dae_ensemble(
        pendulum, (0, 1), guesses, args=(lengths, 9.81), given=[0], reduce="final", **ALONE
    )
    assert found.status.tolist() == [0, 0, -1, -1]
    assert found.y0[:2, :2] == pytest.approx(np.array([[0.3, -0.4], [0.6, -0.8]]), abs=1e-12)
    for i in (0, 1):
        given = {"args": (lengths[i], 9.81), "given": [0]}
        single = solve_dae(pendulum, (0, 1), guesses[i], **given, **TIGHT)
        assert found.reduced["final"][i] == pytest.approx(single.y[:, -1], abs=ROUNDING)
    assert found.message(2) == "Trajectory 2 has no start: component 0 of `y0` is not finite."
    with pytest.raises(ValueError) as alone:
        solve_dae(pendulum, (0, 1), guesses[3], args=(1.0, 9.81), given=[0])
    assert "Trajectory 3 has no start" in found.message(3)
    assert found.message(3).split(": ", 1)[1].rstrip(".") in str(alone.value)
    with pytest.raises(ValueError, match="y0 violates the constraints"):
        solve_dae_ensemble(pendulum, (0, 1), guesses[[1, 1]], args=(1.0, 9.81))


@pytest.mark.parametrize("method", ["Vern9", "Radau"])
def test_other_methods_and_equations_of_index_1(method):
    def circuit(t, y, yp, R):
        return [R * yp[0] + y[0] - y[1], y[0] + y[1] - np.sin(t)]

    R = np.array([0.5, 2.0])
    found = solve_dae_ensemble(circuit, (0, 2), [0.0, 0.0], args=(R,), method=method, **ALONE)
    assert found.index == 1 and found.method == method
    for i in range(2):
        single = solve_dae(circuit, (0, 2), [0.0, 0.0], args=(R[i],), method=method, **TIGHT)
        assert found.y_end[i] == pytest.approx(single.y[:, -1], abs=1e-13)


def test_a_singularity_that_a_step_passes_ends_its_trajectory_alone():
    """The lengths of two of four are 0 within the span, in the middle of long steps."""
    rates = np.array([0.3, 1.0, 0.2, 0.7])
    starts = np.array([[0.0, -1.0, 0.0, rate, 0.0] for rate in rates])
    given = {"method": "DOP853", "t_eval": [0.0, 0.5, 2.0], **TIGHT}
    found = solve_dae_ensemble(shrinking, (0, 2), starts, args=(rates,), simd=False, **given)
    assert found.status.tolist() == [0, -1, 0, -1]
    for i in (1, 3):
        single = solve_dae(shrinking, (0, 2), starts[i], args=(rates[i],), **given)
        assert single.status == -1 and not single.success
        assert found.message(i) == single.message and "singular between t = " in single.message
        assert found[i].t.tolist() == single.t.tolist() == [0.0, 0.5]
        assert found.t_end[i] < 1 / rates[i] and np.isnan(found.y[i, :, 2]).all()
    assert found.y[::2, 1, 2] == pytest.approx(2 * rates[::2] - 1, abs=1e-12)


def test_long_steps_are_no_singularity():
    starts = np.array([from_angle(angle, 3.0, 1.0, 9.81) for angle in (0.3, 1.5, 2.5)])
    loose = {"rtol": 1e-3, "atol": 1e-3, "simd": False}
    found = solve_dae_ensemble(pendulum, (0, 20), starts, args=(1.0, 9.81), **loose)
    assert found.success.all() and (found._results.y_end[:, -1] > 0).any()  # and solved alone


def test_the_guard_of_many_equations_is_a_norm(monkeypatch):
    monkeypatch.setattr(guard, "LARGEST", 0)
    rates = np.array([0.3, 1.0])
    starts = np.array([[0.0, -1.0, 0.0, rate, 0.0] for rate in rates])
    found = solve_dae_ensemble(shrinking, (0, 2), starts, args=(rates,), method="DOP853", **ALONE)
    assert found.status.tolist() == [0, -1] and "singular between t = " in found.message(1)


def test_a_mechanism_of_two_loops_with_masses_that_differ():
    rod = -np.arcsin(0.3 * np.sin(0.5))
    start = [0.5, rod, 0.3 * np.cos(0.5) + np.cos(rod), 4.0, 0, 0, 0, 0]
    masses = np.array([0.5, 1.0, 3.0])
    args = (0.3, 1.0, 1.0, 1.0, masses, 9.81)
    found = solve_dae_ensemble(slider_crank, (0, 1), start, args=args, given=[0, 3], **ALONE)
    for i in range(3):
        own = (*args[:4], masses[i], 9.81)
        single = solve_dae(slider_crank, (0, 1), start, args=own, given=[0, 3], **TIGHT)
        assert found.y_end[i] == pytest.approx(single.y[:, -1], rel=1e-9, abs=1e-9)


def test_a_trajectory_with_other_pivots_is_told():
    numbers = np.array([[[2.0, 1.0], [1.0, 3.0]], [[1e-4, 1.0], [1.0, 3.0]]])
    assert hold(numbers, ((0, 0), (1, 1))).tolist() == [True, False]
    assert hold(numbers, ((0, 1),)).tolist() == [True, True]


def test_constant_matrices_need_no_guard():
    def linear(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[2], y[0] - t]

    assert guard.Guard(reduce_index(linear, [0.0, 1.0, 0.0])).size == 0
    found = solve_dae_ensemble(linear, (0, 1), [[0.0, 1.0, 0.0]] * 2, simd=False)
    assert found.index == 3 and found.y_end == pytest.approx(np.array([[1.0, 1.0, 0.0]] * 2))


def test_what_an_ensemble_does_not_look_for_is_refused():
    def struck(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[2], y[0] - abs(np.sin(t))]

    with pytest.raises(ValueError, match="does not look for its kinks"):
        solve_dae_ensemble(struck, (0.1, 1), [np.sin(0.1), np.cos(0.1), 0.0], method="DOP853")
    with pytest.raises(ValueError, match="cannot return a state to its constraints"):
        solve_dae_ensemble(pendulum, (0, 1), STARTS, args=(LENGTHS, 9.81), method="LSODA")
