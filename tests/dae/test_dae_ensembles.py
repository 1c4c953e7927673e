"""Ensembles of DAEs of index 0 and 1: each trajectory has the bits of `solve_dae`."""

import concurrent.futures
import math

import numpy as np
import pytest

from fastdyn import solve_dae, solve_dae_ensemble
from fastdyn.compile.sentences import CompileWarning
from fastdyn.ensemble import Fold, Shared

TIGHT = {"rtol": 1e-6, "atol": 1e-10}
TIMES = [0.0, 1.0, 40.0, 400.0]
RATES = np.array([3e3, 1e4, 1.7e4, 2.1e4])


def robertson(t, y, yp, k):
    a, b, c = y
    return [yp[0] + 0.04 * a - k * b * c, yp[1] - 0.04 * a + k * b * c + 3e7 * b * b, a + b + c - 1]


def divider(t, y, yp, R, C):
    """A source, a resistor, a capacitor and a diode: voltage at the capacitor and current."""
    u, i = y
    return [C * yp[0] - i + 1e-6 * (math.exp(u / 0.05) - 1), math.sin(t) - R * i - u]


def same(found, single):
    for name in ("t", "y", "yp", "status", "message", "n_accepted", "n_rejected"):
        assert np.array_equal(found[name], single[name]), name


def test_robertson_has_the_bits_of_single_solves_with_any_number_of_threads():
    given = (robertson, (0, 400), [1.0, 0.0, 0.0])
    found = solve_dae_ensemble(*given, args=(RATES,), t_eval=TIMES, **TIGHT)
    assert found.success.all() and found.index == 1 and found.method == "BDF"
    assert found.y.shape == found.yp.shape == (4, 3, 4)
    for i, k in enumerate(RATES):
        same(found[i], solve_dae(*given, args=(k,), t_eval=TIMES, **TIGHT))
    backwards = solve_dae_ensemble(*given, args=(RATES[::-1],), t_eval=TIMES, threads=2, **TIGHT)
    assert np.array_equal(backwards.y[::-1], found.y)
    assert np.array_equal(backwards.yp_end[::-1], found.yp_end)


def test_two_threads_of_the_program_solve_at_once():
    def solve(_):
        return solve_dae_ensemble(robertson, (0, 40), [1.0, 0.0, 0.0], args=(RATES,), **TIGHT).y

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        first, *others = pool.map(solve, range(4))
    assert all(np.array_equal(first, each) for each in others)


def test_a_start_of_each_trajectory_is_made_consistent():
    """The voltages are held, and the currents, guesses, follow from them."""
    R, volts = np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, -0.1])
    guesses = np.column_stack([volts, [7.0, 0.0, -3.0]])
    found = solve_dae_ensemble(divider, (0, 5), guesses, args=(R, 0.5), **TIGHT)
    assert found.y0[:, 0].tolist() == volts.tolist()
    assert found.y0[:, 1] == pytest.approx(-volts / R, abs=1e-15)
    for i in range(3):
        single = solve_dae(divider, (0, 5), guesses[i], args=(R[i], 0.5), **TIGHT)
        assert np.array_equal(found.y_end[i], single.y[:, -1])
        assert np.array_equal(found.yp_end[i], single.yp[:, -1])
        assert found.nfev[i] == single.nfev and found.n_accepted[i] == single.n_accepted
    assert [label.name for label in found.argument_labels] == ["R", "C"]
    assert "3 of 2 components, BDF, 0 failed" in repr(found)


def test_trajectories_without_a_start_fail_alone():
    def F(t, y, yp, a):
        return [yp[0] + a * y[1], math.sqrt(y[0]) - y[1]]

    starts = [[1.0, 1.0], [4.0, 2.0], [np.nan, 1.0], [-1.0, 1.0], [9.0, 3.0], [4.0, 1.0]]
    rates = [[-1.0, 0.0], [-2.0, 0.0], [0.0, 0.0], [0.0, 0.0], [-3.0, -1.0], [-1.0, 0.0]]
    a = np.ones(6)
    found = solve_dae_ensemble(F, (0, 1), starts, rates, args=(a,), given="differential", **TIGHT)
    assert found.status.tolist() == [0, 0, -1, -1, 0, 0]
    assert found.message(2) == "Trajectory 2 has no start: component 0 of `y0` is not finite."
    assert "Trajectory 3 has no start" in found.message(3) and "nan" in found.message(3)
    assert np.isnan(found.y[2:4]).all() and np.isnan(found.y0[2:4]).all()
    good = [0, 1, 4, 5]
    alone = solve_dae_ensemble(
        F, (0, 1), np.array(starts)[good], np.array(rates)[good], args=(a[good],),
        given="differential", **TIGHT,
    )  # fmt: skip
    assert np.array_equal(found.y[good], alone.y) and "2 failed" in repr(found)
    held = solve_dae_ensemble(F, (0, 1), starts, rates, args=(a,), **TIGHT)
    assert "`y0` and `yp0` are not consistent: equation" in held.message(5)
    assert held.status.tolist() == [0, 0, -1, -1, 0, -1]
    with pytest.raises(ValueError, match="are not consistent"):
        solve_dae_ensemble(F, (0, 1), starts[5:], rates[5:], args=(1.0,))


def test_a_trajectory_that_ends_on_its_way_ends_alone():
    """x' = -1 / x ends at x = 0, at t = x0^2 / 2: in one of three trajectories."""

    def F(t, y, yp):
        return [yp[0] * y[1] + 1, y[1] - y[0]]

    found = solve_dae_ensemble(F, (0, 1), [[2.0, 2.0], [1.0, 1.0], [3.0, 3.0]], **TIGHT)
    assert found.status.tolist() == [0, -1, 0]
    single = solve_dae(F, (0, 1), [1.0, 1.0], **TIGHT)
    assert found.message(1)[:100] == single.message[:100] and found.t_end[1] == single.t[-1]
    assert found.y[::2, 0] == pytest.approx([math.sqrt(2), math.sqrt(7)], rel=1e-4)


def test_events_and_reductions_are_those_of_y():
    def low(t, y, k):
        return y[0] - 0.9

    def most(value, t, y, k):
        assert len(y) == 3
        return max(value, y[1])

    low.terminal = True
    given = (robertson, (0, 400), [1.0, 0.0, 0.0])
    found = solve_dae_ensemble(
        *given, args=(RATES,), events=low, reduce=["final", "max", Fold(most)], **TIGHT
    )
    assert (found.status == 1).all() and found.event_names == ["low"]
    for i, k in enumerate(RATES):
        single = solve_dae(*given, args=(k,), events=low, **TIGHT)
        assert np.array_equal(found.t_events[0][i], single.t_events[0])
        for name in ("y_events", "yp_events"):
            assert np.array_equal(getattr(found, name)[0][i], single[name][0])
            assert np.array_equal(found[i][name][0], single[name][0])
        assert found.reduced["max"][i, 2] == single.y[2, -1]
        assert found.reduced["most"][i] == single.y[1].max() <= found.reduced["max"][i, 1]
    assert np.array_equal(found.reduced["final"], found.y_end)
    first = solve_dae_ensemble(*given, args=(RATES,), events=[low], reduce="first_event", **TIGHT)
    assert first.reduced["first_event"][:, 0].tolist() == [t[0] for t in found.t_events[0]]


def test_a_function_in_python_is_solved_as_well():
    def F(t, y, yp, k):
        a, b, c = y
        return robertson(t, [float(np.float64(a).item()), b, c], yp, k)

    with pytest.warns(CompileWarning):
        found = solve_dae_ensemble(F, (0, 4), [1.0, 0, 0], args=(RATES[:2],), **TIGHT)
    for i in range(2):
        single = solve_dae(F, (0, 4), [1.0, 0, 0], args=(RATES[i],), **TIGHT)
        assert np.array_equal(found.y_end[i], single.y[:, -1])


def test_long_states_are_solved_with_sparse_matrices():
    n = 60

    def F(t, y, yp, k):
        heat = k * (np.concatenate([y[1:], y[:1]]) - 2 * y + np.concatenate([y[-1:], y[:-1]]))
        return np.concatenate([yp[:-1] - heat[:-1], [y.sum() - 1.0]])

    start, k = np.zeros(n), np.array([0.5, 1.0, 2.0])
    start[3] = 1.0
    found = solve_dae_ensemble(F, (0, 3), start, args=(k,), **TIGHT)
    for i in range(3):
        single = solve_dae(F, (0, 3), start, args=(k[i],), **TIGHT)
        assert np.array_equal(found.y_end[i], single.y[:, -1])


def test_shared_arrays_and_whole_numbers_are_arguments():
    def F(t, y, yp, table, power):
        return [yp[0] + table[0] * y[1], y[1] - y[0] ** power]

    table, power = np.array([0.5, 1.0]), np.array([1, 2, 3])
    found = solve_dae_ensemble(F, (0, 1), [1.0, 0.0], args=(Shared(table), power), **TIGHT)
    for i in range(3):
        single = solve_dae(F, (0, 1), [1.0, 0.0], args=(table, int(power[i])), **TIGHT)
        assert found.y_end[i] == pytest.approx(single.y[:, -1], rel=1e-12)


def test_a_dataset_has_the_derivatives():
    pytest.importorskip("xarray")
    given = (robertson, (0, 400), [1.0, 0.0, 0.0])
    found = solve_dae_ensemble(*given, args=(RATES,), t_eval=TIMES, **TIGHT)
    data = found.to_xarray()
    assert data.yp.dims == ("trajectory", "component", "time") and data.attrs["index"] == 1
    assert np.array_equal(data.yp, found.yp) and data.k.values.tolist() == RATES.tolist()
    assert np.array_equal(data.yp_end, found.yp_end)
